/* What moves: no stale state in shadows, motion vectors, flicker. */
#include "render_testing.h"

#include "measure/measure.h"

#define WIDTH  200
#define HEIGHT 150

/* Where everything is; a scene can be made there, or brought there. */
typedef struct places {
    vec object, sun, lamp, eye;
    double turn; /* of the object, about +Y */
} places;

static const places start = {{-0.5, 0.8, 0.3}, {0.5, 1, 0.3}, {2, 3, 1}, {3, 4, 6}, 0.3};
static const places goal = {{0.9, 1.3, -0.4}, {-0.8, 1, 0.6}, {-1, 4, 2}, {-2, 4.5, 5}, 1.1};

static void object_matrix(const places *p, float m[16])
{
    gn_compose((const float[3]){(float)p->object.x, (float)p->object.y, (float)p->object.z},
               (const float[4]){0, (float)sin(p->turn / 2), 0, (float)cos(p->turn / 2)},
               (const float[3]){1, 1, 1}, m);
}

typedef struct world {
    gn_scene *scene;
    uint32_t object, part, sun_node, lamp_node, camera_node; /* nodes; part: a child of object */
    uint32_t sun, lamp, camera;
} world;

/* committed: and where the camera looks at the middle. */
static world make_world(const places *p)
{
    world w = {.scene = new_scene()};
    place(w.scene, add_floor(w.scene, 6, 0, GN_NONE), false);
    gn_node_desc node = gn_node_desc_default();
    node.use_matrix = true;
    object_matrix(p, node.matrix);
    node.mesh = add_box(w.scene, v3(-0.5, -0.3, -0.5), v3(0.5, 0.3, 0.5), GN_NONE);
    w.object = place_desc(w.scene, &node, false);
    node = gn_node_desc_default();
    node.mesh = add_sphere(w.scene, v3(0, 0, 0), 0.3, 12, GN_NONE);
    node.parent = w.object;
    node.translation[0] = 0.9f;
    w.part = place_desc(w.scene, &node, false);
    w.sun = add_sun(w.scene, p->sun);
    w.sun_node = w.scene->node_count - 1;
    w.lamp = add_lamp(w.scene, p->lamp);
    w.lamp_node = w.scene->node_count - 1;
    w.camera = add_camera(w.scene, p->eye, v3(0, 0.5, 0), 0.7, 0.1);
    w.camera_node = w.scene->node_count - 1;
    ok(gn_scene_commit(w.scene));
    return w;
}

/* Both scenes look the same: position, surface and visibility of both lights. */
static void assert_same_frames(const gn_scene *a, const gn_scene *b, uint32_t camera,
                               const char *what)
{
    for (uint32_t light = 0; light < 2; light++) {
        frame fa = render(a, camera, light, WIDTH, HEIGHT);
        frame fb = render(b, camera, light, WIDTH, HEIGHT);
        picture(&fa, what);
        size_t surfaces = 0, lit = 0;
        for (size_t i = 0; i < fa.pixels; i++) {
            surfaces += fa.g->surface[i] != fb.g->surface[i];
            lit += fb.visibility[i] > 0.5f;
        }
        /* Flat and instanced trees round differently, so that a pixel may fall to either side. */
        few(surfaces, fa.pixels, 1e-4, "%s: surfaces", what);
        few(count_different(fa.visibility, fb.visibility, fa.pixels, 0.5f), fa.pixels, 1e-4,
            "%s: visibility of light %u", what, light);
        assert_true(lit > fa.pixels / 20 && lit < fa.pixels);
        end(&fa);
        end(&fb);
    }
}

static size_t changed_pixels(const gn_scene *a, const gn_scene *b, uint32_t camera, uint32_t light)
{
    frame fa = render(a, camera, light, WIDTH, HEIGHT);
    frame fb = render(b, camera, light, WIDTH, HEIGHT);
    const size_t changed = count_different(fa.visibility, fb.visibility, fa.pixels, 0.5f);
    end(&fa);
    end(&fb);
    return changed;
}

/* Nodes that stood still are moved one after the other. */
static void test_set_node_matrix(void **state)
{
    (void)state;
    places now = start;
    world w = make_world(&now);
    for (int step = 0; step < 5; step++) {
        const world before = make_world(&now);
        float m[16];
        uint32_t node = w.object, light = w.sun;
        switch (step) {
        case 0:
        case 4:
            now.object = step ? v3(0, 2, 0.5) : goal.object;
            now.turn = step ? -0.7 : goal.turn;
            object_matrix(&now, m);
            break;
        case 1:
            now.sun = goal.sun;
            node = w.sun_node;
            aim(now.sun, v3(0, 0, 0), m);
            break;
        case 2:
            now.lamp = goal.lamp;
            node = w.lamp_node;
            light = w.lamp;
            aim(now.lamp, add(now.lamp, v3(0, -1, 0)), m);
            break;
        default:
            now.eye = goal.eye;
            node = w.camera_node;
            aim(now.eye, v3(0, 0.5, 0), m);
            break;
        }
        ok(gn_scene_set_node_matrix(w.scene, node, m));
        /* Not before the commit. */
        gn_view *view;
        ok(gn_view_create(device, NULL, &view));
        assert_int_equal(gn_view_render(view, w.scene, w.camera, NULL, &w.sun, 1), GN_ERROR_STATE);
        assert_int_equal(gn_view_trace_gbuffer(view, w.scene, w.camera), GN_ERROR_STATE);
        assert_non_null(strstr(gn_device_message(device), "commit"));
        gn_view_destroy(&view);
        ok(gn_scene_commit(w.scene));

        world fresh = make_world(&now);
        char what[32];
        snprintf(what, sizeof what, "moved %d", step);
        assert_same_frames(w.scene, fresh.scene, w.camera, what);
        assert_true(changed_pixels(before.scene, w.scene, w.camera, light) > 100);
        gn_scene_destroy(&fresh.scene);
        gn_scene *gone = before.scene;
        gn_scene_destroy(&gone);
    }
    gn_scene_destroy(&w.scene);
}

/* Channels of object, light and camera, there and back again. */
static void test_set_time(void **state)
{
    (void)state;
    const float times[] = {1, 3};
    for (int kind = 0; kind < 3; kind++) {
        gn_scene *scenes[3]; /* moved from 1 s to 3 s; fresh at 3 s; fresh at 1 s */
        uint32_t camera = 0;
        for (int k = 0; k < 3; k++) {
            gn_scene *scene = scenes[k] = new_scene();
            place(scene, add_floor(scene, 6, 0, GN_NONE), false);
            gn_node_desc parent = gn_node_desc_default();
            uint32_t carrier;
            ok(gn_scene_add_node(scene, &parent, &carrier));
            gn_node_desc node = gn_node_desc_default();
            node.mesh = add_box(scene, v3(-0.5, 0.5, -0.5), v3(0.5, 1, 0.5), GN_NONE);
            node.parent = kind == 0 ? carrier : GN_NONE;
            place_desc(scene, &node, false);
            gn_light_desc light_desc = gn_light_desc_default();
            for (uint32_t i = 0; i < 2; i++) {
                light_desc.type = i ? GN_LIGHT_POINT : GN_LIGHT_DIRECTIONAL;
                light_desc.intensity = 5;
                uint32_t light;
                ok(gn_scene_add_light(scene, &light_desc, &light));
                node = gn_node_desc_default();
                node.use_matrix = true;
                node.parent = kind == 1 ? carrier : GN_NONE;
                aim(v3(1, 3, 1), v3(0.2, 0, 0), node.matrix);
                node.light = light;
                ok(gn_scene_add_node(scene, &node, NULL));
            }
            gn_camera_desc camera_desc = gn_camera_desc_default();
            ok(gn_scene_add_camera(scene, &camera_desc, &camera));
            node = gn_node_desc_default();
            node.use_matrix = true;
            node.parent = kind == 2 ? carrier : GN_NONE;
            node.camera = camera;
            aim(v3(2, 4, 5), v3(0, 0.5, 0), node.matrix);
            ok(gn_scene_add_node(scene, &node, NULL));

            gn_channel_desc channel = gn_channel_desc_default();
            channel.node = carrier;
            channel.path = GN_PATH_TRANSLATION;
            channel.key_count = 2;
            channel.times = times;
            channel.values = (const float[]){-0.8f, 0, 0.1f, 0.7f, 0.3f, -0.2f};
            ok(gn_scene_add_channel(scene, &channel));
            ok(gn_scene_set_time(scene, k == 1 ? 3 : 1));
            ok(gn_scene_commit(scene));
        }
        assert_true(changed_pixels(scenes[0], scenes[1], camera, 1) > 100);
        ok(gn_scene_set_time(scenes[0], 3));
        ok(gn_scene_commit(scenes[0]));
        assert_same_frames(scenes[0], scenes[1], camera, "channel, there");
        ok(gn_scene_set_time(scenes[0], 0)); /* before the first key */
        ok(gn_scene_commit(scenes[0]));
        assert_same_frames(scenes[0], scenes[2], camera, "channel, back");
        for (int k = 0; k < 3; k++)
            gn_scene_destroy(&scenes[k]);
    }
}

/* Nodes, meshes and materials that come after a commit. */
static void test_add_after_commit(void **state)
{
    (void)state;
    world a = make_world(&start), b = make_world(&start);
    gn_node_desc node = gn_node_desc_default();
    node.translation[0] = 1.2f;
    node.translation[1] = 1;
    for (int k = 0; k < 2; k++) {
        gn_scene *scene = k ? b.scene : a.scene;
        if (k == 0)
            ok(gn_scene_commit(scene)); /* nothing to do */
        const uint32_t sided = add_single_sided(scene);
        if (k == 0)
            ok(gn_scene_commit(scene));
        node.mesh = add_box(scene, v3(-0.3, -0.3, -0.3), v3(0.3, 0.3, 0.3), sided);
        if (k == 0)
            ok(gn_scene_commit(scene));
        place_desc(scene, &node, k);
        ok(gn_scene_commit(scene));
    }
    assert_same_frames(a.scene, b.scene, a.camera, "added");
    world without = make_world(&start);
    assert_true(changed_pixels(a.scene, without.scene, a.camera, a.sun) > 100);
    gn_scene_destroy(&a.scene);
    gn_scene_destroy(&b.scene);
    gn_scene_destroy(&without.scene);
}

/* An object that is scaled to nothing and back. */
static void test_vanish(void **state)
{
    (void)state;
    world w = make_world(&start), fresh = make_world(&start);
    float m[16] = {[15] = 1};
    ok(gn_scene_set_node_matrix(w.scene, w.object, m));
    ok(gn_scene_commit(w.scene));
    frame f = render(w.scene, w.camera, w.sun, WIDTH, HEIGHT);
    for (size_t i = 0; i < f.pixels; i++)
        if (f.visibility[i] != (f.g->surface[i] == GN_NONE ? 0 : 1))
            fail_msg("pixel %zu: surface %u, visibility %g", i, f.g->surface[i],
                     (double)f.visibility[i]);
    end(&f);
    object_matrix(&start, m);
    ok(gn_scene_set_node_matrix(w.scene, w.object, m));
    ok(gn_scene_commit(w.scene));
    assert_same_frames(w.scene, fresh.scene, w.camera, "back again");
    gn_scene_destroy(&w.scene);
    gn_scene_destroy(&fresh.scene);
}

/* Motion ------------------------------------------------------------------------------------- */

/* Pixel coordinates and depth of a point, by the camera's own frame. */
static vec project(const gn_camera *camera, vec p)
{
    const float *m = camera->world;
    const vec to = sub(p, v3((double)m[12], (double)m[13], (double)m[14]));
    const double x = dot(to, v3((double)m[0], (double)m[1], (double)m[2]));
    const double y = dot(to, v3((double)m[4], (double)m[5], (double)m[6]));
    const double depth = -dot(to, v3((double)m[8], (double)m[9], (double)m[10]));
    const double half = camera->desc.orthographic ? (double)camera->desc.ymag
                                                  : tan((double)camera->desc.yfov / 2) * depth;
    return v3((x / half / WIDTH * HEIGHT + 1) * WIDTH / 2, (1 - y / half) * HEIGHT / 2, depth);
}

/* m^-1 p for a matrix without scale. */
static vec untransform(const float m[16], vec p)
{
    const vec to = sub(p, v3((double)m[12], (double)m[13], (double)m[14]));
    return v3(dot(to, v3((double)m[0], (double)m[1], (double)m[2])),
              dot(to, v3((double)m[4], (double)m[5], (double)m[6])),
              dot(to, v3((double)m[8], (double)m[9], (double)m[10])));
}

static void check_zero_motion(const gn_gbuffer *g, const char *what)
{
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++)
        for (int axis = 0; axis < 3; axis++)
            if (g->motion[axis][i] != 0.0f)
                fail_msg("%s: motion[%d] of pixel %zu is %g", what, axis, i,
                         (double)g->motion[axis][i]);
}

static void test_motion(void **state)
{
    (void)state;
    world w = make_world(&start);
    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = WIDTH;
    view_desc.height = HEIGHT;
    gn_view *view;
    ok(gn_view_create(device, &view_desc, &view));
    const gn_gbuffer *g = gn_view_gbuffer(view);
    ok(gn_view_render(view, w.scene, w.camera, NULL, &w.sun, 1));
    check_zero_motion(g, "first frame");
    ok(gn_view_render(view, w.scene, w.camera, NULL, &w.sun, 1));
    check_zero_motion(g, "nothing moved");

    places now = start;
    for (int step = 0; step < 3; step++) { /* the object, the camera, both */
        const gn_camera camera_before = w.scene->cameras[w.camera];
        float before[2][16], m[16];
        memcpy(before[0], w.scene->nodes[w.object].world, sizeof m);
        memcpy(before[1], w.scene->nodes[w.part].world, sizeof m);
        if (step != 1) {
            now.object = add(now.object, v3(0.13, 0.05, -0.08));
            now.turn += 0.2;
            object_matrix(&now, m);
            ok(gn_scene_set_node_matrix(w.scene, w.object, m));
        }
        if (step != 0) {
            now.eye = add(now.eye, v3(-0.11, 0.07, 0.09));
            aim(now.eye, v3(0, 0.5, 0), m);
            ok(gn_scene_set_node_matrix(w.scene, w.camera_node, m));
        }
        ok(gn_scene_commit(w.scene));
        ok(gn_view_trace_gbuffer(view, w.scene, w.camera));
        size_t moved = 0;
        for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
            if (g->surface[i] == GN_NONE)
                continue;
            const vec p = position_at(g, i);
            vec then = p;
            if (g->surface[i] > 0) {
                const uint32_t node = g->surface[i] == 1 ? w.object : w.part;
                then = transform(before[g->surface[i] - 1],
                                 untransform(w.scene->nodes[node].world, p));
            }
            const vec here = project(&w.scene->cameras[w.camera], p);
            const vec expected = sub(project(&camera_before, then), here);
            const double off[3] = {(double)g->motion[0][i] - expected.x,
                                   (double)g->motion[1][i] - expected.y,
                                   (double)g->motion[2][i] - expected.z};
            if (fabs(off[0]) > 2e-3 || fabs(off[1]) > 2e-3 || fabs(off[2]) > 1e-5)
                fail_msg("step %d, pixel %zu of surface %u: motion (%g %g %g), expected (%g %g %g)",
                         step, i, g->surface[i], (double)g->motion[0][i], (double)g->motion[1][i],
                         (double)g->motion[2][i], expected.x, expected.y, expected.z);
            if (fabs(here.x - (double)(i % WIDTH) - 0.5) > 2e-3 ||
                fabs(here.y - (double)(i / WIDTH) - 0.5) > 2e-3)
                fail_msg("pixel %zu projects to (%g %g)", i, here.x, here.y);
            moved += hypot(expected.x, expected.y) > 0.5;
        }
        assert_true(moved > 1000);
    }
    gn_view_reset_history(view);
    now.eye = goal.eye;
    float m[16];
    aim(now.eye, v3(0, 0.5, 0), m);
    ok(gn_scene_set_node_matrix(w.scene, w.camera_node, m));
    ok(gn_scene_commit(w.scene));
    ok(gn_view_trace_gbuffer(view, w.scene, w.camera));
    check_zero_motion(g, "after a reset");
    gn_view_destroy(&view);
    gn_scene_destroy(&w.scene);
}

/* Steady where nothing moves, and where a camera passes over a lit plane. */
static void test_flicker(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        gn_scene *scene = new_scene();
        place(scene, add_floor(scene, 50, 0, GN_NONE), false);
        if (kind == 0)
            place(scene, add_box(scene, v3(-1, 0, -1), v3(1, 1, 1), GN_NONE), false);
        const uint32_t sun = add_sun(scene, v3(0.5, 1, 0.3));
        const uint32_t camera = add_camera(scene, v3(3, 4, 6), v3(0, 0, 0), 0.7, 0.1);
        ok(gn_scene_commit(scene));
        gn_view_desc view_desc = gn_view_desc_default();
        view_desc.width = WIDTH;
        view_desc.height = HEIGHT;
        gn_view *view;
        ok(gn_view_create(device, &view_desc, &view));
        gn_flicker_state flicker = {0};
        for (int n = 0; n < 4; n++) {
            if (kind == 1) {
                float m[16];
                const vec shift = v3(0.13 * n, 0.02 * n, 0.07 * n);
                aim(add(v3(3, 4, 6), shift), shift, m);
                ok(gn_scene_set_node_matrix(scene, scene->cameras[camera].node, m));
                ok(gn_scene_commit(scene));
            }
            ok(gn_view_render(view, scene, camera, NULL, &sun, 1));
            const gn_flicker change =
                gn_measure_flicker(&flicker, gn_view_gbuffer(view), gn_view_visibility(view, 0));
            assert_true(change.flicker == 0 && change.toggles == 0);
            if (n > 0 && (double)change.pixels < (kind ? 0.9 : 1) * WIDTH * HEIGHT)
                fail_msg("frame %d: only %zu pixels compared", n, (size_t)change.pixels);
        }
        gn_flicker_state_free(&flicker);
        gn_view_destroy(&view);
        gn_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_set_node_matrix),  cmocka_unit_test(test_set_time),
        cmocka_unit_test(test_add_after_commit), cmocka_unit_test(test_vanish),
        cmocka_unit_test(test_motion),           cmocka_unit_test(test_flicker),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
