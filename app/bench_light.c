/* gnomon bench: what answered the rays, as text and as JSON. */
#include "bench.h"

#include <stdio.h>

static bool has_light_buffer(const gn_bench_row *row)
{
    return row->tracing.buffered > 0 || row->tracing.light_buffer.refused > 0;
}

/* Numbers that are the same for every way of telling. */
typedef struct summary {
    const gn_light_buffer_info *last;            /* frame */
    double built, refused, triangles, tree_rays; /* a frame, mean */
    double tree_share;                           /* of all rays */
} summary;

static summary summarise(const gn_bench_result *result, const gn_bench_row *row)
{
    const gn_light_buffer_info *sum = &row->tracing.light_buffer;
    const double frames = result->frame_count, rays = (double)row->tracing.rays;
    return (summary){.last = &row->frames[result->frame_count - 1].cost.tracing.light_buffer,
                     .built = sum->built / frames,
                     .refused = sum->refused / frames,
                     .triangles = (double)sum->triangles / frames,
                     .tree_rays = (double)sum->tree_rays / frames,
                     .tree_share = rays > 0 ? (double)sum->tree_rays / rays : 0};
}

void gn_bench_print_tracing(const gn_app *app, const gn_bench_result *result, int width)
{
    bool any_rays = false, any = false;
    for (uint32_t i = 0; i < result->count; i++) {
        any_rays = any_rays || result->rows[i].tracing.lights > 0;
        any = any || has_light_buffer(&result->rows[i]);
    }
    if (any)
        printf("\n%-*s%14s%7s%8s%9s%8s%10s%8s%8s%8s%10s%8s%8s\n", width, "rays, a frame", "tracer",
               "tiles", "built", "refused", "k tris", "k entries", "MB", "B/entry", "tree %",
               "build ms", "max", "before");
    for (uint32_t i = 0; i < result->count && any; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (row->tracing.lights == 0)
            continue;
        printf("%-*s%14s", width, row->name, gn_app_answered(&row->tracing));
        if (!has_light_buffer(row)) {
            printf("\n");
            continue;
        }
        const summary s = summarise(result, row);
        const double entries = (double)s.last->entries;
        printf("%7u%8.2f%9.2f%8.1f%10.1f%8.1f%8.1f%8.2f%10.2f%8.2f%8.2f\n", s.last->tiles, s.built,
               s.refused, s.triangles * 1e-3, entries * 1e-3, gn_app_megabytes(s.last->bytes),
               entries > 0 ? (double)s.last->bytes / entries : 0, s.tree_share * 100,
               row->build.mean, row->build.spread.max, row->before.light_buffer.build_ms);
    }
    if (any)
        printf("tiles, entries and MB: of the last frame. built, refused (tiles), tris (put into "
               "tiles), tree (share\nof the rays) and build: mean of the frames, and most; before: "
               "ms of building in the warm-up. Building is\npart of a frame's time.\n");
    else if (any_rays)
        printf("\nAll rays were answered by the tree (bvh).\n");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        char text[256];
        if (row->tracing.lights > 0 && gn_app_fallback(app, row->method, &row->tracing, text))
            printf("%s.\n", text);
    }
}

/* Frame by frame, for plots. */
static void add_series(cJSON *series, const gn_bench_result *result, const gn_bench_row *row)
{
    static const char *const keys[] = {"buffered", "tiles", "built",     "refused", "triangles",
                                       "entries",  "bytes", "tree_rays", "build_ms"};
    enum { COUNT = sizeof keys / sizeof *keys };
    cJSON *list = cJSON_AddObjectToObject(series, "light_buffer"), *arrays[COUNT];
    for (int k = 0; k < COUNT; k++)
        arrays[k] = cJSON_AddArrayToObject(list, keys[k]);
    for (uint32_t f = 0; f < result->frame_count; f++) {
        const gn_app_tracing *tracing = &row->frames[f].cost.tracing;
        const gn_light_buffer_info *info = &tracing->light_buffer;
        const double values[COUNT] = {tracing->buffered,
                                      info->tiles,
                                      info->built,
                                      info->refused,
                                      (double)info->triangles,
                                      (double)info->entries,
                                      (double)info->bytes,
                                      (double)info->tree_rays,
                                      info->build_ms};
        for (int k = 0; k < COUNT; k++)
            cJSON_AddItemToArray(arrays[k], cJSON_CreateNumber(values[k]));
    }
}

void gn_bench_add_tracing(cJSON *json, const gn_app *app, const gn_bench_result *result,
                          const gn_bench_row *row)
{
    if (row->tracing.lights == 0)
        return;
    cJSON_AddStringToObject(json, "tracer", gn_app_answered(&row->tracing));
    gn_app_add_fallback(json, app, row->method, &row->tracing);
    if (!has_light_buffer(row))
        return;
    const summary s = summarise(result, row);
    const struct {
        const char *key;
        double value;
    } parts[] = {{"tiles", s.last->tiles},         {"entries", (double)s.last->entries},
                 {"bytes", (double)s.last->bytes}, {"built", s.built},
                 {"refused", s.refused},           {"triangles", s.triangles},
                 {"tree_rays", s.tree_rays},       {"tree_share", s.tree_share},
                 {"build_ms", row->build.mean},    {"build_ms_max", row->build.spread.max}};
    cJSON *object = cJSON_AddObjectToObject(json, "light_buffer");
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        cJSON_AddNumberToObject(object, parts[i].key, parts[i].value);
    const gn_light_buffer_info *before = &row->before.light_buffer;
    cJSON *warm_up = cJSON_AddObjectToObject(object, "warm_up");
    cJSON_AddNumberToObject(warm_up, "built", before->built);
    cJSON_AddNumberToObject(warm_up, "triangles", (double)before->triangles);
    cJSON_AddNumberToObject(warm_up, "build_ms", before->build_ms);
    add_series(cJSON_GetObjectItem(json, "series"), result, row);
}
