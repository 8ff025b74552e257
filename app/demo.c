/* gnomon demo: built-in scenes with the methods side by side, as pictures, a table and a page. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/measure.h"
#include "scene/scene.h"
#include "app.h"
#include "demo.h"
#include "picture.h"

/* ray-mip0 comes first: all others are compared with it. */
#define METHODS           "ray-mip0,rays,sm,pcf9,evsm,nlmsm64,lt-vsm"
#define RUNS              3
#define REFERENCE_SAMPLES 16
#define FRAMES            12
#define FPS               30.0

/* What is shown, and where the enlarged frame starts: a share of width and height. */
static const struct shown {
    const char *name, *camera;
    double spot[2];
} shown_scenes[] = {{"grove", "CamRoad", {0.21, 0.76}}, {"leafbox", "CamFront", {0.3, 0.88}}};

enum { SCENE_COUNT = sizeof shown_scenes / sizeof *shown_scenes };

/* What is known of one method on one scene. */
typedef struct entry {
    gn_app_method *method;
    double ms[RUNS];
    gn_spread spread;
    double map_ms;            /* making its maps, once */
    gn_app_tracing tracing;   /* of the last run */
    gn_difference difference; /* from the reference, first light */
    double flicker, toggles;  /* sums over frames, weighted by pixels */
    gn_flicker_state state;
} entry;

typedef struct show {
    gn_app app;
    const struct shown *shown;
    double before; /* share of the whole that is done when this scene begins */
    double start;  /* of the whole, as gn_bar.start */
    const char *folder;
    size_t pixels;
    gn_view *view;
    float *planes; /* one a light */
    gn_app_method methods[GN_APP_MAX_METHODS];
    entry entries[GN_APP_MAX_METHODS];
    uint32_t count;
    uint64_t flicker_pixels;
} show;

/* fraction: of this scene's part. */
#define STEP(s, fraction, share, ...)                                                              \
    gn_bar_step(&(s)->app.bar, (s)->before + (fraction) / (double)SCENE_COUNT,                     \
                (share) / (double)SCENE_COUNT, __VA_ARGS__)

/* method: NULL for the reference. */
static bool write_picture(show *s, const gn_view *view, const gn_app_method *method,
                          uint32_t samples, cJSON *methods)
{
    char file[128], path[4096];
    gn_settings settings;
    const char *name = method ? method->name : "reference";
    snprintf(file, sizeof file, "%s.%s.png", s->shown->name, name);
    if (snprintf(path, sizeof path, "%s/%s", s->folder, file) >= (int)sizeof path)
        return gn_app_error(&s->app, "%s: the name is too long", s->folder);
    gn_settings_fill(&settings, &s->app, name, samples, 0);
    if (method)
        gn_settings_add_method(&settings, method);
    if (!gn_write_shaded(&s->app, path, s->app.options.size[0], s->app.options.size[1],
                         gn_view_image(view), &settings))
        return false;
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "name", name);
    cJSON_AddStringToObject(item, "file", file);
    cJSON_AddItemToArray(methods, item);
    gn_app_finished(&s->app, "%s%d of %u pictures of %s are written, and no page",
                    s->before > 0 ? "the scenes before and " : "", cJSON_GetArraySize(methods),
                    s->count + 1, s->shown->name);
    return true;
}

/* map_ms: what it took to make maps is added. */
static bool render(show *s, gn_view *view, const gn_app_method *method, double *map_ms)
{
    gn_app *app = &s->app;
    /* A mask settles first, on a still view. */
    const uint32_t before = gn_app_has_mask(method) ? GN_APP_WARM_UP : 0;
    for (app->frame = 0; app->frame <= before; app->frame++) {
        const gn_visibility_desc desc = gn_app_visibility_desc(app, method);
        gn_view_reset_history(view);
        if (gn_view_render(view, app->scene, app->camera, &desc, app->lights, app->light_count) !=
                GN_OK ||
            gn_app_interrupted())
            return false;
        const gn_timings timings = gn_view_timings(view);
        *map_ms += timings.shadow_map + timings.filter;
    }
    return true;
}

/* One picture a method, and its distance from a supersampled one. */
static bool take_pictures(show *s, cJSON *methods)
{
    gn_app *app = &s->app;
    const gn_view_desc desc = gn_app_view_desc(app, REFERENCE_SAMPLES);
    const gn_app_method yardstick = gn_app_yardstick();
    gn_view *reference = NULL;
    STEP(s, 0.05, 0.35, "%s: reference", s->shown->name);
    double no_maps = 0;
    bool good = gn_view_create(app->device, &desc, &reference) == GN_OK &&
                render(s, reference, &yardstick, &no_maps);
    uint8_t *mask = malloc(s->pixels);
    if (good && !mask)
        good = gn_app_error(app, "out of memory");
    for (uint32_t i = 0; i < s->count && good; i++) {
        entry *e = &s->entries[i];
        STEP(s, 0.4 + 0.2 * i / s->count, 0, "%s: %s", s->shown->name, e->method->name);
        good = render(s, s->view, e->method, &e->map_ms) &&
               write_picture(s, s->view, e->method, 1, methods);
        if (!good)
            break;
        const gn_gbuffer *g = gn_view_gbuffer(s->view);
        for (size_t p = 0; p < s->pixels; p++)
            mask[p] = g->surface[p] != GN_NONE;
        e->difference = gn_measure_difference(gn_view_visibility(reference, 0),
                                              gn_view_visibility(s->view, 0), mask, s->pixels);
    }
    good = good && write_picture(s, reference, NULL, REFERENCE_SAMPLES, methods);
    free(mask);
    gn_view_destroy(&reference);
    return good;
}

static bool take_times(show *s)
{
    for (uint32_t run = 0; run < RUNS; run++) {
        s->app.frame = run + GN_APP_WARM_UP + 1;
        STEP(s, 0.6 + 0.1 * run / RUNS, 0, "%s: timing", s->shown->name);
        for (uint32_t i = 0; i < s->count; i++) {
            entry *e = &s->entries[i];
            gn_app_cost cost;
            if (!gn_app_visibility(&s->app, gn_view_gbuffer(s->view), e->method, s->planes, &cost))
                return false;
            e->ms[run] = cost.total;
            e->tracing = cost.tracing;
        }
    }
    for (uint32_t i = 0; i < s->count; i++)
        s->entries[i].spread = gn_measure_spread(s->entries[i].ms, RUNS);
    return true;
}

/* The first camera that moves, or GN_NONE. */
static uint32_t find_moving_camera(const gn_scene *scene)
{
    for (uint32_t c = 0; c < scene->camera_count; c++) {
        const uint32_t node = scene->cameras[c].node;
        if (node != GN_NONE && scene->nodes[node].animated)
            return c;
    }
    return GN_NONE;
}

/* Change of visibility from frame to frame of a moving camera; all methods see the same frames. */
static bool take_flicker(show *s)
{
    gn_app *app = &s->app;
    const uint32_t camera = find_moving_camera(app->scene);
    if (camera == GN_NONE)
        return true;
    app->camera = camera;
    gn_view_reset_history(s->view);
    for (uint32_t i = 0; i < s->count; i++)
        if (s->methods[i].history)
            gn_history_reset(s->methods[i].history);
    for (uint32_t f = 0; f < FRAMES; f++) {
        app->frame = f;
        STEP(s, 0.7 + 0.3 * f / FRAMES, 0, "%s: flicker, frame %u of %d", s->shown->name, f + 1,
             FRAMES);
        if (!gn_app_set_time(app, f / FPS) ||
            gn_view_trace_gbuffer(s->view, app->scene, camera) != GN_OK)
            return false;
        uint64_t compared = 0;
        for (uint32_t i = 0; i < s->count; i++) {
            entry *e = &s->entries[i];
            const gn_gbuffer *g = gn_view_gbuffer(s->view);
            if (!gn_app_visibility(app, g, e->method, s->planes, NULL))
                return false;
            const gn_flicker flicker = gn_measure_flicker(&e->state, g, s->planes);
            compared = flicker.pixels;
            e->flicker += flicker.flicker * (double)compared;
            e->toggles += flicker.toggles * (double)compared;
        }
        s->flicker_pixels += compared;
    }
    return true;
}

/* value / base, or null where there is nothing to divide by. */
static void add_ratio(cJSON *json, const char *key, double value, double base)
{
    cJSON_AddItemToObject(json, key,
                          base > 0 ? cJSON_CreateNumber(value / base) : cJSON_CreateNull());
}

static void report_methods(const show *s, cJSON *methods)
{
    const entry *base = &s->entries[0]; /* ray-mip0 */
    for (uint32_t i = 0; i < s->count; i++) {
        const entry *e = &s->entries[i];
        cJSON *item = cJSON_GetArrayItem(methods, (int)i);
        cJSON_AddNumberToObject(item, "ms_median", e->spread.median);
        cJSON_AddNumberToObject(item, "ms_min", e->spread.min);
        cJSON_AddNumberToObject(item, "ms_max", e->spread.max);
        if (gn_app_has_map(e->method))
            cJSON_AddNumberToObject(item, "map_ms", e->map_ms);
        if (gn_app_has_rays(e->method))
            cJSON_AddStringToObject(item, "tracer", gn_app_answered(&e->tracing));
        add_ratio(item, "rays_per_second", (double)e->tracing.rays,
                  e->tracing.rays > 0 ? e->spread.median * 1e-3 : 0);
        cJSON_AddNumberToObject(item, "mse", e->difference.mse);
        cJSON_AddNumberToObject(item, "wrong_pixels", e->difference.wrong);
        cJSON_AddNumberToObject(item, "mean_visibility", e->difference.mean_b);
        add_ratio(item, "flicker", e->flicker, (double)s->flicker_pixels);
        add_ratio(item, "toggles", e->toggles, (double)s->flicker_pixels);
        add_ratio(item, "flicker_ratio", e->flicker, base->flicker);
        add_ratio(item, "toggles_ratio", e->toggles, base->toggles);
    }
    cJSON *reference = cJSON_GetArrayItem(methods, (int)s->count);
    if (reference)
        cJSON_AddNumberToObject(reference, "mean_visibility", base->difference.mean_a);
}

/* Everything about one scene, added to results. */
static bool show_scene(show *s, cJSON *scenes, const gn_app_options *options)
{
    gn_app *app = &s->app;
    gn_app_options chosen = *options;
    chosen.camera = s->shown->camera;
    s->count = gn_app_parse_methods("demo", METHODS, NULL, s->methods);
    if (s->count == 0)
        return gn_app_error(app, "the methods of the demonstration are not there");
    for (uint32_t i = 0; i < s->count; i++)
        s->entries[i].method = &s->methods[i];
    s->pixels = (size_t)options->size[0] * options->size[1];
    if (!gn_app_open(app, "demo", &chosen) || !gn_app_use_methods(app, s->methods, s->count))
        return false;
    app->bar.start = s->start;
    STEP(s, 0.0, 0.05, "making %s", s->shown->name);
    if (!gn_app_load(app, s->shown->name) || !gn_app_choose(app))
        return false;
    const gn_view_desc desc = gn_app_view_desc(app, 1);
    s->planes = malloc(s->pixels * app->light_count * sizeof *s->planes);
    if (!s->planes)
        return gn_app_error(app, "out of memory");
    if (gn_view_create(app->device, &desc, &s->view) != GN_OK)
        return false;

    cJSON *scene = cJSON_CreateObject();
    cJSON_AddItemToArray(scenes, scene);
    cJSON_AddStringToObject(scene, "name", s->shown->name);
    for (const gn_procedural *p = gn_procedurals; p->name; p++) {
        if (strcmp(p->name, s->shown->name) == 0)
            cJSON_AddStringToObject(scene, "description", p->description);
    }
    char text[32];
    cJSON_AddStringToObject(scene, "camera", gn_app_camera_name(app, text));
    cJSON *lights = cJSON_AddArrayToObject(scene, "lights");
    for (uint32_t l = 0; l < app->light_count; l++)
        cJSON_AddItemToArray(lights,
                             cJSON_CreateString(gn_app_light_name(app, app->lights[l], text)));
    cJSON_AddNumberToObject(scene, "width", options->size[0]);
    cJSON_AddNumberToObject(scene, "height", options->size[1]);
    cJSON_AddNumberToObject(scene, "instanced_triangles", (double)app->info.instanced_triangles);
    cJSON_AddItemToObject(scene, "spot", cJSON_CreateDoubleArray(s->shown->spot, 2));
    cJSON *methods = cJSON_AddArrayToObject(scene, "methods");
    if (!take_pictures(s, methods) || !take_times(s) || !take_flicker(s))
        return false;
    report_methods(s, methods);
    return true;
}

static double number(const cJSON *item, const char *key)
{
    const cJSON *value = cJSON_GetObjectItem(item, key);
    return cJSON_IsNumber(value) ? value->valuedouble : -1;
}

static void print_known(double value, const char *format, int width)
{
    if (value < 0)
        printf("%*s", width, "-");
    else
        printf(format, value);
}

static void print_table(const cJSON *results)
{
    const cJSON *scene, *method;
    cJSON_ArrayForEach(scene, cJSON_GetObjectItem(results, "scenes"))
    {
        printf("%s\n  %-14s%14s%10s%10s%12s%12s%12s%10s%10s\n",
               cJSON_GetStringValue(cJSON_GetObjectItem(scene, "name")), "method", "tracer", "ms",
               "maps, ms", "Mrays/s", "mse", "mean", "flicker", "toggles");
        cJSON_ArrayForEach(method, cJSON_GetObjectItem(scene, "methods"))
        {
            const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(method, "name"));
            if (!cJSON_GetObjectItem(method, "mse")) {
                printf("  %-14s%14s%10s%10s%12s%12s%12.4f\n", name, "", "", "", "", "",
                       number(method, "mean_visibility"));
                continue;
            }
            const char *tracer = cJSON_GetStringValue(cJSON_GetObjectItem(method, "tracer"));
            printf("  %-14s%14s%10.1f", name, tracer ? tracer : "-", number(method, "ms_median"));
            print_known(number(method, "map_ms"), "%10.1f", 10);
            print_known(number(method, "rays_per_second") * 1e-6, "%12.2f", 12);
            printf("%12.5f%12.4f%10.3f%10.3f\n", number(method, "mse"),
                   number(method, "mean_visibility"), number(method, "flicker_ratio"),
                   number(method, "toggles_ratio"));
        }
    }
    printf(
        "flicker and toggles are ratios to ray-mip0; mse is against %d samples a pixel; maps are\n"
        "made once, and kept\n",
        REFERENCE_SAMPLES);
}

static void release(show *s)
{
    for (uint32_t i = 0; i < s->count; i++)
        gn_flicker_state_free(&s->entries[i].state);
    gn_view_destroy(&s->view);
    free(s->planes);
    gn_app_release_methods(s->methods, s->count);
    gn_app_close(&s->app);
}

static int run(const gn_app_options *options, const char *folder, const char *command_line)
{
    cJSON *scenes = cJSON_CreateArray(), *results = NULL;
    int code = GN_EXIT_OK;
    const double start = gn_milliseconds();
    for (size_t i = 0; i < SCENE_COUNT && code == GN_EXIT_OK; i++) {
        const bool last = i + 1 == SCENE_COUNT;
        show *s = calloc(1, sizeof *s);
        if (!s) {
            gn_app app = {.command = "demo"};
            gn_app_error(&app, "out of memory");
            code = gn_app_fail(&app);
            break;
        }
        s->shown = &shown_scenes[i];
        s->before = (double)i / SCENE_COUNT;
        s->start = start;
        s->folder = folder;
        s->app.command = "demo";
        bool good = gn_app_make_folder(&s->app, folder) && show_scene(s, scenes, options);
        if (good && last) {
            s->app.scene_name = NULL;
            s->app.light_count = 0;
            results = gn_app_json(&s->app);
            cJSON_AddStringToObject(results, "command_line", command_line);
            cJSON_AddNumberToObject(results, "reference_spp", REFERENCE_SAMPLES);
            cJSON_AddNumberToObject(results, "runs", RUNS);
            cJSON_AddNumberToObject(results, "frames", FRAMES);
            cJSON_AddItemToObject(results, "scenes", scenes);
            scenes = NULL;
            good = gn_demo_write_page(&s->app, folder, results);
            gn_bar_clear(&s->app.bar);
            if (good && !options->json) {
                print_table(results);
                printf("pictures and page: %s/index.html\n", folder);
                good = gn_app_flush(&s->app);
            } else if (good) {
                good = gn_app_print_json(&s->app, results);
                results = NULL;
            }
        }
        if (!good)
            code = gn_app_fail(&s->app);
        release(s);
        free(s);
    }
    cJSON_Delete(scenes);
    cJSON_Delete(results);
    return code;
}

int gn_app_demo(int argc, char **argv)
{
    static const char *const words[] = {NULL};
    const gn_usage usage = {"demo",
                            "built-in scenes with the methods side by side, as pictures and a page",
                            "-o FOLDER [options]",
                            words,
                            NULL,
                            {"gnomon demo -o demo", "gnomon demo -o small --size 640x360 --json"}};
    gn_app_options common = gn_app_options_default();
    common.size[0] = 1280;
    common.size[1] = 720;
    const char *folder = NULL;
    const gn_option options[] = {
        GN_TEXT("output", 'o', "FOLDER", &folder, "where pictures and index.html go"),
        GN_SIZE("size", 's', common.size, "pixels, default 1280x720"),
        GN_APP_SCENE_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END,
    };
    const char *unused;
    const int code = gn_options_parse(&usage, options, argc, argv, &unused);
    if (code != GN_GO_ON)
        return code;
    if (!folder)
        return gn_usage_error("demo", "-o FOLDER is missing");
    char command_line[1024] = "gnomon";
    size_t used = strlen(command_line);
    for (int i = 0; i < argc && used < sizeof command_line; i++)
        used += (size_t)snprintf(command_line + used, sizeof command_line - used, " %s", argv[i]);
    return run(&common, folder, command_line);
}
