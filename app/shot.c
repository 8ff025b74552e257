/* A method at work on a view of its own: frame after frame, up to its pictures. */
#include <stdlib.h>

#include "render.h"

/* AOVs that visibility gives on its way. */
#define FACTS                                                                                      \
    (1u << GN_AOV_LOD | 1u << GN_AOV_LOOKUPS | 1u << GN_AOV_RAYS | 1u << GN_AOV_CLASS |            \
     1u << GN_AOV_LISTS | 1u << GN_AOV_CASCADE | 1u << GN_AOV_TEST)

void gn_shot_close(gn_shot *shot)
{
    for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
        free(shot->frame.facts[aov]);
    gn_view_destroy(&shot->frame.view);
    gn_antialias_destroy(&shot->antialias);
    free(shot->smooth);
    free(shot->stats);
}

/* Planes for what visibility knows, one a light. */
static bool make_facts(gn_shot *shot)
{
    gn_frame *frame = &shot->frame;
    gn_app *app = frame->app;
    gn_visibility_stats *stats = shot->stats;
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
        if (frame->aovs & FACTS & 1u << aov &&
            !(frame->facts[aov] = malloc(pixels * app->light_count * sizeof(float))))
            return gn_app_error(app, "out of memory");
    for (uint32_t l = 0; l < app->light_count; l++) {
        float **const planes[] = {
            [GN_AOV_LOD] = &stats[l].lod,       [GN_AOV_LOOKUPS] = &stats[l].lookups,
            [GN_AOV_RAYS] = &stats[l].traced,   [GN_AOV_CLASS] = &stats[l].leak_class,
            [GN_AOV_LISTS] = &stats[l].entries, [GN_AOV_CASCADE] = &stats[l].layer,
            [GN_AOV_TEST] = &stats[l].test};
        for (uint32_t aov = 0; aov < sizeof planes / sizeof *planes; aov++)
            if (frame->facts[aov])
                *planes[aov] = frame->facts[aov] + l * pixels;
    }
    return true;
}

static bool open_antialias(gn_shot *shot, gn_app_antialias kind)
{
    gn_app *app = shot->frame.app;
    if (kind == GN_APP_NO_ANTIALIAS)
        return true;
    gn_antialias_desc desc = gn_antialias_desc_default();
    desc.kind = kind == GN_APP_TAA ? GN_ANTIALIAS_TAA : GN_ANTIALIAS_SMAA_T2X;
    desc.width = app->options.size[0];
    desc.height = app->options.size[1];
    shot->smooth = malloc((size_t)desc.width * desc.height * 3 * sizeof *shot->smooth);
    return (shot->smooth || gn_app_error(app, "out of memory")) &&
           gn_antialias_create(app->device, &desc, &shot->antialias) == GN_OK;
}

bool gn_shot_open(gn_shot *shot, gn_app *app, const gn_render_options *o,
                  const gn_app_method *method, const char *name, gn_app_antialias antialias,
                  uint32_t aovs)
{
    const gn_view_desc desc = gn_app_view_desc(app, o->samples);
    *shot = (gn_shot){.frame = {.app = app, .method = method, .aovs = aovs}, .name = name};
    shot->stats = calloc(app->light_count, sizeof *shot->stats);
    if ((!shot->stats && !gn_app_error(app, "out of memory")) ||
        gn_view_create(app->device, &desc, &shot->frame.view) != GN_OK || !make_facts(shot) ||
        !open_antialias(shot, antialias))
        return false;
    gn_view_set_stats(shot->frame.view, shot->stats);
    return true;
}

double gn_time_of(const gn_render_options *o, int64_t number)
{
    return o->frames.given ? (number > 0 ? (double)number : 0) / o->fps : o->common.time;
}

bool gn_shot_move(gn_shot *shot, const gn_render_options *o, int64_t number)
{
    gn_app *app = shot->frame.app;
    app->frame = (uint32_t)number;
    const double start = gn_milliseconds();
    if (o->frames.given && !gn_app_set_time(app, gn_time_of(o, number)))
        return false;
    shot->update_ms = gn_milliseconds() - start;
    return true;
}

bool gn_shot_render(gn_shot *shot)
{
    gn_frame *frame = &shot->frame;
    gn_app *app = frame->app;
    if (frame->method->no_reuse)
        gn_history_reset_maps(gn_view_history(frame->view));
    gn_visibility_desc desc = gn_app_visibility_desc(app, frame->method);
    desc.history = NULL; /* the view's, which can be saved */
    if (shot->antialias) {
        float jitter[2];
        gn_antialias_jitter(shot->antialias, jitter);
        if (gn_view_set_jitter(frame->view, jitter[0], jitter[1]) != GN_OK)
            return false;
    }
    if (gn_view_render(frame->view, app->scene, app->camera, &desc, app->lights,
                       app->light_count) != GN_OK ||
        gn_app_interrupted())
        return false;
    frame->image = gn_view_image(frame->view);
    const double start = gn_milliseconds();
    if (shot->antialias) {
        if (gn_antialias_apply(shot->antialias, gn_view_gbuffer(frame->view), frame->image,
                               shot->smooth) != GN_OK)
            return false;
        frame->image = shot->smooth;
    }
    shot->antialias_ms = gn_milliseconds() - start;
    frame->tracing = (gn_app_tracing){0};
    for (uint32_t l = 0; l < app->light_count; l++)
        gn_app_add_stats(&frame->tracing, &shot->stats[l]);
    gn_app_add_tracing(&shot->tracing, &frame->tracing);
    return true;
}

bool gn_shot_warm_up(gn_shot *shot, const gn_render_options *o, uint32_t first)
{
    gn_app *app = shot->frame.app;
    if (o->history_in)
        return (first == 0 || gn_app_set_time(app, gn_time_of(o, (int64_t)first - 1))) &&
               gn_view_load_history(shot->frame.view, app->scene, o->history_in) == GN_OK;
    for (uint32_t i = o->warm_up; i > 0; i--)
        if (!gn_shot_move(shot, o, (int64_t)first - i) || !gn_shot_render(shot))
            return false;
    shot->tracing = (gn_app_tracing){0}; /* of what is shown */
    return true;
}

bool gn_shot_look_back(gn_shot *shot, const gn_render_options *o, uint32_t number)
{
    const gn_app *app = shot->frame.app;
    return gn_shot_move(shot, o, number) &&
           gn_view_trace_gbuffer(shot->frame.view, app->scene, app->camera) == GN_OK;
}

cJSON *gn_shot_report(const gn_shot *shot, const gn_render_options *o, uint32_t number,
                      double write_ms)
{
    const gn_frame *frame = &shot->frame;
    const gn_visibility_stats *stats = shot->stats;
    const gn_app *app = frame->app;
    const gn_timings timings = gn_view_timings(frame->view);
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddNumberToObject(entry, "frame", number);
    cJSON_AddNumberToObject(entry, "time", gn_time_of(o, number));
    cJSON *ms = cJSON_AddObjectToObject(entry, "ms");
    cJSON_AddNumberToObject(ms, "update", shot->update_ms);
    cJSON_AddNumberToObject(ms, "gbuffer", timings.gbuffer);
    cJSON_AddNumberToObject(ms, "visibility", timings.visibility);
    cJSON_AddNumberToObject(ms, "shadow_map", timings.shadow_map);
    cJSON_AddNumberToObject(ms, "filter", timings.filter);
    cJSON_AddNumberToObject(ms, "test", timings.test);
    cJSON_AddNumberToObject(ms, "trace", timings.trace);
    cJSON_AddNumberToObject(ms, "shade", timings.shade);
    if (shot->antialias)
        cJSON_AddNumberToObject(ms, "antialias", shot->antialias_ms);
    cJSON_AddNumberToObject(ms, "write", write_ms);
    cJSON *means = cJSON_AddArrayToObject(entry, "mean_visibility");
    gn_leak_counts leak = {0};
    for (uint32_t l = 0; l < app->light_count; l++) {
        gn_app_add_counts(&leak, &stats[l].leak);
        const float *visibility = gn_view_visibility(frame->view, l);
        double sum = 0;
        for (size_t i = 0; i < pixels; i++)
            sum += (double)visibility[i];
        cJSON_AddItemToArray(means, cJSON_CreateNumber(sum / (double)pixels));
    }
    cJSON_AddNumberToObject(entry, "rays", (double)frame->tracing.rays);
    if (gn_app_has_rays(frame->method))
        gn_app_add_tracing_json(entry, &frame->tracing);
    if (frame->method->method.trace == GN_TRACE_LEAK)
        cJSON_AddItemToObject(entry, "leak",
                              gn_app_leak_json(&leak, (double)pixels * app->light_count));
    return entry;
}
