/* glTF animations: all of them play together, from time 0. */
#include "scene/gltf.h"

#include <stdio.h>
#include <string.h>

/* What a channel's target says; node is GN_NONE where there is nothing to move. */
typedef struct target {
    uint32_t node;
    gn_animation_path path;
} target;

static gn_result read_target(gn_gltf *gltf, const cJSON *channel, target *out)
{
    const cJSON *item = NULL;
    const char *path = "";
    out->node = GN_NONE;
    GN_TRY(gn_gltf_object(gltf, channel, "target", &item));
    uint32_t node = GN_NONE;
    GN_TRY(gn_gltf_string(gltf, item, "path", &path));
    GN_TRY(gn_gltf_index(gltf, item, "node", &gltf->nodes, &node));
    if (strcmp(path, "translation") == 0)
        out->path = GN_PATH_TRANSLATION;
    else if (strcmp(path, "rotation") == 0)
        out->path = GN_PATH_ROTATION;
    else if (strcmp(path, "scale") == 0)
        out->path = GN_PATH_SCALE;
    else {
        gn_scene_warn(gltf->scene, "%s: animation of \"%.20s\" is not supported; left out",
                      gltf->where, path);
        return GN_OK;
    }
    if (node == GN_NONE || gltf->node_indices[node] == GN_NONE)
        return GN_OK;
    if (cJSON_HasObjectItem(gltf->nodes.items[node], "matrix"))
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "it animates node %u, whose transform is a matrix", node);
    const uint8_t bit = (uint8_t)(1u << out->path);
    if (gltf->node_paths[node] & bit) {
        gn_scene_warn(gltf->scene,
                      "%s: the %s of node %u is animated by an earlier channel; left out",
                      gltf->where, path, node);
        return GN_OK;
    }
    gltf->node_paths[node] |= bit;
    out->node = gltf->node_indices[node];
    return GN_OK;
}

static gn_result read_interpolation(gn_gltf *gltf, const cJSON *sampler,
                                    gn_interpolation *interpolation)
{
    const char *name = "LINEAR";
    GN_TRY(gn_gltf_string(gltf, sampler, "interpolation", &name));
    if (strcmp(name, "STEP") == 0)
        *interpolation = GN_INTERPOLATION_STEP;
    else if (strcmp(name, "LINEAR") == 0)
        *interpolation = GN_INTERPOLATION_LINEAR;
    else if (strcmp(name, "CUBICSPLINE") == 0)
        *interpolation = GN_INTERPOLATION_CUBICSPLINE;
    else
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "unknown interpolation \"%.20s\"", name);
    return GN_OK;
}

static gn_result check_times(gn_gltf *gltf, const float *times, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (times[i] < 0 || (i > 0 && times[i] <= times[i - 1]))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                                "key %u: its time %g s is negative or not after the key before it",
                                i, (double)times[i]);
    }
    return GN_OK;
}

static gn_result add_channel(gn_gltf *gltf, const cJSON *sampler, gn_channel_desc *desc)
{
    uint32_t input = GN_NONE, output = GN_NONE;
    GN_TRY(read_interpolation(gltf, sampler, &desc->interpolation));
    GN_TRY(gn_gltf_index(gltf, sampler, "input", &gltf->accessors, &input));
    GN_TRY(gn_gltf_index(gltf, sampler, "output", &gltf->accessors, &output));
    if (input == GN_NONE || output == GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "its sampler has no input or output");
    gn_gltf_accessor keys, values;
    GN_TRY(gn_gltf_open_accessor(gltf, input, &keys));
    GN_TRY(gn_gltf_open_accessor(gltf, output, &values));
    const uint64_t elements = desc->interpolation == GN_INTERPOLATION_CUBICSPLINE ? 3 : 1;
    if (values.count != keys.count * elements)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "accessor %u has %u values for %u keys instead of %llu", output,
                            values.count, keys.count, (unsigned long long)(keys.count * elements));

    float *key_times = NULL, *key_values = NULL;
    const uint32_t components = desc->path == GN_PATH_ROTATION ? 4 : 3;
    gn_result result = gn_gltf_read_floats(gltf, &keys, 1, GN_GLTF_FLOAT, &key_times);
    if (result == GN_OK)
        result = check_times(gltf, key_times, keys.count);
    if (result == GN_OK)
        result = gn_gltf_read_floats(gltf, &values, components, GN_GLTF_NORMALIZED, &key_values);
    if (result == GN_OK) {
        desc->key_count = keys.count;
        desc->times = key_times;
        desc->values = key_values;
        result = gn_scene_add_channel(gltf->scene, desc);
        if (result != GN_OK)
            gn_gltf_refail(gltf, result);
    }
    gn_free(gltf->context, key_times);
    gn_free(gltf->context, key_values);
    return result;
}

static gn_result read_channel(gn_gltf *gltf, const cJSON *channel, const gn_gltf_list *samplers)
{
    target to;
    uint32_t sampler = GN_NONE;
    GN_TRY(gn_gltf_index(gltf, channel, "sampler", samplers, &sampler));
    if (sampler == GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "it has no sampler");
    GN_TRY(read_target(gltf, channel, &to));
    if (to.node == GN_NONE)
        return GN_OK;
    gn_channel_desc desc = gn_channel_desc_default();
    desc.node = to.node;
    desc.path = to.path;
    return add_channel(gltf, samplers->items[sampler], &desc);
}

static gn_result read_channels(gn_gltf *gltf, uint32_t animation, const gn_gltf_list *channels,
                               const gn_gltf_list *samplers)
{
    for (uint32_t i = 0; i < channels->count; i++) {
        gn_gltf_at(gltf, &gltf->animations, animation);
        const size_t length = strlen(gltf->where);
        snprintf(gltf->where + length, sizeof gltf->where - length, ", channel %u", i);
        GN_TRY(read_channel(gltf, channels->items[i], samplers));
    }
    return GN_OK;
}

gn_result gn_gltf_read_animations(gn_gltf *gltf)
{
    for (uint32_t i = 0; i < gltf->animations.count; i++) {
        gn_gltf_at(gltf, &gltf->animations, i);
        const cJSON *animation = gltf->animations.items[i];
        gn_gltf_list channels = {0}, samplers = {0};
        gn_result result =
            gn_gltf_make_list(gltf, animation, "channels", "animation channel", &channels);
        if (result == GN_OK)
            result = gn_gltf_make_list(gltf, animation, "samplers", "animation sampler", &samplers);
        if (result == GN_OK)
            result = read_channels(gltf, i, &channels, &samplers);
        gn_free(gltf->context, channels.items);
        gn_free(gltf->context, samplers.items);
        GN_TRY(result);
    }
    gltf->where[0] = '\0';
    return GN_OK;
}
