/* Visibility by the options: settings of maps, histories, costs. */
#include <math.h>

#include "method.h"

/* Settings ---------------------------------------------------------------------------------- */

/* The first option that only maps use, or NULL. */
static const char *map_option(const gn_app_map_options *o)
{
    const struct {
        const char *name;
        bool given;
    } options[] = {{"map-size", o->resolution != GN_NONE},
                   {"cascades", o->cascades != GN_NONE},
                   {"splits", o->splits.count > 0},
                   {"split-weight", !isnan(o->split_weight)},
                   {"shadow-distance", !isnan(o->distance)},
                   {"enlarge", !isnan(o->enlarge)},
                   {"no-reuse", o->no_reuse},
                   {"refresh", o->refresh != GN_NONE},
                   {"undrawn", o->undrawn != GN_NONE},
                   {"map-samples", o->samples != GN_NONE},
                   {"map-alpha", o->alpha != GN_NONE},
                   {"filter-width", o->filter_width != GN_NONE},
                   {"filter-sigma", !isnan(o->filter_sigma)},
                   {"mip-maps", o->mip_maps},
                   {"reading", o->reading != GN_NONE},
                   {"depth-bias", !isnan(o->depth_bias)},
                   {"normal-bias", !isnan(o->normal_bias)},
                   {"min-variance", !isnan(o->minimum_variance)},
                   {"moment-bias", !isnan(o->moment_bias)}};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        if (options[i].given)
            return options[i].name;
    return NULL;
}

static void take_count(uint32_t *to, uint32_t value)
{
    if (value != GN_NONE)
        *to = value;
}

static void take_real(float *to, double value)
{
    if (!isnan(value))
        *to = (float)value;
}

gn_map_desc gn_app_map_desc(const gn_app_map_options *o)
{
    gn_map_desc desc = gn_map_desc_default();
    take_count(&desc.resolution, o->resolution);
    take_count(&desc.samples, o->samples);
    take_count(&desc.filter_width, o->filter_width);
    if (o->alpha != GN_NONE)
        desc.alpha = (gn_map_alpha)o->alpha;
    if (o->reading != GN_NONE)
        desc.reading = (gn_map_reading)o->reading;
    if (o->splits.count > 0)
        desc.cascades = desc.split_count = o->splits.count;
    for (uint32_t i = 0; i < o->splits.count; i++)
        desc.splits[i] = (float)o->splits.values[i];
    take_count(&desc.cascades, o->cascades);
    take_count(&desc.undrawn, o->undrawn);
    take_count(&desc.refresh, o->refresh);
    if (o->no_reuse)
        desc.enlarge = 0;
    take_real(&desc.enlarge, o->enlarge);
    take_real(&desc.distance, o->distance);
    take_real(&desc.split_weight, o->split_weight);
    take_real(&desc.filter_sigma, o->filter_sigma);
    take_real(&desc.depth_bias, o->depth_bias);
    take_real(&desc.normal_bias, o->normal_bias);
    take_real(&desc.minimum_variance, o->minimum_variance);
    take_real(&desc.moment_bias, o->moment_bias);
    desc.mip_maps = o->mip_maps;
    return desc;
}

/* --esm and --evsm; true where they were of use to this method. */
static bool set_exponents(const gn_app_map_options *o, gn_map_format *format, bool *esm, bool *evsm)
{
    if (format->kind == GN_MAP_ESM && o->esm.count > 0) {
        format->positive_exponent = (float)o->esm.values[0];
        *esm = true;
    }
    if (format->kind != GN_MAP_EVSM || o->evsm.count == 0)
        return true;
    format->positive_exponent = (float)o->evsm.values[0];
    if (o->evsm.count > 1)
        format->negative_exponent = (float)o->evsm.values[1];
    *evsm = true;
    return !format->one_sided || o->evsm.count == 1;
}

bool gn_app_accepts_map(gn_app *app, const gn_map_format *format, const gn_map_desc *desc)
{
    gn_shadow_map *map;
    const bool accepted = gn_shadow_map_create(app->device, format, desc, &map) == GN_OK;
    gn_shadow_map_destroy(&map);
    return accepted;
}

/* The first option that only masks use, or NULL. */
static const char *mask_option(const gn_app_leak_options *o)
{
    return o->kernel != GN_NONE       ? "leak-kernel"
           : o->no_expand             ? "no-expand"
           : o->no_remove             ? "no-remove"
           : o->depth_test != GN_NONE ? "depth-test"
                                      : NULL;
}

/* Later ones win. */
static void take_leak(gn_leak_desc *desc, const gn_app_leak_options *o)
{
    take_real(&desc->epsilon, o->epsilon);
    if (o->kernel != GN_NONE)
        desc->kernel = (gn_leak_kernel)o->kernel;
    if (o->depth_test != GN_NONE)
        desc->depth_test = (gn_switch)o->depth_test;
    desc->expand = desc->expand && !o->no_expand;
    desc->remove = desc->remove && !o->no_remove;
}

/* A method's settings: the options', and over them those of its name. */
static void settle(const gn_app *app, gn_app_method *method)
{
    const gn_app_modifiers *own = &method->own;
    method->map = app->map;
    take_count(&method->map.resolution, own->resolution);
    take_count(&method->map.refresh, own->refresh);
    take_count(&method->map.undrawn, own->undrawn);
    method->no_reuse = app->options.map.no_reuse || own->no_reuse;
    if (method->no_reuse && isnan(app->options.map.enlarge))
        method->map.enlarge = 0;
    if (method->no_reuse) /* what is made anew in every frame is whole in every frame */
        method->map.refresh = 1;
    method->leak = gn_visibility_desc_default().leak;
    take_leak(&method->leak, &app->options.leak);
    take_leak(&method->leak, &own->leak);
}

/* Options that none of the methods has a use for. */
static bool check_unused(gn_app *app, const gn_app_method *methods, uint32_t count)
{
    bool map = false, leak = false, mask = false, rays = false, buffer = false;
    for (uint32_t i = 0; i < count; i++) {
        rays = rays || gn_app_has_rays(&methods[i]);
        buffer = buffer ||
                 (gn_app_has_rays(&methods[i]) && gn_app_tracer(app, &methods[i]) != GN_TRACER_BVH);
        map = map || gn_app_has_map(&methods[i]);
        leak = leak || (gn_app_has_map(&methods[i]) && methods[i].method.trace == GN_TRACE_LEAK);
        mask = mask || gn_app_has_mask(&methods[i]);
    }
    const char *of_maps = map_option(&app->options.map);
    const char *of_masks = mask_option(&app->options.leak);
    if (!map && of_maps)
        return gn_app_error(app, "--%s: no method that reads a map is run", of_maps);
    if (!leak && !isnan(app->options.leak.epsilon))
        return gn_app_error(app, "--leak-epsilon: no method of leak tracing is run");
    if (!mask && of_masks)
        return gn_app_error(app, "--%s: no method with a mask is run", of_masks);
    if (!rays && app->options.tracer.kind != GN_NONE)
        return gn_app_error(app, "--tracer: no method that traces rays is run");
    if (!buffer && !isnan(app->options.tracer.light_buffer_limit))
        return gn_app_error(app, "--light-buffer-limit: no method may use a light buffer");
    return true;
}

bool gn_app_use_methods(gn_app *app, gn_app_method *methods, uint32_t count)
{
    const gn_app_map_options *o = &app->options.map;
    bool esm = false, evsm = false;
    app->map = gn_app_map_desc(o);
    app->wrong_usage = true; /* up to the last check */
    for (uint32_t i = 0; i < count; i++) {
        gn_app_method *m = &methods[i];
        if (!gn_app_has_map(m))
            continue;
        settle(app, m);
        if (!set_exponents(o, &m->method.map, &esm, &evsm))
            return gn_app_error(app, "--evsm: %s is one-sided, and has one exponent", m->name);
        if (!gn_app_accepts_map(app, &m->method.map, &m->map))
            return false;
    }
    if (!check_unused(app, methods, count))
        return false;
    if ((o->esm.count > 0 && !esm) || (o->evsm.count > 0 && !evsm))
        return gn_app_error(app, "--%s: no method of that kind is run",
                            o->esm.count > 0 && !esm ? "esm" : "evsm");
    app->wrong_usage = false;
    for (uint32_t i = 0; i < count; i++)
        if (!methods[i].pseudo && gn_history_create(app->device, &methods[i].history) != GN_OK)
            return false;
    return true;
}

void gn_app_release_methods(gn_app_method *methods, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        gn_history_destroy(&methods[i].history);
}

/* Visibility -------------------------------------------------------------------------------- */

gn_visibility_desc gn_app_visibility_desc(const gn_app *app, const gn_app_method *method)
{
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = &method->method;
    desc.rescale_alpha = !app->options.no_alpha_rescale;
    desc.tracer = gn_app_tracer(app, method);
    desc.light_buffer_limit = gn_app_light_buffer_limit(app);
    desc.history = method->history;
    if (gn_app_has_map(method)) {
        desc.map = method->map;
        desc.leak = method->leak;
    }
    desc.camera = app->camera;
    desc.frame = app->frame;
    return desc;
}

bool gn_app_visibility(gn_app *app, const gn_gbuffer *gbuffer, gn_app_method *method, float *planes,
                       gn_app_cost *cost)
{
    const size_t pixels = (size_t)gbuffer->width * gbuffer->height;
    gn_visibility_desc desc = gn_app_visibility_desc(app, method);
    gn_app_cost sum = {0};
    const double start = gn_milliseconds();
    if (method->no_reuse)
        gn_history_reset_maps(method->history);
    for (uint32_t i = 0; i < app->light_count; i++) {
        gn_visibility_stats stats = {0};
        desc.light = app->lights[i];
        if (gn_scene_visibility(app->scene, gbuffer, &desc, planes + i * pixels, &stats) != GN_OK)
            return false;
        gn_app_add_stats(&sum.tracing, &stats);
        sum.fitted += stats.map.fitted;
        sum.pending += stats.map.pending;
        gn_app_add_counts(&sum.leak, &stats.leak);
        sum.shadow_map += stats.map.depth_ms;
        sum.filter += stats.map.filter_ms;
        sum.test += stats.test_ms;
        sum.trace += stats.trace_ms;
    }
    sum.total = gn_milliseconds() - start;
    if (cost)
        *cost = sum;
    return !gn_app_interrupted();
}
