/* gnomon bench --maps: shadow maps drawn by tiles, against ray packets through the same samples. */
#include "bench.h"
#include "method.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "measure/measure.h"
#include "render/device.h"

#define QUANTUM (1.0 / 65535.0)

typedef struct maps_options {
    const gn_method *method; /* whose map is made */
    gn_map_desc desc;
    uint32_t repeats;
} maps_options;

/* One layer, drawn and traced. */
typedef struct layer_row {
    float extent, range;       /* metres: half the width (a tangent in perspective); far - near */
    gn_spread raster, packets; /* milliseconds */
    double covered, different; /* shares of the samples: < 1; apart by more than a quantum */
} layer_row;

typedef struct maps_result {
    layer_row layers[GN_MAX_CASCADES];
    uint32_t count;
    gn_spread refresh, depth, filter; /* milliseconds: all layers placed anew, and its parts */
    size_t bytes;
} maps_result;

/* Measurement ----------------------------------------------------------------------------------*/

static void compare_depths(const float *drawn, const float *traced, size_t count, layer_row *row)
{
    size_t covered = 0, different = 0;
    for (size_t i = 0; i < count; i++) {
        covered += drawn[i] < 1.0f;
        different += fabs((double)drawn[i] - (double)traced[i]) > QUANTUM;
    }
    row->covered = (double)covered / (double)count;
    row->different = (double)different / (double)count;
}

static size_t sample_count(const maps_options *o)
{
    return (size_t)o->desc.resolution * o->desc.resolution * o->desc.samples;
}

/* Drawing and tracing take turns, so that both see the same machine; the first turn warms up. */
static bool measure_layer(gn_app *app, const maps_options *o, const gn_map_layer_info *layer,
                          float *depths, double *times, layer_row *row)
{
    const size_t count = sample_count(o);
    gn_depth_job job = {.scene = app->scene,
                        .projection = {.perspective = layer->perspective,
                                       .extent = layer->extent,
                                       .near = layer->near,
                                       .far = layer->far,
                                       .resolution = layer->resolution},
                        .casters = GN_CASTERS_ALL,
                        .alpha = o->desc.alpha,
                        .samples = o->desc.samples};
    for (int i = 0; i < 3; i++) {
        job.projection.origin[i] = layer->origin[i];
        job.projection.right[i] = layer->right[i];
        job.projection.up[i] = layer->up[i];
        job.projection.forward[i] = layer->forward[i];
    }
    *row = (layer_row){.extent = layer->extent, .range = layer->far - layer->near};
    for (uint32_t i = 0; i <= o->repeats; i++) {
        const uint32_t slot = i > 0 ? i - 1 : 0;
        const double start = gn_milliseconds();
        job.depth = depths;
        if (gn_cpu_depth(&app->device->cpu, &job) != GN_OK)
            return false;
        const double drawn = gn_milliseconds();
        job.depth = depths + count;
        if (gn_cpu_depth_rays(&app->device->cpu, &job) != GN_OK)
            return false;
        times[slot] = drawn - start;
        times[o->repeats + slot] = gn_milliseconds() - drawn;
        if (gn_app_interrupted())
            return gn_app_error(app, "interrupted");
    }
    row->raster = gn_measure_spread(times, o->repeats);
    row->packets = gn_measure_spread(times + o->repeats, o->repeats);
    compare_depths(depths, depths + count, count, row);
    return true;
}

/* Places, draws and filters all layers anew. */
static bool measure_refresh(gn_app *app, const maps_options *o, gn_shadow_map *map, double *times,
                            maps_result *result)
{
    const float aspect = (float)app->options.size[0] / (float)app->options.size[1];
    for (uint32_t i = 0; i <= o->repeats; i++) {
        const uint32_t slot = i > 0 ? i - 1 : 0;
        gn_map_update update = {0};
        gn_shadow_map_reset(map);
        const double start = gn_milliseconds();
        if (gn_shadow_map_update(map, app->scene, app->lights[0], app->camera, aspect, &update) !=
            GN_OK)
            return false;
        times[slot] = gn_milliseconds() - start;
        times[o->repeats + slot] = update.depth_ms;
        times[2 * o->repeats + slot] = update.filter_ms;
    }
    result->refresh = gn_measure_spread(times, o->repeats);
    result->depth = gn_measure_spread(times + o->repeats, o->repeats);
    result->filter = gn_measure_spread(times + 2 * o->repeats, o->repeats);
    result->bytes = gn_shadow_map_bytes(map);
    result->count = gn_shadow_map_layer_count(map);
    return true;
}

static bool measure_maps(gn_app *app, const maps_options *o, maps_result *result)
{
    const size_t count = sample_count(o);
    gn_shadow_map *map = NULL;
    float *depths = calloc(count, 2 * sizeof *depths);
    double *times = calloc(o->repeats, 3 * sizeof *times);
    bool good = depths && times;
    if (!good)
        gn_app_error(app, "no memory for maps of %u texels a side", o->desc.resolution);
    gn_bar_step(&app->bar, 0.1, 0.2, "all layers");
    good = good && gn_shadow_map_create(app->device, &o->method->map, &o->desc, &map) == GN_OK &&
           measure_refresh(app, o, map, times, result);
    for (uint32_t i = 0; good && i < result->count; i++) {
        gn_bar_step(&app->bar, 0.3 + 0.7 * i / result->count, 0.7 / result->count, "layers");
        const gn_map_layer_info layer = gn_shadow_map_layer(map, i);
        good = measure_layer(app, o, &layer, depths, times, &result->layers[i]);
    }
    gn_bar_clear(&app->bar);
    gn_shadow_map_destroy(&map);
    free(times);
    free(depths);
    return good;
}

/* Output ---------------------------------------------------------------------------------------*/

static void print_result(const gn_app *app, const maps_options *o, const maps_result *r)
{
    const gn_device_info info = gn_device_get_info(app->device);
    char camera[32], light[32];
    printf("%s, camera %s, light %s; layers of %u x %u texels, %u %s a texel, alpha %s; %u threads,"
           " %s; medians of %u\n\n",
           app->scene_name, gn_app_camera_name(app, camera),
           gn_app_light_name(app, app->lights[0], light), o->desc.resolution, o->desc.resolution,
           o->desc.samples, o->desc.samples == 1 ? "sample" : "samples",
           gn_app_map_alpha_names[o->desc.alpha], info.threads, info.isa_name, o->repeats);
    printf("%-8s%10s%10s%12s%12s%8s%12s%12s\n", "layer", "extent", "range", "raster ms",
           "packets ms", "ratio", "covered %", "different %");
    for (uint32_t i = 0; i < r->count; i++) {
        const layer_row *row = &r->layers[i];
        printf("%-8u%10.2f%10.2f%12.2f%12.2f%8.2f%12.2f%12.4f\n", i, (double)row->extent,
               (double)row->range, row->raster.median, row->packets.median,
               row->packets.median / row->raster.median, 100 * row->covered, 100 * row->different);
    }
    printf("\nAll %u layers of %s placed anew: %.1f ms (drawn %.1f, filtered %.1f), %.0f MB.\n",
           r->count, o->method->name, r->refresh.median, r->depth.median, r->filter.median,
           (double)r->bytes * 1e-6);
    printf("different: samples apart by more than 1/65535 of the range.\n");
}

static void add_layer(cJSON *item, const layer_row *row)
{
    cJSON_AddNumberToObject(item, "raster_ms", row->raster.median);
    cJSON_AddNumberToObject(item, "raster_ms_min", row->raster.min);
    cJSON_AddNumberToObject(item, "packets_ms", row->packets.median);
    cJSON_AddNumberToObject(item, "packets_ms_min", row->packets.min);
    cJSON_AddNumberToObject(item, "ratio", row->packets.median / row->raster.median);
    cJSON_AddNumberToObject(item, "covered", row->covered);
    cJSON_AddNumberToObject(item, "different", row->different);
}

static cJSON *result_json(const gn_app *app, const maps_options *o, const maps_result *r)
{
    cJSON *json = gn_app_json(app);
    cJSON_AddStringToObject(json, "method", o->method->name);
    cJSON_AddStringToObject(json, "alpha", gn_app_map_alpha_names[o->desc.alpha]);
    cJSON_AddNumberToObject(json, "map_size", o->desc.resolution);
    cJSON_AddNumberToObject(json, "samples", o->desc.samples);
    cJSON_AddNumberToObject(json, "repeats", o->repeats);
    cJSON_AddNumberToObject(json, "cascades_ms", r->refresh.median);
    cJSON_AddNumberToObject(json, "cascades_ms_min", r->refresh.min);
    cJSON_AddNumberToObject(json, "cascades_depth_ms", r->depth.median);
    cJSON_AddNumberToObject(json, "cascades_filter_ms", r->filter.median);
    cJSON_AddNumberToObject(json, "bytes", (double)r->bytes);
    /* The nearest layer once more: what comparisons are made of. */
    if (r->count > 0)
        add_layer(json, &r->layers[0]);
    cJSON *list = cJSON_AddArrayToObject(json, "layers");
    for (uint32_t i = 0; i < r->count; i++) {
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(list, item);
        cJSON_AddNumberToObject(item, "extent", (double)r->layers[i].extent);
        cJSON_AddNumberToObject(item, "range", (double)r->layers[i].range);
        add_layer(item, &r->layers[i]);
    }
    return json;
}

int gn_app_bench_maps(int argc, char **argv)
{
    static const char *const words[] = {"SCENE", NULL};
    static const char *const notes[] = {
        "The layers of one light (the first chosen) around the camera's view, each drawn and "
        "traced",
        "in turns, and the time to place, draw and filter them all anew. A sun has 3 cascades",
        "unless --cascades says otherwise.", NULL};
    const gn_usage usage = {"bench",
                            "time of drawing shadow maps, against ray packets",
                            "SCENE --maps [options]",
                            words,
                            notes,
                            {"gnomon bench grove --maps", "gnomon bench scene.glb --maps "
                                                          "--map-samples 4 --json > maps.json"}};
    gn_app_options common = gn_app_options_default();
    common.map.cascades = 3;
    maps_options maps = {.repeats = 5};
    const char *method = "nlmsm64";
    bool chosen = false;
    const gn_option options[] = {
        GN_FLAG("maps", 0, &chosen, "measure the drawing of shadow maps"),
        GN_TEXT("method", 'm', "NAME", &method, "whose map is made of the depths, default nlmsm64"),
        GN_COUNT("repeats", 'r', "N", &maps.repeats, 1, 1000, "turns of each, default 5"),
        GN_APP_PLACE_OPTIONS(common),
        GN_APP_SHOT_OPTIONS(common),
        GN_APP_TIME_OPTION(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END};
    const char *name;
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    if (code != GN_GO_ON)
        return code;
    maps.method = gn_method_find(method);
    if (!maps.method || maps.method->map.kind == GN_MAP_NONE ||
        !gn_map_has_texels(&maps.method->map))
        return gn_usage_error("bench", "--method %s: not a method with a filtered map", method);
    maps.desc = gn_app_map_desc(&common.map);
    gn_app app = {0};
    maps_result result = {0};
    app.wrong_usage = true; /* up to the check of the map's settings */
    bool good = gn_app_open(&app, "bench", &common) &&
                gn_app_accepts_map(&app, &maps.method->map, &maps.desc);
    app.wrong_usage = !good;
    good = good && gn_app_load(&app, name) && gn_app_choose(&app) &&
           measure_maps(&app, &maps, &result);
    if (good && common.json)
        good = gn_app_print_json(&app, result_json(&app, &maps, &result));
    else if (good) {
        print_result(&app, &maps, &result);
        good = gn_app_flush(&app);
    }
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_close(&app);
    return code;
}
