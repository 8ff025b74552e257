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

bool gn_app_use_methods(gn_app *app, gn_app_method *methods, uint32_t count)
{
    const gn_app_map_options *o = &app->options.map;
    bool any = false, esm = false, evsm = false;
    app->map = gn_app_map_desc(o);
    app->wrong_usage = true; /* up to the last check */
    for (uint32_t i = 0; i < count; i++) {
        gn_app_method *m = &methods[i];
        if (!gn_app_has_map(m))
            continue;
        any = true;
        if (!set_exponents(o, &m->method.map, &esm, &evsm))
            return gn_app_error(app, "--evsm: %s is one-sided, and has one exponent", m->name);
        if (!gn_app_accepts_map(app, &m->method.map, &app->map))
            return false;
    }
    const char *option = any ? NULL : map_option(o);
    if (option)
        return gn_app_error(app, "--%s: no method that reads a map is run", option);
    if ((o->esm.count > 0 && !esm) || (o->evsm.count > 0 && !evsm))
        return gn_app_error(app, "--%s: no method of that kind is run",
                            o->esm.count > 0 && !esm ? "esm" : "evsm");
    app->wrong_usage = false;
    for (uint32_t i = 0; i < count; i++)
        if (gn_app_has_map(&methods[i]) &&
            gn_history_create(app->device, &methods[i].history) != GN_OK)
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
    if (gn_app_has_map(method)) {
        desc.map = app->map;
        desc.history = method->history;
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
    if (app->options.map.no_reuse && method->history)
        gn_history_reset(method->history);
    for (uint32_t i = 0; i < app->light_count; i++) {
        gn_visibility_stats stats = {0};
        desc.light = app->lights[i];
        if (gn_scene_visibility(app->scene, gbuffer, &desc, planes + i * pixels, &stats) != GN_OK)
            return false;
        sum.rays += stats.rays;
        sum.fitted += stats.map.fitted;
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
