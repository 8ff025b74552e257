/* The container of binary glTF: JSON, and the binary chunk written piece by piece. */
#include "scene/glb.h"

#include <math.h>
#include <string.h>

static const char *const array_names[GN_GLB_ARRAYS] = {
    "accessors", "animations", "bufferViews", "cameras",  "images",  "lights",
    "materials", "meshes",     "nodes",       "samplers", "textures"};

/* JSON -------------------------------------------------------------------------------------- */

cJSON *gn_glb_append(gn_glb *w, cJSON *list, cJSON *item)
{
    if (cJSON_AddItemToArray(list, item))
        return item;
    cJSON_Delete(item);
    w->out_of_memory = true;
    return NULL;
}

cJSON *gn_glb_put(gn_glb *w, cJSON *object, const char *key, cJSON *item)
{
    if (cJSON_AddItemToObject(object, key, item))
        return item;
    cJSON_Delete(item);
    w->out_of_memory = true;
    return NULL;
}

void gn_glb_put_number(gn_glb *w, cJSON *object, const char *key, double value)
{
    gn_glb_put(w, object, key, cJSON_CreateNumber(value));
}

void gn_glb_put_name(gn_glb *w, cJSON *object, const char *name)
{
    if (name && name[0])
        gn_glb_put(w, object, "name", cJSON_CreateString(name));
}

void gn_glb_put_floats(gn_glb *w, cJSON *object, const char *key, const float *values, int count)
{
    gn_glb_put(w, object, key, cJSON_CreateFloatArray(values, count));
}

cJSON *gn_glb_add(gn_glb *w, gn_glb_array kind, uint32_t *index)
{
    if (index)
        *index = w->counts[kind];
    w->counts[kind]++;
    return gn_glb_append(w, w->arrays[kind], cJSON_CreateObject());
}

/* Binary data ------------------------------------------------------------------------------- */

uint32_t gn_glb_add_view(gn_glb *w, gn_glb_piece new_piece, int target)
{
    uint32_t index = w->counts[GN_GLB_VIEWS];
    if (!gn_grow(w->context, (void **)&w->pieces, index, &w->piece_capacity, sizeof *w->pieces)) {
        w->out_of_memory = true;
        return 0;
    }
    w->pieces[index] = new_piece;
    uint64_t bytes = new_piece.count * new_piece.size;
    cJSON *view = gn_glb_add(w, GN_GLB_VIEWS, NULL);
    gn_glb_put_number(w, view, "buffer", 0);
    gn_glb_put_number(w, view, "byteOffset", (double)w->size);
    gn_glb_put_number(w, view, "byteLength", (double)bytes);
    if (target)
        gn_glb_put_number(w, view, "target", target);
    w->size += (bytes + 3) / 4 * 4;
    return index;
}

/* File -------------------------------------------------------------------------------------- */

void gn_glb_assemble(gn_glb *w)
{
    cJSON *asset = gn_glb_put(w, w->root, "asset", cJSON_CreateObject());
    gn_glb_put(w, asset, "version", cJSON_CreateString("2.0"));
    gn_glb_put(w, asset, "generator", cJSON_CreateString("gnomon"));
    gn_glb_put_number(w, w->root, "scene", 0);
    cJSON *scenes = gn_glb_put(w, w->root, "scenes", cJSON_CreateArray());
    cJSON *scene = gn_glb_append(w, scenes, cJSON_CreateObject());
    if (w->roots && w->roots->child) {
        gn_glb_put(w, scene, "nodes", w->roots);
        w->roots = NULL;
    }
    for (gn_glb_array kind = 0; kind < GN_GLB_ARRAYS; kind++) {
        if (w->counts[kind] == 0)
            continue;
        cJSON *parent = w->root;
        if (kind == GN_GLB_LIGHTS) {
            cJSON *used = gn_glb_put(w, w->root, "extensionsUsed", cJSON_CreateArray());
            gn_glb_append(w, used, cJSON_CreateString("KHR_lights_punctual"));
            cJSON *extensions = gn_glb_put(w, w->root, "extensions", cJSON_CreateObject());
            parent = gn_glb_put(w, extensions, "KHR_lights_punctual", cJSON_CreateObject());
        }
        gn_glb_put(w, parent, array_names[kind], w->arrays[kind]);
        w->arrays[kind] = NULL;
    }
    if (w->size > 0) {
        cJSON *buffers = gn_glb_put(w, w->root, "buffers", cJSON_CreateArray());
        cJSON *buffer = gn_glb_append(w, buffers, cJSON_CreateObject());
        gn_glb_put_number(w, buffer, "byteLength", (double)w->size);
    }
}

static gn_result write_words(gn_file *file, const uint32_t *words, size_t count)
{
    uint8_t bytes[32];
    for (size_t i = 0; i < 4 * count; i++)
        bytes[i] = (uint8_t)(words[i / 4] >> 8 * (i % 4));
    return gn_file_write(file, bytes, 4 * count);
}

static float length3(const float v[3])
{
    return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Fills block with elements [first, first + count) of a piece that is not plain. */
static void convert(const gn_glb_piece *source, uint64_t first, uint64_t count, void *block)
{
    uint16_t *shorts = block;
    float *floats = block;
    switch (source->form) {
    case GN_GLB_SHORTENED:
        for (uint64_t i = 0; i < count; i++)
            shorts[i] = (uint16_t)((const uint32_t *)source->data)[first + i];
        break;
    case GN_GLB_UNIT_LENGTH:
        for (uint64_t i = 0; i < count; i++) {
            const float *normal = (const float *)source->data + 3 * (first + i);
            float length = length3(normal);
            bool usable = length > 1e-12f && isfinite(length);
            for (unsigned c = 0; c < 3; c++)
                floats[3 * i + c] = usable ? normal[c] / length : c == 1;
        }
        break;
    case GN_GLB_PLAIN:
    case GN_GLB_ZERO:
        memset(block, 0, count * source->size);
        break;
    }
}

static gn_result write_piece(gn_file *file, const gn_glb_piece *source)
{
    uint64_t bytes = source->count * source->size;
    gn_result result = GN_OK;
    if (source->form == GN_GLB_PLAIN) {
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

gn_result gn_glb_write_file(gn_glb *w, gn_file *file, const char *json)
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
    for (uint32_t i = 0; i < w->counts[GN_GLB_VIEWS] && result == GN_OK; i++)
        result = write_piece(file, &w->pieces[i]);
    return result;
}
