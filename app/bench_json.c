/* gnomon bench: its results as JSON. */
#include <math.h>
#include <stdio.h>

#include "bench.h"

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

/* Hardware counters, those that there are. */
static void add_counters(cJSON *json, const gn_bench_row *row)
{
    cJSON *counters = NULL;
    for (int i = 0; i < GN_COUNTER_COUNT; i++) {
        if (!isfinite(row->counts[i]))
            continue;
        if (!counters)
            counters = cJSON_AddObjectToObject(json, "counters");
        cJSON_AddNumberToObject(counters, gn_counter_names[i], row->counts[i]);
    }
}

static void add_method(cJSON *methods, const gn_app *app, const gn_bench_result *result,
                       const gn_bench_row *row, double pixels)
{
    const gn_bench_row *rival = gn_bench_rival(result);
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
        add_counters(json, row);
        if (row->map_layers > 0) {
            cJSON *map = cJSON_AddObjectToObject(json, "map");
            cJSON_AddNumberToObject(map, "layers", row->map_layers);
            cJSON_AddNumberToObject(map, "fits", row->map_fits);
            cJSON_AddNumberToObject(map, "pending", row->map_pending);
            cJSON_AddNumberToObject(map, "bytes", (double)row->map_bytes);
            cJSON_AddNumberToObject(map, "ns_per_pixel", gn_bench_ns_per_pixel(row, pixels));
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
                gn_bench_ratio(row->visibility.spread.median, rival->visibility.spread.median));
    }
    if (row->steady) {
        cJSON_AddNumberToObject(json, "flicker", row->flicker);
        cJSON_AddNumberToObject(json, "toggles", row->toggles);
        if (rival) {
            cJSON_AddNumberToObject(json, "flicker_ratio",
                                    gn_bench_ratio(row->flicker, rival->flicker));
            cJSON_AddNumberToObject(json, "toggles_ratio",
                                    gn_bench_ratio(row->toggles, rival->toggles));
        }
    }
    if (result->residual && row->timed) {
        cJSON_AddNumberToObject(json, "residual_flicker", row->residual_flicker);
        cJSON_AddNumberToObject(json, "residual_toggles", row->residual_toggles);
        if (rival) {
            cJSON_AddNumberToObject(json, "residual_flicker_ratio",
                                    gn_bench_ratio(row->residual_flicker, rival->residual_flicker));
            cJSON_AddNumberToObject(json, "residual_toggles_ratio",
                                    gn_bench_ratio(row->residual_toggles, rival->residual_toggles));
        }
    }
    if (result->referenced) {
        if (row->timed) {
            cJSON_AddNumberToObject(json, "mse", row->mse);
            if (rival)
                cJSON_AddNumberToObject(json, "mse_ratio", gn_bench_ratio(row->mse, rival->mse));
        }
        cJSON_AddNumberToObject(json, "mean_visibility", row->mean);
    }
}

cJSON *gn_bench_json(const gn_app *app, const gn_bench_options *o, const gn_bench_result *result)
{
    const double pixels = (double)app->options.size[0] * app->options.size[1];
    cJSON *json = gn_app_json(app);
    cJSON_AddNumberToObject(json, "frames", o->frames);
    cJSON_AddNumberToObject(json, "fps", o->fps);
    cJSON_AddNumberToObject(json, "time", o->start);
    cJSON_AddNumberToObject(json, "warm_up", o->warm_up);
    cJSON_AddNumberToObject(json, "repeats", result->repeats);
    cJSON_AddNumberToObject(json, "instanced_triangles", (double)app->info.instanced_triangles);
    cJSON_AddNumberToObject(json, "rays", (double)result->rays);
    add_spread(json, "update_ms", result->update);
    if (result->referenced) {
        cJSON *reference = cJSON_AddObjectToObject(json, "reference");
        cJSON_AddNumberToObject(reference, "samples", o->reference);
        cJSON_AddNumberToObject(reference, "frames", result->referenced);
        cJSON_AddNumberToObject(reference, "mean_visibility", result->reference_mean);
    }
    char busy[256];
    cJSON_AddBoolToObject(json, "busy", gn_bench_busy(result, busy));
    cJSON_AddNumberToObject(json, "other_load", result->others); /* NaN is written as null */
    if (!o->machine->counts)
        cJSON_AddStringToObject(json, "no_counters", o->machine->reason);
    cJSON *methods = cJSON_AddArrayToObject(json, "methods");
    for (uint32_t i = 0; i < result->count; i++)
        add_method(methods, app, result, &result->rows[i], pixels);
    return json;
}
