/* The scene's tables: descriptors, life, textures, materials, lights, cameras. */
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979323846

/* Descriptors -------------------------------------------------------------------------------- */

gn_texture_desc gn_texture_desc_default(void)
{
    return (gn_texture_desc){.cookie = GN_COOKIE};
}

gn_material_desc gn_material_desc_default(void)
{
    return (gn_material_desc){.cookie = GN_COOKIE,
                              .base_color = {1, 1, 1, 1},
                              .texture = GN_NONE,
                              .uv_transform = {1, 0, 0, 0, 1, 0},
                              .alpha_cutoff = 0.5f};
}

gn_node_desc gn_node_desc_default(void)
{
    return (gn_node_desc){.cookie = GN_COOKIE,
                          .parent = GN_NONE,
                          .rotation = {0, 0, 0, 1},
                          .scale = {1, 1, 1},
                          .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                          .mesh = GN_NONE,
                          .light = GN_NONE,
                          .camera = GN_NONE};
}

gn_light_desc gn_light_desc_default(void)
{
    return (gn_light_desc){.cookie = GN_COOKIE,
                           .type = GN_LIGHT_DIRECTIONAL,
                           .color = {1, 1, 1},
                           .intensity = 1,
                           .range = INFINITY,
                           .outer_cone_angle = (float)(PI / 4),
                           .on = true};
}

gn_camera_desc gn_camera_desc_default(void)
{
    return (gn_camera_desc){.cookie = GN_COOKIE, .yfov = (float)(PI / 3), .ymag = 1, .znear = 0.1f};
}

gn_channel_desc gn_channel_desc_default(void)
{
    return (gn_channel_desc){
        .cookie = GN_COOKIE, .node = GN_NONE, .interpolation = GN_INTERPOLATION_LINEAR};
}

/* Small helpers ------------------------------------------------------------------------------ */

gn_label gn_make_label(const char *kind, uint32_t index, const char *name)
{
    gn_label label;
    if (name && name[0])
        snprintf(label.text, sizeof label.text, "%s %u \"%.240s\"", kind, index, name);
    else
        snprintf(label.text, sizeof label.text, "%s %u", kind, index);
    return label;
}

bool gn_all_finite(const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i]))
            return false;
    }
    return true;
}

static gn_result out_of_memory(gn_scene *scene, const gn_label *label)
{
    return gn_fail(scene->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", label->text);
}

static gn_result invalid(gn_scene *scene, const gn_label *label, const char *reason)
{
    return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT, "%s: %s", label->text, reason);
}

static bool in_unit_interval(float value)
{
    return value >= 0 && value <= 1; /* false for NaN */
}

/* Life --------------------------------------------------------------------------------------- */

gn_result gn_scene_create(gn_device *device, gn_scene **scene)
{
    *scene = NULL;
    gn_context *context = gn_device_context(device);
    gn_scene *made = gn_alloc_zero(context, 1, sizeof *made);
    if (!made)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "no memory for a scene");
    made->device = device;
    made->context = context;
    made->number = ++context->scenes;
    made->default_material = GN_NONE;
    *scene = made;
    return GN_OK;
}

void gn_scene_destroy(gn_scene **handle)
{
    if (!handle || !*handle)
        return;
    gn_scene *scene = *handle;
    gn_context *context = scene->context;
    if (scene->accel_destroy)
        scene->accel_destroy(scene->accel);
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        gn_free(context, scene->textures[i].rgba[0]);
        gn_free(context, scene->textures[i].name);
    }
    for (uint32_t i = 0; i < scene->material_count; i++) {
        gn_alpha_map_free(context, &scene->materials[i].alpha);
        gn_free(context, scene->materials[i].name);
    }
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        gn_mesh_free(context, &scene->meshes[i]);
    for (uint32_t i = 0; i < scene->node_count; i++)
        gn_free(context, scene->nodes[i].name);
    for (uint32_t i = 0; i < scene->channel_count; i++) {
        gn_free(context, (void *)scene->channels[i].desc.times);
        gn_free(context, (void *)scene->channels[i].desc.values);
    }
    for (uint32_t i = 0; i < scene->light_count; i++)
        gn_free(context, scene->lights[i].name);
    for (uint32_t i = 0; i < scene->camera_count; i++)
        gn_free(context, scene->cameras[i].name);
    for (uint32_t i = 0; i < scene->warning_count; i++)
        gn_free(context, scene->warnings[i]);
    gn_free(context, scene->textures);
    gn_free(context, scene->materials);
    gn_free(context, scene->meshes);
    gn_free(context, scene->nodes);
    gn_free(context, scene->channels);
    gn_free(context, scene->lights);
    gn_free(context, scene->cameras);
    gn_free(context, scene->warnings);
    gn_free(context, scene);
    *handle = NULL;
}

void gn_scene_warn(gn_scene *scene, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (uint32_t i = 0; i < scene->warning_count; i++) {
        if (strcmp(scene->warnings[i], text) == 0)
            return;
    }
    gn_log(scene->context, GN_LOG_WARNING, "%s", text);
    char *copy = gn_alloc_string(scene->context, text);
    if (!copy)
        return;
    if (!gn_grow(scene->context, (void **)&scene->warnings, scene->warning_count,
                 &scene->warning_capacity, sizeof *scene->warnings)) {
        gn_free(scene->context, copy);
        return;
    }
    scene->warnings[scene->warning_count++] = copy;
}

/* Textures ----------------------------------------------------------------------------------- */

gn_result gn_scene_add_texture(gn_scene *scene, const gn_texture_desc *desc, uint32_t *index)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_texture_desc);
    gn_label label = gn_make_label("texture", scene->texture_count, desc->name);
    if (desc->width == 0 || desc->height == 0 || desc->width > GN_MAX_TEXTURE_SIZE ||
        desc->height > GN_MAX_TEXTURE_SIZE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: %u x %u texels, must be 1 to %u each way", label.text, desc->width,
                       desc->height, GN_MAX_TEXTURE_SIZE);
    if (!desc->rgba)
        return invalid(scene, &label, "no pixels");
    if (!gn_grow(context, (void **)&scene->textures, scene->texture_count, &scene->texture_capacity,
                 sizeof *scene->textures))
        return out_of_memory(scene, &label);

    gn_texture texture = {.width = desc->width, .height = desc->height};
    texture.name = gn_alloc_string(context, desc->name);
    texture.rgba[0] = gn_alloc(context, gn_chain_texels(desc->width, desc->height), 4);
    if (!texture.name || !texture.rgba[0]) {
        gn_free(context, texture.name);
        gn_free(context, texture.rgba[0]);
        return out_of_memory(scene, &label);
    }
    memcpy(texture.rgba[0], desc->rgba, (size_t)desc->width * desc->height * 4);
    gn_result result = gn_texture_build_mips(context, &texture);
    if (result != GN_OK) {
        gn_free(context, texture.name);
        gn_free(context, texture.rgba[0]);
        return result;
    }
    if (index)
        *index = scene->texture_count;
    scene->textures[scene->texture_count++] = texture;
    scene->edits++;
    return GN_OK;
}

/* Materials ---------------------------------------------------------------------------------- */

static gn_result check_material(gn_scene *scene, const gn_material_desc *desc,
                                const gn_label *label)
{
    for (int i = 0; i < 4; i++) {
        if (!in_unit_interval(desc->base_color[i]))
            return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                           "%s: base_color[%d] is %g, must be in [0,1]", label->text, i,
                           (double)desc->base_color[i]);
    }
    if (desc->texture != GN_NONE && desc->texture >= scene->texture_count)
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: texture %u does not exist, there are %u", label->text, desc->texture,
                       scene->texture_count);
    if ((unsigned)desc->wrap_u > GN_WRAP_MIRROR || (unsigned)desc->wrap_v > GN_WRAP_MIRROR)
        return invalid(scene, label, "unknown wrap mode");
    if (!gn_all_finite(desc->uv_transform, 6))
        return invalid(scene, label, "uv_transform is not finite");
    if ((unsigned)desc->alpha_mode > GN_ALPHA_BLEND)
        return invalid(scene, label, "unknown alpha mode");
    if (!in_unit_interval(desc->alpha_cutoff))
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: alpha cutoff is %g, must be in [0,1]", label->text,
                       (double)desc->alpha_cutoff);
    return GN_OK;
}

gn_result gn_scene_add_material(gn_scene *scene, const gn_material_desc *desc, uint32_t *index)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_material_desc);
    /* The default material stays behind the caller's, so that those count from 0 without gaps. */
    const bool has_default = scene->default_material != GN_NONE;
    const uint32_t added = scene->material_count - (has_default ? 1 : 0);
    gn_label label = gn_make_label("material", added, desc->name);
    gn_result result = check_material(scene, desc, &label);
    if (result != GN_OK)
        return result;
    if (!gn_grow(context, (void **)&scene->materials, scene->material_count,
                 &scene->material_capacity, sizeof *scene->materials))
        return out_of_memory(scene, &label);

    gn_material material = {.desc = *desc};
    material.desc.cookie = 0;
    material.desc.name = NULL;
    material.name = gn_alloc_string(context, desc->name);
    if (!material.name)
        return out_of_memory(scene, &label);
    if (desc->alpha_mode != GN_ALPHA_OPAQUE) {
        const gn_texture *texture =
            desc->texture == GN_NONE ? NULL : &scene->textures[desc->texture];
        result = gn_alpha_map_build(context, texture, desc, &material.alpha);
        if (result != GN_OK) {
            gn_free(context, material.name);
            return result;
        }
        material.masked = material.alpha.levels > 0;
    }

    if (has_default) {
        scene->materials[added + 1] = scene->materials[added];
        scene->default_material = added + 1;
        for (uint32_t i = 0; i < scene->mesh_count; i++) {
            for (uint32_t p = 0; p < scene->meshes[i].part_count; p++) {
                if (scene->meshes[i].parts[p].material == added)
                    scene->meshes[i].parts[p].material = added + 1;
            }
        }
    }
    scene->materials[added] = material;
    scene->material_count++;
    scene->structure_version++;
    scene->edits++;
    if (index)
        *index = added;
    return GN_OK;
}

/* Lights and cameras ------------------------------------------------------------------------- */

gn_result gn_scene_add_light(gn_scene *scene, const gn_light_desc *desc, uint32_t *index)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_light_desc);
    gn_label label = gn_make_label("light", scene->light_count, desc->name);
    if ((unsigned)desc->type > GN_LIGHT_SPOT)
        return invalid(scene, &label, "unknown type");
    for (int i = 0; i < 3; i++) {
        if (!(desc->color[i] >= 0) || !isfinite(desc->color[i]))
            return invalid(scene, &label, "color must be finite and not negative");
    }
    if (!(desc->intensity >= 0) || !isfinite(desc->intensity))
        return invalid(scene, &label, "intensity must be finite and not negative");
    if (!(desc->range > 0))
        return invalid(scene, &label, "range must be positive");
    if (!isfinite(desc->inner_cone_angle) || !isfinite(desc->outer_cone_angle))
        return invalid(scene, &label, "cone angles must be finite");
    if (desc->type == GN_LIGHT_SPOT &&
        !(desc->inner_cone_angle >= 0 && desc->inner_cone_angle < desc->outer_cone_angle &&
          desc->outer_cone_angle <= (float)(PI / 2)))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: cone angles %g and %g, must be 0 <= inner < outer <= pi/2", label.text,
                       (double)desc->inner_cone_angle, (double)desc->outer_cone_angle);
    if (!gn_grow(context, (void **)&scene->lights, scene->light_count, &scene->light_capacity,
                 sizeof *scene->lights))
        return out_of_memory(scene, &label);

    gn_light light = {.desc = *desc, .node = GN_NONE, .direction = {0, 0, -1}};
    light.desc.cookie = 0;
    light.desc.name = NULL;
    light.name = gn_alloc_string(context, desc->name);
    if (!light.name)
        return out_of_memory(scene, &label);
    if (index)
        *index = scene->light_count;
    scene->lights[scene->light_count++] = light;
    scene->edits++;
    return GN_OK;
}

gn_result gn_scene_add_camera(gn_scene *scene, const gn_camera_desc *desc, uint32_t *index)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_camera_desc);
    gn_label label = gn_make_label("camera", scene->camera_count, desc->name);
    if (!isfinite(desc->yfov) || !isfinite(desc->ymag))
        return invalid(scene, &label, "yfov and ymag must be finite");
    if (!desc->orthographic && !(desc->yfov > 0 && desc->yfov < (float)PI))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: yfov is %g radians, must be between 0 and pi", label.text,
                       (double)desc->yfov);
    if (desc->orthographic && !(desc->ymag > 0))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: ymag is %g, must be positive",
                       label.text, (double)desc->ymag);
    if (!(desc->znear >= 0) || !isfinite(desc->znear))
        return invalid(scene, &label, "znear must be finite and not negative");
    if (!gn_grow(context, (void **)&scene->cameras, scene->camera_count, &scene->camera_capacity,
                 sizeof *scene->cameras))
        return out_of_memory(scene, &label);

    gn_camera camera = {
        .desc = *desc, .node = GN_NONE, .world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    camera.desc.cookie = 0;
    camera.desc.name = NULL;
    camera.name = gn_alloc_string(context, desc->name);
    if (!camera.name)
        return out_of_memory(scene, &label);
    if (index)
        *index = scene->camera_count;
    scene->cameras[scene->camera_count++] = camera;
    scene->edits++;
    return GN_OK;
}
