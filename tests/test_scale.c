/* The same scene in other units: visibility does not change. */
#include "render_testing.h"

#define WIDTH  400
#define HEIGHT 225

/* Where two pictures differ, of `pixels`; at most 1e-4 may differ by more than a half. */
static void compare(const frame *one, const frame *other, const char *name, double unit,
                    const char *method)
{
    size_t lit = 0, surfaces = 0;
    for (size_t i = 0; i < one->pixels; i++) {
        lit += one->visibility[i] > 0.5f;
        surfaces += one->g->surface[i] != other->g->surface[i];
    }
    const size_t wrong = count_different(one->visibility, other->visibility, one->pixels, 0.5f);
    print_message("%s * %g, %s: %zu pixels differ by more than 0.5, %zu by more than 0.1; "
                  "%zu other surfaces\n",
                  name, unit, method, wrong,
                  count_different(one->visibility, other->visibility, one->pixels, 0.1f), surfaces);
    few(wrong, one->pixels, 1e-4, "%s * %g, %s", name, unit, method);
    few(surfaces, one->pixels, 1e-4, "%s * %g: surfaces", name, unit);
    if (lit < one->pixels / 50 || lit == one->pixels)
        fail_msg("%s: %zu pixels are lit, nothing is tested", name, lit);
}

static void check_scenes(gn_scene *const scenes[3], const double units[3], const char *name,
                         uint32_t light)
{
    static const char *const methods[] = {"ray-mip0", "ray-coverage"};
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        gn_visibility_desc desc = gn_visibility_desc_default();
        desc.method = gn_method_find(methods[m]);
        frame one = render_desc(scenes[0], 0, light, &desc, WIDTH, HEIGHT);
        picture(&one, name);
        for (int k = 1; k < 3; k++) {
            frame other = render_desc(scenes[k], 0, light, &desc, WIDTH, HEIGHT);
            compare(&one, &other, name, units[k], methods[m]);
            end(&other);
        }
        end(&one);
    }
}

static void test_procedural(void **state)
{
    (void)state;
    static const double units[3] = {1, 1e-3, 1e3};
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        gn_scene *scenes[3];
        for (int k = 0; k < 3; k++) {
            gn_procedural_desc desc = gn_procedural_desc_default();
            desc.scale = 0.1;
            desc.unit = units[k];
            ok(gn_scene_create_procedural(device, kind->name, &desc, &scenes[k]));
        }
        check_scenes(scenes, units, kind->name, 0);
        for (int k = 0; k < 3; k++)
            gn_scene_destroy(&scenes[k]);
    }
}

/* Boxes, a sphere, a card with holes, flat and as instances, under a sun and a lamp. */
static gn_scene *make_scene(double unit, bool moving)
{
    gn_scene *scene = new_scene();
    uint8_t rgba[64 * 64 * 4];
    for (int i = 0; i < 64 * 64; i++) {
        memset(rgba + 4 * i, 128, 4);
        rgba[4 * i + 3] = (uint8_t)((i % 64 / 8 + i / 512) % 2 ? 255 : i % 64 * 2);
    }
    gn_texture_desc texture = gn_texture_desc_default();
    texture.width = texture.height = 64;
    texture.rgba = rgba;
    gn_material_desc material = gn_material_desc_default();
    material.alpha_mode = GN_ALPHA_MASK;
    material.double_sided = true;
    uint32_t masked;
    ok(gn_scene_add_texture(scene, &texture, &material.texture));
    ok(gn_scene_add_material(scene, &material, &masked));
    place(scene, add_floor(scene, 12 * unit, 0, GN_NONE), moving);
    place(scene, add_box(scene, v3(-2 * unit, 0, -unit), v3(-unit, 1.5 * unit, unit), GN_NONE),
          moving);
    place(scene, add_sphere(scene, v3(unit, unit, 0), 0.8 * unit, 40, GN_NONE), moving);
    gn_node_desc node = gn_node_desc_default();
    node.mesh = add_floor(scene, 0.9 * unit, 0, masked);
    node.rotation[0] = 0.3f;
    node.rotation[2] = 0.2f;
    node.translation[1] = (float)(2.2 * unit);
    place_desc(scene, &node, moving);
    /* Lengths in the node instead of the mesh. */
    node.mesh = add_box(scene, v3(-0.5, -0.5, -0.5), v3(0.5, 0.5, 0.5), GN_NONE);
    node.translation[2] = (float)(1.7 * unit);
    node.translation[1] = (float)(0.6 * unit);
    for (int i = 0; i < 3; i++)
        node.scale[i] = (float)(0.5 * unit);
    place_desc(scene, &node, moving);
    add_camera(scene, v3(4 * unit, 4.5 * unit, 7 * unit), v3(0, 0.5 * unit, 0), 0.7, 0.1 * unit);
    add_sun(scene, v3(-0.4, 1, 0.5));
    add_lamp(scene, v3(-unit, 5 * unit, 2 * unit));
    ok(gn_scene_commit(scene));
    return scene;
}

static void test_own_scene(void **state)
{
    (void)state;
    static const double units[3] = {1, 1e-3, 1e3};
    for (int moving = 0; moving < 2; moving++) {
        gn_scene *scenes[3];
        for (int k = 0; k < 3; k++)
            scenes[k] = make_scene(units[k], moving);
        check_scenes(scenes, units, moving ? "instances, sun" : "flat, sun", 0);
        check_scenes(scenes, units, moving ? "instances, lamp" : "flat, lamp", 1);
        for (int k = 0; k < 3; k++)
            gn_scene_destroy(&scenes[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_procedural),
        cmocka_unit_test(test_own_scene),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
