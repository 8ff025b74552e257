/* glTF nodes: the tree of the default scene, with what hangs on it. */
#include "scene/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define HALF_PI 1.57079632679489662f

/* Lights and cameras ------------------------------------------------------------------------ */

static gn_result read_switch(gn_gltf *gltf, const cJSON *item, bool *on)
{
    const cJSON *extras = cJSON_GetObjectItemCaseSensitive(item, "extras");
    return cJSON_IsObject(extras) ? gn_gltf_bool(gltf, extras, "defaultOn", on) : GN_OK;
}

static gn_result read_spot(gn_gltf *gltf, const cJSON *item, gn_light_desc *desc)
{
    const cJSON *spot = NULL;
    GN_TRY(gn_gltf_object(gltf, item, "spot", &spot));
    GN_TRY(gn_gltf_float(gltf, spot, "innerConeAngle", &desc->inner_cone_angle));
    GN_TRY(gn_gltf_float(gltf, spot, "outerConeAngle", &desc->outer_cone_angle));
    /* Pi/2 printed with few digits may be a little more. */
    if (desc->outer_cone_angle > HALF_PI && desc->outer_cone_angle < HALF_PI + 1e-4f)
        desc->outer_cone_angle = HALF_PI;
    return GN_OK;
}

static gn_result add_light(gn_gltf *gltf, uint32_t index, const cJSON *node, uint32_t *light)
{
    const cJSON *item = gltf->lights.items[index];
    gn_light_desc desc = gn_light_desc_default();
    const char *type = "";
    GN_TRY(gn_gltf_string(gltf, item, "type", &type));
    if (strcmp(type, "directional") == 0)
        desc.type = GN_LIGHT_DIRECTIONAL;
    else if (strcmp(type, "point") == 0)
        desc.type = GN_LIGHT_POINT;
    else if (strcmp(type, "spot") == 0)
        desc.type = GN_LIGHT_SPOT;
    else
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "light %u: unknown type \"%.20s\"", index, type);
    desc.name = gn_gltf_name(item)[0] ? gn_gltf_name(item) : gn_gltf_name(node);
    GN_TRY(gn_gltf_floats(gltf, item, "color", 3, desc.color));
    GN_TRY(gn_gltf_float(gltf, item, "intensity", &desc.intensity));
    if (desc.type != GN_LIGHT_DIRECTIONAL)
        GN_TRY(gn_gltf_float(gltf, item, "range", &desc.range));
    if (desc.type == GN_LIGHT_SPOT)
        GN_TRY(read_spot(gltf, item, &desc));
    GN_TRY(read_switch(gltf, item, &desc.on));
    GN_TRY(read_switch(gltf, node, &desc.on));
    const gn_result result = gn_scene_add_light(gltf->scene, &desc, light);
    return result == GN_OK ? GN_OK : gn_gltf_refail(gltf, result);
}

static gn_result add_camera(gn_gltf *gltf, uint32_t index, const cJSON *node, uint32_t *camera)
{
    const cJSON *item = gltf->cameras.items[index], *lens = NULL;
    gn_camera_desc desc = gn_camera_desc_default();
    const char *type = "";
    GN_TRY(gn_gltf_string(gltf, item, "type", &type));
    desc.orthographic = strcmp(type, "orthographic") == 0;
    if (!desc.orthographic && strcmp(type, "perspective") != 0)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "camera %u: unknown type \"%.20s\"", index,
                            type);
    GN_TRY(gn_gltf_object(gltf, item, type, &lens));
    if (!lens)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "camera %u: %s is missing", index, type);
    GN_TRY(gn_gltf_float(gltf, lens, "yfov", &desc.yfov));
    GN_TRY(gn_gltf_float(gltf, lens, "ymag", &desc.ymag));
    GN_TRY(gn_gltf_float(gltf, lens, "znear", &desc.znear));
    char number[32];
    snprintf(number, sizeof number, "camera %u", index);
    desc.name = gn_gltf_name(node)[0]   ? gn_gltf_name(node)
                : gn_gltf_name(item)[0] ? gn_gltf_name(item)
                                        : number;
    const gn_result result = gn_scene_add_camera(gltf->scene, &desc, camera);
    return result == GN_OK ? GN_OK : gn_gltf_refail(gltf, result);
}

/* Transforms -------------------------------------------------------------------------------- */

static gn_result read_transform(gn_gltf *gltf, const cJSON *node, gn_node_desc *desc)
{
    desc->use_matrix = cJSON_HasObjectItem(node, "matrix");
    if (desc->use_matrix) {
        if (cJSON_HasObjectItem(node, "translation") || cJSON_HasObjectItem(node, "rotation") ||
            cJSON_HasObjectItem(node, "scale"))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                                "it has both a matrix and translation, rotation or scale");
        return gn_gltf_floats(gltf, node, "matrix", 16, desc->matrix);
    }
    GN_TRY(gn_gltf_floats(gltf, node, "translation", 3, desc->translation));
    GN_TRY(gn_gltf_floats(gltf, node, "rotation", 4, desc->rotation));
    return gn_gltf_floats(gltf, node, "scale", 3, desc->scale);
}

/* EXT_mesh_gpu_instancing ------------------------------------------------------------------- */

typedef struct instances {
    uint32_t count;
    float *translations, *rotations, *scales; /* NULL where the file has none */
} instances;

static gn_result read_instance_attribute(gn_gltf *gltf, const cJSON *attributes, const char *name,
                                         uint32_t components, gn_gltf_rule rule, instances *set,
                                         float **values)
{
    uint32_t index = GN_NONE;
    GN_TRY(gn_gltf_index(gltf, attributes, name, &gltf->accessors, &index));
    if (index == GN_NONE)
        return GN_OK;
    gn_gltf_accessor accessor;
    GN_TRY(gn_gltf_open_accessor(gltf, index, &accessor));
    if (!accessor.data) /* else a small file could ask for any number of nodes */
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED,
                            "EXT_mesh_gpu_instancing: accessor %u has no bufferView", index);
    if (set->count != 0 && accessor.count != set->count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "EXT_mesh_gpu_instancing: %s has %u elements, another attribute %u",
                            name, accessor.count, set->count);
    set->count = accessor.count;
    return gn_gltf_read_floats(gltf, &accessor, components, rule, values);
}

static gn_result add_instances(gn_gltf *gltf, const instances *set, uint32_t parent, uint32_t mesh)
{
    for (uint32_t i = 0; i < set->count; i++) {
        gn_node_desc desc = gn_node_desc_default();
        desc.parent = parent;
        desc.mesh = mesh;
        if (set->translations)
            memcpy(desc.translation, set->translations + (size_t)i * 3, sizeof desc.translation);
        if (set->rotations)
            memcpy(desc.rotation, set->rotations + (size_t)i * 4, sizeof desc.rotation);
        if (set->scales)
            memcpy(desc.scale, set->scales + (size_t)i * 3, sizeof desc.scale);
        const gn_result result = gn_scene_add_node(gltf->scene, &desc, NULL);
        if (result != GN_OK)
            return gn_gltf_refail(gltf, result);
    }
    return GN_OK;
}

static gn_result read_instance_attributes(gn_gltf *gltf, const cJSON *extension, instances *set)
{
    const cJSON *attributes = NULL;
    GN_TRY(gn_gltf_object(gltf, extension, "attributes", &attributes));
    GN_TRY(read_instance_attribute(gltf, attributes, "TRANSLATION", 3, GN_GLTF_FLOAT, set,
                                   &set->translations));
    GN_TRY(read_instance_attribute(gltf, attributes, "ROTATION", 4, GN_GLTF_NORMALIZED, set,
                                   &set->rotations));
    return read_instance_attribute(gltf, attributes, "SCALE", 3, GN_GLTF_FLOAT, set, &set->scales);
}

static gn_result read_instances(gn_gltf *gltf, const cJSON *extension, uint32_t parent,
                                uint32_t mesh)
{
    instances set = {0};
    gn_result result = read_instance_attributes(gltf, extension, &set);
    if (result == GN_OK)
        result = add_instances(gltf, &set, parent, mesh);
    gn_free(gltf->context, set.translations);
    gn_free(gltf->context, set.rotations);
    gn_free(gltf->context, set.scales);
    return result;
}

/* The tree ---------------------------------------------------------------------------------- */

static gn_result read_node(gn_gltf *gltf, uint32_t index, uint32_t parent)
{
    gn_gltf_at(gltf, &gltf->nodes, index);
    const cJSON *node = gltf->nodes.items[index];
    uint32_t mesh = GN_NONE, light = GN_NONE, camera = GN_NONE, skin = GN_NONE;
    GN_TRY(gn_gltf_index(gltf, node, "mesh", &gltf->meshes, &mesh));
    GN_TRY(gn_gltf_index(gltf, node, "camera", &gltf->cameras, &camera));
    GN_TRY(gn_gltf_index(gltf, node, "skin", &gltf->skins, &skin));
    GN_TRY(gn_gltf_index(gltf, gn_gltf_extension(node, "KHR_lights_punctual"), "light",
                         &gltf->lights, &light));

    gn_node_desc desc = gn_node_desc_default();
    desc.name = gn_gltf_name(node);
    desc.parent = parent;
    GN_TRY(read_transform(gltf, node, &desc));
    if (light != GN_NONE)
        GN_TRY(add_light(gltf, light, node, &desc.light));
    if (camera != GN_NONE)
        GN_TRY(add_camera(gltf, camera, node, &desc.camera));
    if (skin != GN_NONE) {
        const gn_label label = gn_make_label("skin", skin, gn_gltf_name(gltf->skins.items[skin]));
        gn_scene_warn(gltf->scene,
                      "%.100s: skins are not supported; the mesh is shown in its bind pose",
                      label.text);
    }
    const cJSON *instancing = gn_gltf_extension(node, "EXT_mesh_gpu_instancing");
    if (mesh != GN_NONE && !instancing)
        desc.mesh = gltf->mesh_indices[mesh];
    const gn_result result = gn_scene_add_node(gltf->scene, &desc, &gltf->node_indices[index]);
    if (result != GN_OK)
        return gn_gltf_refail(gltf, result);
    if (mesh != GN_NONE && instancing && gltf->mesh_indices[mesh] != GN_NONE)
        GN_TRY(
            read_instances(gltf, instancing, gltf->node_indices[index], gltf->mesh_indices[mesh]));
    return GN_OK;
}

/* Fills parents (GN_NONE: a root); refuses two parents and cycles. */
static gn_result find_parents(gn_gltf *gltf, uint32_t *parents, uint32_t *visits)
{
    const uint32_t count = gltf->nodes.count;
    memset(parents, 0xff, count * sizeof *parents);
    memset(visits, 0xff, count * sizeof *visits);
    for (uint32_t i = 0; i < count; i++) {
        gn_gltf_at(gltf, &gltf->nodes, i);
        const cJSON *children = NULL, *item = NULL;
        GN_TRY(gn_gltf_array(gltf, gltf->nodes.items[i], "children", &children));
        cJSON_ArrayForEach(item, children)
        {
            uint32_t child = GN_NONE;
            GN_TRY(gn_gltf_index(gltf, item, "child", &gltf->nodes, &child));
            if (parents[child] != GN_NONE)
                return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "its child %u is a child of node %u too",
                                    child, parents[child]);
            parents[child] = i;
        }
    }
    /* Going up from each node must not come back to where that walk has been. */
    for (uint32_t i = 0; i < count; i++) {
        uint32_t node = i;
        while (node != GN_NONE && visits[node] == GN_NONE) {
            visits[node] = i;
            node = parents[node];
        }
        if (node != GN_NONE && visits[node] == i) {
            gn_gltf_at(gltf, &gltf->nodes, node);
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "it is its own ancestor");
        }
    }
    return GN_OK;
}

/* Puts the roots of the default scene on the stack, the last one first. Without scenes all roots
 * are taken. */
static gn_result push_roots(gn_gltf *gltf, const uint32_t *parents, uint32_t *stack,
                            uint32_t *depth)
{
    gltf->where[0] = '\0';
    uint32_t scene = gltf->scenes.count > 0 ? 0 : GN_NONE;
    GN_TRY(gn_gltf_index(gltf, gltf->root, "scene", &gltf->scenes, &scene));
    if (scene == GN_NONE) {
        for (uint32_t i = gltf->nodes.count; i-- > 0;) {
            if (parents[i] == GN_NONE)
                stack[(*depth)++] = i;
        }
        return GN_OK;
    }
    gn_gltf_at(gltf, &gltf->scenes, scene);
    const cJSON *roots = NULL, *item = NULL;
    GN_TRY(gn_gltf_array(gltf, gltf->scenes.items[scene], "nodes", &roots));
    if (cJSON_GetArraySize(roots) > (int)gltf->nodes.count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "it names a node twice");
    cJSON_ArrayForEach(item, roots)
    {
        uint32_t node = GN_NONE;
        GN_TRY(gn_gltf_index(gltf, item, "node", &gltf->nodes, &node));
        if (parents[node] != GN_NONE)
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "its node %u is a child of node %u", node,
                                parents[node]);
        stack[(*depth)++] = node;
    }
    for (uint32_t i = 0; i < *depth / 2; i++) {
        const uint32_t other = stack[*depth - 1 - i];
        stack[*depth - 1 - i] = stack[i];
        stack[i] = other;
    }
    return GN_OK;
}

/* Parents before children, in the order of the file. Each node has one parent at most and there
 * are no cycles, so that the stack never holds a node twice, unless a scene names it twice. */
static gn_result read_tree(gn_gltf *gltf, uint32_t *parents, uint32_t *stack)
{
    uint32_t depth = 0, added = 0;
    GN_TRY(find_parents(gltf, parents, stack));
    GN_TRY(push_roots(gltf, parents, stack, &depth));
    while (depth > 0) {
        const uint32_t index = stack[--depth], parent = parents[index];
        if (gltf->node_indices[index] != GN_NONE)
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "the scene names node %u twice", index);
        GN_TRY(read_node(gltf, index, parent == GN_NONE ? GN_NONE : gltf->node_indices[parent]));
        added++;
        const cJSON *children =
            cJSON_GetObjectItemCaseSensitive(gltf->nodes.items[index], "children");
        const uint32_t first = depth;
        const cJSON *item = NULL;
        cJSON_ArrayForEach(item, children) stack[depth++] = (uint32_t)item->valuedouble;
        for (uint32_t low = first, high = depth; low + 1 < high; low++) {
            const uint32_t other = stack[--high];
            stack[high] = stack[low];
            stack[low] = other;
        }
    }
    if (added < gltf->nodes.count)
        gn_scene_warn(gltf->scene, "%u nodes are not in the default scene; left out",
                      gltf->nodes.count - added);
    gltf->where[0] = '\0';
    return GN_OK;
}

gn_result gn_gltf_read_nodes(gn_gltf *gltf)
{
    const size_t count = gltf->nodes.count;
    uint32_t *parents = gn_alloc(gltf->context, count, sizeof *parents);
    uint32_t *stack = gn_alloc(gltf->context, 2 * count, sizeof *stack);
    const gn_result result =
        parents && stack ? read_tree(gltf, parents, stack) : gn_gltf_no_memory(gltf);
    gn_free(gltf->context, parents);
    gn_free(gltf->context, stack);
    return result;
}
