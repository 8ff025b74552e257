/* gnomon compare: two methods on one view. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/measure.h"
#include "app.h"
#include "picture.h"

#define RUNS              5
#define REFERENCE_SAMPLES 64

static const char *const pseudo_methods[] = {"reference", NULL};

/* One of the two. */
typedef struct side {
    gn_app_method *method;
    uint32_t samples;
    gn_view *view;
    double ms[RUNS];
    uint32_t runs;
    gn_spread spread;
    double map_ms;          /* making its maps, once */
    double rays;            /* a pixel and light, in the last of the runs */
    gn_app_tracing tracing; /* of the last of the runs; no lights where none was traced */
    gn_app_tracing before;  /* of the frames before the runs, together */
} side;

typedef struct comparison {
    gn_app app;
    gn_app_method methods[2];
    side sides[2];
    gn_difference *differences; /* one a light */
    double ratio;               /* time of b over time of a */
    double gain;                /* of the difference picture */
    uint32_t warm_up;           /* frames before, of methods with a mask */
    cJSON *files;
} comparison;

/* What answered the rays of a frame. */
static void note_tracing(const gn_app *app, const gn_visibility_stats *stats, side *s)
{
    s->tracing = (gn_app_tracing){0};
    for (uint32_t l = 0; l < app->light_count; l++)
        gn_app_add_stats(&s->tracing, &stats[l]);
    gn_app_add_tracing(&s->before, &s->tracing);
}

/* The frames of a view at rest, the last of which is shown. */
static bool render_frames(const comparison *c, gn_app *app, side *s, gn_visibility_stats *stats)
{
    /* The pseudo-method: the plain ray many times a pixel. */
    const gn_app_method yardstick = gn_app_yardstick();
    const gn_app_method *method = s->method->pseudo ? &yardstick : s->method;
    gn_view_set_stats(s->view, stats);
    /* A mask settles on a still view. */
    const uint32_t before = gn_app_has_mask(method) ? c->warm_up : 0;
    for (app->frame = 0; app->frame <= before; app->frame++) {
        const gn_visibility_desc visibility = gn_app_visibility_desc(app, method);
        if (method->no_reuse)
            gn_history_reset_maps(method->history);
        if (gn_view_render(s->view, app->scene, app->camera, &visibility, app->lights,
                           app->light_count) != GN_OK ||
            gn_app_interrupted())
            return false;
        const gn_timings timings = gn_view_timings(s->view);
        if (method->no_reuse)
            s->map_ms = 0;
        s->map_ms += timings.shadow_map + timings.filter;
        if (gn_app_has_rays(method))
            note_tracing(app, stats, s);
    }
    return true;
}

static bool render_side(const comparison *c, gn_app *app, side *s)
{
    const gn_view_desc desc = gn_app_view_desc(app, s->samples);
    gn_visibility_stats *stats = calloc(app->light_count, sizeof *stats);
    bool good = stats || gn_app_error(app, "out of memory");
    good = good && gn_view_create(app->device, &desc, &s->view) == GN_OK &&
           render_frames(c, app, s, stats);
    if (s->view)
        gn_view_set_stats(s->view, NULL);
    free(stats);
    return good;
}

/* Times the visibility stage of both, in turns, on one G-buffer. A supersampled side is timed as
 * it was rendered, once. */
static bool time_sides(comparison *c)
{
    gn_app *app = &c->app;
    const gn_gbuffer *g = gn_view_gbuffer(c->sides[0].view);
    float *planes = malloc((size_t)g->width * g->height * app->light_count * sizeof *planes);
    if (!planes)
        return gn_app_error(app, "out of memory");
    bool good = true;
    for (uint32_t run = 0; run < RUNS && good; run++) {
        app->frame = c->warm_up + 1 + run; /* of a view that stands still */
        gn_bar_step(&app->bar, 0.7 + 0.2 * run / RUNS, 0.2 / RUNS, "timing, %u of %d", run + 1,
                    RUNS);
        for (int k = 0; k < 2 && good; k++) {
            side *s = &c->sides[k];
            gn_app_cost cost;
            if (s->samples > 1)
                continue;
            good = gn_app_visibility(app, g, s->method, planes, &cost);
            s->ms[s->runs++] = cost.total;
            if (gn_app_has_rays(s->method))
                s->tracing = cost.tracing;
            s->rays = (double)cost.tracing.rays / ((double)g->width * g->height * app->light_count);
        }
    }
    for (int k = 0; k < 2; k++) {
        side *s = &c->sides[k];
        if (s->runs == 0)
            s->ms[s->runs++] = gn_view_timings(s->view).visibility;
        s->spread = gn_measure_spread(s->ms, s->runs);
    }
    c->ratio = c->sides[1].spread.median / c->sides[0].spread.median;
    free(planes);
    return good;
}

/* Where there is no surface there is no visibility to compare. */
static bool measure(comparison *c)
{
    gn_app *app = &c->app;
    const gn_gbuffer *g = gn_view_gbuffer(c->sides[0].view);
    const size_t pixels = (size_t)g->width * g->height;
    uint8_t *mask = malloc(pixels);
    c->differences = calloc(app->light_count, sizeof *c->differences);
    const bool good = (mask && c->differences) || gn_app_error(app, "out of memory");
    for (size_t i = 0; i < pixels && good; i++)
        mask[i] = g->surface[i] != GN_NONE;
    for (uint32_t l = 0; l < app->light_count && good; l++)
        c->differences[l] =
            gn_measure_difference(gn_view_visibility(c->sides[0].view, l),
                                  gn_view_visibility(c->sides[1].view, l), mask, pixels);
    free(mask);
    return good;
}

/* Pictures ---------------------------------------------------------------------------------- */

/* Where b lets more light through than a: orange; less: blue; on a dim grey picture. The largest
 * difference of any light counts. */
static void paint_difference(const comparison *c, const uint8_t *a, uint8_t *out)
{
    const size_t pixels = (size_t)c->app.options.size[0] * c->app.options.size[1];
    static const float more[3] = {255, 140, 20}, less[3] = {30, 120, 255};
    for (size_t i = 0; i < pixels; i++) {
        float most = 0;
        for (uint32_t l = 0; l < c->app.light_count; l++) {
            const float d = gn_view_visibility(c->sides[1].view, l)[i] -
                            gn_view_visibility(c->sides[0].view, l)[i];
            if (fabsf(d) > fabsf(most))
                most = d;
        }
        const float grey = 0.35f * (0.3f * a[3 * i] + 0.6f * a[3 * i + 1] + 0.1f * a[3 * i + 2]);
        const float *color = most > 0 ? more : less;
        const float share = fminf((float)c->gain * fabsf(most), 1);
        for (size_t k = 0; k < 3; k++)
            out[3 * i + k] = (uint8_t)(grey + (color[k] - grey) * share + 0.5f);
    }
}

static bool write_picture(comparison *c, const char *path, uint32_t width, const uint8_t *pixels,
                          const char *names, const gn_app_method *method)
{
    gn_app *app = &c->app;
    gn_settings settings;
    gn_settings_fill(&settings, app, names, 1, app->options.time);
    gn_settings_add_method(&settings, method);
    if (gn_write_png(app->device, path, width, app->options.size[1], 3, pixels, settings.attributes,
                     settings.count) != GN_OK)
        return false;
    cJSON_AddItemToArray(c->files, cJSON_CreateString(path));
    gn_app_finished(app, "%d pictures are written, and no numbers printed",
                    cJSON_GetArraySize(c->files));
    return true;
}

/* output: a folder, or the .png of the side by side alone. pictures: a, b, difference, side by
 * side (three times as wide). */
static bool write_pictures(comparison *c, const char *output, uint8_t *const pictures[4])
{
    gn_app *app = &c->app;
    const uint32_t width = app->options.size[0], height = app->options.size[1];
    const size_t row = (size_t)width * 3;
    const gn_app_method *a = c->sides[0].method, *b = c->sides[1].method;
    const gn_app_method *with_map = gn_app_has_map(a) ? a : b; /* whose settings are named */
    for (int k = 0; k < 2; k++)
        gn_encode_srgb(gn_view_image(c->sides[k].view), pictures[k], row * height);
    paint_difference(c, pictures[0], pictures[2]);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t k = 0; k < 3; k++)
            memcpy(pictures[3] + (3 * y + k) * row, pictures[k] + y * row, row);
    }
    char names[320], path[4096];
    snprintf(names, sizeof names, "%s, %s, difference", a->name, b->name);
    const size_t length = strlen(output);
    if (length > 4 && strcmp(output + length - 4, ".png") == 0)
        return write_picture(c, output, 3 * width, pictures[3], names, with_map);

    const struct {
        const char *file, *names;
        uint32_t width;
        const gn_app_method *method;
    } files[4] = {{"a", a->name, width, a},
                  {"b", b->name, width, b},
                  {"difference", names, width, with_map},
                  {"side-by-side", names, 3 * width, with_map}};
    bool good = gn_app_make_folder(app, output);
    for (int k = 0; k < 4 && good; k++) {
        if (snprintf(path, sizeof path, "%s/%s.png", output, files[k].file) >= (int)sizeof path)
            return gn_app_error(app, "%s: the name is too long", output);
        good = write_picture(c, path, files[k].width, pictures[k], files[k].names, files[k].method);
    }
    return good;
}

static bool paint_and_write(comparison *c, const char *output)
{
    gn_app *app = &c->app;
    const size_t bytes = (size_t)app->options.size[0] * app->options.size[1] * 3;
    uint8_t *pictures[4] = {0};
    bool good = true;
    for (int k = 0; k < 4 && good; k++) {
        pictures[k] = malloc(k == 3 ? bytes * 3 : bytes);
        good = pictures[k] || gn_app_error(app, "out of memory");
    }
    gn_bar_step(&app->bar, 0.9, 0.1, "writing %s", output);
    good = good && write_pictures(c, output, pictures);
    for (int k = 0; k < 4; k++)
        free(pictures[k]);
    return good;
}

/* Results ----------------------------------------------------------------------------------- */

static void print_tracing(const side *s)
{
    if (s->tracing.lights == 0)
        return;
    printf("   by %s", gn_app_answered(&s->tracing));
    if (s->tracing.buffered > 0)
        printf(": %u tiles of %.1f MB, and %.2f to build them, once", s->tracing.light_buffer.tiles,
               gn_app_megabytes(s->tracing.light_buffer.bytes), s->before.light_buffer.build_ms);
}

static void print_table(const comparison *c)
{
    const side *a = &c->sides[0], *b = &c->sides[1];
    printf("%-16s%12s%12s%12s%10s%10s\n", "light", "wrong", "mean abs", "mse", "psnr", "mean b-a");
    for (uint32_t l = 0; l < c->app.light_count; l++) {
        char number[32];
        const gn_difference *d = &c->differences[l];
        printf("%-16s%11.4f%%%12.6f%12.6f%10.2f%+10.4f\n",
               gn_app_light_name(&c->app, c->app.lights[l], number), d->wrong * 100, d->mean_abs,
               d->mse, gn_measure_psnr(d->mse, 1), d->mean_b - d->mean_a);
    }
    printf("\nvisibility, ms    median       min       max\n");
    for (int k = 0; k < 2; k++) {
        const gn_spread *s = &c->sides[k].spread;
        printf("%-14s%10.2f%10.2f%10.2f", c->sides[k].method->name, s->median, s->min, s->max);
        if (gn_app_has_map(c->sides[k].method))
            printf("   and %.2f to make its maps%s", c->sides[k].map_ms,
                   c->sides[k].method->no_reuse ? ", which is part of it" : ", once");
        if (c->sides[k].method->method.trace == GN_TRACE_LEAK)
            printf("; %.2f %% rays", c->sides[k].rays * 100);
        print_tracing(&c->sides[k]);
        printf("\n");
    }
    for (int k = 0; k < 2; k++) {
        char text[256];
        if (gn_app_fallback(&c->app, c->sides[k].method, &c->sides[k].tracing, text))
            printf("%s\n", text);
    }
    printf("%s takes %.3f times the time of %s\n", b->method->name, c->ratio, a->method->name);
}

static bool print_json(comparison *c)
{
    cJSON *json = gn_app_json(&c->app);
    for (int k = 0; k < 2; k++) {
        const side *s = &c->sides[k];
        cJSON *entry = cJSON_AddObjectToObject(json, k ? "b" : "a");
        cJSON_AddStringToObject(entry, "name", s->method->name);
        cJSON_AddNumberToObject(entry, "spp", s->samples);
        cJSON_AddNumberToObject(entry, "ms_median", s->spread.median);
        cJSON_AddNumberToObject(entry, "ms_min", s->spread.min);
        cJSON_AddNumberToObject(entry, "ms_max", s->spread.max);
        cJSON_AddNumberToObject(entry, "runs", s->runs);
        cJSON_AddNumberToObject(entry, "map_ms", s->map_ms);
        if (s->samples == 1)
            cJSON_AddNumberToObject(entry, "rays_per_pixel", s->rays);
        if (s->tracing.lights > 0) {
            gn_app_add_tracing_json(entry, &s->tracing);
            cJSON_AddNumberToObject(entry, "build_ms", s->before.light_buffer.build_ms);
            gn_app_add_fallback(entry, &c->app, s->method, &s->tracing);
        }
    }
    cJSON_AddNumberToObject(json, "time_ratio", c->ratio);
    cJSON *list = cJSON_AddArrayToObject(json, "differences");
    for (uint32_t l = 0; l < c->app.light_count; l++) {
        char number[32];
        const gn_difference *d = &c->differences[l];
        const double psnr = gn_measure_psnr(d->mse, 1);
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddStringToObject(entry, "light",
                                gn_app_light_name(&c->app, c->app.lights[l], number));
        cJSON_AddNumberToObject(entry, "wrong_pixels", d->wrong);
        cJSON_AddNumberToObject(entry, "mean_abs", d->mean_abs);
        cJSON_AddNumberToObject(entry, "mse", d->mse);
        cJSON_AddItemToObject(entry, "psnr",
                              isfinite(psnr) ? cJSON_CreateNumber(psnr) : cJSON_CreateNull());
        cJSON_AddNumberToObject(entry, "max_abs", d->max_abs);
        cJSON_AddNumberToObject(entry, "mean_a", d->mean_a);
        cJSON_AddNumberToObject(entry, "mean_b", d->mean_b);
        cJSON_AddItemToArray(list, entry);
    }
    cJSON_AddItemToObject(json, "files", c->files);
    c->files = NULL;
    return gn_app_print_json(&c->app, json);
}

static bool run(comparison *c, const gn_app_options *options, const char *scene, const char *output)
{
    gn_app *app = &c->app;
    bool good = gn_app_open(app, "compare", options) && gn_app_use_methods(app, c->methods, 2) &&
                gn_app_load(app, scene) && gn_app_choose(app);
    const uint32_t samples = c->sides[0].samples + c->sides[1].samples;
    double done = 0.1;
    for (int k = 0; k < 2 && good; k++) {
        const double share = 0.6 * c->sides[k].samples / samples;
        gn_bar_step(&app->bar, done, share, "%s", c->sides[k].method->name);
        good = render_side(c, app, &c->sides[k]);
        if (good)
            gn_app_finished(app, "%s %s rendered, and nothing is written",
                            k ? "both methods" : c->sides[k].method->name, k ? "are" : "is");
        done += share;
    }
    good = good && measure(c) && time_sides(c) && (!output || paint_and_write(c, output));
    gn_bar_clear(&app->bar);
    if (good && options->json)
        good = print_json(c);
    else if (good)
        print_table(c);
    return good && gn_app_flush(app);
}

int gn_app_compare(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--images") == 0)
            return gn_app_compare_images(argc, argv);
    }
    static const char *const words[] = {"SCENE", NULL};
    static const char *const notes[] = {
        "METHOD: a name in 'gnomon methods', or reference: ray-mip0 with 64 samples a pixel,",
        "camera jitter and all.",
        "OUT is a folder for a.png, b.png, difference.png and side-by-side.png, or a .png for the",
        "last of them. In the difference, orange is lighter in B and blue darker.",
        "Pixels that see no surface are left out. A pixel is wrong where visibility differs by",
        "more than 0.5. Times: the visibility stage, 5 runs in turns, on one G-buffer; maps and",
        "masks are kept from run to run as from frame to frame of a view at rest, maps unless",
        "--no-reuse is given, and light buffers.",
        "'gnomon compare --images REFERENCE TEST' compares two picture files; see its --help.",
        NULL};
    const gn_usage usage = {
        "compare",
        "two methods on one view: pictures, difference, numbers",
        "SCENE --a METHOD --b METHOD [-o OUT] [options]",
        words,
        notes,
        {"gnomon compare grove --a ray-mip0 --b ray-coverage -o comparison",
         "gnomon compare scene.glb --a reference --b ray-saturate --size 1280x720 --json"}};
    gn_app_options common = gn_app_options_default();
    const char *a = NULL, *b = NULL, *output = NULL, *scene;
    comparison c = {.gain = 1, .warm_up = GN_APP_WARM_UP};
    const gn_option options[] = {
        GN_TEXT("a", 'a', "METHOD", &a, "the method to compare with"),
        GN_TEXT("b", 'b', "METHOD", &b, "the method to compare"),
        GN_TEXT("output", 'o', "OUT", &output, "a folder, or a .png"),
        GN_REAL("gain", 'g', "X", &c.gain, 1, 1000, "factor of the difference picture, default 1"),
        GN_APP_SHOT_OPTIONS(common),
        GN_APP_TIME_OPTION(common),
        GN_COUNT("warm-up", 0, "N", &c.warm_up, 0, 1000,
                 "frames in which masks settle, the view at rest, default 8"),
        GN_APP_MAP_OPTIONS(common),
        GN_APP_LEAK_OPTIONS(common),
        GN_APP_TRACER_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END,
    };
    int code = gn_options_parse(&usage, options, argc, argv, &scene);
    if (code != GN_GO_ON)
        return code;
    if (!a || !b)
        return gn_usage_error("compare", "--%s METHOD is missing", a ? "b" : "a");

    c.files = cJSON_CreateArray();
    for (int k = 0; k < 2 && code == GN_GO_ON; k++) {
        const char *name = k ? b : a;
        if (strchr(name, ','))
            code = gn_usage_error("compare", "--%c takes one method", k ? 'b' : 'a');
        else if (!gn_app_parse_method("compare", name, pseudo_methods, &c.methods[k]))
            code = GN_EXIT_USAGE;
        c.sides[k].method = &c.methods[k];
        c.sides[k].samples = c.methods[k].pseudo ? REFERENCE_SAMPLES : 1;
    }
    if (code == GN_GO_ON)
        code = run(&c, &common, scene, output) ? GN_EXIT_OK : gn_app_fail(&c.app);
    for (int k = 0; k < 2; k++)
        gn_view_destroy(&c.sides[k].view);
    free(c.differences);
    cJSON_Delete(c.files);
    gn_app_release_methods(c.methods, 2);
    gn_app_close(&c.app);
    return code;
}
