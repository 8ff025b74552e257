/* Scenes to binary glTF 2.0.
 *
 * The JSON is built first, and with it a list of what the binary chunk holds; the chunk itself is
 * then written piece by piece, straight from the scene's own arrays. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <gnomon/procedural.h>
#include <spng.h>

#include "output/output.h"
#include "scene/scene.h"

enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER = 34963, FLOAT = 5126, SHORT = 5123, INT = 5125 };

/* The top-level arrays of the file. */
typedef enum array {
    ACCESSORS,
    ANIMATIONS,
    VIEWS,
    CAMERAS,
    IMAGES,
    LIGHTS,
    MATERIALS,
    MESHES,
    NODES,
    SAMPLERS,
    TEXTURES,
    ARRAYS
} array;

static const char *const array_names[ARRAYS] = {"accessors", "animations", "bufferViews", "cameras",
                                                "images",    "lights",     "materials",   "meshes",
                                                "nodes",     "samplers",   "textures"};

/* A piece of the binary chunk: count elements of size bytes as they will be in the file. */
typedef struct piece {
    enum { PLAIN, SHORTENED, UNIT_LENGTH, ZERO } form; /* how the file's bytes come from data */
    const void *data;
    uint64_t count, size;
} piece;

typedef struct writer {
    const gn_scene *scene;
    gn_context *context;
    const char *path;
    cJSON *root, *arrays[ARRAYS];
    uint32_t counts[ARRAYS];
    cJSON **nodes;    /* of each of the scene's nodes */
    cJSON *roots;     /* node indices of the file's scene */
    uint32_t *lookup; /* file's texture for each scene texture and pair of wrap modes */
    void **pngs;      /* of each scene texture, from spng */
    piece *pieces;    /* as long as views */
    uint32_t piece_capacity;
    uint64_t size; /* of the binary chunk */
    bool out_of_memory;
} writer;

/* JSON -------------------------------------------------------------------------------------- */

static cJSON *append(writer *w, cJSON *list, cJSON *item)
{
    if (cJSON_AddItemToArray(list, item))
        return item;
    cJSON_Delete(item);
    w->out_of_memory = true;
    return NULL;
}

static cJSON *put(writer *w, cJSON *object, const char *key, cJSON *item)
{
    if (cJSON_AddItemToObject(object, key, item))
        return item;
    cJSON_Delete(item);
    w->out_of_memory = true;
    return NULL;
}

static void put_number(writer *w, cJSON *object, const char *key, double value)
{
    put(w, object, key, cJSON_CreateNumber(value));
}

static void put_name(writer *w, cJSON *object, const char *name)
{
    if (name && name[0])
        put(w, object, "name", cJSON_CreateString(name));
}

static void put_floats(writer *w, cJSON *object, const char *key, const float *values, int count)
{
    put(w, object, key, cJSON_CreateFloatArray(values, count));
}

/* Adds an object to one of the top-level arrays. */
static cJSON *add(writer *w, array kind, uint32_t *index)
{
    if (index)
        *index = w->counts[kind];
    w->counts[kind]++;
    return append(w, w->arrays[kind], cJSON_CreateObject());
}

/* Binary data ------------------------------------------------------------------------------- */

/* Notes a piece of the binary chunk and gives the number of its buffer view; target may be 0. */
static uint32_t add_view(writer *w, piece new_piece, int target)
{
    uint32_t index = w->counts[VIEWS];
    if (!gn_grow(w->context, (void **)&w->pieces, index, &w->piece_capacity, sizeof *w->pieces)) {
        w->out_of_memory = true;
        return 0;
    }
    w->pieces[index] = new_piece;
    uint64_t bytes = new_piece.count * new_piece.size;
    cJSON *view = add(w, VIEWS, NULL);
    put_number(w, view, "buffer", 0);
    put_number(w, view, "byteOffset", (double)w->size);
    put_number(w, view, "byteLength", (double)bytes);
    if (target)
        put_number(w, view, "target", target);
    w->size += (bytes + 3) / 4 * 4;
    return index;
}

static cJSON *add_accessor(writer *w, piece data, int target, int type, const char *shape,
                           uint32_t *index)
{
    uint32_t view = add_view(w, data, target);
    cJSON *accessor = add(w, ACCESSORS, index);
    put_number(w, accessor, "bufferView", view);
    put_number(w, accessor, "componentType", type);
    put_number(w, accessor, "count", (double)data.count);
    put(w, accessor, "type", cJSON_CreateString(shape));
    return accessor;
}

static void put_bounds(writer *w, cJSON *accessor, const float *values, uint32_t count,
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
    put_floats(w, accessor, "min", low, (int)components);
    put_floats(w, accessor, "max", high, (int)components);
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

/* Images ------------------------------------------------------------------------------------ */

static bool is_opaque(const gn_texture *texture)
{
    size_t texels = (size_t)texture->width * texture->height;
    for (size_t i = 0; i < texels; i++)
        if (texture->rgba[0][4 * i + 3] != 255)
            return false;
    return true;
}

/* RGBA, or RGB where every texel is opaque. *png is freed with free(). */
static gn_result encode_png(writer *w, const gn_texture *texture, void **png, size_t *size)
{
    size_t texels = (size_t)texture->width * texture->height;
    bool opaque = is_opaque(texture);
    const uint8_t *pixels = texture->rgba[0];
    uint8_t *rgb = NULL;
    if (opaque) {
        rgb = gn_alloc(w->context, texels, 3);
        for (size_t i = 0; i < texels && rgb; i++)
            memcpy(rgb + 3 * i, pixels + 4 * i, 3);
        pixels = rgb;
    }
    spng_ctx *encoder = pixels ? spng_ctx_new(SPNG_CTX_ENCODER) : NULL;
    int error = SPNG_EMEM;
    if (encoder) {
        struct spng_ihdr header = {.width = texture->width,
                                   .height = texture->height,
                                   .bit_depth = 8,
                                   .color_type = opaque ? SPNG_COLOR_TYPE_TRUECOLOR
                                                        : SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
        error = spng_set_option(encoder, SPNG_ENCODE_TO_BUFFER, 1);
        if (!error)
            error = spng_set_ihdr(encoder, &header);
        if (!error)
            error = spng_encode_image(encoder, pixels, texels * (opaque ? 3 : 4), SPNG_FMT_PNG,
                                      SPNG_ENCODE_FINALIZE);
        if (!error)
            *png = spng_get_png_buffer(encoder, size, &error);
    }
    spng_ctx_free(encoder);
    gn_free(w->context, rgb);
    if (error == SPNG_EMEM)
        w->out_of_memory = true;
    else if (error)
        return gn_fail(w->context, GN_ERROR_IO, "%s: cannot encode texture '%s' as PNG: %s",
                       w->path, texture->name, spng_strerror(error));
    return GN_OK;
}

static gn_result add_images(writer *w)
{
    for (uint32_t i = 0; i < w->scene->texture_count && !w->out_of_memory; i++) {
        const gn_texture *texture = &w->scene->textures[i];
        size_t size = 0;
        gn_result result = encode_png(w, texture, &w->pngs[i], &size);
        if (result != GN_OK)
            return result;
        cJSON *image = add(w, IMAGES, NULL);
        put_name(w, image, texture->name);
        put(w, image, "mimeType", cJSON_CreateString("image/png"));
        piece data = {PLAIN, w->pngs[i], size, 1};
        put_number(w, image, "bufferView", add_view(w, data, 0));
    }
    return GN_OK;
}

/* Materials --------------------------------------------------------------------------------- */

/* glTF keeps the wrap modes with the texture: one of the file's textures for each pair in use. */
static uint32_t find_texture(writer *w, uint32_t image, gn_wrap wrap_u, gn_wrap wrap_v)
{
    static const int modes[3] = {10497, 33071, 33648};
    uint32_t *known = &w->lookup[9 * (size_t)image + 3 * (size_t)wrap_u + (size_t)wrap_v];
    if (*known != GN_NONE)
        return *known;
    uint32_t sampler_index;
    cJSON *sampler = add(w, SAMPLERS, &sampler_index);
    put_number(w, sampler, "magFilter", 9729);
    put_number(w, sampler, "minFilter", 9987);
    put_number(w, sampler, "wrapS", modes[wrap_u]);
    put_number(w, sampler, "wrapT", modes[wrap_v]);
    cJSON *texture = add(w, TEXTURES, known);
    put_number(w, texture, "sampler", sampler_index);
    put_number(w, texture, "source", image);
    return *known;
}

static void add_materials(writer *w)
{
    for (uint32_t i = 0; i < w->scene->material_count; i++) {
        if (i == w->scene->default_material)
            continue;
        const gn_material *material = &w->scene->materials[i];
        const gn_material_desc *desc = &material->desc;
        cJSON *item = add(w, MATERIALS, NULL);
        put_name(w, item, material->name);
        cJSON *surface = put(w, item, "pbrMetallicRoughness", cJSON_CreateObject());
        put_floats(w, surface, "baseColorFactor", desc->base_color, 4);
        put_number(w, surface, "metallicFactor", 0);
        put_number(w, surface, "roughnessFactor", 1);
        if (desc->texture != GN_NONE) {
            uint32_t texture = find_texture(w, desc->texture, desc->wrap_u, desc->wrap_v);
            cJSON *reference = put(w, surface, "baseColorTexture", cJSON_CreateObject());
            put_number(w, reference, "index", texture);
        }
        if (desc->alpha_mode != GN_ALPHA_OPAQUE) {
            bool mask = desc->alpha_mode == GN_ALPHA_MASK;
            put(w, item, "alphaMode", cJSON_CreateString(mask ? "MASK" : "BLEND"));
            if (mask)
                put_number(w, item, "alphaCutoff", (double)desc->alpha_cutoff);
        }
        if (desc->double_sided)
            put(w, item, "doubleSided", cJSON_CreateTrue());
    }
}

/* Meshes ------------------------------------------------------------------------------------ */

static void add_part(writer *w, const gn_part *part, cJSON *primitives)
{
    uint32_t vertices = part->vertex_count, indices = 3 * part->triangle_count, accessor;
    cJSON *primitive = append(w, primitives, cJSON_CreateObject());
    cJSON *attributes = put(w, primitive, "attributes", cJSON_CreateObject());
    piece data = {PLAIN, part->positions, vertices, 12};
    cJSON *positions = add_accessor(w, data, ARRAY_BUFFER, FLOAT, "VEC3", &accessor);
    put_bounds(w, positions, part->positions, vertices, 3);
    put_number(w, attributes, "POSITION", accessor);
    if (part->normals) {
        data = (piece){PLAIN, part->normals, vertices, 12};
        if (!are_unit_length(part->normals, vertices))
            data.form = UNIT_LENGTH;
        add_accessor(w, data, ARRAY_BUFFER, FLOAT, "VEC3", &accessor);
        put_number(w, attributes, "NORMAL", accessor);
    }
    /* A material with a texture needs coordinates, if only zeros. */
    bool textured = w->scene->materials[part->material].desc.texture != GN_NONE;
    if (part->uvs || textured) {
        data = (piece){part->uvs ? PLAIN : ZERO, part->uvs, vertices, 8};
        add_accessor(w, data, ARRAY_BUFFER, FLOAT, "VEC2", &accessor);
        put_number(w, attributes, "TEXCOORD_0", accessor);
    }
    /* 65535 is no index in 16 bits, but a mark. */
    bool narrow = vertices <= 65535;
    data = (piece){narrow ? SHORTENED : PLAIN, part->indices, indices, narrow ? 2 : 4};
    add_accessor(w, data, ELEMENT_ARRAY_BUFFER, narrow ? SHORT : INT, "SCALAR", &accessor);
    put_number(w, primitive, "indices", accessor);
    if (part->material != w->scene->default_material)
        put_number(w, primitive, "material", part->material);
}

static void add_meshes(writer *w)
{
    for (uint32_t i = 0; i < w->scene->mesh_count; i++) {
        const gn_mesh *mesh = &w->scene->meshes[i];
        cJSON *item = add(w, MESHES, NULL);
        put_name(w, item, mesh->name);
        cJSON *primitives = put(w, item, "primitives", cJSON_CreateArray());
        for (uint32_t k = 0; k < mesh->part_count; k++)
            add_part(w, &mesh->parts[k], primitives);
    }
}

/* Lights and cameras ------------------------------------------------------------------------ */

static void add_lights(writer *w)
{
    static const char *const types[3] = {"directional", "point", "spot"};
    for (uint32_t i = 0; i < w->scene->light_count; i++) {
        const gn_light_desc *desc = &w->scene->lights[i].desc;
        /* glTF's colours end at 1: what is brighter goes into the intensity. */
        float brightest = fmaxf(fmaxf(desc->color[0], desc->color[1]), fmaxf(desc->color[2], 1));
        const float color[3] = {desc->color[0] / brightest, desc->color[1] / brightest,
                                desc->color[2] / brightest};
        cJSON *item = add(w, LIGHTS, NULL);
        put_name(w, item, w->scene->lights[i].name);
        put(w, item, "type", cJSON_CreateString(types[desc->type]));
        put_floats(w, item, "color", color, 3);
        put_number(w, item, "intensity", (double)(desc->intensity * brightest));
        if (desc->type != GN_LIGHT_DIRECTIONAL && isfinite(desc->range))
            put_number(w, item, "range", (double)desc->range);
        if (desc->type == GN_LIGHT_SPOT) {
            cJSON *spot = put(w, item, "spot", cJSON_CreateObject());
            put_number(w, spot, "innerConeAngle", (double)desc->inner_cone_angle);
            /* The float nearest to pi / 2 lies above it. */
            put_number(w, spot, "outerConeAngle", fmin((double)desc->outer_cone_angle, M_PI_2));
        }
    }
}

static void add_cameras(writer *w)
{
    for (uint32_t i = 0; i < w->scene->camera_count; i++) {
        const gn_camera_desc *desc = &w->scene->cameras[i].desc;
        cJSON *item = add(w, CAMERAS, NULL);
        put_name(w, item, w->scene->cameras[i].name);
        const char *type = desc->orthographic ? "orthographic" : "perspective";
        put(w, item, "type", cJSON_CreateString(type));
        cJSON *lens = put(w, item, type, cJSON_CreateObject());
        if (desc->orthographic) {
            put_number(w, lens, "xmag", (double)desc->ymag * 16 / 9);
            put_number(w, lens, "ymag", (double)desc->ymag);
            /* Required, but nothing is too far for us. */
            put_number(w, lens, "zfar", ((double)desc->znear + (double)desc->ymag) * 1e4);
            put_number(w, lens, "znear", (double)desc->znear);
        } else {
            put_number(w, lens, "yfov", (double)desc->yfov);
            put_number(w, lens, "znear", (double)fmaxf(desc->znear, FLT_MIN));
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

static void put_light(writer *w, cJSON *node, uint32_t light)
{
    cJSON *extensions = put(w, node, "extensions", cJSON_CreateObject());
    cJSON *reference = put(w, extensions, "KHR_lights_punctual", cJSON_CreateObject());
    put_number(w, reference, "light", light);
    if (!w->scene->lights[light].desc.on) {
        cJSON *extras = put(w, node, "extras", cJSON_CreateObject());
        put(w, extras, "defaultOn", cJSON_CreateFalse());
    }
}

/* As the node was added, unless somebody moved it since by a matrix. */
static void put_transform(writer *w, cJSON *item, const gn_node *node)
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
            put_floats(w, item, "matrix", node->local, 16);
        return;
    }
    if (!all_equal(desc->translation, zero, 3))
        put_floats(w, item, "translation", desc->translation, 3);
    if (!all_equal(desc->rotation, level, 4))
        put_floats(w, item, "rotation", desc->rotation, 4);
    if (!all_equal(desc->scale, one, 3))
        put_floats(w, item, "scale", desc->scale, 3);
}

static void add_node(writer *w, uint32_t index)
{
    const gn_node *node = &w->scene->nodes[index];
    cJSON *item = w->nodes[index] = add(w, NODES, NULL);
    put_name(w, item, node->name);
    put_transform(w, item, node);
    if (node->desc.mesh != GN_NONE)
        put_number(w, item, "mesh", node->desc.mesh);
    if (node->desc.camera != GN_NONE)
        put_number(w, item, "camera", node->desc.camera);
    if (node->desc.light != GN_NONE)
        put_light(w, item, node->desc.light);
    cJSON *list = w->roots;
    if (node->desc.parent != GN_NONE) {
        cJSON *parent = w->nodes[node->desc.parent];
        list = cJSON_GetObjectItemCaseSensitive(parent, "children");
        if (!list)
            list = put(w, parent, "children", cJSON_CreateArray());
    }
    append(w, list, cJSON_CreateNumber(index));
}

static void add_nodes(writer *w)
{
    for (uint32_t i = 0; i < w->scene->node_count; i++)
        add_node(w, i);
    /* In glTF everything hangs on a node. */
    uint32_t index;
    for (uint32_t i = 0; i < w->scene->light_count; i++)
        if (w->scene->lights[i].node == GN_NONE) {
            cJSON *item = add(w, NODES, &index);
            put_name(w, item, w->scene->lights[i].name);
            put_light(w, item, i);
            append(w, w->roots, cJSON_CreateNumber(index));
        }
    for (uint32_t i = 0; i < w->scene->camera_count; i++)
        if (w->scene->cameras[i].node == GN_NONE) {
            cJSON *item = add(w, NODES, &index);
            put_name(w, item, w->scene->cameras[i].name);
            put_number(w, item, "camera", i);
            append(w, w->roots, cJSON_CreateNumber(index));
        }
}

static void add_animation(writer *w)
{
    static const char *const ways[3] = {"STEP", "LINEAR", "CUBICSPLINE"};
    static const char *const paths[3] = {"translation", "rotation", "scale"};
    if (w->scene->channel_count == 0)
        return;
    cJSON *animation = add(w, ANIMATIONS, NULL);
    cJSON *channels = put(w, animation, "channels", cJSON_CreateArray());
    cJSON *samplers = put(w, animation, "samplers", cJSON_CreateArray());
    for (uint32_t i = 0; i < w->scene->channel_count; i++) {
        const gn_channel_desc *desc = &w->scene->channels[i].desc;
        uint32_t times, values, keys = desc->key_count;
        bool turns = desc->path == GN_PATH_ROTATION;
        piece data = {PLAIN, desc->times, keys, 4};
        cJSON *accessor = add_accessor(w, data, 0, FLOAT, "SCALAR", &times);
        put_bounds(w, accessor, desc->times, keys, 1);
        uint64_t elements =
            (uint64_t)keys * (desc->interpolation == GN_INTERPOLATION_CUBICSPLINE ? 3 : 1);
        data = (piece){PLAIN, desc->values, elements, turns ? 16 : 12};
        add_accessor(w, data, 0, FLOAT, turns ? "VEC4" : "VEC3", &values);
        cJSON *sampler = append(w, samplers, cJSON_CreateObject());
        put_number(w, sampler, "input", times);
        put_number(w, sampler, "output", values);
        put(w, sampler, "interpolation", cJSON_CreateString(ways[desc->interpolation]));
        cJSON *channel = append(w, channels, cJSON_CreateObject());
        put_number(w, channel, "sampler", i);
        cJSON *target = put(w, channel, "target", cJSON_CreateObject());
        put_number(w, target, "node", desc->node);
        put(w, target, "path", cJSON_CreateString(paths[desc->path]));
    }
}

/* File -------------------------------------------------------------------------------------- */

/* Hangs the filled arrays on the root. */
static void assemble(writer *w)
{
    cJSON *asset = put(w, w->root, "asset", cJSON_CreateObject());
    put(w, asset, "version", cJSON_CreateString("2.0"));
    put(w, asset, "generator", cJSON_CreateString("gnomon"));
    put_number(w, w->root, "scene", 0);
    cJSON *scenes = put(w, w->root, "scenes", cJSON_CreateArray());
    cJSON *scene = append(w, scenes, cJSON_CreateObject());
    if (w->roots && w->roots->child) {
        put(w, scene, "nodes", w->roots);
        w->roots = NULL;
    }
    for (array kind = 0; kind < ARRAYS; kind++) {
        if (w->counts[kind] == 0)
            continue;
        cJSON *parent = w->root;
        if (kind == LIGHTS) {
            cJSON *used = put(w, w->root, "extensionsUsed", cJSON_CreateArray());
            append(w, used, cJSON_CreateString("KHR_lights_punctual"));
            cJSON *extensions = put(w, w->root, "extensions", cJSON_CreateObject());
            parent = put(w, extensions, "KHR_lights_punctual", cJSON_CreateObject());
        }
        put(w, parent, array_names[kind], w->arrays[kind]);
        w->arrays[kind] = NULL;
    }
    if (w->size > 0) {
        cJSON *buffers = put(w, w->root, "buffers", cJSON_CreateArray());
        cJSON *buffer = append(w, buffers, cJSON_CreateObject());
        put_number(w, buffer, "byteLength", (double)w->size);
    }
}

static gn_result write_words(gn_file *file, const uint32_t *words, size_t count)
{
    uint8_t bytes[32];
    for (size_t i = 0; i < 4 * count; i++)
        bytes[i] = (uint8_t)(words[i / 4] >> 8 * (i % 4));
    return gn_file_write(file, bytes, 4 * count);
}

/* Fills block with elements [first, first + count) of a piece that is not plain. */
static void convert(const piece *source, uint64_t first, uint64_t count, void *block)
{
    uint16_t *shorts = block;
    float *floats = block;
    switch (source->form) {
    case SHORTENED:
        for (uint64_t i = 0; i < count; i++)
            shorts[i] = (uint16_t)((const uint32_t *)source->data)[first + i];
        break;
    case UNIT_LENGTH:
        for (uint64_t i = 0; i < count; i++) {
            const float *normal = (const float *)source->data + 3 * (first + i);
            float length = length3(normal);
            bool usable = length > 1e-12f && isfinite(length);
            for (unsigned c = 0; c < 3; c++)
                floats[3 * i + c] = usable ? normal[c] / length : c == 1;
        }
        break;
    case PLAIN:
    case ZERO:
        memset(block, 0, count * source->size);
        break;
    }
}

static gn_result write_piece(gn_file *file, const piece *source)
{
    uint64_t bytes = source->count * source->size;
    gn_result result = GN_OK;
    if (source->form == PLAIN) {
        result = gn_file_write(file, source->data, bytes);
    } else {
        uint32_t block[3 * 1024];
        for (uint64_t i = 0, count; i < source->count && result == GN_OK; i += count) {
            count = source->count - i < 1024 ? source->count - i : 1024;
            convert(source, i, count, block);
            result = gn_file_write(file, block, count * source->size);
        }
    }
    if (result == GN_OK)
        result = gn_file_write(file, "\0\0\0", (4 - bytes % 4) % 4);
    return result;
}

static gn_result write_file(writer *w, gn_file *file, const char *json)
{
    size_t length = strlen(json), padded = (length + 3) / 4 * 4;
    uint64_t total = 12 + 8 + padded + (w->size > 0 ? 8 + w->size : 0);
    if (total > UINT32_MAX)
        return gn_fail(w->context, GN_ERROR_UNSUPPORTED,
                       "%s: the scene needs %llu bytes, and a .glb can hold 4294967295", w->path,
                       (unsigned long long)total);
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)total, (uint32_t)padded, 0x4e4f534a};
    gn_result result = write_words(file, head, 5);
    if (result == GN_OK)
        result = gn_file_write(file, json, length);
    if (result == GN_OK)
        result = gn_file_write(file, "   ", padded - length);
    if (w->size == 0)
        return result;
    const uint32_t chunk[2] = {(uint32_t)w->size, 0x004e4942};
    if (result == GN_OK)
        result = write_words(file, chunk, 2);
    for (uint32_t i = 0; i < w->counts[VIEWS] && result == GN_OK; i++)
        result = write_piece(file, &w->pieces[i]);
    return result;
}

static gn_result no_memory(const writer *w)
{
    return gn_fail(w->context, GN_ERROR_OUT_OF_MEMORY, "%s: no memory to write the scene", w->path);
}

static gn_result write_scene(writer *w)
{
    gn_result result = add_images(w);
    if (result != GN_OK)
        return result;
    add_materials(w);
    add_meshes(w);
    add_lights(w);
    add_cameras(w);
    add_nodes(w);
    add_animation(w);
    assemble(w);
    char *json = w->out_of_memory ? NULL : cJSON_PrintUnformatted(w->root);
    if (!json)
        return no_memory(w);
    gn_file file;
    result = gn_file_begin(w->context, w->path, &file);
    if (result == GN_OK) {
        result = write_file(w, &file, json);
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
    writer w = {.scene = scene, .context = context, .path = path ? path : ""};
    size_t lookups = 9 * (size_t)scene->texture_count;
    w.root = cJSON_CreateObject();
    w.roots = cJSON_CreateArray();
    w.nodes = gn_alloc_zero(context, scene->node_count, sizeof *w.nodes);
    w.pngs = gn_alloc_zero(context, scene->texture_count, sizeof *w.pngs);
    w.lookup = gn_alloc(context, lookups, sizeof *w.lookup);
    bool ready = w.root && w.roots && w.nodes && w.pngs && w.lookup;
    for (array kind = 0; kind < ARRAYS; kind++) {
        w.arrays[kind] = cJSON_CreateArray();
        ready = ready && w.arrays[kind];
    }
    for (size_t i = 0; i < lookups && ready; i++)
        w.lookup[i] = GN_NONE;

    gn_result result = ready ? write_scene(&w) : no_memory(&w);

    cJSON_Delete(w.root);
    cJSON_Delete(w.roots);
    for (array kind = 0; kind < ARRAYS; kind++)
        cJSON_Delete(w.arrays[kind]);
    for (uint32_t i = 0; i < scene->texture_count && w.pngs; i++)
        free(w.pngs[i]);
    gn_free(context, w.nodes);
    gn_free(context, w.pngs);
    gn_free(context, w.lookup);
    gn_free(context, w.pieces);
    return result;
}
