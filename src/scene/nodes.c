/* Nodes: the hierarchy, what hangs on it, and where everything is. */
#include "scene/scene.h"

#include <math.h>
#include <string.h>

#include <cglm/cglm.h>

void gn_compose(const float translation[3], const float rotation[4], const float scale[3],
                float matrix[16])
{
    versor q = {rotation[0], rotation[1], rotation[2], rotation[3]};
    mat4 m;
    glm_quat_mat4(q, m);
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++)
            m[column][row] *= scale[column];
        m[3][column] = translation[column];
    }
    memcpy(matrix, m, sizeof m);
}

static bool is_affine(const float matrix[16])
{
    return gn_all_finite(matrix, 16) && matrix[3] == 0 && matrix[7] == 0 && matrix[11] == 0 &&
           matrix[15] == 1;
}

static bool normalize_quaternion(float q[4])
{
    const double length =
        sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] + (double)q[3] * q[3]);
    for (int i = 0; i < 4; i++)
        q[i] = (float)(q[i] / length);
    return length > 0;
}

/* Editing ------------------------------------------------------------------------------------ */

static gn_result check_reference(gn_scene *scene, const gn_label *label, const char *kind,
                                 uint32_t index, uint32_t count)
{
    if (index == GN_NONE || index < count)
        return GN_OK;
    return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                   "%s: %s %u does not exist, there are %u", label->text, kind, index, count);
}

static gn_result check_node(gn_scene *scene, const gn_node_desc *desc, const gn_label *label)
{
    gn_context *context = scene->context;
    gn_result result = check_reference(scene, label, "parent", desc->parent, scene->node_count);
    if (result == GN_OK)
        result = check_reference(scene, label, "mesh", desc->mesh, scene->mesh_count);
    if (result == GN_OK)
        result = check_reference(scene, label, "light", desc->light, scene->light_count);
    if (result == GN_OK)
        result = check_reference(scene, label, "camera", desc->camera, scene->camera_count);
    if (result != GN_OK)
        return result;
    if (desc->light != GN_NONE && scene->lights[desc->light].node != GN_NONE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: light %u already hangs on node %u",
                       label->text, desc->light, scene->lights[desc->light].node);
    if (desc->camera != GN_NONE && scene->cameras[desc->camera].node != GN_NONE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: camera %u already hangs on node %u",
                       label->text, desc->camera, scene->cameras[desc->camera].node);
    if (desc->use_matrix && !is_affine(desc->matrix))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: the matrix is not affine and finite (last row 0 0 0 1)", label->text);
    if (!gn_all_finite(desc->translation, 3) || !gn_all_finite(desc->rotation, 4) ||
        !gn_all_finite(desc->scale, 3))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: translation, rotation or scale is not finite", label->text);
    return GN_OK;
}

gn_result gn_scene_add_node(gn_scene *scene, const gn_node_desc *desc, uint32_t *index)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_node_desc);
    gn_label label = gn_make_label("node", scene->node_count, desc->name);
    gn_result result = check_node(scene, desc, &label);
    if (result != GN_OK)
        return result;

    gn_node node = {.desc = *desc};
    node.desc.cookie = 0;
    node.desc.name = NULL;
    if (!normalize_quaternion(node.desc.rotation))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: the rotation has no length",
                       label.text);
    memcpy(node.translation, node.desc.translation, sizeof node.translation);
    memcpy(node.rotation, node.desc.rotation, sizeof node.rotation);
    memcpy(node.scale, node.desc.scale, sizeof node.scale);
    if (desc->use_matrix)
        memcpy(node.local, desc->matrix, sizeof node.local);
    else
        gn_compose(node.translation, node.rotation, node.scale, node.local);
    node.name = gn_alloc_string(context, desc->name);
    if (!node.name || !gn_grow(context, (void **)&scene->nodes, scene->node_count,
                               &scene->node_capacity, sizeof *scene->nodes)) {
        gn_free(context, node.name);
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", label.text);
    }
    if (desc->light != GN_NONE)
        scene->lights[desc->light].node = scene->node_count;
    if (desc->camera != GN_NONE)
        scene->cameras[desc->camera].node = scene->node_count;
    if (index)
        *index = scene->node_count;
    scene->nodes[scene->node_count++] = node;
    scene->structure_version++;
    scene->edits++;
    return GN_OK;
}

gn_result gn_scene_set_node_matrix(gn_scene *scene, uint32_t node, const float matrix[16])
{
    if (node >= scene->node_count)
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                       "node %u does not exist, there are %u", node, scene->node_count);
    if (!is_affine(matrix))
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: the matrix is not affine and finite (last row 0 0 0 1)",
                       gn_make_label("node", node, scene->nodes[node].name).text);
    memcpy(scene->nodes[node].local, matrix, sizeof scene->nodes[node].local);
    scene->nodes[node].animated = true;
    scene->edits++;
    return GN_OK;
}

/* Resolving ---------------------------------------------------------------------------------- */

static void cross(const float a[3], const float b[3], float result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

/* In double, so that no finite vector over- or underflows. False without a direction. */
static bool normalize(float v[3])
{
    const double length = sqrt((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2]);
    if (!(length > 0))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] = (float)(v[i] / length);
    return true;
}

/* The frame that looks where world's -Z looks, with its +Y as far up as that allows: scale, mirror
 * and shear are gone. Axes that a scale of 0 took away are replaced by any that fit. */
static void orthonormal_frame(const float world[16], float frame[16])
{
    float x[3], y[3], z[3];
    memcpy(x, world, sizeof x);
    memcpy(y, world + 4, sizeof y);
    memcpy(z, world + 8, sizeof z);
    const bool has_y = normalize(y);
    if (!normalize(z)) {
        cross(x, y, z);
        if (!normalize(z))
            memcpy(z, (float[3]){0, 0, 1}, sizeof z);
    }
    if (has_y)
        cross(y, z, x);
    if (!has_y || !normalize(x)) {
        cross(fabsf(z[1]) < 0.9f ? (float[3]){0, 1, 0} : (float[3]){0, 0, 1}, z, x);
        normalize(x);
    }
    cross(z, x, y);
    normalize(y);
    memset(frame, 0, 16 * sizeof *frame);
    memcpy(frame, x, sizeof x);
    memcpy(frame + 4, y, sizeof y);
    memcpy(frame + 8, z, sizeof z);
    memcpy(frame + 12, world + 12, 3 * sizeof *frame);
    frame[15] = 1;
}

/* Parents come before children, so that one pass suffices. */
static gn_result resolve_nodes(gn_scene *scene)
{
    bool moved = false;
    gn_result result = GN_OK;
    for (uint32_t i = 0; result == GN_OK && i < scene->node_count; i++) {
        gn_node *node = &scene->nodes[i];
        mat4 world;
        memcpy(world, node->local, sizeof world);
        if (node->desc.parent != GN_NONE) {
            const gn_node *parent = &scene->nodes[node->desc.parent];
            mat4 above;
            memcpy(above, parent->world, sizeof above);
            glm_mul(above, world, world);
            node->animated |= parent->animated;
        }
        if (!gn_all_finite(world[0], 16))
            result = gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                             "%s: its place in the world is not finite",
                             gn_make_label("node", i, node->name).text);
        if (memcmp(node->world, world, sizeof world) != 0) {
            memcpy(node->world, world, sizeof world);
            moved = true;
        }
    }
    if (moved)
        scene->transform_version++;
    return result;
}

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static const float *world_of(const gn_scene *scene, uint32_t node)
{
    return node == GN_NONE ? identity : scene->nodes[node].world;
}

/* The box of a mesh's box under world, axis by axis (Arvo 1990), in double so that huge but finite
 * scenes stay finite until the end. */
static void grow_bounds(gn_scene *scene, const float world[16], const gn_mesh *mesh)
{
    for (int axis = 0; axis < 3; axis++) {
        double low = world[12 + axis], high = world[12 + axis];
        for (int k = 0; k < 3; k++) {
            const double a = (double)world[4 * k + axis] * mesh->bounds_min[k];
            const double b = (double)world[4 * k + axis] * mesh->bounds_max[k];
            low += fmin(a, b);
            high += fmax(a, b);
        }
        scene->bounds_min[axis] = fminf(scene->bounds_min[axis], (float)low);
        scene->bounds_max[axis] = fmaxf(scene->bounds_max[axis], (float)high);
    }
}

static gn_result resolve_bounds(gn_scene *scene)
{
    bool empty = true;
    for (int axis = 0; axis < 3; axis++) {
        scene->bounds_min[axis] = INFINITY;
        scene->bounds_max[axis] = -INFINITY;
    }
    for (uint32_t i = 0; i < scene->node_count; i++) {
        const gn_node *node = &scene->nodes[i];
        if (node->desc.mesh == GN_NONE)
            continue;
        empty = false;
        grow_bounds(scene, node->world, &scene->meshes[node->desc.mesh]);
        if (!gn_all_finite(scene->bounds_min, 3) || !gn_all_finite(scene->bounds_max, 3))
            return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                           "%s: its mesh reaches beyond what floats can hold",
                           gn_make_label("node", i, node->name).text);
    }
    if (empty) {
        memset(scene->bounds_min, 0, sizeof scene->bounds_min);
        memset(scene->bounds_max, 0, sizeof scene->bounds_max);
    }
    return GN_OK;
}

gn_result gn_scene_resolve(gn_scene *scene)
{
    gn_result result = resolve_nodes(scene);
    if (result != GN_OK)
        return result;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        gn_light *light = &scene->lights[i];
        float frame[16];
        orthonormal_frame(world_of(scene, light->node), frame);
        for (int axis = 0; axis < 3; axis++) {
            light->position[axis] = frame[12 + axis];
            light->direction[axis] = -frame[8 + axis];
        }
    }
    for (uint32_t i = 0; i < scene->camera_count; i++)
        orthonormal_frame(world_of(scene, scene->cameras[i].node), scene->cameras[i].world);
    return resolve_bounds(scene);
}

/* Conveniences ------------------------------------------------------------------------------- */

/* A rotation that turns +Z to azimuth (clockwise from -Z seen from above) and elevation; radians.*/
static void aim(double azimuth, double elevation, float rotation[4])
{
    /* A turn about Y by pi - azimuth after one about X by -elevation. */
    const double y = (GLM_PI - azimuth) / 2, x = -elevation / 2;
    rotation[0] = (float)(cos(y) * sin(x));
    rotation[1] = (float)(sin(y) * cos(x));
    rotation[2] = (float)(-sin(y) * sin(x));
    rotation[3] = (float)(cos(y) * cos(x));
}

gn_result gn_scene_add_sun(gn_scene *scene, double azimuth, double elevation, uint32_t *light)
{
    if (!isfinite(azimuth) || !(elevation >= -90 && elevation <= 90))
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                       "sun: azimuth %g, elevation %g; the elevation must be in [-90,90] degrees",
                       azimuth, elevation);
    gn_light_desc desc = gn_light_desc_default();
    desc.name = "sun";
    uint32_t index;
    gn_result result = gn_scene_add_light(scene, &desc, &index);
    if (result != GN_OK)
        return result;
    gn_node_desc node = gn_node_desc_default();
    node.name = "sun";
    node.light = index;
    aim(fmod(azimuth, 360) * GLM_PI / 180, elevation * GLM_PI / 180, node.rotation);
    result = gn_scene_add_node(scene, &node, NULL);
    if (result != GN_OK) {
        gn_free(scene->context, scene->lights[--scene->light_count].name);
        return result;
    }
    if (light)
        *light = index;
    return GN_OK;
}

gn_result gn_scene_add_overview(gn_scene *scene, uint32_t *camera)
{
    if (scene->edits != scene->committed)
        return gn_fail(scene->context, GN_ERROR_STATE,
                       "overview: the scene must be committed first");
    double center[3], radius = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double half = ((double)scene->bounds_max[axis] - scene->bounds_min[axis]) / 2;
        center[axis] = scene->bounds_min[axis] + half;
        radius += half * half;
    }
    radius = sqrt(radius);
    if (!(radius > 0))
        return gn_fail(scene->context, GN_ERROR_STATE, "overview: the scene has nothing to show");

    gn_camera_desc desc = gn_camera_desc_default();
    desc.name = "overview";
    desc.yfov = (float)(GLM_PI / 4);
    const double distance = radius / sin(GLM_PI / 8); /* the bounding sphere touches the view */
    desc.znear = (float)(distance * 1e-3);
    uint32_t index;
    gn_result result = gn_scene_add_camera(scene, &desc, &index);
    if (result != GN_OK)
        return result;

    const double azimuth = GLM_PI * 145 / 180, elevation = GLM_PI * 20 / 180;
    gn_node_desc node = gn_node_desc_default();
    node.name = "overview";
    node.camera = index;
    aim(azimuth, elevation, node.rotation);
    node.translation[0] = (float)(center[0] + distance * cos(elevation) * sin(azimuth));
    node.translation[1] = (float)(center[1] + distance * sin(elevation));
    node.translation[2] = (float)(center[2] - distance * cos(elevation) * cos(azimuth));
    result = gn_scene_add_node(scene, &node, NULL);
    if (result != GN_OK) {
        gn_free(scene->context, scene->cameras[--scene->camera_count].name);
        return result;
    }
    if (camera)
        *camera = index;
    return GN_OK;
}
