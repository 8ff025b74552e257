/* Scenes to binary glTF 2.0: what becomes of each thing in a scene. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gnomon/procedural.h>

#include "scene/glb.h"

enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER = 34963, FLOAT = 5126, SHORT = 5123, INT = 5125 };

static cJSON *add_accessor(gn_glb *w, gn_glb_piece data, int target, int type, const char *shape,
                           uint32_t *index)
{
    uint32_t view = gn_glb_add_view(w, data, target);
    cJSON *accessor = gn_glb_add(w, GN_GLB_ACCESSORS, index);
    gn_glb_put_number(w, accessor, "bufferView", view);
    gn_glb_put_number(w, accessor, "componentType", type);
    gn_glb_put_number(w, accessor, "count", (double)data.count);
    gn_glb_put(w, accessor, "type", cJSON_CreateString(shape));
    return accessor;
}

static void put_bounds(gn_glb *w, cJSON *accessor, const float *values, uint32_t count,
                       uint32_t components)
{
    float low[3], high[3];
    for (uint32_t c = 0; c < components; c++) {
        low[c] = high[c] = values[c];
        for (uint32_t i = 1; i < count; i++) {
            float value = values[(size_t)i * components + c];
            low[c] = value < low[c] ? value : low[c];
            high[c] = value > high[c] ? value : high[c];
        }
    }
    gn_glb_put_floats(w, accessor, "min", low, (int)components);
    gn_glb_put_floats(w, accessor, "max", high, (int)components);
}

static float length3(const float v[3])
{
    return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static bool are_unit_length(const float *normals, uint32_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(length3(normals + 3 * i) - 1) < 1e-3f))
            return false;
    return true;
}

/* Materials --------------------------------------------------------------------------------- */

/* glTF keeps the wrap modes with the texture: one of the file's textures for each pair in use. */
static uint32_t find_texture(gn_glb *w, uint32_t image, gn_wrap wrap_u, gn_wrap wrap_v)
{
    static const int modes[3] = {10497, 33071, 33648};
    uint32_t *known = &w->lookup[9 * (size_t)image + 3 * (size_t)wrap_u + (size_t)wrap_v];
    if (*known != GN_NONE)
        return *known;
    uint32_t sampler_index;
    cJSON *sampler = gn_glb_add(w, GN_GLB_SAMPLERS, &sampler_index);
    gn_glb_put_number(w, sampler, "magFilter", 9729);
    gn_glb_put_number(w, sampler, "minFilter", 9987);
    gn_glb_put_number(w, sampler, "wrapS", modes[wrap_u]);
    gn_glb_put_number(w, sampler, "wrapT", modes[wrap_v]);
    cJSON *texture = gn_glb_add(w, GN_GLB_TEXTURES, known);
    gn_glb_put_number(w, texture, "sampler", sampler_index);
    gn_glb_put_number(w, texture, "source", image);
    return *known;
}

static void add_materials(gn_glb *w)
{
    for (uint32_t i = 0; i < w->scene->material_count; i++) {
        if (i == w->scene->default_material)
            continue;
        const gn_material *material = &w->scene->materials[i];
        const gn_material_desc *desc = &material->desc;
        cJSON *item = gn_glb_add(w, GN_GLB_MATERIALS, NULL);
        gn_glb_put_name(w, item, material->name);
        cJSON *surface = gn_glb_put(w, item, "pbrMetallicRoughness", cJSON_CreateObject());
        gn_glb_put_floats(w, surface, "baseColorFactor", desc->base_color, 4);
        gn_glb_put_number(w, surface, "metallicFactor", 0);
        gn_glb_put_number(w, surface, "roughnessFactor", 1);
        if (desc->texture != GN_NONE) {
            uint32_t texture = find_texture(w, desc->texture, desc->wrap_u, desc->wrap_v);
            cJSON *reference = gn_glb_put(w, surface, "baseColorTexture", cJSON_CreateObject());
            gn_glb_put_number(w, reference, "index", texture);
        }
        if (desc->alpha_mode != GN_ALPHA_OPAQUE) {
            bool mask = desc->alpha_mode == GN_ALPHA_MASK;
            gn_glb_put(w, item, "alphaMode", cJSON_CreateString(mask ? "MASK" : "BLEND"));
            if (mask)
                gn_glb_put_number(w, item, "alphaCutoff", (double)desc->alpha_cutoff);
        }
        if (desc->double_sided)
            gn_glb_put(w, item, "doubleSided", cJSON_CreateTrue());
    }
}

/* Meshes ------------------------------------------------------------------------------------ */

static void add_part(gn_glb *w, const gn_part *part, cJSON *primitives)
{
    uint32_t vertices = part->vertex_count, indices = 3 * part->triangle_count, accessor;
    cJSON *primitive = gn_glb_append(w, primitives, cJSON_CreateObject());
    cJSON *attributes = gn_glb_put(w, primitive, "attributes", cJSON_CreateObject());
    gn_glb_piece data = {GN_GLB_PLAIN, part->positions, vertices, 12};
    cJSON *positions = add_accessor(w, data, ARRAY_BUFFER, FLOAT, "VEC3", &accessor);
    put_bounds(w, positions, part->positions, vertices, 3);
    gn_glb_put_number(w, attributes, "POSITION", accessor);
    if (part->normals) {
        data = (gn_glb_piece){GN_GLB_PLAIN, part->normals, vertices, 12};
        if (!are_unit_length(part->normals, vertices))
            data.form = GN_GLB_UNIT_LENGTH;
        add_accessor(w, data, ARRAY_BUFFER, FLOAT, "VEC3", &accessor);
        gn_glb_put_number(w, attributes, "NORMAL", accessor);
    }
    /* A texture needs coordinates, if only zeros; without a texture nobody reads them. */
    if (w->scene->materials[part->material].desc.texture != GN_NONE) {
        data = (gn_glb_piece){part->uvs ? GN_GLB_PLAIN : GN_GLB_ZERO, part->uvs, vertices, 8};
        add_accessor(w, data, ARRAY_BUFFER, FLOAT, "VEC2", &accessor);
        gn_glb_put_number(w, attributes, "TEXCOORD_0", accessor);
    }
    /* 65535 is no index in 16 bits, but a mark. */
    bool narrow = vertices <= 65535;
    data = (gn_glb_piece){narrow ? GN_GLB_SHORTENED : GN_GLB_PLAIN, part->indices, indices,
                          narrow ? 2 : 4};
    add_accessor(w, data, ELEMENT_ARRAY_BUFFER, narrow ? SHORT : INT, "SCALAR", &accessor);
    gn_glb_put_number(w, primitive, "indices", accessor);
    if (part->material != w->scene->default_material)
        gn_glb_put_number(w, primitive, "material", part->material);
}

static void add_meshes(gn_glb *w)
{
    for (uint32_t i = 0; i < w->scene->mesh_count; i++) {
        const gn_mesh *mesh = &w->scene->meshes[i];
        cJSON *item = gn_glb_add(w, GN_GLB_MESHES, NULL);
        gn_glb_put_name(w, item, mesh->name);
        cJSON *primitives = gn_glb_put(w, item, "primitives", cJSON_CreateArray());
        for (uint32_t k = 0; k < mesh->part_count; k++)
            add_part(w, &mesh->parts[k], primitives);
    }
}

/* Lights and cameras ------------------------------------------------------------------------ */

static void add_lights(gn_glb *w)
{
    static const char *const types[3] = {"directional", "point", "spot"};
    for (uint32_t i = 0; i < w->scene->light_count; i++) {
        const gn_light_desc *desc = &w->scene->lights[i].desc;
        /* glTF's colours end at 1: what is brighter goes into the intensity. */
        float brightest = fmaxf(fmaxf(desc->color[0], desc->color[1]), fmaxf(desc->color[2], 1));
        const float color[3] = {desc->color[0] / brightest, desc->color[1] / brightest,
                                desc->color[2] / brightest};
        cJSON *item = gn_glb_add(w, GN_GLB_LIGHTS, NULL);
        gn_glb_put_name(w, item, w->scene->lights[i].name);
        gn_glb_put(w, item, "type", cJSON_CreateString(types[desc->type]));
        gn_glb_put_floats(w, item, "color", color, 3);
        gn_glb_put_number(w, item, "intensity", (double)(desc->intensity * brightest));
        if (desc->type != GN_LIGHT_DIRECTIONAL && isfinite(desc->range))
            gn_glb_put_number(w, item, "range", (double)desc->range);
        if (desc->type == GN_LIGHT_SPOT) {
            cJSON *spot = gn_glb_put(w, item, "spot", cJSON_CreateObject());
            gn_glb_put_number(w, spot, "innerConeAngle", (double)desc->inner_cone_angle);
            /* The float nearest to pi / 2 lies above it. */
            gn_glb_put_number(w, spot, "outerConeAngle",
                              fmin((double)desc->outer_cone_angle, M_PI_2));
        }
    }
}

static void add_cameras(gn_glb *w)
{
    for (uint32_t i = 0; i < w->scene->camera_count; i++) {
        const gn_camera_desc *desc = &w->scene->cameras[i].desc;
        cJSON *item = gn_glb_add(w, GN_GLB_CAMERAS, NULL);
        gn_glb_put_name(w, item, w->scene->cameras[i].name);
        const char *type = desc->orthographic ? "orthographic" : "perspective";
        gn_glb_put(w, item, "type", cJSON_CreateString(type));
        cJSON *lens = gn_glb_put(w, item, type, cJSON_CreateObject());
        if (desc->orthographic) {
            gn_glb_put_number(w, lens, "xmag", (double)desc->ymag * 16 / 9);
            gn_glb_put_number(w, lens, "ymag", (double)desc->ymag);
            /* Required, but nothing is too far for us. */
            gn_glb_put_number(w, lens, "zfar", ((double)desc->znear + (double)desc->ymag) * 1e4);
            gn_glb_put_number(w, lens, "znear", (double)desc->znear);
        } else {
            gn_glb_put_number(w, lens, "yfov", (double)desc->yfov);
            gn_glb_put_number(w, lens, "znear", (double)fmaxf(desc->znear, FLT_MIN));
        }
    }
}

/* Nodes ------------------------------------------------------------------------------------- */

static bool all_equal(const float *values, const float *others, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (values[i] != others[i])
            return false;
    return true;
}

static void put_light(gn_glb *w, cJSON *node, uint32_t light)
{
    cJSON *extensions = gn_glb_put(w, node, "extensions", cJSON_CreateObject());
    cJSON *reference = gn_glb_put(w, extensions, "KHR_lights_punctual", cJSON_CreateObject());
    gn_glb_put_number(w, reference, "light", light);
    if (!w->scene->lights[light].desc.on) {
        cJSON *extras = gn_glb_put(w, node, "extras", cJSON_CreateObject());
        gn_glb_put(w, extras, "defaultOn", cJSON_CreateFalse());
    }
}

/* As the node was added, unless somebody moved it since by a matrix. */
static void put_transform(gn_glb *w, cJSON *item, const gn_node *node)
{
    static const float zero[3], one[3] = {1, 1, 1}, level[4] = {0, 0, 0, 1};
    const gn_node_desc *desc = &node->desc;
    float matrix[16], identity[16];
    gn_compose(zero, level, one, identity);
    if (desc->use_matrix)
        memcpy(matrix, desc->matrix, sizeof matrix);
    else
        gn_compose(desc->translation, desc->rotation, desc->scale, matrix);
    if (node->paths == 0 && (desc->use_matrix || !all_equal(matrix, node->local, 16))) {
        if (!all_equal(node->local, identity, 16))
            gn_glb_put_floats(w, item, "matrix", node->local, 16);
        return;
    }
    if (!all_equal(desc->translation, zero, 3))
        gn_glb_put_floats(w, item, "translation", desc->translation, 3);
    if (!all_equal(desc->rotation, level, 4))
        gn_glb_put_floats(w, item, "rotation", desc->rotation, 4);
    if (!all_equal(desc->scale, one, 3))
        gn_glb_put_floats(w, item, "scale", desc->scale, 3);
}

static void add_node(gn_glb *w, uint32_t index)
{
    const gn_node *node = &w->scene->nodes[index];
    cJSON *item = w->nodes[index] = gn_glb_add(w, GN_GLB_NODES, NULL);
    gn_glb_put_name(w, item, node->name);
    put_transform(w, item, node);
    if (node->desc.mesh != GN_NONE)
        gn_glb_put_number(w, item, "mesh", node->desc.mesh);
    if (node->desc.camera != GN_NONE)
        gn_glb_put_number(w, item, "camera", node->desc.camera);
    if (node->desc.light != GN_NONE)
        put_light(w, item, node->desc.light);
    cJSON *list = w->roots;
    if (node->desc.parent != GN_NONE) {
        cJSON *parent = w->nodes[node->desc.parent];
        list = cJSON_GetObjectItemCaseSensitive(parent, "children");
        if (!list)
            list = gn_glb_put(w, parent, "children", cJSON_CreateArray());
    }
    gn_glb_append(w, list, cJSON_CreateNumber(index));
}

static void add_nodes(gn_glb *w)
{
    for (uint32_t i = 0; i < w->scene->node_count; i++)
        add_node(w, i);
    /* In glTF everything hangs on a node. */
    uint32_t index;
    for (uint32_t i = 0; i < w->scene->light_count; i++)
        if (w->scene->lights[i].node == GN_NONE) {
            cJSON *item = gn_glb_add(w, GN_GLB_NODES, &index);
            gn_glb_put_name(w, item, w->scene->lights[i].name);
            put_light(w, item, i);
            gn_glb_append(w, w->roots, cJSON_CreateNumber(index));
        }
    for (uint32_t i = 0; i < w->scene->camera_count; i++)
        if (w->scene->cameras[i].node == GN_NONE) {
            cJSON *item = gn_glb_add(w, GN_GLB_NODES, &index);
            gn_glb_put_name(w, item, w->scene->cameras[i].name);
            gn_glb_put_number(w, item, "camera", i);
            gn_glb_append(w, w->roots, cJSON_CreateNumber(index));
        }
}

static void add_animation(gn_glb *w)
{
    static const char *const ways[3] = {"STEP", "LINEAR", "CUBICSPLINE"};
    static const char *const paths[3] = {"translation", "rotation", "scale"};
    if (w->scene->channel_count == 0)
        return;
    cJSON *animation = gn_glb_add(w, GN_GLB_ANIMATIONS, NULL);
    cJSON *channels = gn_glb_put(w, animation, "channels", cJSON_CreateArray());
    cJSON *samplers = gn_glb_put(w, animation, "samplers", cJSON_CreateArray());
    for (uint32_t i = 0; i < w->scene->channel_count; i++) {
        const gn_channel_desc *desc = &w->scene->channels[i].desc;
        uint32_t times, values, keys = desc->key_count;
        bool turns = desc->path == GN_PATH_ROTATION;
        gn_glb_piece data = {GN_GLB_PLAIN, desc->times, keys, 4};
        cJSON *accessor = add_accessor(w, data, 0, FLOAT, "SCALAR", &times);
        put_bounds(w, accessor, desc->times, keys, 1);
        uint64_t elements =
            (uint64_t)keys * (desc->interpolation == GN_INTERPOLATION_CUBICSPLINE ? 3 : 1);
        data = (gn_glb_piece){GN_GLB_PLAIN, desc->values, elements, turns ? 16 : 12};
        add_accessor(w, data, 0, FLOAT, turns ? "VEC4" : "VEC3", &values);
        cJSON *sampler = gn_glb_append(w, samplers, cJSON_CreateObject());
        gn_glb_put_number(w, sampler, "input", times);
        gn_glb_put_number(w, sampler, "output", values);
        gn_glb_put(w, sampler, "interpolation", cJSON_CreateString(ways[desc->interpolation]));
        cJSON *channel = gn_glb_append(w, channels, cJSON_CreateObject());
        gn_glb_put_number(w, channel, "sampler", i);
        cJSON *target = gn_glb_put(w, channel, "target", cJSON_CreateObject());
        gn_glb_put_number(w, target, "node", desc->node);
        gn_glb_put(w, target, "path", cJSON_CreateString(paths[desc->path]));
    }
}

/* File -------------------------------------------------------------------------------------- */

static gn_result no_memory(const gn_glb *w)
{
    return gn_fail(w->context, GN_ERROR_OUT_OF_MEMORY, "%s: no memory to write the scene", w->path);
}

static gn_result write_scene(gn_glb *w)
{
    gn_result result = gn_glb_add_images(w);
    if (result != GN_OK)
        return result;
    add_materials(w);
    add_meshes(w);
    add_lights(w);
    add_cameras(w);
    add_nodes(w);
    add_animation(w);
    gn_glb_assemble(w);
    char *json = w->out_of_memory ? NULL : cJSON_PrintUnformatted(w->root);
    if (!json)
        return no_memory(w);
    gn_file file;
    result = gn_file_begin(w->context, w->path, &file);
    if (result == GN_OK) {
        result = gn_glb_write_file(w, &file, json);
        if (result == GN_OK)
            result = gn_file_commit(&file);
        else
            gn_file_abort(&file);
    }
    cJSON_free(json);
    return result;
}

gn_result gn_scene_write_glb(const gn_scene *scene, const char *path)
{
    gn_context *context = scene->context;
    gn_glb w = {.scene = scene, .context = context, .path = path ? path : ""};
    size_t lookups = 9 * (size_t)scene->texture_count;
    w.root = cJSON_CreateObject();
    w.roots = cJSON_CreateArray();
    w.nodes = gn_alloc_zero(context, scene->node_count, sizeof *w.nodes);
    w.pngs = gn_alloc_zero(context, scene->texture_count, sizeof *w.pngs);
    w.lookup = gn_alloc(context, lookups, sizeof *w.lookup);
    bool ready = w.root && w.roots && w.nodes && w.pngs && w.lookup;
    for (gn_glb_array kind = 0; kind < GN_GLB_ARRAYS; kind++) {
        w.arrays[kind] = cJSON_CreateArray();
        ready = ready && w.arrays[kind];
    }
    for (size_t i = 0; i < lookups && ready; i++)
        w.lookup[i] = GN_NONE;

    gn_result result = ready ? write_scene(&w) : no_memory(&w);

    cJSON_Delete(w.root);
    cJSON_Delete(w.roots);
    for (gn_glb_array kind = 0; kind < GN_GLB_ARRAYS; kind++)
        cJSON_Delete(w.arrays[kind]);
    for (uint32_t i = 0; i < scene->texture_count && w.pngs; i++)
        free(w.pngs[i]);
    gn_free(context, w.nodes);
    gn_free(context, w.pngs);
    gn_free(context, w.lookup);
    gn_free(context, w.pieces);
    return result;
}
