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

#include <gnomon/procedural.h>

#include "glb_checking.h"
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
