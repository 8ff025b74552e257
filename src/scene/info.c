/* What is in a scene: counts, names, searches. */
#include "scene/scene.h"

#include <string.h>

typedef struct triangle_counts {
    uint64_t all, masked;
} triangle_counts;

static triangle_counts count_triangles(const gn_scene *scene, const gn_mesh *mesh)
{
    triangle_counts counts = {0};
    for (uint32_t i = 0; i < mesh->part_count; i++) {
        const gn_part *part = &mesh->parts[i];
        counts.all += part->triangle_count;
        if (scene->materials[part->material].desc.alpha_mode != GN_ALPHA_OPAQUE)
            counts.masked += part->triangle_count;
    }
    return counts;
}

gn_scene_info gn_scene_get_info(const gn_scene *scene)
{
    gn_scene_info info = {
        .nodes = scene->node_count,
        .meshes = scene->mesh_count,
        .materials = scene->material_count - (scene->default_material != GN_NONE ? 1 : 0),
        .textures = scene->texture_count,
        .lights = scene->light_count,
        .cameras = scene->camera_count,
        .channels = scene->channel_count,
        .warning_count = scene->warning_count,
    };
    for (uint32_t i = 0; i < scene->material_count; i++)
        info.masked_materials += scene->materials[i].desc.alpha_mode != GN_ALPHA_OPAQUE;
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const triangle_counts counts = count_triangles(scene, &scene->meshes[i]);
        info.triangles += counts.all;
        info.masked_triangles += counts.masked;
    }
    for (uint32_t i = 0; i < scene->node_count; i++) {
        if (scene->nodes[i].desc.mesh == GN_NONE)
            continue;
        const triangle_counts counts =
            count_triangles(scene, &scene->meshes[scene->nodes[i].desc.mesh]);
        info.mesh_nodes++;
        info.instanced_triangles += counts.all;
        info.instanced_masked_triangles += counts.masked;
    }
    for (uint32_t i = 0; i < scene->channel_count; i++) {
        const gn_channel_desc *channel = &scene->channels[i].desc;
        const double end = channel->times[channel->key_count - 1];
        if (end > info.duration)
            info.duration = end;
    }
    memcpy(info.bounds_min, scene->bounds_min, sizeof info.bounds_min);
    memcpy(info.bounds_max, scene->bounds_max, sizeof info.bounds_max);
    return info;
}

const char *gn_scene_warning(const gn_scene *scene, uint32_t index)
{
    return index < scene->warning_count ? scene->warnings[index] : "";
}

const char *gn_scene_camera_name(const gn_scene *scene, uint32_t camera)
{
    return camera < scene->camera_count ? scene->cameras[camera].name : "";
}

const char *gn_scene_light_name(const gn_scene *scene, uint32_t light)
{
    return light < scene->light_count ? scene->lights[light].name : "";
}

uint32_t gn_scene_find_camera(const gn_scene *scene, const char *name)
{
    for (uint32_t i = 0; name && name[0] && i < scene->camera_count; i++) {
        if (strcmp(scene->cameras[i].name, name) == 0)
            return i;
    }
    return GN_NONE;
}

uint32_t gn_scene_find_light(const gn_scene *scene, const char *name)
{
    for (uint32_t i = 0; name && name[0] && i < scene->light_count; i++) {
        if (strcmp(scene->lights[i].name, name) == 0)
            return i;
    }
    return GN_NONE;
}

gn_light_desc gn_scene_get_light(const gn_scene *scene, uint32_t light)
{
    if (light >= scene->light_count)
        return gn_light_desc_default();
    gn_light_desc desc = scene->lights[light].desc;
    desc.cookie = GN_COOKIE;
    desc.name = scene->lights[light].name;
    return desc;
}
