/* A small reader of .glb files that shares nothing with gnomon's own: it checks the rules of
 * binary glTF that a writer can break. */
#ifndef GLB_CHECKING_H
#define GLB_CHECKING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <cjson/cJSON.h>

static uint8_t *read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    uint8_t *data = malloc(*size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *size, file), *size);
    data[*size] = 0;
    fclose(file);
    return data;
}

typedef struct file {
    uint8_t *data, *chunk;
    size_t size, chunk_size;
    cJSON *root;
} file;

static uint32_t word(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static file open_glb(const char *path)
{
    file f = {0};
    f.data = read_file(path, &f.size);
    assert_true(f.size >= 20 && f.size % 4 == 0);
    assert_memory_equal(f.data, "glTF", 4);
    assert_int_equal(word(f.data + 4), 2);
    assert_int_equal(word(f.data + 8), f.size);
    size_t json_size = word(f.data + 12);
    assert_memory_equal(f.data + 16, "JSON", 4);
    assert_true(json_size % 4 == 0 && 20 + json_size <= f.size);
    f.root = cJSON_ParseWithLength((const char *)f.data + 20, json_size);
    assert_non_null(f.root);
    size_t at = 20 + json_size;
    if (at < f.size) {
        f.chunk_size = word(f.data + at);
        assert_memory_equal(f.data + at + 4, "BIN\0", 4);
        assert_int_equal(at + 8 + f.chunk_size, f.size);
        f.chunk = f.data + at + 8;
    }
    return f;
}

static void close_glb(file *f)
{
    cJSON_Delete(f->root);
    free(f->data);
}

static const cJSON *get(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

static uint64_t get_uint(const cJSON *object, const char *key)
{
    const cJSON *item = get(object, key);
    if (!cJSON_IsNumber(item) || item->valuedouble < 0 ||
        item->valuedouble != floor(item->valuedouble))
        fail_msg("\"%s\" is no index or size", key);
    return (uint64_t)item->valuedouble;
}

static const cJSON *entry(const file *f, const char *array, uint64_t index)
{
    const cJSON *item = cJSON_GetArrayItem(get(f->root, array), (int)index);
    if (!item)
        fail_msg("%s %u is not there", array, (unsigned)index);
    return item;
}

static uint32_t length_of(const file *f, const char *array)
{
    return (uint32_t)cJSON_GetArraySize(get(f->root, array));
}

/* The bytes of an accessor, after a check of every rule about them. */
static const uint8_t *check_accessor(const file *f, uint64_t index, const char *type,
                                     uint32_t component_type, int target, uint64_t *count)
{
    const cJSON *accessor = entry(f, "accessors", index);
    assert_string_equal(get(accessor, "type")->valuestring, type);
    if (component_type)
        assert_int_equal(get_uint(accessor, "componentType"), component_type);
    uint64_t kind = get_uint(accessor, "componentType");
    uint64_t size = (kind == 5126 || kind == 5125 ? 4u : 2u) *
                    (strcmp(type, "SCALAR") == 0 ? 1u : (uint64_t)(type[3] - '0'));
    const cJSON *view = entry(f, "bufferViews", get_uint(accessor, "bufferView"));
    uint64_t offset = get_uint(view, "byteOffset"), length = get_uint(view, "byteLength");
    *count = get_uint(accessor, "count");
    assert_true(*count > 0 && *count * size == length);
    assert_true(offset % 4 == 0 && offset + length <= f->chunk_size);
    assert_int_equal(get_uint(view, "buffer"), 0);
    if (target)
        assert_int_equal(get_uint(view, "target"), target);
    else
        assert_null(get(view, "target"));
    return f->chunk + offset;
}

/* The "min" and "max" of an accessor are exactly those of its values. */
static void check_bounds(const file *f, uint64_t index, const uint8_t *data, uint64_t count,
                         uint32_t components)
{
    const cJSON *accessor = entry(f, "accessors", index);
    for (uint32_t c = 0; c < components; c++) {
        float low = INFINITY, high = -INFINITY;
        for (uint64_t i = 0; i < count; i++) {
            float value;
            memcpy(&value, data + 4 * (i * components + c), 4);
            assert_true(isfinite(value));
            low = fminf(low, value);
            high = fmaxf(high, value);
        }
        assert_true((float)cJSON_GetArrayItem(get(accessor, "min"), (int)c)->valuedouble == low);
        assert_true((float)cJSON_GetArrayItem(get(accessor, "max"), (int)c)->valuedouble == high);
    }
}

static void check_primitive(const file *f, const cJSON *primitive)
{
    const cJSON *attributes = get(primitive, "attributes");
    uint64_t vertices, count, indices, position = get_uint(attributes, "POSITION");
    const uint8_t *data = check_accessor(f, position, "VEC3", 5126, 34962, &vertices);
    check_bounds(f, position, data, vertices, 3);
    if (get(attributes, "NORMAL")) {
        data = check_accessor(f, get_uint(attributes, "NORMAL"), "VEC3", 5126, 34962, &count);
        assert_int_equal(count, vertices);
        for (uint64_t i = 0; i < count; i++) {
            float n[3];
            memcpy(n, data + 12 * i, 12);
            assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 5e-3f);
        }
    }
    if (get(attributes, "TEXCOORD_0")) {
        check_accessor(f, get_uint(attributes, "TEXCOORD_0"), "VEC2", 5126, 34962, &count);
        assert_int_equal(count, vertices);
    }
    if (get(primitive, "material")) {
        const cJSON *material = entry(f, "materials", get_uint(primitive, "material"));
        if (get(get(material, "pbrMetallicRoughness"), "baseColorTexture"))
            assert_non_null(get(attributes, "TEXCOORD_0"));
    }
    uint64_t accessor = get_uint(primitive, "indices");
    bool narrow = get_uint(entry(f, "accessors", accessor), "componentType") == 5123;
    data = check_accessor(f, accessor, "SCALAR", narrow ? 5123 : 5125, 34963, &indices);
    assert_int_equal(indices % 3, 0);
    for (uint64_t i = 0; i < indices; i++) {
        uint32_t vertex =
            narrow ? data[2 * i] | (uint32_t)data[2 * i + 1] << 8 : word(data + 4 * i);
        assert_true(vertex < vertices && !(narrow && vertex == 65535));
    }
}

static void check_animations(const file *f)
{
    const cJSON *animation, *channel;
    cJSON_ArrayForEach(animation, get(f->root, "animations"))
    {
        cJSON_ArrayForEach(channel, get(animation, "channels"))
        {
            const cJSON *sampler =
                cJSON_GetArrayItem(get(animation, "samplers"), (int)get_uint(channel, "sampler"));
            const cJSON *target = get(channel, "target");
            const char *path = get(target, "path")->valuestring;
            const char *way = get(sampler, "interpolation")->valuestring;
            const cJSON *node = entry(f, "nodes", get_uint(target, "node"));
            assert_null(get(node, "matrix"));
            uint64_t keys, values, input = get_uint(sampler, "input");
            const uint8_t *data = check_accessor(f, input, "SCALAR", 5126, 0, &keys);
            check_bounds(f, input, data, keys, 1);
            const char *type = strcmp(path, "rotation") == 0 ? "VEC4" : "VEC3";
            check_accessor(f, get_uint(sampler, "output"), type, 5126, 0, &values);
            assert_int_equal(values, strcmp(way, "CUBICSPLINE") == 0 ? 3 * keys : keys);
        }
    }
}

/* Every node hangs in the tree once. */
static void check_nodes(const file *f)
{
    uint32_t count = length_of(f, "nodes");
    uint8_t *seen = calloc(count + 1, 1);
    assert_non_null(seen);
    const cJSON *item, *node;
    cJSON_ArrayForEach(item, get(cJSON_GetArrayItem(get(f->root, "scenes"), 0), "nodes"))
        seen[(uint32_t)item->valuedouble]++;
    cJSON_ArrayForEach(node, get(f->root, "nodes"))
    {
        cJSON_ArrayForEach(item, get(node, "children")) seen[(uint32_t)item->valuedouble]++;
        if (get(node, "mesh"))
            entry(f, "meshes", get_uint(node, "mesh"));
        if (get(node, "camera"))
            entry(f, "cameras", get_uint(node, "camera"));
    }
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal(seen[i], 1);
    free(seen);
}

static void check_glb(const char *path)
{
    file f = open_glb(path);
    assert_string_equal(get(get(f.root, "asset"), "version")->valuestring, "2.0");
    if (f.chunk)
        assert_int_equal(get_uint(entry(&f, "buffers", 0), "byteLength"), f.chunk_size);
    const cJSON *item, *primitive;
    /* Buffer views follow one another: each byte belongs to one of them, or pads it. */
    uint64_t end = 0;
    cJSON_ArrayForEach(item, get(f.root, "bufferViews"))
    {
        assert_int_equal(get_uint(item, "byteOffset"), end);
        end = (end + get_uint(item, "byteLength") + 3) / 4 * 4;
    }
    assert_int_equal(end, f.chunk_size);
    cJSON_ArrayForEach(item, get(f.root, "images"))
    {
        const cJSON *view = entry(&f, "bufferViews", get_uint(item, "bufferView"));
        assert_memory_equal(f.chunk + get_uint(view, "byteOffset"), "\x89PNG\r\n\x1a\n", 8);
    }
    cJSON_ArrayForEach(item, get(f.root, "textures"))
    {
        entry(&f, "images", get_uint(item, "source"));
        entry(&f, "samplers", get_uint(item, "sampler"));
    }
    cJSON_ArrayForEach(item, get(f.root, "materials")) if (get(item, "alphaCutoff"))
        assert_string_equal(get(item, "alphaMode")->valuestring, "MASK");
    cJSON_ArrayForEach(item, get(f.root, "meshes"))
        cJSON_ArrayForEach(primitive, get(item, "primitives")) check_primitive(&f, primitive);
    check_nodes(&f);
    check_animations(&f);
    bool lights = get(get(f.root, "extensions"), "KHR_lights_punctual") != NULL;
    assert_true(lights == (get(f.root, "extensionsUsed") != NULL));
    close_glb(&f);
}

#endif
