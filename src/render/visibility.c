/* Visibility of one light by any method: by rays, or by what the light's map holds. */
#include "render/device.h"
#include "render/history.h"
#include "render/shadow_map.h"

static gn_result check(const gn_scene *scene, const gn_visibility_desc *desc)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_visibility_desc);
    if (!scene->accel || scene->edits != scene->committed)
        return gn_fail(context, GN_ERROR_STATE, "the scene has edits that are not committed");
    if (!desc->method)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "no method is given");
    if (desc->light >= scene->light_count)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "light %u does not exist: the scene has %u", desc->light,
                       scene->light_count);
    if (!(desc->cutoff >= 0.0f && desc->cutoff <= 0.5f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a visibility cutoff of %g: the range is 0 to 0.5", (double)desc->cutoff);
    if (!(desc->point_light_clip >= 0.0f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a point light clip of %g: it must not be negative",
                       (double)desc->point_light_clip);
    return GN_OK;
}

static gn_result trace_all(const gn_scene *scene, const gn_gbuffer *gbuffer,
                           const gn_visibility_desc *desc, float *visibility,
                           gn_visibility_stats *stats)
{
    gn_visibility_job job = {.tracer = {.accel = scene->accel},
                             .gbuffer = gbuffer,
                             .light = scene->lights[desc->light],
                             .visibility = visibility,
                             .lod = stats->lod,
                             .lookups = stats->lookups};
    const double start = gn_milliseconds();
    stats->rays = gn_cpu_visibility(&scene->device->cpu, &job, desc);
    stats->trace_ms = gn_milliseconds() - start;
    return GN_OK;
}

static gn_result read_map(const gn_scene *scene, const gn_gbuffer *gbuffer,
                          const gn_visibility_desc *desc, gn_history *history, float *visibility,
                          gn_visibility_stats *stats)
{
    gn_shadow_map *map;
    GN_TRY(
        gn_history_reserve_map(history, scene, desc->light, &desc->method->map, &desc->map, &map));
    GN_TRY(gn_shadow_map_update(map, scene, desc->light, desc->camera,
                                (float)gbuffer->width / (float)gbuffer->height, &stats->map));
    gn_map_job job = {.gbuffer = gbuffer,
                      .light = scene->lights[desc->light],
                      .frame = desc->frame,
                      .visibility = visibility,
                      .layer = stats->layer};
    gn_shadow_map_fill_job(map, &job);
    const double start = gn_milliseconds();
    const gn_result result = gn_cpu_map_visibility(&scene->device->cpu, &job);
    stats->test_ms = gn_milliseconds() - start;
    return result;
}

/* Facts that a method does not make are plain. */
static void clear(float *plane, float value, const gn_gbuffer *gbuffer)
{
    const size_t pixels = (size_t)gbuffer->width * gbuffer->height;
    for (size_t i = 0; plane && i < pixels; i++)
        plane[i] = value;
}

gn_result gn_scene_visibility(const gn_scene *scene, const gn_gbuffer *gbuffer,
                              const gn_visibility_desc *desc, float *visibility,
                              gn_visibility_stats *stats)
{
    gn_context *context = scene->context;
    GN_TRY(check(scene, desc));
    gn_visibility_stats unused = {0};
    if (!stats)
        stats = &unused;
    stats->rays = 0;
    stats->map = (gn_map_update){0};
    stats->test_ms = stats->trace_ms = 0.0;
    const bool has_map = desc->method->map.kind != GN_MAP_NONE;
    if (desc->method->trace == GN_TRACE_ALL) {
        if (has_map)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "method %s traces every pixel: its map would never be read",
                           desc->method->name);
        clear(stats->layer, -1.0f, gbuffer);
        return trace_all(scene, gbuffer, desc, visibility, stats);
    }
    if (desc->method->trace == GN_TRACE_LEAK)
        return gn_fail(context, GN_ERROR_UNSUPPORTED, "leak tracing is being built");
    if (!has_map)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "method %s neither traces rays nor reads a map", desc->method->name);
    clear(stats->lod, 0.0f, gbuffer);
    clear(stats->lookups, 0.0f, gbuffer);
    if (desc->history)
        return read_map(scene, gbuffer, desc, desc->history, visibility, stats);
    gn_history *history;
    GN_TRY(gn_history_create(scene->device, &history));
    const gn_result result = read_map(scene, gbuffer, desc, history, visibility, stats);
    gn_history_destroy(&history);
    return result;
}
