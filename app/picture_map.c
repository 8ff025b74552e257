/* Shadow maps as pictures: depth, and the offset of the fourth moment. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "picture.h"

/* What xi4 is clamped to, and its upper bound (moment paper, section 3.3). */
#define XI4_LEAST 1.2e-7f
#define XI4_MOST  0.25f

/* Of every texel the mean of its samples; the nearer of static and moving casters. */
static void resolve_depth(const gn_map_layer_info *info, float *out)
{
    const size_t texels = (size_t)info->resolution * info->resolution;
    memset(out, 0, texels * sizeof *out);
    for (uint32_t s = 0; s < info->samples; s++)
        for (size_t i = 0; i < texels; i++) {
            float depth = info->depth[s * texels + i];
            if (info->dynamic_depth)
                depth = fminf(depth, info->dynamic_depth[s * texels + i]);
            out[i] += depth / (float)info->samples;
        }
}

/* Near white, far dark grey, stretched over the depths that occur; nothing black. */
static void paint_depth(const float *depth, size_t count, uint8_t *grey)
{
    float nearest = 1, farthest = 0;
    for (size_t i = 0; i < count; i++) {
        if (depth[i] >= 1)
            continue;
        nearest = fminf(nearest, depth[i]);
        farthest = fmaxf(farthest, depth[i]);
    }
    const float scale = farthest > nearest ? 1 / (farthest - nearest) : 0;
    for (size_t i = 0; i < count; i++)
        grey[i] = depth[i] >= 1
                      ? 0
                      : (uint8_t)(255.5f - 215.0f * (fminf(depth[i], farthest) - nearest) * scale);
}

static void paint_xi4(const float *xi4, size_t count, uint8_t *rgb)
{
    const float low = log2f(XI4_LEAST), high = log2f(XI4_MOST);
    for (size_t i = 0; i < count; i++)
        gn_heat_color((log2f(fmaxf(xi4[i], XI4_LEAST)) - low) / (high - low), rgb + 3 * i);
}

typedef struct sheet {
    uint32_t resolution, layers;
    float *values; /* layers * resolution^2 */
} sheet;

static bool read_sheet(gn_app *app, gn_aov aov, const gn_shadow_map *map, sheet *s)
{
    s->layers = gn_shadow_map_layer_count(map);
    s->resolution = gn_shadow_map_layer(map, 0).resolution;
    const size_t texels = (size_t)s->resolution * s->resolution;
    s->values = malloc(s->layers * texels * sizeof *s->values);
    if (!s->values)
        return gn_app_error(app, "out of memory for pictures of a map");
    for (uint32_t l = 0; l < s->layers; l++) {
        const gn_map_layer_info info = gn_shadow_map_layer(map, l);
        if (aov == GN_AOV_MAP)
            resolve_depth(&info, s->values + l * texels);
        else if (gn_shadow_map_xi4(map, l, s->values + l * texels) != GN_OK)
            return false;
    }
    return true;
}

static bool write_png(const gn_frame *frame, gn_aov aov, const sheet *s, const char *name)
{
    const size_t texels = (size_t)s->resolution * s->resolution,
                 channels = aov == GN_AOV_MAP ? 1 : 3, row = s->resolution * channels;
    uint8_t *layer = malloc(texels * channels), *picture = malloc(texels * channels * s->layers);
    bool good = layer && picture;
    if (!good)
        gn_app_error(frame->app, "%s: out of memory", name);
    for (uint32_t l = 0; l < s->layers && layer && picture; l++) {
        if (aov == GN_AOV_MAP)
            paint_depth(s->values + l * texels, texels, layer);
        else
            paint_xi4(s->values + l * texels, texels, layer);
        for (uint32_t y = 0; y < s->resolution; y++)
            memcpy(picture + (y * s->layers + l) * row, layer + y * row, row);
    }
    good = good && gn_write_png(frame->app->device, name, s->resolution * s->layers, s->resolution,
                                (uint32_t)channels, picture, frame->settings->attributes,
                                frame->settings->count) == GN_OK;
    free(layer);
    free(picture);
    return good;
}

static bool write_exr(const gn_frame *frame, gn_aov aov, const sheet *s, const char *name)
{
    enum { MOST = 8 };
    gn_layer layers[MOST];
    char names[MOST][16];
    const size_t texels = (size_t)s->resolution * s->resolution;
    const uint32_t count = s->layers < MOST ? s->layers : MOST;
    for (uint32_t l = 0; l < count; l++) {
        snprintf(names[l], sizeof names[l], "%s.%u", gn_aov_names[aov], l);
        layers[l] = (gn_layer){.name = names[l],
                               .channels = aov == GN_AOV_MAP ? "Z" : "Y",
                               .planes = {s->values + l * texels},
                               .stride = 1,
                               .full_precision = 1};
    }
    return gn_write_exr(frame->app->device, name, s->resolution, s->resolution, layers, count,
                        frame->settings->attributes, frame->settings->count) == GN_OK;
}

bool gn_frame_write_map(const gn_frame *frame, gn_aov aov, uint32_t light, const char *path,
                        cJSON *files)
{
    gn_app *app = frame->app;
    const gn_shadow_map *map = gn_history_map(gn_view_history(frame->view), app->lights[light]);
    char suffix[320], name[4096];
    gn_aov_suffix(app, aov, light, suffix, sizeof suffix);
    if (!gn_insert_suffix(app, path, suffix, name, sizeof name))
        return false;
    if (!map || gn_shadow_map_layer_count(map) == 0)
        return gn_app_error(app, "%s: the light has no map", name);
    const size_t length = strlen(path);
    const bool exr = length > 4 && strcmp(path + length - 4, ".exr") == 0;
    sheet s = {0};
    const bool good = read_sheet(app, aov, map, &s) &&
                      (exr ? write_exr(frame, aov, &s, name) : write_png(frame, aov, &s, name));
    free(s.values);
    if (good && files)
        cJSON_AddItemToArray(files, cJSON_CreateString(name));
    return good;
}
