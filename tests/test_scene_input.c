/* What a scene refuses, and how it says so. */
#include "scene_testing.h"

static void descriptors_must_come_from_their_default(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    assert_int_equal(gn_scene_add_texture(scene, &(gn_texture_desc){0}, NULL),
                     GN_ERROR_INVALID_DESC);
    assert_int_equal(gn_scene_add_material(scene, &(gn_material_desc){0}, NULL),
                     GN_ERROR_INVALID_DESC);
    assert_int_equal(gn_scene_add_node(scene, &(gn_node_desc){0}, NULL), GN_ERROR_INVALID_DESC);
    assert_int_equal(gn_scene_add_light(scene, NULL, NULL), GN_ERROR_INVALID_DESC);
    assert_int_equal(gn_scene_add_camera(scene, &(gn_camera_desc){0}, NULL), GN_ERROR_INVALID_DESC);
    assert_int_equal(gn_scene_add_channel(scene, &(gn_channel_desc){0}), GN_ERROR_INVALID_DESC);
    gn_scene_destroy(&scene);
    assert_null(scene);
    assert_int_equal(context.bytes, 0);
}

static void defaults_are_valid(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_material_desc material = gn_material_desc_default();
    gn_node_desc node = gn_node_desc_default();
    gn_light_desc light = gn_light_desc_default();
    gn_camera_desc camera = gn_camera_desc_default();
    uint32_t index = GN_NONE;
    assert_int_equal(gn_scene_add_material(scene, &material, &index), GN_OK);
    assert_int_equal(index, 0);
    assert_int_equal(gn_scene_add_node(scene, &node, NULL), GN_OK);
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    assert_int_equal(gn_scene_add_camera(scene, &camera, NULL), GN_OK);
    light.type = GN_LIGHT_SPOT;
    assert_int_equal(gn_scene_add_light(scene, &light, &index), GN_OK);
    assert_int_equal(index, 1);
    gn_scene_destroy(&scene);
}

static void bad_textures_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    const uint8_t pixel[4] = {0};
    gn_texture_desc desc = gn_texture_desc_default();
    desc.name = "bark";
    desc.rgba = pixel;
    assert_refused(gn_scene_add_texture(scene, &desc, NULL), "texture 0 \"bark\": 0 x 0");
    desc.width = GN_MAX_TEXTURE_SIZE + 1;
    desc.height = 1;
    assert_refused(gn_scene_add_texture(scene, &desc, NULL), "16385");
    desc.width = 1;
    desc.rgba = NULL;
    assert_refused(gn_scene_add_texture(scene, &desc, NULL), "no pixels");
    assert_int_equal(scene->texture_count, 0);
    gn_scene_destroy(&scene);
}

static void bad_materials_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_material_desc desc = gn_material_desc_default();
    desc.name = "leaf";
    static const float bad_cutoffs[] = {-0.1f, 1.5f, NAN, INFINITY};
    for (int i = 0; i < 4; i++) {
        desc.alpha_cutoff = bad_cutoffs[i];
        assert_refused(gn_scene_add_material(scene, &desc, NULL),
                       "material 0 \"leaf\": alpha cutoff");
    }
    desc = gn_material_desc_default();
    desc.base_color[2] = NAN;
    assert_refused(gn_scene_add_material(scene, &desc, NULL), "base_color[2]");
    desc = gn_material_desc_default();
    desc.texture = 3;
    assert_refused(gn_scene_add_material(scene, &desc, NULL), "texture 3 does not exist");
    desc = gn_material_desc_default();
    desc.uv_transform[5] = INFINITY;
    assert_refused(gn_scene_add_material(scene, &desc, NULL), "uv_transform");
    desc = gn_material_desc_default();
    desc.wrap_v = (gn_wrap)7;
    assert_refused(gn_scene_add_material(scene, &desc, NULL), "wrap");
    desc = gn_material_desc_default();
    desc.alpha_mode = (gn_alpha_mode)-1;
    assert_refused(gn_scene_add_material(scene, &desc, NULL), "alpha mode");
    assert_int_equal(scene->material_count, 0);
    gn_scene_destroy(&scene);
}

static void bad_meshes_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    float positions[9], normals[9] = {0}, uvs[6] = {0};
    uint32_t indices[] = {0, 1, 2};
    memcpy(positions, triangle, sizeof positions);
    const gn_mesh_part good = {.vertex_count = 3,
                               .positions = positions,
                               .normals = normals,
                               .uvs = uvs,
                               .index_count = 3,
                               .indices = indices,
                               .material = GN_NONE};
    gn_mesh_part parts[2] = {good, good};

    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 0, NULL), "mesh 0 \"oak\": no parts");
    parts[1].vertex_count = 2;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "part 1: fewer than 3");
    parts[1] = good;
    parts[1].index_count = 2;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "2 indices");
    parts[1] = good;
    parts[1].material = 0;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "material 0 does not exist");
    parts[1] = good;
    indices[1] = 3;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "index 1 names vertex 3");
    indices[1] = 1;
    positions[7] = NAN;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "position of vertex 2");
    positions[7] = 0;
    normals[0] = INFINITY;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "normal of vertex 0");
    normals[0] = 0;
    uvs[3] = NAN;
    assert_refused(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), "coordinate of vertex 1");
    uvs[3] = 0;
    assert_int_equal(scene->mesh_count, 0);
    assert_int_equal(gn_scene_add_mesh(scene, "oak", parts, 2, NULL), GN_OK);
    gn_scene_destroy(&scene);
    assert_int_equal(context.bytes, 0);
}

static void bad_lights_and_cameras_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_light_desc light = gn_light_desc_default();
    light.name = "lamp";
    light.intensity = -1;
    assert_refused(gn_scene_add_light(scene, &light, NULL), "light 0 \"lamp\": intensity");
    light = gn_light_desc_default();
    light.color[1] = NAN;
    assert_refused(gn_scene_add_light(scene, &light, NULL), "color");
    light = gn_light_desc_default();
    light.range = 0;
    assert_refused(gn_scene_add_light(scene, &light, NULL), "range");
    light.range = NAN;
    assert_refused(gn_scene_add_light(scene, &light, NULL), "range");
    light = gn_light_desc_default();
    light.type = GN_LIGHT_SPOT;
    light.inner_cone_angle = light.outer_cone_angle;
    assert_refused(gn_scene_add_light(scene, &light, NULL), "cone angles");
    light.outer_cone_angle = 1.6f;
    assert_refused(gn_scene_add_light(scene, &light, NULL), "cone angles");

    gn_camera_desc camera = gn_camera_desc_default();
    static const float bad_fovs[] = {0, -1, 3.1416f, NAN};
    for (int i = 0; i < 4; i++) {
        camera.yfov = bad_fovs[i];
        assert_refused(gn_scene_add_camera(scene, &camera, NULL), "yfov");
    }
    camera = gn_camera_desc_default();
    camera.orthographic = true;
    camera.ymag = 0;
    assert_refused(gn_scene_add_camera(scene, &camera, NULL), "ymag");
    camera = gn_camera_desc_default();
    camera.znear = -1;
    assert_refused(gn_scene_add_camera(scene, &camera, NULL), "znear");
    assert_int_equal(scene->light_count + scene->camera_count, 0);
    gn_scene_destroy(&scene);
}

static void bad_nodes_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_light_desc light = gn_light_desc_default();
    gn_camera_desc camera = gn_camera_desc_default();
    assert_int_equal(gn_scene_add_light(scene, &light, NULL), GN_OK);
    assert_int_equal(gn_scene_add_camera(scene, &camera, NULL), GN_OK);

    gn_node_desc desc = gn_node_desc_default();
    desc.name = "trunk";
    desc.parent = 0; /* itself */
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "node 0 \"trunk\": parent 0");
    desc = gn_node_desc_default();
    desc.mesh = 0;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "mesh 0");
    desc = gn_node_desc_default();
    desc.light = 1;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "light 1");
    desc = gn_node_desc_default();
    desc.rotation[3] = 0;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "rotation");
    desc = gn_node_desc_default();
    desc.translation[0] = NAN;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "not finite");
    desc = gn_node_desc_default();
    desc.use_matrix = true;
    desc.matrix[3] = 0.5f;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "affine");

    desc = gn_node_desc_default();
    desc.light = 0;
    desc.camera = 0;
    add_node(scene, &desc);
    desc.camera = GN_NONE;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "light 0 already hangs on node 0");
    desc.light = GN_NONE;
    desc.camera = 0;
    assert_refused(gn_scene_add_node(scene, &desc, NULL), "camera 0 already hangs on node 0");

    float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, NAN, 1};
    assert_refused(gn_scene_set_node_matrix(scene, 0, matrix), "node 0");
    assert_refused(gn_scene_set_node_matrix(scene, 5, matrix), "node 5 does not exist");
    assert_refused(gn_scene_set_time(scene, (double)NAN), "time");
    assert_int_equal(scene->node_count, 1);
    gn_scene_destroy(&scene);
}

static void bad_channels_are_refused(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_node_desc node = gn_node_desc_default();
    add_node(scene, &node);
    node.use_matrix = true;
    add_node(scene, &node);

    float times[] = {0, 1}, values[8] = {0};
    gn_channel_desc good = gn_channel_desc_default();
    good.node = 0;
    good.key_count = 2;
    good.times = times;
    good.values = values;
    gn_channel_desc desc = good;
    desc.node = 2;
    assert_refused(gn_scene_add_channel(scene, &desc), "channel 0: node 2");
    desc = good;
    desc.node = 1;
    assert_refused(gn_scene_add_channel(scene, &desc), "node 1 has a matrix");
    desc = good;
    desc.key_count = 0;
    assert_refused(gn_scene_add_channel(scene, &desc), "no keys");
    desc = good;
    desc.path = (gn_animation_path)3;
    assert_refused(gn_scene_add_channel(scene, &desc), "path");
    desc = good;
    desc.path = GN_PATH_ROTATION;
    assert_refused(gn_scene_add_channel(scene, &desc), "no length");
    times[1] = 0;
    assert_refused(gn_scene_add_channel(scene, &good), "time 1");
    times[1] = INFINITY;
    assert_refused(gn_scene_add_channel(scene, &good), "time 1");
    times[1] = 1;
    times[0] = -1;
    assert_refused(gn_scene_add_channel(scene, &good), "time 0");
    times[0] = 0;
    values[5] = NAN;
    assert_refused(gn_scene_add_channel(scene, &good), "key 1");
    values[5] = 0;
    assert_int_equal(scene->channel_count, 0);
    assert_int_equal(gn_scene_add_channel(scene, &good), GN_OK);
    assert_refused(gn_scene_add_channel(scene, &good), "translation of node 0 is animated already");
    gn_scene_destroy(&scene);
    assert_int_equal(context.bytes, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descriptors_must_come_from_their_default),
        cmocka_unit_test(defaults_are_valid),
        cmocka_unit_test(bad_textures_are_refused),
        cmocka_unit_test(bad_materials_are_refused),
        cmocka_unit_test(bad_meshes_are_refused),
        cmocka_unit_test(bad_lights_and_cameras_are_refused),
        cmocka_unit_test(bad_nodes_are_refused),
        cmocka_unit_test(bad_channels_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
