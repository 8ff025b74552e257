/* What answers shadow rays: choices, and what is said of light buffers. */
#include <math.h>
#include <stdio.h>

#include "method.h"

#define MEGABYTE 1048576.0

gn_tracer_kind gn_app_tracer(const gn_app *app, const gn_app_method *method)
{
    const uint32_t given = app->options.tracer.kind;
    return (gn_tracer_kind)(method->own.tracer != GN_NONE ? method->own.tracer
                            : given != GN_NONE            ? given
                                                          : GN_TRACER_AUTO);
}

size_t gn_app_light_buffer_limit(const gn_app *app)
{
    const double given = app->options.tracer.light_buffer_limit;
    return isnan(given) ? gn_visibility_desc_default().light_buffer_limit
                        : (size_t)(given * MEGABYTE);
}

double gn_app_megabytes(size_t bytes)
{
    return (double)bytes / MEGABYTE;
}

/* What happened ---------------------------------------------------------------------------- */

static void add_info(gn_light_buffer_info *a, const gn_light_buffer_info *b)
{
    a->tiles += b->tiles;
    a->built += b->built;
    a->refused += b->refused;
    a->triangles += b->triangles;
    a->entries += b->entries;
    a->bytes += b->bytes;
    a->tree_rays += b->tree_rays;
    a->build_ms += b->build_ms;
}

void gn_app_add_stats(gn_app_tracing *tracing, const gn_visibility_stats *stats)
{
    tracing->lights++;
    tracing->buffered += stats->tracer == GN_TRACER_LIGHT_BUFFER;
    tracing->rays += stats->rays;
    add_info(&tracing->light_buffer, &stats->light_buffer);
}

void gn_app_add_tracing(gn_app_tracing *a, const gn_app_tracing *b)
{
    a->lights += b->lights;
    a->buffered += b->buffered;
    a->rays += b->rays;
    add_info(&a->light_buffer, &b->light_buffer);
}

const char *gn_app_answered(const gn_app_tracing *tracing)
{
    return tracing->buffered == 0                 ? gn_app_tracer_names[GN_TRACER_BVH]
           : tracing->buffered == tracing->lights ? gn_app_tracer_names[GN_TRACER_LIGHT_BUFFER]
                                                  : "both";
}

bool gn_app_fallback(const gn_app *app, const gn_app_method *method, const gn_app_tracing *tracing,
                     char text[256])
{
    const gn_light_buffer_info *info = &tracing->light_buffer;
    const double share = tracing->rays > 0 ? (double)info->tree_rays / (double)tracing->rays : 0;
    if (!gn_app_has_rays(method))
        return false;
    if (info->refused > 0)
        snprintf(text, 256,
                 "%s: %.3g tiles of a light buffer were refused, beyond %.0f MB or with lists too "
                 "long to be worth it; the tree traced %.3g %% of the rays",
                 method->name, (double)info->refused / tracing->lights,
                 gn_app_megabytes(gn_app_light_buffer_limit(app)), 100 * share);
    else if (gn_app_tracer(app, method) == GN_TRACER_LIGHT_BUFFER &&
             tracing->buffered < tracing->lights)
        snprintf(text, 256,
                 "%s: the tree answered in place of the light buffer, %u of %u times; the limit is "
                 "%.0f MB",
                 method->name, tracing->lights - tracing->buffered, tracing->lights,
                 gn_app_megabytes(gn_app_light_buffer_limit(app)));
    else
        return false;
    return true;
}

void gn_app_add_fallback(cJSON *json, const gn_app *app, const gn_app_method *method,
                         const gn_app_tracing *tracing)
{
    char text[256];
    if (gn_app_fallback(app, method, tracing, text))
        cJSON_AddStringToObject(json, "fallback", text);
}

void gn_app_add_tracing_json(cJSON *json, const gn_app_tracing *tracing)
{
    const gn_light_buffer_info *info = &tracing->light_buffer;
    cJSON_AddStringToObject(json, "tracer", gn_app_answered(tracing));
    if (tracing->buffered == 0 && info->refused == 0)
        return;
    const struct {
        const char *key;
        double value;
    } parts[] = {{"tiles", info->tiles},
                 {"built", info->built},
                 {"refused", info->refused},
                 {"triangles", (double)info->triangles},
                 {"entries", (double)info->entries},
                 {"bytes", (double)info->bytes},
                 {"tree_rays", (double)info->tree_rays},
                 {"build_ms", info->build_ms}};
    cJSON *object = cJSON_AddObjectToObject(json, "light_buffer");
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        cJSON_AddNumberToObject(object, parts[i].key, parts[i].value);
}
