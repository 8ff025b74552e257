/* Scenes written as .glb: read back by a small independent reader, and by gn_scene_load(). */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <dirent.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>

#include <cjson/cJSON.h>
#include <gnomon/procedural.h>

#include "scene/scene.h"

static gn_device *device;
static char folder[] = "/tmp/gnomon-glb-XXXXXX";

static const char *in_folder(const char *name)
{
    static char paths[4][128];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static uint32_t files_in_folder(void)
{
    uint32_t count = 0;
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (const struct dirent *entry; (entry = readdir(directory));)
        count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static gn_scene *make(const char *name, double scale)
{
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = scale;
    gn_scene *scene = NULL;
    if (gn_scene_create_procedural(device, name, &desc, &scene) != GN_OK)
        fail_msg("%s: %s", name, gn_device_message(device));
    return scene;
}

static void write_glb(const gn_scene *scene, const char *path)
{
    if (gn_scene_write_glb(scene, path) != GN_OK)
        fail_msg("%s", gn_device_message(device));
}

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

/* An independent reader --------------------------------------------------------------------- */

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

/* Round trip -------------------------------------------------------------------------------- */

static void assert_floats(const float *a, const float *b, size_t count, const char *what)
{
    for (size_t i = 0; i < count; i++)
        if (a[i] != b[i])
            fail_msg("%s: value %zu is %.9g, was %.9g", what, i, (double)b[i], (double)a[i]);
}

static void compare_parts(const gn_part *a, const gn_part *b, bool textured, const char *name)
{
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_int_equal(a->material, b->material);
    assert_floats(a->positions, b->positions, 3 * (size_t)a->vertex_count, name);
    if (a->normals)
        for (size_t i = 0; i < 3 * (size_t)a->vertex_count; i++)
            assert_true(fabsf(a->normals[i] - b->normals[i]) < 1e-6f);
    if (a->uvs && textured)
        assert_floats(a->uvs, b->uvs, 2 * (size_t)a->vertex_count, name);
    assert_memory_equal(a->indices, b->indices, 12 * (size_t)a->triangle_count);
}

static void compare_materials(const gn_scene *a, const gn_scene *b)
{
    assert_int_equal(a->material_count, b->material_count);
    assert_int_equal(a->texture_count, b->texture_count);
    for (uint32_t i = 0; i < a->material_count; i++) {
        const gn_material_desc *x = &a->materials[i].desc, *y = &b->materials[i].desc;
        assert_string_equal(a->materials[i].name, b->materials[i].name);
        assert_floats(x->base_color, y->base_color, 4, "base colour");
        assert_int_equal(x->alpha_mode, y->alpha_mode);
        assert_int_equal(x->double_sided, y->double_sided);
        if (x->alpha_mode == GN_ALPHA_MASK)
            assert_floats(&x->alpha_cutoff, &y->alpha_cutoff, 1, "cutoff");
        assert_int_equal(x->texture == GN_NONE, y->texture == GN_NONE);
        if (x->texture == GN_NONE)
            continue;
        assert_int_equal(x->wrap_u, y->wrap_u);
        assert_int_equal(x->wrap_v, y->wrap_v);
        const gn_texture *s = &a->textures[x->texture], *t = &b->textures[y->texture];
        assert_int_equal(s->width, t->width);
        assert_int_equal(s->height, t->height);
        assert_memory_equal(s->rgba[0], t->rgba[0], (size_t)s->width * s->height * 4);
    }
}

static void compare_channels(const gn_scene *a, const gn_scene *b)
{
    assert_int_equal(a->channel_count, b->channel_count);
    for (uint32_t i = 0; i < a->channel_count; i++) {
        const gn_channel_desc *x = &a->channels[i].desc, *y = &b->channels[i].desc;
        assert_int_equal(x->node, y->node);
        assert_int_equal(x->path, y->path);
        assert_int_equal(x->interpolation, y->interpolation);
        assert_int_equal(x->key_count, y->key_count);
        assert_floats(x->times, y->times, x->key_count, "times");
        size_t values = (x->path == GN_PATH_ROTATION ? 4u : 3u) * (size_t)x->key_count *
                        (x->interpolation == GN_INTERPOLATION_CUBICSPLINE ? 3 : 1);
        assert_floats(x->values, y->values, values, "values");
    }
}

static void compare_scenes(const gn_scene *a, const gn_scene *b)
{
    compare_materials(a, b);
    assert_int_equal(a->mesh_count, b->mesh_count);
    for (uint32_t i = 0; i < a->mesh_count; i++) {
        assert_string_equal(a->meshes[i].name, b->meshes[i].name);
        assert_int_equal(a->meshes[i].part_count, b->meshes[i].part_count);
        for (uint32_t k = 0; k < a->meshes[i].part_count; k++) {
            const gn_part *part = &a->meshes[i].parts[k];
            bool textured = a->materials[part->material].desc.texture != GN_NONE;
            compare_parts(part, &b->meshes[i].parts[k], textured, a->meshes[i].name);
        }
    }
    assert_int_equal(a->node_count, b->node_count);
    for (uint32_t i = 0; i < a->node_count; i++) {
        const gn_node *x = &a->nodes[i], *y = &b->nodes[i];
        assert_string_equal(x->name, y->name);
        assert_int_equal(x->desc.parent, y->desc.parent);
        assert_int_equal(x->desc.mesh, y->desc.mesh);
        for (int k = 0; k < 16; k++)
            if (!(fabsf(x->world[k] - y->world[k]) <= 1e-6f * (1 + fabsf(x->world[k]))))
                fail_msg("%s: world[%d] is %.9g, was %.9g", x->name, k, (double)y->world[k],
                         (double)x->world[k]);
    }
    assert_int_equal(a->light_count, b->light_count);
    for (uint32_t i = 0; i < a->light_count; i++) {
        const gn_light_desc *x = &a->lights[i].desc, *y = &b->lights[i].desc;
        assert_string_equal(a->lights[i].name, b->lights[i].name);
        assert_int_equal(x->type, y->type);
        assert_int_equal(x->on, y->on);
        for (int k = 0; k < 3; k++)
            assert_true(fabsf(x->color[k] * x->intensity - y->color[k] * y->intensity) <=
                        1e-6f * x->intensity * x->color[k]);
        assert_floats(&x->range, &y->range, x->type != GN_LIGHT_DIRECTIONAL, "range");
        if (x->type == GN_LIGHT_SPOT) {
            assert_floats(&x->inner_cone_angle, &y->inner_cone_angle, 1, "inner cone");
            assert_floats(&x->outer_cone_angle, &y->outer_cone_angle, 1, "outer cone");
        }
    }
    assert_int_equal(a->camera_count, b->camera_count);
    for (uint32_t i = 0; i < a->camera_count; i++) {
        const gn_camera_desc *x = &a->cameras[i].desc, *y = &b->cameras[i].desc;
        assert_string_equal(a->cameras[i].name, b->cameras[i].name);
        assert_int_equal(x->orthographic, y->orthographic);
        assert_floats(&x->yfov, &y->yfov, !x->orthographic, "yfov");
        assert_floats(&x->ymag, &y->ymag, x->orthographic, "ymag");
        assert_true(fabsf(x->znear - y->znear) < 1e-30f);
    }
    compare_channels(a, b);
}

static void check_round_trip(const gn_scene *scene, const char *name)
{
    const char *path = in_folder(name);
    write_glb(scene, path);
    check_glb(path);
    gn_scene *loaded = NULL;
    if (gn_scene_load(device, path, &loaded) != GN_OK)
        fail_msg("%s", gn_device_message(device));
    compare_scenes(scene, loaded);
    assert_int_equal(gn_scene_get_info(loaded).warning_count, 0);
    gn_scene_destroy(&loaded);
    unlink(path);
}

static void test_procedural(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        gn_scene *scene = make(kind->name, 0.2);
        check_round_trip(scene, "scene.glb");
        gn_scene_destroy(&scene);
    }
}

static void test_same_bytes(void **state)
{
    (void)state;
    uint8_t *data[2];
    size_t sizes[2];
    for (int i = 0; i < 2; i++) {
        gn_scene *scene = make("leafbox", 0.5);
        write_glb(scene, in_folder("same.glb"));
        data[i] = read_file(in_folder("same.glb"), &sizes[i]);
        gn_scene_destroy(&scene);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(data[0], data[1], sizes[0]);
    free(data[0]);
    free(data[1]);
    unlink(in_folder("same.glb"));
}

/* Everything that the procedural scenes do not have ------------------------------------------ */

static void add_odd_materials(gn_scene *scene)
{
    uint8_t rgba[5 * 3 * 4];
    for (size_t i = 0; i < sizeof rgba; i++)
        rgba[i] = (uint8_t)(37 * i);
    gn_texture_desc texture = gn_texture_desc_default();
    texture.name = "not square";
    texture.width = 5;
    texture.height = 3;
    texture.rgba = rgba;
    assert_int_equal(gn_scene_add_texture(scene, &texture, NULL), GN_OK);
    for (uint32_t i = 0; i < 4; i++) {
        gn_material_desc desc = gn_material_desc_default();
        desc.name = i == 0 ? "quote \" backslash \\ \xc3\xa4" : "";
        desc.texture = i < 3 ? 0 : GN_NONE;
        desc.wrap_u = (gn_wrap)(i % 3);
        desc.wrap_v = GN_WRAP_MIRROR;
        desc.alpha_mode = (gn_alpha_mode)(i % 3);
        desc.alpha_cutoff = 0.3f;
        desc.base_color[1] = 1.0f / 3;
        desc.double_sided = i == 2;
        assert_int_equal(gn_scene_add_material(scene, &desc, NULL), GN_OK);
    }
}

/* Too many vertices for 16-bit indices, one more than fit, and one part without anything. */
static void add_odd_meshes(gn_scene *scene)
{
    enum { MANY = 65536 };
    float *values = malloc(MANY * 5 * sizeof *values);
    assert_non_null(values);
    for (uint32_t i = 0; i < MANY; i++) {
        values[3 * i] = (float)(i % 256) / 7;
        values[3 * i + 1] = (float)(i / 256) / 7;
        values[3 * i + 2] = (float)(i % 13) / 13;
        values[3 * MANY + 2 * i] = (float)i / 3;
        values[3 * MANY + 2 * i + 1] = -(float)i / 9;
    }
    const uint32_t far[6] = {0, MANY - 1, 1, 2, MANY - 256, 300}, near[3] = {0, 2, 1};
    /* Normals of other lengths, and one of none. */
    const float normals[9] = {0, 0, 3, 0, 0.25f, 0, 0, 0, 0};
    const gn_mesh_part parts[4] = {{MANY, values, NULL, values + 3 * MANY, 6, far, 0},
                                   {MANY - 1, values, NULL, NULL, 3, near, 1},
                                   {3, values + 30, normals, NULL, 3, near, 3},
                                   {3, values + 60, NULL, NULL, 3, near, GN_NONE}};
    assert_int_equal(gn_scene_add_mesh(scene, "odd", parts, 4, NULL), GN_OK);
    free(values);
}

static void add_odd_nodes(gn_scene *scene)
{
    gn_light_desc light = gn_light_desc_default();
    light.name = "spot";
    light.type = GN_LIGHT_SPOT;
    light.color[0] = 4;
    light.color[2] = 0.1f;
    light.intensity = 0.7f;
    light.outer_cone_angle = 1.57079637f; /* the float nearest to pi / 2 */
    light.on = false;
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    gn_camera_desc camera = gn_camera_desc_default();
    camera.name = "flat";
    camera.orthographic = true;
    camera.ymag = 2.5f;
    camera.znear = 0;
    assert_int_equal(gn_scene_add_camera(scene, &camera, NULL), GN_OK);
    camera.name = "close";
    camera.orthographic = false;
    assert_int_equal(gn_scene_add_camera(scene, &camera, NULL), GN_OK);

    gn_node_desc node = gn_node_desc_default();
    node.name = "matrix";
    node.use_matrix = true;
    node.matrix[12] = 0.1f;
    node.matrix[0] = -2;
    node.mesh = 0;
    assert_int_equal(gn_scene_add_node(scene, &node, NULL), GN_OK);
    node = gn_node_desc_default();
    node.parent = 0;
    node.rotation[0] = 0.5f;
    node.scale[1] = 0.2f;
    node.light = 0;
    node.camera = 0;
    assert_int_equal(gn_scene_add_node(scene, &node, NULL), GN_OK);
    node.parent = 1;
    node.light = GN_NONE;
    node.camera = 1;
    node.mesh = 0;
    node.name = "close"; /* readers name a camera after its node */
    assert_int_equal(gn_scene_add_node(scene, &node, NULL), GN_OK);
    const float moved[16] = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 3, 1.1f, 5, 1};
    assert_int_equal(gn_scene_set_node_matrix(scene, 2, moved), GN_OK);
}

static void add_odd_channels(gn_scene *scene)
{
    const float times[3] = {0, 0.1f, 2}, identity[4] = {0, 0, 0, 1};
    float values[36];
    for (int i = 0; i < 36; i++)
        values[i] = i % 4 < 4 ? identity[i % 4] : 0;
    for (uint32_t i = 0; i < 3; i++) {
        static const gn_animation_path paths[3] = {GN_PATH_SCALE, GN_PATH_TRANSLATION,
                                                   GN_PATH_ROTATION};
        gn_channel_desc desc = gn_channel_desc_default();
        desc.node = 1;
        desc.path = paths[i];
        desc.interpolation = (gn_interpolation)i;
        desc.key_count = 3;
        desc.times = times;
        desc.values = values;
        assert_int_equal(gn_scene_add_channel(scene, &desc), GN_OK);
    }
}

static void test_odd_scene(void **state)
{
    (void)state;
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create(device, &scene), GN_OK);
    add_odd_materials(scene);
    add_odd_meshes(scene);
    add_odd_nodes(scene);
    add_odd_channels(scene);
    assert_int_equal(gn_scene_commit(scene), GN_OK);
    write_glb(scene, in_folder("odd.glb"));
    check_glb(in_folder("odd.glb"));

    /* What glTF cannot say as it is: the length of normals, and coordinates that are not there. */
    gn_scene *loaded = NULL;
    if (gn_scene_load(device, in_folder("odd.glb"), &loaded) != GN_OK)
        fail_msg("%s", gn_device_message(device));
    const float *normals = loaded->meshes[0].parts[2].normals;
    assert_floats((const float[9]){0, 0, 1, 0, 1, 0, 0, 1, 0}, normals, 9, "normals");
    for (uint32_t i = 0; i < 9; i++)
        scene->meshes[0].parts[2].normals[i] = normals[i];
    compare_scenes(scene, loaded);
    gn_scene_destroy(&loaded);
    gn_scene_destroy(&scene);
    unlink(in_folder("odd.glb"));
}

/* A scene without anything is a valid file, too. */
static void test_empty_scene(void **state)
{
    (void)state;
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create(device, &scene), GN_OK);
    write_glb(scene, in_folder("empty.glb"));
    check_glb(in_folder("empty.glb"));
    gn_scene_destroy(&scene);
    unlink(in_folder("empty.glb"));
}

/* Failures ---------------------------------------------------------------------------------- */

static void assert_unwritable(const gn_scene *scene, const char *path, const char *reason)
{
    assert_int_equal(gn_scene_write_glb(scene, path), GN_ERROR_IO);
    const char *message = gn_device_message(device);
    if (!strstr(message, path) || !strstr(message, reason))
        fail_msg("the message is \"%s\", expected \"%s\" and \"%s\" in it", message, path, reason);
}

static void test_failures(void **state)
{
    (void)state;
    gn_scene *scene = make("leafbox", 0.1);
    if (access("/dev/full", W_OK) == 0)
        assert_unwritable(scene, "/dev/full", "No space left");
    assert_unwritable(scene, in_folder("nowhere/scene.glb"), "No such file");
    assert_unwritable(scene, folder, "directory");

    /* A disk that fills up while the file is written: what was there before stays. */
    FILE *before = fopen(in_folder("scene.glb"), "wb");
    assert_non_null(before);
    assert_true(fputs("before", before) >= 0 && fclose(before) == 0);
    struct rlimit usual, tight;
    getrlimit(RLIMIT_FSIZE, &usual);
    tight = usual;
    tight.rlim_cur = 20000;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &tight), 0);
    gn_result result = gn_scene_write_glb(scene, in_folder("scene.glb"));
    setrlimit(RLIMIT_FSIZE, &usual);
    assert_int_equal(result, GN_ERROR_IO);
    assert_non_null(strstr(gn_device_message(device), "scene.glb"));
    size_t size;
    uint8_t *data = read_file(in_folder("scene.glb"), &size);
    assert_string_equal((const char *)data, "before");
    free(data);
    assert_int_equal(files_in_folder(), 1);
    unlink(in_folder("scene.glb"));
    gn_scene_destroy(&scene);
}

static int set_up(void **state)
{
    (void)state;
    return mkdtemp(folder) && gn_device_create(NULL, &device) == GN_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    gn_device_destroy(&device);
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_procedural), cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_odd_scene), cmocka_unit_test(test_empty_scene),
        cmocka_unit_test(test_failures)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
