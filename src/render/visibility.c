/* Visibility of one light by any method: by rays, by what the light's map holds, or by rays where
 * the map is unsure. */
#include <string.h>

#include "render/device.h"
#include "render/history.h"
#include "render/shadow_map.h"
#include "render/tracer.h"

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
    if (!(desc->leak.epsilon >= 0.0f && desc->leak.epsilon <= 0.49f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a leak test epsilon of %g: the range is 0 to 0.49",
                       (double)desc->leak.epsilon);
    if ((uint32_t)desc->tracer > GN_TRACER_LIGHT_BUFFER)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "tracer %u does not exist",
                       (unsigned)desc->tracer);
    return GN_OK;
}

static gn_result trace_all(const gn_scene *scene, const gn_gbuffer *gbuffer,
                           const gn_visibility_desc *desc, gn_history *history, float *visibility,
                           gn_visibility_stats *stats)
{
    gn_visibility_job job = {.gbuffer = gbuffer,
                             .light = scene->lights[desc->light],
                             .visibility = visibility,
                             .lod = stats->lod,
                             .lookups = stats->lookups,
                             .entries = stats->entries,
                             .traced = stats->traced};
    const double start = gn_milliseconds();
    GN_TRY(gn_choose_tracer(scene, desc, (size_t)gbuffer->width * gbuffer->height, history,
                            &job.tracer));
    GN_TRY(gn_cpu_visibility(&scene->device->cpu, &job, desc, &stats->rays));
    gn_describe_tracer(&job.tracer, stats);
    stats->trace_ms = gn_milliseconds() - start;
    return GN_OK;
}

/* Brings the light's map up to date. */
static gn_result update_map(const gn_scene *scene, const gn_gbuffer *gbuffer,
                            const gn_visibility_desc *desc, const gn_map_desc *settings,
                            gn_history *history, gn_map_job *job, gn_visibility_stats *stats)
{
    gn_shadow_map *map;
    GN_TRY(gn_history_reserve_map(history, scene, desc->light, &desc->method->map, settings, &map));
    GN_TRY(gn_shadow_map_update(map, scene, desc->light, desc->camera,
                                (float)gbuffer->width / (float)gbuffer->height, &stats->map));
    gn_shadow_map_fill_job(map, job);
    return GN_OK;
}

static gn_result read_map(const gn_scene *scene, const gn_gbuffer *gbuffer,
                          const gn_visibility_desc *desc, gn_history *history, float *visibility,
                          gn_visibility_stats *stats)
{
    gn_map_job job = {.gbuffer = gbuffer,
                      .light = scene->lights[desc->light],
                      .frame = desc->frame,
                      .visibility = visibility,
                      .layer = stats->layer};
    GN_TRY(update_map(scene, gbuffer, desc, &desc->map, history, &job, stats));
    const double start = gn_milliseconds();
    GN_TRY(gn_cpu_map_visibility(&scene->device->cpu, &job));
    stats->test_ms = gn_milliseconds() - start;
    if (stats->test)
        memcpy(stats->test, visibility,
               (size_t)gbuffer->width * gbuffer->height * sizeof *visibility);
    return GN_OK;
}

/* Settings of a map under leak tracing, where they are left to it. */
static gn_map_desc leak_settings(const gn_map_format *format, const gn_map_desc *desc)
{
    gn_map_desc settings = *desc;
    if (settings.refresh == 0)
        settings.refresh = 8;
    if (settings.undrawn == GN_NONE)
        settings.undrawn = settings.cascades > 1 ? 1 : 0;
    /* The finer the texels near the camera, the fewer rays and errors. */
    if (settings.split_weight < 0.0f)
        settings.split_weight = 0.95f;
    /* What these do not decide is traced; what lifting decides may be wrong. Plain depths decide
     * everything. */
    if (settings.normal_bias < 0.0f && format->kind >= GN_MAP_VSM)
        settings.normal_bias = 0.0f;
    /* One depth is always sure: four are asked whether they agree. Noise would have every neighbour
     * change its mind from frame to frame. */
    if (format->kind == GN_MAP_DEPTH || format->single_depth ||
        (format->kind == GN_MAP_NLMSM && settings.reading == GN_READING_AUTO))
        settings.reading = GN_READING_BILINEAR;
    return settings;
}

/* ESM and four moments call much of a shadow's inside lit; there removal needs the depth test
 * (section 3.1.2). */
static gn_switch resolve_depth_test(const gn_visibility_desc *desc)
{
    const gn_map_kind kind = desc->method->map.kind;
    if (desc->leak.depth_test != GN_SWITCH_AUTO)
        return desc->leak.depth_test;
    return kind == GN_MAP_ESM || kind == GN_MAP_MSM || kind == GN_MAP_NLMSM ? GN_SWITCH_ON
                                                                            : GN_SWITCH_OFF;
}

static gn_result trace_leaks(const gn_scene *scene, const gn_gbuffer *gbuffer,
                             const gn_visibility_desc *desc, gn_history *history, float *visibility,
                             gn_visibility_stats *stats)
{
    const gn_light *light = &scene->lights[desc->light];
    const gn_map_desc settings = leak_settings(&desc->method->map, &desc->map);
    gn_leak_job job = {.map = {.gbuffer = gbuffer,
                               .light = *light,
                               .frame = desc->frame,
                               .visibility = visibility,
                               .layer = stats->layer},
                       .rays = {.gbuffer = gbuffer,
                                .light = *light,
                                .visibility = visibility,
                                .lod = stats->lod,
                                .lookups = stats->lookups,
                                .entries = stats->entries},
                       .desc = desc->leak,
                       .test = stats->test,
                       .traced = stats->traced,
                       .leak_class = stats->leak_class};
    job.desc.depth_test = resolve_depth_test(desc);
    GN_TRY(update_map(scene, gbuffer, desc, &settings, history, &job.map, stats));
    if (desc->method->mask)
        GN_TRY(gn_history_begin_mask(history, desc->light, desc->camera, gbuffer,
                                     job.desc.depth_test == GN_SWITCH_ON, &job.mask));
    gn_result result = gn_choose_tracer(scene, desc, (size_t)gbuffer->width * gbuffer->height,
                                        history, &job.rays.tracer);
    if (result == GN_OK)
        result = gn_cpu_leak(&scene->device->cpu, &job, desc);
    /* What rays have missed is there for the next frame. */
    if (result == GN_OK && job.rays.tracer.buffer)
        result = gn_light_buffer_grow(job.rays.tracer.buffer);
    if (result != GN_OK) {
        gn_history_cut(history); /* the mask is half written */
        return result;
    }
    gn_describe_tracer(&job.rays.tracer, stats);
    stats->rays = job.traced_count;
    stats->leak = job.counts;
    stats->test_ms = job.test_ms;
    stats->trace_ms = job.trace_ms;
    return GN_OK;
}

static gn_result find_visibility(const gn_scene *scene, const gn_gbuffer *gbuffer,
                                 const gn_visibility_desc *desc, gn_history *history,
                                 float *visibility, gn_visibility_stats *stats)
{
    switch (desc->method->trace) {
    case GN_TRACE_ALL:
        return trace_all(scene, gbuffer, desc, history, visibility, stats);
    case GN_TRACE_LEAK:
        return trace_leaks(scene, gbuffer, desc, history, visibility, stats);
    default:
        return read_map(scene, gbuffer, desc, history, visibility, stats);
    }
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
    stats->leak = (gn_leak_counts){0};
    stats->tracer = GN_TRACER_BVH;
    stats->light_buffer = (gn_light_buffer_info){0};
    stats->test_ms = stats->trace_ms = 0.0;
    clear(stats->traced, 0.0f, gbuffer);
    clear(stats->entries, 0.0f, gbuffer);
    clear(stats->leak_class, (float)GN_LEAK_NOTHING, gbuffer);
    const bool has_map = desc->method->map.kind != GN_MAP_NONE;
    if (desc->method->trace == GN_TRACE_ALL) {
        if (has_map)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "method %s traces every pixel: its map would never be read",
                           desc->method->name);
        clear(stats->layer, -1.0f, gbuffer);
        clear(stats->test, 1.0f, gbuffer);
    } else if (!has_map) {
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "method %s neither traces rays nor reads a map", desc->method->name);
    } else {
        clear(stats->lod, 0.0f, gbuffer);
        clear(stats->lookups, 0.0f, gbuffer);
    }
    if (desc->history)
        return find_visibility(scene, gbuffer, desc, desc->history, visibility, stats);
    gn_history *history;
    GN_TRY(gn_history_create(scene->device, &history));
    const gn_result result = find_visibility(scene, gbuffer, desc, history, visibility, stats);
    gn_history_destroy(&history);
    return result;
}
