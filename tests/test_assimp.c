/* Formats other than glTF: instances, lights and cameras come through Assimp as they should. */
#include "glb_testing.h"

/* Two instances of a triangle, a camera of 60 degrees across at 2:1, a spot of 40 degrees. */
static const char collada[] =
    "<?xml version='1.0'?>"
    "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
    "<asset><unit name='meter' meter='1'/><up_axis>Y_UP</up_axis></asset>"
    "<library_cameras><camera id='c' name='c'><optics><technique_common><perspective>"
    "<xfov>60</xfov><aspect_ratio>2</aspect_ratio><znear>0.2</znear><zfar>100</zfar>"
    "</perspective></technique_common></optics></camera></library_cameras>"
    "<library_lights><light id='s' name='s'><technique_common><spot><color>2 2 2"
    "</color><constant_attenuation>0</constant_attenuation><quadratic_attenuation>1"
    "</quadratic_attenuation><falloff_angle>40</falloff_angle></spot>"
    "</technique_common></light></library_lights>"
    "<library_geometries><geometry id='g'><mesh><source id='p'>"
    "<float_array id='pa' count='9'>0 0 0 1 0 0 0 1 0</float_array><technique_common>"
    "<accessor source='#pa' count='3' stride='3'><param name='X' type='float'/>"
    "<param name='Y' type='float'/><param name='Z' type='float'/></accessor>"
    "</technique_common></source><vertices id='v'>"
    "<input semantic='POSITION' source='#p'/></vertices><triangles count='1'>"
    "<input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles></mesh>"
    "</geometry></library_geometries>"
    "<library_visual_scenes><visual_scene id='w'><node id='n1'><translate>1 0 0"
    "</translate><instance_geometry url='#g'/></node><node id='n2'><translate>5 0 0"
    "</translate><instance_geometry url='#g'/></node><node id='Cam' name='Cam'>"
    "<translate>0 0 9</translate><instance_camera url='#c'/></node>"
    "<node id='Lamp' name='Lamp'><instance_light url='#s'/></node></visual_scene>"
    "</library_visual_scenes>"
    "<scene><instance_visual_scene url='#w'/></scene></COLLADA>";

/* A quad, which becomes two triangles. */
static const char ply[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n"
                          "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

static gn_scene *load(const char *suffix, const char *text)
{
    char path[64];
    snprintf(path, sizeof path, "/tmp/gnomon-assimp-XXXXXX%s", suffix);
    const int descriptor = mkstemps(path, (int)strlen(suffix));
    assert_true(descriptor >= 0);
    close(descriptor);
    write_file(path, text, strlen(text));
    gn_scene *scene = NULL;
    const gn_result result = gn_scene_load(test_device(), path, &scene);
    unlink(path);
    if (result != GN_OK)
        fail_msg("%s", gn_device_message(test_device()));
    return scene;
}

static void collada_scene(void **state)
{
    (void)state;
    gn_scene *scene = load(".dae", collada);
    const gn_scene_info info = gn_scene_get_info(scene);
    assert_int_equal(info.meshes, 1);
    assert_int_equal(info.mesh_nodes, 2);
    assert_int_equal(info.instanced_triangles, 2);
    assert_floats(info.bounds_min, (float[]){1, 0, 0}, 3, 1e-6f);
    assert_floats(info.bounds_max, (float[]){6, 1, 0}, 3, 1e-6f);

    const uint32_t camera = gn_scene_find_camera(scene, "Cam");
    assert_int_equal(camera, 0);
    const double radians = 3.14159265358979323846 / 180;
    const float yfov = (float)(2 * atan(tan(30 * radians) / 2));
    assert_floats(&scene->cameras[0].desc.yfov, &yfov, 1, 1e-6f);
    assert_floats(&scene->cameras[0].desc.znear, (float[]){0.2f}, 1, 1e-7f);
    assert_floats(scene->cameras[0].world + 12, (float[]){0, 0, 9}, 3, 1e-6f);
    assert_floats(scene->cameras[0].world + 8, (float[]){0, 0, 1}, 3, 1e-6f);

    assert_int_equal(info.lights, 1);
    const gn_light_desc light = gn_scene_get_light(scene, 0);
    assert_string_equal(gn_scene_light_name(scene, 0), "Lamp");
    assert_int_equal(light.type, GN_LIGHT_SPOT);
    assert_floats(light.color, (float[]){2, 2, 2}, 3, 1e-6f);
    assert_true(light.inner_cone_angle < light.outer_cone_angle);
    assert_floats(scene->lights[0].direction, (float[]){0, 0, -1}, 3, 1e-6f);
    gn_scene_destroy(&scene);
}

static void ply_quad(void **state)
{
    (void)state;
    gn_scene *scene = load(".ply", ply);
    assert_int_equal(gn_scene_get_info(scene).triangles, 2);
    assert_true(scene->materials[scene->meshes[0].parts[0].material].desc.double_sided);
    gn_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(collada_scene), cmocka_unit_test(ply_quad)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
