/* gnomon bench: the table, as text and as JSON. */
#include "bench.h"

#include <stdio.h>
#include <string.h>

#define BASELINE "naive"
#define RIVAL    "ray-mip0" /* what steadiness and error are held against; or else the next */
#define RIVAL_2  RIVAL ":bvh"

static const gn_bench_row *find_rival(const gn_bench_result *result)
{
    const gn_bench_row *rival = gn_bench_find(result, RIVAL);
    return rival ? rival : gn_bench_find(result, RIVAL_2);
}

/* value / RIVAL's, or -1 where there is nothing to divide by. */
static double ratio(double value, double rival)
{
    return rival > 0 ? value / rival : -1;
}

static void print_cell(double value, const char *format, int width)
{
    if (value < 0)
        printf("%*s", width, "-");
    else
        printf(format, width, value);
}

/* Reading the map: nanoseconds a pixel of the picture, all lights. */
static double ns_per_pixel(const gn_bench_row *row, double pixels)
{
    return row->test.spread.median * 1e6 / pixels;
}

/* Room for the longest name. */
static int name_width(const gn_bench_result *result)
{
    size_t width = 13;
    for (uint32_t i = 0; i < result->count; i++)
        width = strlen(result->rows[i].name) > width ? strlen(result->rows[i].name) : width;
    return (int)width + 1;
}

static bool any_traces(const gn_bench_result *result, gn_trace_rule trace)
{
    for (uint32_t i = 0; i < result->count; i++)
        if (result->rows[i].timed && result->rows[i].trace == trace)
            return true;
    return false;
}

/* What only methods that read maps alone have. */
static void print_maps(const gn_bench_result *result, double pixels)
{
    if (!any_traces(result, GN_TRACE_NONE))
        return;
    const int width = name_width(result);
    printf("\n%-*s%9s%9s%9s%8s%8s%8s%8s%9s%10s%8s\n", width, "maps, mean ms", "depth", "filter",
           "test", "ns/px", "layers", "fits", "MB", "wrong %", "mean abs", "x mip0");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (!row->timed || row->trace != GN_TRACE_NONE)
            continue;
        printf("%-*s%9.2f%9.2f%9.2f%8.2f%8u%8.2f%8.0f%9.3f%10.5f%8.2f\n", width, row->name,
               row->shadow_map.mean, row->filter.mean, row->test.mean, ns_per_pixel(row, pixels),
               row->map_layers, row->map_fits, (double)row->map_bytes * 1e-6, row->wrong * 100,
               row->mean_abs, row->speedup.spread.median);
    }
    printf("ns/px: of the test, median. fits: layers placed anew, a frame. wrong and mean abs: "
           "against "
           "ray-mip0.\n");
}

/* What only leak tracing has. */
static void print_leaks(const gn_bench_result *result, double pixels)
{
    if (!any_traces(result, GN_TRACE_LEAK))
        return;
    const int width = name_width(result);
    printf("\n%-*s%8s%8s%8s%8s%7s%7s%8s%9s%9s%10s%8s%8s%8s%7s\n", width, "leak tracing, ms", "mean",
           "min", "max", "x all", "min", "max", "rays %", "wrong %", "worst", "mean abs", "test",
           "trace", "maps", "fits");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (!row->timed || row->trace != GN_TRACE_LEAK)
            continue;
        printf("%-*s%8.1f%8.1f%8.1f%8.2f%7.2f%7.2f%8.2f%9.4f%9.4f%10.5f%8.2f%8.2f%8.2f%7.2f\n",
               width, row->name, row->visibility.mean, row->visibility.spread.min,
               row->visibility.spread.max, row->speedup.mean, row->speedup.spread.min,
               row->speedup.spread.max, row->rays / pixels * 100, row->wrong * 100,
               row->wrong_max * 100, row->mean_abs, row->test.mean, row->trace_rays.mean,
               row->shadow_map.mean + row->filter.mean, row->map_fits);
    }
    printf(
        "x all, wrong and mean abs: against a ray for every pixel with the same alpha rule, which "
        "is run\ntoo; x all: mean, least and most of the frames' ratios; worst: frame. test, "
        "trace and maps: mean ms.\n");
}

/* Steadiness once more, real motion taken off. */
static void print_residuals(const gn_bench_result *result)
{
    if (!result->residual)
        return;
    const int width = name_width(result);
    const gn_bench_row *rival = find_rival(result);
    printf("\n%-*s%9s%8s%9s%8s\n", width, "residual", "flicker", "/ mip0", "toggles", "/ mip0");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (!row->timed)
            continue;
        printf("%-*s%9.3f", width, row->name, row->residual_flicker * 1e3);
        print_cell(rival ? ratio(row->residual_flicker, rival->residual_flicker) : -1, "%*.3f", 8);
        printf("%9.3f", row->residual_toggles * 1e3);
        print_cell(rival ? ratio(row->residual_toggles, rival->residual_toggles) : -1, "%*.3f", 8);
        printf("\n");
    }
    printf("residual: after the change of the reference from frame to frame is taken off.\n");
}

static void print_table(const gn_app *app, const gn_bench_options *o, const gn_bench_result *result)
{
    const gn_bench_row *rival = find_rival(result);
    const gn_bench_row *naive = gn_bench_find(result, BASELINE);
    char text[32];
    printf("%s, camera %s, %u x %u, %u frames at %g a second, %u threads, %s\n", app->scene_name,
           gn_app_camera_name(app, text), app->options.size[0], app->options.size[1], o->frames,
           o->fps, gn_device_get_info(app->device).threads,
           gn_device_get_info(app->device).isa_name);
    printf("%.2f million shadow rays trace all; G-buffer %.1f ms, scene update %.2f ms\n\n",
           (double)result->rays * 1e-6, result->gbuffer.median, result->update.median);
    const int width = name_width(result);
    const double pixels = (double)app->options.size[0] * app->options.size[1];
    printf("%-*s%9s%9s%9s%8s%8s%8s%8s", width, "", "ms", "min", "max", "ns/ray", "Mray/s",
           "x naive", "/ mip0");
    printf("%9s%8s%9s%8s", "flicker", "/ mip0", "toggles", "/ mip0");
    printf(result->referenced ? "%9s%8s%8s\n" : "\n", "mse", "/ mip0", "mean");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        const bool plain = row->timed && row->trace == GN_TRACE_ALL; /* rays are all it does */
        printf("%-*s", width, row->name);
        print_cell(row->timed ? row->visibility.spread.median : -1, "%*.1f", 9);
        print_cell(row->timed ? row->visibility.spread.min : -1, "%*.1f", 9);
        print_cell(row->timed ? row->visibility.spread.max : -1, "%*.1f", 9);
        print_cell(plain ? ratio(row->visibility.spread.median * 1e6, row->rays) : -1, "%*.1f", 8);
        print_cell(plain ? row->rays / (row->visibility.spread.median * 1e3) : -1, "%*.2f", 8);
        print_cell(naive && row->timed ? row->speedup_naive.median : -1, "%*.2f", 8);
        print_cell(rival && row->timed
                       ? ratio(row->visibility.spread.median, rival->visibility.spread.median)
                       : -1,
                   "%*.2f", 8);
        print_cell(row->steady ? row->flicker * 1e3 : -1, "%*.3f", 9);
        print_cell(rival && row->steady ? ratio(row->flicker, rival->flicker) : -1, "%*.3f", 8);
        print_cell(row->steady ? row->toggles * 1e3 : -1, "%*.3f", 9);
        print_cell(rival && row->steady ? ratio(row->toggles, rival->toggles) : -1, "%*.3f", 8);
        if (result->referenced) {
            print_cell(row->timed ? row->mse * 1e3 : -1, "%*.3f", 9);
            print_cell(rival && row->timed ? ratio(row->mse, rival->mse) : -1, "%*.3f", 8);
            print_cell(row->mean, "%*.4f", 8);
        }
        printf("\n");
    }
    print_residuals(result);
    print_maps(result, pixels);
    print_leaks(result, pixels * app->light_count);
    gn_bench_print_tracing(app, result, width);
    printf("\nflicker, toggles and mse are in 1/1000.");
    if (result->referenced)
        printf(" The reference has %u samples a pixel on %u frames, and a mean of %.4f.",
               o->reference, result->referenced, result->reference_mean);
    printf("\n");
    for (uint32_t i = 0; i < result->count; i++)
        if (result->rows[i].timed && result->rows[i].noise > 1.15) {
            printf("The machine was busy: repeats of %s differ by a factor of %.2f.\n",
                   result->rows[i].name, result->rows[i].noise);
            break;
        }
}

static void add_spread(cJSON *json, const char *prefix, gn_spread spread)
{
    char key[64];
    const struct {
        const char *name;
        double value;
    } parts[] = {{"median", spread.median}, {"min", spread.min}, {"max", spread.max}};
    for (int i = 0; i < 3; i++) {
        snprintf(key, sizeof key, "%s_%s", prefix, parts[i].name);
        cJSON_AddNumberToObject(json, key, parts[i].value);
    }
}

/* Frame by frame, for plots. */
static void add_series(cJSON *json, const gn_bench_result *result, const gn_bench_row *row)
{
    static const char *const keys[] = {"ms",     "rays",   "wrong",   "mean_abs",
                                       "map_ms", "fitted", "pending", "flicker"};
    enum { COUNT = sizeof keys / sizeof *keys };
    cJSON *list = cJSON_AddObjectToObject(json, "series"), *arrays[COUNT];
    for (int k = 0; k < COUNT; k++)
        arrays[k] = cJSON_AddArrayToObject(list, keys[k]);
    for (uint32_t f = 0; f < result->frame_count; f++) {
        const gn_bench_frame *frame = &row->frames[f];
        const gn_app_cost *cost = &frame->cost;
        const double values[COUNT] = {cost->total,
                                      (double)cost->tracing.rays,
                                      frame->wrong,
                                      frame->mean_abs,
                                      cost->shadow_map + cost->filter,
                                      cost->fitted,
                                      cost->pending,
                                      frame->flicker}; /* NaN is written as null */
        for (int k = 0; k < COUNT; k++)
            cJSON_AddItemToArray(arrays[k], cJSON_CreateNumber(values[k]));
    }
}

static void add_passes(cJSON *json, const gn_bench_result *result, const gn_bench_row *row)
{
    const struct {
        const char *name;
        gn_bench_part part;
    } passes[] = {{"shadow_map", row->shadow_map},
                  {"filter", row->filter},
                  {"test", row->test},
                  {"trace", row->trace_rays}};
    cJSON *list = cJSON_AddObjectToObject(json, "passes");
    add_spread(cJSON_AddObjectToObject(list, "gbuffer"), "ms", result->gbuffer);
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) {
        cJSON *pass = cJSON_AddObjectToObject(list, passes[i].name);
        add_spread(pass, "ms", passes[i].part.spread);
        cJSON_AddNumberToObject(pass, "ms_mean", passes[i].part.mean);
    }
}

static void add_method(cJSON *methods, const gn_app *app, const gn_bench_result *result,
                       const gn_bench_row *row, double pixels)
{
    const gn_bench_row *rival = find_rival(result);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddItemToArray(methods, json);
    cJSON_AddStringToObject(json, "name", row->name);
    if (row->timed) {
        add_spread(json, "ms", row->visibility.spread);
        cJSON_AddNumberToObject(json, "ms_mean", row->visibility.mean);
        cJSON_AddNumberToObject(json, "noise", row->noise);
        add_passes(json, result, row);
        cJSON_AddNumberToObject(json, "rays_per_pixel", row->rays / pixels);
        if (row->rays > 0 && row->trace == GN_TRACE_ALL) {
            cJSON_AddNumberToObject(json, "ns_per_ray",
                                    row->visibility.spread.median * 1e6 / row->rays);
            cJSON_AddNumberToObject(json, "rays_per_second",
                                    row->rays / row->visibility.spread.median * 1e3);
        }
        if (row->map_layers > 0) {
            cJSON *map = cJSON_AddObjectToObject(json, "map");
            cJSON_AddNumberToObject(map, "layers", row->map_layers);
            cJSON_AddNumberToObject(map, "fits", row->map_fits);
            cJSON_AddNumberToObject(map, "pending", row->map_pending);
            cJSON_AddNumberToObject(map, "bytes", (double)row->map_bytes);
            cJSON_AddNumberToObject(map, "ns_per_pixel", ns_per_pixel(row, pixels));
        }
        /* Against tracing all; plain rays are that themselves. */
        if (row->yardstick)
            cJSON_AddStringToObject(json, "yardstick", row->yardstick);
        cJSON_AddNumberToObject(json, "wrong_pixels", row->wrong);
        cJSON_AddNumberToObject(json, "wrong_max", row->wrong_max);
        cJSON_AddNumberToObject(json, "mean_abs", row->mean_abs);
        cJSON_AddNumberToObject(json, "mean_abs_max", row->mean_abs_max);
        if (row->yardstick) {
            cJSON_AddNumberToObject(json, "speedup", row->speedup.spread.median);
            cJSON_AddNumberToObject(json, "speedup_mean", row->speedup.mean);
            cJSON_AddNumberToObject(json, "speedup_min", row->speedup.spread.min);
            cJSON_AddNumberToObject(json, "speedup_max", row->speedup.spread.max);
        }
        if (row->trace == GN_TRACE_LEAK) {
            cJSON_AddItemToObject(
                json, "leak",
                gn_app_leak_json(&row->leak, pixels * result->frame_count * result->light_count));
            cJSON_AddNumberToObject(json, "mask_bytes", (double)row->mask_bytes);
        }
        add_series(json, result, row);
        gn_bench_add_tracing(json, app, result, row);
        if (row->speedup_naive.median > 0) {
            cJSON_AddNumberToObject(json, "speedup_naive", row->speedup_naive.median);
            cJSON_AddNumberToObject(json, "speedup_naive_min", row->speedup_naive.min);
        }
        if (rival)
            cJSON_AddNumberToObject(
                json, "ms_ratio",
                ratio(row->visibility.spread.median, rival->visibility.spread.median));
    }
    if (row->steady) {
        cJSON_AddNumberToObject(json, "flicker", row->flicker);
        cJSON_AddNumberToObject(json, "toggles", row->toggles);
        if (rival) {
            cJSON_AddNumberToObject(json, "flicker_ratio", ratio(row->flicker, rival->flicker));
            cJSON_AddNumberToObject(json, "toggles_ratio", ratio(row->toggles, rival->toggles));
        }
    }
    if (result->residual && row->timed) {
        cJSON_AddNumberToObject(json, "residual_flicker", row->residual_flicker);
        cJSON_AddNumberToObject(json, "residual_toggles", row->residual_toggles);
        if (rival) {
            cJSON_AddNumberToObject(json, "residual_flicker_ratio",
                                    ratio(row->residual_flicker, rival->residual_flicker));
            cJSON_AddNumberToObject(json, "residual_toggles_ratio",
                                    ratio(row->residual_toggles, rival->residual_toggles));
        }
    }
    if (result->referenced) {
        if (row->timed) {
            cJSON_AddNumberToObject(json, "mse", row->mse);
            if (rival)
                cJSON_AddNumberToObject(json, "mse_ratio", ratio(row->mse, rival->mse));
        }
        cJSON_AddNumberToObject(json, "mean_visibility", row->mean);
    }
}

static cJSON *make_json(const gn_app *app, const gn_bench_options *o, const gn_bench_result *result)
{
    const double pixels = (double)app->options.size[0] * app->options.size[1];
    cJSON *json = gn_app_json(app);
    cJSON_AddNumberToObject(json, "frames", o->frames);
    cJSON_AddNumberToObject(json, "fps", o->fps);
    cJSON_AddNumberToObject(json, "warm_up", o->warm_up);
    cJSON_AddNumberToObject(json, "repeats", o->repeats);
    cJSON_AddNumberToObject(json, "instanced_triangles", (double)app->info.instanced_triangles);
    cJSON_AddNumberToObject(json, "rays", (double)result->rays);
    add_spread(json, "update_ms", result->update);
    if (result->referenced) {
        cJSON *reference = cJSON_AddObjectToObject(json, "reference");
        cJSON_AddNumberToObject(reference, "samples", o->reference);
        cJSON_AddNumberToObject(reference, "frames", result->referenced);
        cJSON_AddNumberToObject(reference, "mean_visibility", result->reference_mean);
    }
    cJSON *methods = cJSON_AddArrayToObject(json, "methods");
    for (uint32_t i = 0; i < result->count; i++)
        add_method(methods, app, result, &result->rows[i], pixels);
    return json;
}

/* What methods with maps, and tracers, are held against, where the list does not have it. */
static uint32_t add_yardsticks(gn_app_method methods[GN_APP_MAX_METHODS], uint32_t count)
{
    const uint32_t given = count;
    for (uint32_t i = 0; i < given && count < GN_APP_MAX_METHODS; i++) {
        if (!gn_app_has_map(&methods[i]) && methods[i].own.tracer == GN_NONE)
            continue;
        gn_app_yardstick_of(&methods[i], &methods[count]);
        uint32_t k = 0;
        while (strcmp(methods[k].name, methods[count].name) != 0)
            k++;
        count += k == count;
    }
    return count;
}

/* A mask takes some frames to settle, all else one. */
static uint32_t usual_warm_up(const gn_app_method *methods, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (gn_app_has_mask(&methods[i]))
            return GN_APP_WARM_UP;
    return 1;
}

int gn_app_bench(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], "--filter") == 0)
            return gn_app_bench_filter(argc, argv);
        else if (strcmp(argv[i], "--maps") == 0)
            return gn_app_bench_maps(argc, argv);
        else if (strcmp(argv[i], "--evaluate") == 0)
            return gn_app_bench_evaluate(argc, argv);
    static const char *const names[] = {"SCENE", NULL};
    static const char *const pseudo[] = {BASELINE, NULL};
    static const char *const notes[] = {
        "Methods take turns on the same frames. The path is run --repeats times, each from",
        "nothing; a frame's time is the fastest of them, and the table has the median, least and",
        "most over the frames. 'naive' is the baseline: one ray at a time, an instance a node,",
        "alpha test in mip 0. Ratios are to ray-mip0.",
        "Methods are names in 'gnomon methods', names with * and ?, or all, rays, maps, leaks;",
        "those with a map take modifiers: 'lt-vsm:mip0:no-remove', 'lt-*:size=1024'; see",
        "docs/cli.md. Those that trace rays take ':bvh' and ':light-buffer', and are then held",
        "against the same rays of the tree, ':bvh'.",
        "Maps are held against ray-mip0, leak tracing against a ray for every pixel with the same",
        "alpha rule; that is run too. Maps and masks are kept from frame to frame; a frame's time",
        "has what it took to bring them up to date.",
        "'gnomon bench --filter' measures the filter of shadow maps alone, 'gnomon bench SCENE",
        "--maps' their drawing, 'gnomon bench SCENE --evaluate' their reading; see the --help of",
        "each.",
        NULL};
    const gn_usage usage = {
        "bench",
        "time, steadiness and error of methods on the frames of one camera",
        "SCENE [options]",
        names,
        notes,
        {"gnomon bench grove --camera CamWalk --frames 60 --reference 64",
         "gnomon bench scene.glb --methods naive,ray-mip0,ray-saturate --json > result.json"}};
    gn_app_options common = gn_app_options_default();
    gn_bench_options bench = {
        .frames = 12, .warm_up = GN_NONE, .repeats = 3, .fps = 60, .reference_frames = 3};
    const char *list = BASELINE ",rays", *path = NULL;
    const gn_option options[] = {
        GN_TEXT("methods", 'm', "A,B,...", &list, "methods to run; default: naive and the rays"),
        GN_COUNT("frames", 'f', "N", &bench.frames, 1, 100000, "frames to measure, default 12"),
        GN_REAL("fps", 0, "N", &bench.fps, 0.001, 100000,
                "frames a second of the animation, default 60"),
        GN_COUNT("repeats", 'r', "N", &bench.repeats, 1, 1000,
                 "runs of the path, default 3; of each frame the fastest counts"),
        GN_COUNT("warm-up", 0, "N", &bench.warm_up, 0, 1000,
                 "frames before the first, default 1, or 8 where a method has a mask"),
        GN_TEXT("path", 0, "CAMERA", &path, "the camera whose animation is the path; as --camera"),
        GN_COUNT("reference", 0, "SPP", &bench.reference, 0, 4096,
                 "also measure error against SPP samples a pixel; default 0: not"),
        GN_COUNT("reference-frames", 0, "N", &bench.reference_frames, 1, 100000,
                 "frames that get a reference, default 3; with all, residual flicker is shown too"),
        GN_APP_SHOT_OPTIONS(common),
        GN_APP_TIME_OPTION(common),
        GN_APP_MAP_OPTIONS(common),
        GN_APP_TRACER_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END};
    const char *name;
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    if (code != GN_GO_ON)
        return code;
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    uint32_t count = gn_app_parse_methods("bench", list, pseudo, methods);
    if (count == 0)
        return GN_EXIT_USAGE;
    count = add_yardsticks(methods, count);
    if (bench.warm_up == GN_NONE)
        bench.warm_up = usual_warm_up(methods, count);
    if (path)
        common.camera = path;
    bench.start = common.time;

    gn_app app = {0};
    gn_bench_result result = {0};
    bool good = gn_app_open(&app, "bench", &common) && gn_app_use_methods(&app, methods, count) &&
                gn_app_load(&app, name) && gn_app_choose(&app) &&
                gn_bench_run(&app, &bench, methods, count, &result);
    if (good) {
        if (common.json)
            good = gn_app_print_json(&app, make_json(&app, &bench, &result));
        else
            print_table(&app, &bench, &result);
    }
    if (good && (fflush(stdout) != 0 || ferror(stdout)))
        good = gn_app_error(&app, "standard output: cannot write");
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    if (app.device)
        gn_bench_free(&app, &result);
    gn_app_release_methods(methods, count);
    gn_app_close(&app);
    return code;
}
