/* Small glTF files made in memory, for the reader's tests.
 *
 * JSON is written with ' for ". Every file holds a quad in the unit square at z = 0:
 * bufferViews and accessors 0: positions, 1: texture coordinates, 2: indices; a test appends its
 * own data and its own views and accessors after them. */
#ifndef GN_TESTS_GLB_TESTING_H
#define GN_TESTS_GLB_TESTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#include <gnomon/gnomon.h>

#include "scene/scene.h"

#define ASSET "'asset':{'version':'2.0'},"
/* Where further views go on: 12 + 8 floats and 6 indices, padded. */
#define QUAD_BYTES 92
#define QUAD_VIEWS                                                                                 \
    "{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':32},"                   \
    "{'buffer':0,'byteOffset':80,'byteLength':12}"
#define QUAD_ACCESSORS                                                                             \
    "{'bufferView':0,'componentType':5126,'type':'VEC3','count':4},"                               \
    "{'bufferView':1,'componentType':5126,'type':'VEC2','count':4},"                               \
    "{'bufferView':2,'componentType':5123,'type':'SCALAR','count':6}"
#define QUAD_MESH                                                                                  \
    "{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1},'indices':2,'material':0}]}"
#define QUAD_SCENE                                                                                 \
    "'materials':[{}],'meshes':[" QUAD_MESH "],'nodes':[{'mesh':0}],'scenes':[{'nodes':[0]}],"     \
    "'scene':0"

static const float quad_positions[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

typedef struct glb {
    uint8_t data[16384];
    size_t size;
} glb;

__attribute__((unused)) static gn_device *test_device(void)
{
    static gn_device *device;
    if (!device)
        assert_int_equal(gn_device_create(NULL, &device), GN_OK);
    return device;
}

static void put_u32(uint8_t *at, size_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

/* The JSON with views and accessors ("" or ",{...}") after the quad's, and rest after them. */
static size_t make_json(char *json, size_t capacity, size_t bin_size, const char *views,
                        const char *accessors, const char *rest)
{
    const int length =
        snprintf(json, capacity,
                 "{" ASSET "'buffers':[{'byteLength':%zu}],'bufferViews':[" QUAD_VIEWS
                 "%s],'accessors':[" QUAD_ACCESSORS "%s],%s}",
                 bin_size, views, accessors, rest);
    assert_in_range(length, 1, (int)capacity - 1);
    for (char *letter = json; *letter; letter++) {
        if (*letter == '\'')
            *letter = '"';
    }
    return (size_t)length;
}

static void make_glb(glb *file, const void *bin, size_t bin_size, const char *views,
                     const char *accessors, const char *rest)
{
    static const float uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    char json[8192];
    const size_t total = (QUAD_BYTES + bin_size + 3) / 4 * 4;
    const size_t length = make_json(json, sizeof json, total, views, accessors, rest);
    const size_t padded = (length + 3) / 4 * 4;
    file->size = 20 + padded + 8 + total;
    assert_in_range(file->size, 1, sizeof file->data);
    memset(file->data, 0, file->size);
    memcpy(file->data, "glTF\2", 5);
    put_u32(file->data + 8, file->size);
    put_u32(file->data + 12, padded);
    memcpy(file->data + 16, "JSON", 4);
    memset(file->data + 20, ' ', padded);
    memcpy(file->data + 20, json, length);
    uint8_t *chunk = file->data + 20 + padded;
    put_u32(chunk, total);
    memcpy(chunk + 4, "BIN", 4);
    memcpy(chunk + 8, quad_positions, 48);
    memcpy(chunk + 8 + 48, uvs, 32);
    memcpy(chunk + 8 + 80, indices, 12);
    if (bin_size > 0)
        memcpy(chunk + 8 + QUAD_BYTES, bin, bin_size);
}

/* Reads a file that must be good. */
__attribute__((unused)) static gn_scene *read_good(const void *bin, size_t bin_size,
                                                   const char *views, const char *accessors,
                                                   const char *rest)
{
    static glb file;
    make_glb(&file, bin, bin_size, views, accessors, rest);
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create(test_device(), &scene), GN_OK);
    const gn_result result = gn_import_gltf_memory(scene, file.data, file.size);
    if (result != GN_OK)
        fail_msg("%s", gn_device_message(test_device()));
    return scene;
}

/* Reads bytes that must be refused with a message that holds each of two texts. */
__attribute__((unused)) static void assert_bad_bytes(const void *data, size_t size,
                                                     const char *first, const char *second)
{
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create(test_device(), &scene), GN_OK);
    const gn_result result = gn_import_gltf_memory(scene, data, size);
    gn_scene_destroy(&scene);
    const char *message = gn_device_message(test_device());
    if (result == GN_OK)
        fail_msg("accepted, where \"%s\" and \"%s\" were expected", first, second);
    if (!strstr(message, first) || !strstr(message, second))
        fail_msg("\"%s\" does not hold \"%s\" and \"%s\"", message, first, second);
}

__attribute__((unused)) static void assert_bad(const void *bin, size_t bin_size, const char *views,
                                               const char *accessors, const char *rest,
                                               const char *first, const char *second)
{
    static glb file;
    make_glb(&file, bin, bin_size, views, accessors, rest);
    assert_bad_bytes(file.data, file.size, first, second);
}

__attribute__((unused)) static void write_file(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

__attribute__((unused)) static void assert_floats(const float *values, const float *expected,
                                                  size_t count, float tolerance)
{
    for (size_t i = 0; i < count; i++) {
        if (!(fabsf(values[i] - expected[i]) <= tolerance))
            fail_msg("value %zu is %.9g, not %.9g", i, (double)values[i], (double)expected[i]);
    }
}

/* A PNG of 2 x 1 texels, red opaque and green with alpha 64. */
#define PNG_2X1                                                                                    \
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAD0lEQVR4nGP4z8DwHwgdABA5Az6tfOGaAAAAAElFTk"   \
    "SuQmCC"

#endif
