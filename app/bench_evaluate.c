/* gnomon bench --evaluate: the reading of shadow maps, nanoseconds a pixel. */
#include "bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cpu/map.h"
#include "measure/measure.h"
#include "render/device.h"
#include "render/shadow_map.h"

#define YARDSTICK "pcf9" /* the dear one, that others are held against */

static const uint32_t cascades[] = {1, 3};
enum { SIZES = 3, CASCADES = 2 };

typedef struct evaluate_row {
    const char *name;
    gn_spread ns[CASCADES][SIZES], yardstick[CASCADES][SIZES]; /* a pixel of the picture */
} evaluate_row;

typedef struct evaluation {
    gn_app *app;
    uint32_t repeats;
    gn_app_method *methods;
    uint32_t count;
    uint32_t sizes[SIZES][2], size_count;
    evaluate_row rows[GN_APP_MAX_METHODS];
    double
        read[SIZES]; /* share of the pixels that read the map: the others face away, or are sky */
    gn_view *views[SIZES];
    float *visibility, *layer;
    double *times;
} evaluation;

static size_t pixels_of(const evaluation *e, uint32_t size)
{
    return (size_t)e->sizes[size][0] * e->sizes[size][1];
}

static bool make_map(evaluation *e, const gn_map_format *format, const gn_map_desc *settings,
                     uint32_t count, gn_shadow_map **map)
{
    gn_app *app = e->app;
    gn_map_desc desc = *settings;
    desc.cascades = count;
    return gn_shadow_map_create(app->device, format, &desc, map) == GN_OK &&
           gn_shadow_map_update(*map, app->scene, app->lights[0], app->camera,
                                (float)e->sizes[0][0] / (float)e->sizes[0][1], NULL) == GN_OK;
}

static bool read_map(evaluation *e, const gn_shadow_map *map, uint32_t size, float *layer,
                     double *nanoseconds)
{
    gn_map_job job = {.gbuffer = gn_view_gbuffer(e->views[size]),
                      .light = e->app->scene->lights[e->app->lights[0]],
                      .visibility = e->visibility,
                      .layer = layer};
    gn_shadow_map_fill_job(map, &job);
    const double start = gn_milliseconds();
    const bool good = gn_cpu_map_visibility(&e->app->device->cpu, &job) == GN_OK;
    *nanoseconds = (gn_milliseconds() - start) * 1e6 / (double)pixels_of(e, size);
    return good;
}

/* The map and the yardstick take turns; the first turn warms up. */
static bool measure(evaluation *e, const gn_shadow_map *map, const gn_shadow_map *yardstick,
                    evaluate_row *row, int c)
{
    for (uint32_t size = 0; size < e->size_count; size++) {
        for (uint32_t i = 0; i <= e->repeats; i++) {
            double *slot = &e->times[i > 0 ? i - 1 : 0];
            if (!read_map(e, map, size, NULL, slot) ||
                !read_map(e, yardstick, size, NULL, slot + e->repeats))
                return false;
            if (gn_app_interrupted())
                return gn_app_error(e->app, "interrupted");
        }
        row->ns[c][size] = gn_measure_spread(e->times, e->repeats);
        row->yardstick[c][size] = gn_measure_spread(e->times + e->repeats, e->repeats);
    }
    return true;
}

/* How many pixels read anything at all. */
static bool count_read(evaluation *e, const gn_shadow_map *map)
{
    double time;
    for (uint32_t size = 0; size < e->size_count; size++) {
        if (!read_map(e, map, size, e->layer, &time))
            return false;
        size_t read = 0;
        for (size_t i = 0; i < pixels_of(e, size); i++)
            read += e->layer[i] >= 0.0f;
        e->read[size] = (double)read / (double)pixels_of(e, size);
    }
    return true;
}

static bool measure_cascades(evaluation *e, int c)
{
    gn_shadow_map *yardstick = NULL, *map = NULL;
    bool good =
        make_map(e, &gn_method_find(YARDSTICK)->map, &e->app->map, cascades[c], &yardstick) &&
        (c > 0 || count_read(e, yardstick));
    for (uint32_t m = 0; good && m < e->count; m++) {
        gn_bar_step(&e->app->bar, ((double)m / e->count + c) / CASCADES, 0.5 / e->count, "%s",
                    e->methods[m].name);
        e->rows[m].name = e->methods[m].name;
        good = make_map(e, &e->methods[m].method.map, &e->methods[m].map, cascades[c], &map) &&
               measure(e, map, yardstick, &e->rows[m], c);
        gn_shadow_map_destroy(&map);
    }
    gn_shadow_map_destroy(&yardstick);
    return good;
}

static bool make_views(evaluation *e)
{
    for (uint32_t size = 0; size < e->size_count; size++) {
        gn_view_desc desc = gn_app_view_desc(e->app, 1);
        desc.width = e->sizes[size][0];
        desc.height = e->sizes[size][1];
        if (gn_view_create(e->app->device, &desc, &e->views[size]) != GN_OK ||
            gn_view_trace_gbuffer(e->views[size], e->app->scene, e->app->camera) != GN_OK)
            return false;
    }
    return true;
}

static bool evaluate(evaluation *e)
{
    gn_app *app = e->app;
    if (app->scene->lights[app->lights[0]].desc.type != GN_LIGHT_DIRECTIONAL)
        return gn_app_error(app, "--evaluate is about cascades: the light must be a sun");
    e->visibility = calloc(pixels_of(e, e->size_count - 1), sizeof *e->visibility);
    e->layer = calloc(pixels_of(e, e->size_count - 1), sizeof *e->layer);
    e->times = calloc(e->repeats, 2 * sizeof *e->times);
    bool good = e->visibility && e->layer && e->times;
    if (!good)
        gn_app_error(app, "out of memory");
    good = good && make_views(e);
    for (int c = 0; good && c < CASCADES; c++)
        good = measure_cascades(e, c);
    gn_bar_clear(&app->bar);
    for (uint32_t size = 0; size < e->size_count; size++)
        gn_view_destroy(&e->views[size]);
    free(e->visibility);
    free(e->layer);
    free(e->times);
    return good;
}

/* Output ---------------------------------------------------------------------------------------*/

static void print_rows(const evaluation *e)
{
    const gn_device_info info = gn_device_get_info(e->app->device);
    char camera[32], light[32];
    printf("%s, camera %s, light %s; layers of %u x %u texels; %u threads, %s; medians of %u\n",
           e->app->scene_name, gn_app_camera_name(e->app, camera),
           gn_app_light_name(e->app, e->app->lights[0], light), e->app->map.resolution,
           e->app->map.resolution, info.threads, info.isa_name, e->repeats);
    for (int c = 0; c < CASCADES; c++) {
        printf("\n%-16s", cascades[c] == 1 ? "one map" : "three cascades");
        for (uint32_t size = 0; size < e->size_count; size++) {
            char text[32];
            snprintf(text, sizeof text, "%u x %u", e->sizes[size][0], e->sizes[size][1]);
            printf("%14s%10s", text, "/ " YARDSTICK);
        }
        printf("\n");
        for (uint32_t m = 0; m < e->count; m++) {
            printf("%-16s", e->rows[m].name);
            for (uint32_t size = 0; size < e->size_count; size++)
                printf("%14.2f%10.3f", e->rows[m].ns[c][size].median,
                       e->rows[m].ns[c][size].median / e->rows[m].yardstick[c][size].median);
            printf("\n");
        }
    }
    printf("\nNanoseconds a pixel of the picture, of which %.1f %% read the map, and the share of "
           "what " YARDSTICK " takes in the same turns.\n",
           100 * e->read[e->size_count / 2]);
}

static cJSON *rows_json(const evaluation *e)
{
    cJSON *json = gn_app_json(e->app);
    cJSON_AddNumberToObject(json, "map_size", e->app->map.resolution);
    cJSON_AddNumberToObject(json, "repeats", e->repeats);
    cJSON *list = cJSON_AddArrayToObject(json, "evaluate");
    for (uint32_t m = 0; m < e->count; m++)
        for (int c = 0; c < CASCADES; c++)
            for (uint32_t size = 0; size < e->size_count; size++) {
                const evaluate_row *row = &e->rows[m];
                cJSON *item = cJSON_CreateObject();
                cJSON_AddItemToArray(list, item);
                cJSON_AddStringToObject(item, "name", row->name);
                cJSON_AddNumberToObject(item, "cascades", cascades[c]);
                cJSON_AddNumberToObject(item, "width", e->sizes[size][0]);
                cJSON_AddNumberToObject(item, "height", e->sizes[size][1]);
                cJSON_AddNumberToObject(item, "read", e->read[size]);
                cJSON_AddNumberToObject(item, "ns_median", row->ns[c][size].median);
                cJSON_AddNumberToObject(item, "ns_min", row->ns[c][size].min);
                cJSON_AddNumberToObject(item, "ns_max", row->ns[c][size].max);
                cJSON_AddNumberToObject(item, "ns_" YARDSTICK, row->yardstick[c][size].median);
                cJSON_AddNumberToObject(item, "ratio_" YARDSTICK,
                                        row->ns[c][size].median / row->yardstick[c][size].median);
            }
    return json;
}

int gn_app_bench_evaluate(int argc, char **argv)
{
    static const char *const words[] = {"SCENE", NULL};
    static const char *const notes[] = {
        "The maps of a sun, one and three cascades, are made once and read for pictures of --size,",
        "or else of 1280x720, 1920x1080 and 3840x2160 pixels, in turns with " YARDSTICK ".", NULL};
    const gn_usage usage = {"bench",
                            "time of reading shadow maps, a pixel",
                            "SCENE --evaluate [options]",
                            words,
                            notes,
                            {"gnomon bench grove --evaluate",
                             "gnomon bench scene.glb --evaluate --methods vsm,nlmsm64 --json > "
                             "evaluate.json"}};
    static const uint32_t usual[SIZES][2] = {{1280, 720}, {1920, 1080}, {3840, 2160}};
    gn_app_options common = gn_app_options_default();
    memset(common.size, 0, sizeof common.size); /* not given */
    evaluation *e = calloc(1, sizeof *e);
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    const char *list = "maps", *name;
    uint32_t repeats = 7;
    bool chosen = false;
    const gn_option options[] = {
        GN_FLAG("evaluate", 0, &chosen, "measure the reading of shadow maps"),
        GN_TEXT("methods", 'm', "A,B,...", &list, "methods with a map; default: all of them"),
        GN_COUNT("repeats", 'r', "N", &repeats, 1, 1000, "turns of each, default 7"),
        GN_APP_SHOT_OPTIONS(common),
        GN_APP_TIME_OPTION(common),
        GN_APP_MAP_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END};
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    const uint32_t count =
        code == GN_GO_ON ? gn_app_parse_methods("bench", list, NULL, methods) : 0;
    for (uint32_t m = 0; m < count && code == GN_GO_ON; m++)
        if (!gn_app_has_map(&methods[m]))
            code = gn_usage_error("bench", "--methods: %s has no map to read", methods[m].name);
        else if (methods[m].method.trace != GN_TRACE_NONE)
            code = gn_usage_error("bench", "--methods: %s traces rays; maps alone are read here",
                                  methods[m].name);
    if (code != GN_GO_ON || count == 0) {
        free(e);
        return code != GN_GO_ON ? code : GN_EXIT_USAGE;
    }
    const bool given = common.size[0] > 0;
    if (!given)
        memcpy(common.size, usual[1], sizeof common.size);
    gn_app app = {0};
    bool good = gn_app_open(&app, "bench", &common) && gn_app_use_methods(&app, methods, count) &&
                gn_app_load(&app, name) && gn_app_choose(&app);
    if (good && !e)
        good = gn_app_error(&app, "out of memory");
    if (good) {
        e->app = &app;
        e->repeats = repeats;
        e->methods = methods;
        e->count = count;
        e->size_count = given ? 1 : SIZES;
        memcpy(e->sizes, given ? common.size : usual[0], e->size_count * sizeof *e->sizes);
        good = evaluate(e);
    }
    if (good && common.json)
        good = gn_app_print_json(&app, rows_json(e));
    else if (good) {
        print_rows(e);
        good = gn_app_flush(&app);
    }
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_release_methods(methods, count);
    gn_app_close(&app);
    free(e);
    return code;
}
