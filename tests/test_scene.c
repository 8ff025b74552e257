/* The scene: materials and meshes, hierarchy, cameras, lights, versions. */
#include "scene_testing.h"

#define PI 3.14159265358979323846

/* Meshes and materials ----------------------------------------------------------------------- */

static void uvs_are_transformed_by_their_material(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_material_desc material = gn_material_desc_default();
    memcpy(material.uv_transform, (float[6]){2, 3, 5, 7, 11, 13}, sizeof material.uv_transform);
    assert_int_equal(gn_scene_add_material(scene, &material, NULL), GN_OK);
    gn_mesh_part part = triangle_part();
    part.material = 0;
    assert_int_equal(gn_scene_add_mesh(scene, NULL, &part, 1, NULL), GN_OK);
    const float *uvs = scene->meshes[0].parts[0].uvs;
    static const float expected[] = {5, 13, 7, 20, 8, 24};
    for (int i = 0; i < 6; i++)
        assert_near((double)uvs[i], (double)expected[i], 0, "uv");
    gn_scene_destroy(&scene);
}

/* Parts without a material share one that nobody counts, and callers' indices have no gaps. */
static void the_default_material_is_shared_and_hidden(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    add_triangle(scene);
    add_triangle(scene);
    assert_int_equal(gn_scene_get_info(scene).materials, 0);
    const uint32_t hidden = scene->meshes[0].parts[0].material;
    assert_int_equal(scene->meshes[1].parts[0].material, hidden);
    assert_true(scene->materials[hidden].desc.double_sided);
    gn_mesh_part part = triangle_part();
    part.material = hidden;
    assert_refused(gn_scene_add_mesh(scene, NULL, &part, 1, NULL), "does not exist");

    gn_material_desc red = gn_material_desc_default();
    red.name = "red";
    red.base_color[1] = 0;
    uint32_t index = GN_NONE;
    assert_int_equal(gn_scene_add_material(scene, &red, &index), GN_OK);
    assert_int_equal(index, 0);
    assert_string_equal(scene->materials[0].name, "red");
    for (uint32_t i = 0; i < 2; i++) {
        const gn_material *material = &scene->materials[scene->meshes[i].parts[0].material];
        assert_near((double)material->desc.base_color[1], 1, 0, "the default's green");
    }
    assert_int_equal(gn_scene_get_info(scene).materials, 1);
    gn_scene_destroy(&scene);
}

static void info_counts(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    static const uint8_t texels[] = {9, 9, 9, 255, 9, 9, 9, 0};
    gn_texture_desc texture = gn_texture_desc_default();
    texture.width = 2;
    texture.height = 1;
    texture.rgba = texels;
    assert_int_equal(gn_scene_add_texture(scene, &texture, NULL), GN_OK);
    gn_material_desc material = gn_material_desc_default();
    material.texture = 0;
    material.alpha_mode = GN_ALPHA_MASK;
    assert_int_equal(gn_scene_add_material(scene, &material, NULL), GN_OK);
    assert_true(scene->materials[0].masked);
    gn_mesh_part parts[2] = {triangle_part(), triangle_part()};
    parts[1].material = 0;
    uint32_t mesh = GN_NONE;
    assert_int_equal(gn_scene_add_mesh(scene, NULL, parts, 2, &mesh), GN_OK);
    gn_node_desc node = gn_node_desc_default();
    add_node(scene, &node);
    node.mesh = mesh;
    for (int i = 0; i < 3; i++)
        add_node(scene, &node);
    const float times[] = {0.5f, 2.5f}, values[6] = {0};
    gn_channel_desc channel = gn_channel_desc_default();
    channel.node = 1;
    channel.key_count = 2;
    channel.times = times;
    channel.values = values;
    assert_int_equal(gn_scene_add_channel(scene, &channel), GN_OK);
    gn_scene_warn(scene, "skin %d is left out", 3);
    gn_scene_warn(scene, "skin %d is left out", 3);
    gn_scene_warn(scene, "skin %d is left out", 4);

    const gn_scene_info info = gn_scene_get_info(scene);
    assert_int_equal(info.nodes, 4);
    assert_int_equal(info.mesh_nodes, 3);
    assert_int_equal(info.meshes, 1);
    assert_int_equal(info.materials, 1);
    assert_int_equal(info.masked_materials, 1);
    assert_int_equal(info.textures, 1);
    assert_int_equal(info.channels, 1);
    assert_int_equal(info.triangles, 2);
    assert_int_equal(info.instanced_triangles, 6);
    assert_int_equal(info.masked_triangles, 1);
    assert_int_equal(info.instanced_masked_triangles, 3);
    assert_near(info.duration, 2.5, 0, "duration");
    assert_int_equal(info.warning_count, 2);
    assert_string_equal(gn_scene_warning(scene, 1), "skin 4 is left out");
    gn_scene_destroy(&scene);
    assert_int_equal(context.bytes, 0);
}

static void names_are_found(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_light_desc light = gn_light_desc_default();
    gn_camera_desc camera = gn_camera_desc_default();
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    light.name = "lamp";
    light.intensity = 4;
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    camera.name = "walk";
    assert_int_equal(gn_scene_add_camera(scene, &camera, NULL), GN_OK);
    assert_int_equal(gn_scene_find_light(scene, "lamp"), 1);
    assert_int_equal(gn_scene_find_light(scene, "sun"), GN_NONE);
    assert_int_equal(gn_scene_find_light(scene, ""), GN_NONE);
    assert_int_equal(gn_scene_find_camera(scene, "walk"), 0);
    assert_string_equal(gn_scene_light_name(scene, 0), "");
    assert_string_equal(gn_scene_camera_name(scene, 0), "walk");
    const gn_light_desc again = gn_scene_get_light(scene, 1);
    assert_near((double)again.intensity, 4, 0, "intensity");
    assert_int_equal(gn_scene_add_light(scene, &again, NULL), GN_OK); /* a valid descriptor */
    assert_string_equal(gn_scene_light_name(scene, 2), "lamp");
    gn_scene_destroy(&scene);
}

/* Hierarchy ---------------------------------------------------------------------------------- */

static void children_follow_their_parents(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    const uint32_t mesh = add_triangle(scene);
    gn_node_desc desc = gn_node_desc_default();
    desc.translation[0] = 10;
    /* A quarter turn about Z, of any length. */
    memcpy(desc.rotation, (float[4]){0, 0, 2, 2}, sizeof desc.rotation);
    desc.scale[0] = desc.scale[1] = desc.scale[2] = 3;
    const uint32_t parent = add_node(scene, &desc);
    desc = gn_node_desc_default();
    desc.parent = parent;
    desc.use_matrix = true;
    desc.matrix[12] = 1; /* one to its right, which is up in the world */
    desc.mesh = mesh;
    const uint32_t child = add_node(scene, &desc);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    const float *world = scene->nodes[child].world;
    assert_vector(world, 0, 3, 0, "x axis");
    assert_vector(world + 4, -3, 0, 0, "y axis");
    assert_vector(world + 8, 0, 0, 3, "z axis");
    assert_vector(world + 12, 10, 3, 0, "origin");
    /* The triangle (0,0) (1,0) (0,2) lands on (10,3) (10,6) (4,3). */
    assert_vector(scene->bounds_min, 4, 3, 0, "lower bound");
    assert_vector(scene->bounds_max, 10, 6, 0, "upper bound");
    gn_scene_destroy(&scene);
}

static void places_beyond_floats_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_node_desc desc = gn_node_desc_default();
    desc.scale[0] = desc.scale[1] = desc.scale[2] = 1e30f;
    desc.name = "huge";
    desc.parent = add_node(scene, &desc);
    add_node(scene, &desc);
    assert_refused(gn_scene_resolve(scene), "node 1 \"huge\"");
    gn_scene_destroy(&scene);
}

static void check_camera(const float frame[16])
{
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++) {
            double dot = 0;
            for (int i = 0; i < 3; i++)
                dot += (double)frame[4 * a + i] * (double)frame[4 * b + i];
            assert_near(dot, a == b, 1e-6, "the product of two axes");
        }
    }
    const double determinant =
        (double)frame[0] * ((double)frame[5] * frame[10] - (double)frame[6] * frame[9]) -
        (double)frame[4] * ((double)frame[1] * frame[10] - (double)frame[2] * frame[9]) +
        (double)frame[8] * ((double)frame[1] * frame[6] - (double)frame[2] * frame[5]);
    assert_near(determinant, 1, 1e-5, "the determinant");
}

static void cameras_are_orthonormal_whatever_the_scale(void **state)
{
    (void)state;
    static const float scales[][3] = {{1, 1, 1},          {1e-3f, 1e-3f, 1e-3f},
                                      {1e3f, 1e3f, 1e3f}, {0.1f, 5, 30},
                                      {1e-30f, 1, 1e18f}, {-1, 1, 1},
                                      {0, 0, 0},          {1, 1, 0},
                                      {0, 1, 1},          {1, 0, 1}};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        gn_scene *scene = make_scene();
        gn_camera_desc camera = gn_camera_desc_default();
        assert_int_equal(gn_scene_add_camera(scene, &camera, NULL), GN_OK);
        gn_node_desc desc = gn_node_desc_default();
        memcpy(desc.scale, scales[i], sizeof desc.scale);
        desc.parent = add_node(scene, &desc);
        /* A turn below an uneven scale: shear. */
        memcpy(desc.rotation, (float[4]){0.3f, 0.5f, -0.2f, 0.7f}, sizeof desc.rotation);
        desc.scale[0] = desc.scale[1] = desc.scale[2] = 1;
        desc.translation[1] = 7;
        desc.camera = 0;
        const uint32_t node = add_node(scene, &desc);
        assert_int_equal(gn_scene_resolve(scene), GN_OK);
        const float *frame = scene->cameras[0].world, *world = scene->nodes[node].world;
        check_camera(frame);
        assert_memory_equal(frame + 12, world + 12, 3 * sizeof *frame);
        /* It looks where the node's -Z looks. */
        const double length = sqrt((double)world[8] * world[8] + (double)world[9] * world[9] +
                                   (double)world[10] * world[10]);
        if (length > 0)
            assert_vector(frame + 8, world[8] / length, world[9] / length, world[10] / length,
                          "the view's axis");
        gn_scene_destroy(&scene);
    }
}

static void lights_hang_on_nodes(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_light_desc light = gn_light_desc_default();
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    gn_node_desc desc = gn_node_desc_default();
    desc.light = 1;
    memcpy(desc.translation, (float[3]){1, 2, 3}, sizeof desc.translation);
    memcpy(desc.rotation, (float[4]){-1, 0, 0, 1}, sizeof desc.rotation); /* -Z becomes -Y */
    memcpy(desc.scale, (float[3]){4, 5, 6}, sizeof desc.scale);
    add_node(scene, &desc);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_vector(scene->lights[0].direction, 0, 0, -1, "direction at the root");
    assert_vector(scene->lights[1].direction, 0, -1, 0, "direction");
    assert_vector(scene->lights[1].position, 1, 2, 3, "position");
    gn_scene_destroy(&scene);
}

static void the_sun_stands_where_it_is_told(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    static const double angles[][2] = {{0, 0},     {90, 0},    {180, 30}, {270, 45},
                                       {123, -20}, {-400, 90}, {37, 60}};
    for (uint32_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        uint32_t light = GN_NONE;
        assert_int_equal(gn_scene_add_sun(scene, angles[i][0], angles[i][1], &light), GN_OK);
        assert_int_equal(light, i);
        assert_int_equal(gn_scene_resolve(scene), GN_OK);
        /* Clockwise seen from above: from -Z (north) by +X (east). Light travels away from it. */
        const double a = angles[i][0] * PI / 180, e = angles[i][1] * PI / 180;
        assert_vector(scene->lights[light].direction, -cos(e) * sin(a), -sin(e), cos(e) * cos(a),
                      "the sun's direction");
    }
    assert_refused(gn_scene_add_sun(scene, 0, 91, NULL), "elevation");
    assert_refused(gn_scene_add_sun(scene, (double)NAN, 0, NULL), "sun");
    gn_scene_destroy(&scene);
}

static void the_overview_sees_everything(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_node_desc desc = gn_node_desc_default();
    desc.mesh = add_triangle(scene);
    desc.scale[0] = 100;
    desc.translation[2] = -40;
    add_node(scene, &desc);
    assert_int_equal(gn_scene_add_overview(scene, NULL), GN_ERROR_STATE);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    scene->committed = scene->edits;
    uint32_t index = GN_NONE;
    assert_int_equal(gn_scene_add_overview(scene, &index), GN_OK);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    const gn_camera *camera = &scene->cameras[index];
    const double slope = tan((double)camera->desc.yfov / 2);
    for (int corner = 0; corner < 8; corner++) {
        double view[3] = {0};
        for (int axis = 0; axis < 3; axis++) {
            for (int i = 0; i < 3; i++) {
                const float *bound = corner >> i & 1 ? scene->bounds_max : scene->bounds_min;
                view[axis] +=
                    ((double)bound[i] - camera->world[12 + i]) * camera->world[4 * axis + i];
            }
        }
        assert_true(-view[2] > (double)camera->desc.znear);
        assert_true(fabs(view[0]) <= -view[2] * slope * 1.00001);
        assert_true(fabs(view[1]) <= -view[2] * slope * 1.00001);
    }
    assert_true(camera->world[9] > 0); /* from above */
    gn_scene_destroy(&scene);

    scene = make_scene();
    assert_int_equal(gn_scene_add_overview(scene, NULL), GN_ERROR_STATE); /* nothing to see */
    gn_scene_destroy(&scene);
}

/* Versions ----------------------------------------------------------------------------------- */

static void versions_grow_when_something_changes(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_node_desc desc = gn_node_desc_default();
    desc.mesh = add_triangle(scene);
    const uint64_t with_mesh = scene->structure_version;
    assert_true(with_mesh > 0);
    const uint32_t parent = add_node(scene, &desc);
    desc.parent = parent;
    const uint32_t child = add_node(scene, &desc);
    assert_true(scene->structure_version > with_mesh);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    const uint64_t structure = scene->structure_version, transform = scene->transform_version;
    assert_true(transform > 0);
    assert_false(scene->nodes[child].animated);

    /* Nothing moves: nothing grows, but there is something to commit. */
    const uint64_t edits = scene->edits;
    assert_int_equal(gn_scene_set_time(scene, 1), GN_OK);
    assert_true(scene->edits > edits);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_int_equal(scene->transform_version, transform);

    float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
    assert_int_equal(gn_scene_set_node_matrix(scene, parent, matrix), GN_OK);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_true(scene->transform_version > transform);
    assert_int_equal(scene->structure_version, structure);
    assert_vector(scene->nodes[child].world + 12, 5, 0, 0, "the child");
    assert_true(scene->nodes[parent].animated);
    assert_true(scene->nodes[child].animated);
    gn_scene_destroy(&scene);
}

/* A move that another node's failure kept from being committed is not forgotten. */
static void a_failed_commit_forgets_no_move(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_node_desc desc = gn_node_desc_default();
    const uint32_t first = add_node(scene, &desc), second = add_node(scene, &desc);
    desc.parent = second;
    desc.scale[0] = 1e30f;
    add_node(scene, &desc);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    const uint64_t transform = scene->transform_version;
    float moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
    float huge[16] = {1e30f, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    float back[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    assert_int_equal(gn_scene_set_node_matrix(scene, first, moved), GN_OK);
    assert_int_equal(gn_scene_set_node_matrix(scene, second, huge), GN_OK);
    assert_refused(gn_scene_resolve(scene), "node 2");
    assert_int_equal(gn_scene_set_node_matrix(scene, second, back), GN_OK);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_true(scene->transform_version > transform);
    assert_vector(scene->nodes[first].world + 12, 5, 0, 0, "the moved node");
    gn_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uvs_are_transformed_by_their_material),
        cmocka_unit_test(the_default_material_is_shared_and_hidden),
        cmocka_unit_test(info_counts),
        cmocka_unit_test(names_are_found),
        cmocka_unit_test(children_follow_their_parents),
        cmocka_unit_test(places_beyond_floats_are_refused),
        cmocka_unit_test(cameras_are_orthonormal_whatever_the_scale),
        cmocka_unit_test(lights_hang_on_nodes),
        cmocka_unit_test(the_sun_stands_where_it_is_told),
        cmocka_unit_test(the_overview_sees_everything),
        cmocka_unit_test(versions_grow_when_something_changes),
        cmocka_unit_test(a_failed_commit_forgets_no_move),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
