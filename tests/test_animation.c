/* Animation: hand-computed values, brute force in doubles, and what must hold at any time. */
#include "scene_testing.h"

#define PI 3.14159265358979323846

/* A scene of one node with one channel. */
static gn_scene *make_animated(gn_animation_path path, gn_interpolation interpolation,
                               uint32_t key_count, const float *times, const float *values)
{
    gn_scene *scene = make_scene();
    gn_node_desc node = gn_node_desc_default();
    add_node(scene, &node);
    gn_channel_desc channel = gn_channel_desc_default();
    channel.node = 0;
    channel.path = path;
    channel.interpolation = interpolation;
    channel.key_count = key_count;
    channel.times = times;
    channel.values = values;
    assert_int_equal(gn_scene_add_channel(scene, &channel), GN_OK);
    return scene;
}

static const gn_node *at(gn_scene *scene, double seconds)
{
    assert_int_equal(gn_scene_set_time(scene, seconds), GN_OK);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    return &scene->nodes[0];
}

static void steps_hold_until_the_next_key(void **state)
{
    (void)state;
    static const float times[] = {1, 2, 4}, values[] = {1, 0, 0, 2, 0, 0, 3, 0, 0};
    gn_scene *scene = make_animated(GN_PATH_TRANSLATION, GN_INTERPOLATION_STEP, 3, times, values);
    static const double expected[][2] = {{-5, 1}, {0, 1},   {1, 1}, {1.999, 1},
                                         {2, 2},  {3.9, 2}, {4, 3}, {9, 3}};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        assert_vector(at(scene, expected[i][0])->world + 12, expected[i][1], 0, 0, "the step");
    gn_scene_destroy(&scene);
}

static void lines_are_straight_and_clamped(void **state)
{
    (void)state;
    static const float times[] = {1, 2, 4}, values[] = {0, 0, 8, 2, 4, 6, 4, 0, -2};
    gn_scene *scene = make_animated(GN_PATH_TRANSLATION, GN_INTERPOLATION_LINEAR, 3, times, values);
    assert_vector(scene->nodes[0].local + 12, 0, 0, 8, "before any set_time");
    assert_vector(at(scene, 0)->world + 12, 0, 0, 8, "before the first key");
    assert_vector(at(scene, 1.25)->world + 12, 0.5, 1, 7.5, "a quarter of the way");
    assert_vector(at(scene, 2)->world + 12, 2, 4, 6, "on a key");
    assert_vector(at(scene, 3.5)->world + 12, 3.5, 1, 0, "three quarters of the way");
    assert_vector(at(scene, 100)->world + 12, 4, 0, -2, "after the last key");
    assert_vector(at(scene, 1.25)->world + 12, 0.5, 1, 7.5, "back again");
    gn_scene_destroy(&scene);
}

static void scales_scale(void **state)
{
    (void)state;
    static const float times[] = {0, 1}, values[] = {1, 1, 1, 3, 5, 7};
    gn_scene *scene = make_animated(GN_PATH_SCALE, GN_INTERPOLATION_LINEAR, 2, times, values);
    const float *world = at(scene, 0.5)->world;
    assert_vector(world, 2, 0, 0, "x axis");
    assert_vector(world + 4, 0, 3, 0, "y axis");
    assert_vector(world + 8, 0, 0, 4, "z axis");
    gn_scene_destroy(&scene);
}

/* From no turn to `angle` about Y: the angle grows evenly, and the shorter way is taken even where
 * the quaternion has the other sign. */
static void check_turn(double angle, double sign)
{
    const float times[] = {0, 1};
    const float values[] = {
        0, 0, 0, 1, 0, (float)(sign * sin(angle / 2)), 0, (float)(sign * cos(angle / 2))};
    gn_scene *scene = make_animated(GN_PATH_ROTATION, GN_INTERPOLATION_LINEAR, 2, times, values);
    for (int i = 0; i <= 16; i++) {
        const double turn = angle * i / 16;
        const float *world = at(scene, i / 16.0)->world;
        assert_vector(world, cos(turn), 0, -sin(turn), "x axis");
        assert_vector(world + 4, 0, 1, 0, "y axis");
        assert_vector(world + 8, sin(turn), 0, cos(turn), "z axis");
    }
    gn_scene_destroy(&scene);
}

static void rotations_turn_evenly_the_shorter_way(void **state)
{
    (void)state;
    static const double angles[] = {PI / 2, -2.5, 1e-3, 1e-7, 0, 3.1};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        check_turn(angles[i], 1);
        check_turn(angles[i], -1);
    }
}

/* The specification's formula, in its own terms. */
static double hermite(double t, double span, double from, double out, double to, double in)
{
    return (2 * pow(t, 3) - 3 * pow(t, 2) + 1) * from +
           span * (pow(t, 3) - 2 * pow(t, 2) + t) * out + (-2 * pow(t, 3) + 3 * pow(t, 2)) * to +
           span * (pow(t, 3) - pow(t, 2)) * in;
}

static void splines_are_the_specifications(void **state)
{
    (void)state;
    static const float times[] = {0.5f, 2.5f, 3};
    static const float values[3][3][3] = {{{9, 9, 9}, {0, 1, 2}, {1, -1, 4}},
                                          {{2, 0, 1}, {5, 5, 5}, {-3, 2, 0}},
                                          {{1, 1, 1}, {0, 0, 0}, {7, 7, 7}}};
    gn_scene *scene = make_animated(GN_PATH_TRANSLATION, GN_INTERPOLATION_CUBICSPLINE, 3, times,
                                    &values[0][0][0]);
    for (int i = 0; i <= 60; i++) {
        const double seconds = i * 0.06;
        double expected[3];
        for (int c = 0; c < 3; c++) {
            const int key = seconds < 2.5 ? 0 : 1;
            const double span = key == 0 ? 2 : 0.5;
            const double t = fmin(fmax((seconds - (double)times[key]) / span, 0), 1);
            expected[c] = hermite(t, span, (double)values[key][1][c], (double)values[key][2][c],
                                  (double)values[key + 1][1][c], (double)values[key + 1][0][c]);
        }
        assert_vector(at(scene, seconds)->world + 12, expected[0], expected[1], expected[2],
                      "the spline");
    }
    gn_scene_destroy(&scene);
}

/* A spline whose tangents are the slope of a parabola is that parabola. */
static void splines_reproduce_parabolas(void **state)
{
    (void)state;
    static const float times[] = {0, 1, 3};
    float values[3][3][3] = {0};
    for (int key = 0; key < 3; key++) {
        values[key][0][0] = values[key][2][0] = 2 * times[key];
        values[key][1][0] = times[key] * times[key];
    }
    gn_scene *scene = make_animated(GN_PATH_TRANSLATION, GN_INTERPOLATION_CUBICSPLINE, 3, times,
                                    &values[0][0][0]);
    for (double t = 0; t <= 3; t += 0.125)
        assert_vector(at(scene, t)->world + 12, t * t, 0, 0, "the parabola");
    gn_scene_destroy(&scene);
}

static void spline_rotations_stay_rotations(void **state)
{
    (void)state;
    static const float times[] = {0, 1};
    static const float values[2][3][4] = {{{0}, {0, 0, 0, 1}, {1, 2, 0, -1}},
                                          {{0, 1, 3, 0}, {0.6f, 0, 0.8f, 0}, {0}}};
    gn_scene *scene =
        make_animated(GN_PATH_ROTATION, GN_INTERPOLATION_CUBICSPLINE, 2, times, &values[0][0][0]);
    for (double t = 0; t <= 1; t += 1.0 / 32) {
        const float *q = at(scene, t)->rotation;
        double expected[4], length = 0;
        for (int c = 0; c < 4; c++) {
            expected[c] = hermite(t, 1, (double)values[0][1][c], (double)values[0][2][c],
                                  (double)values[1][1][c], (double)values[1][0][c]);
            length += expected[c] * expected[c];
        }
        for (int c = 0; c < 4; c++)
            assert_near((double)q[c], expected[c] / sqrt(length), 1e-6, "the quaternion");
        const float *world = scene->nodes[0].world;
        for (int axis = 0; axis < 3; axis++) {
            const double x = (double)world[4 * axis], y = (double)world[4 * axis + 1],
                         z = (double)world[4 * axis + 2];
            assert_near(x * x + y * y + z * z, 1, 1e-5, "an axis");
        }
    }
    gn_scene_destroy(&scene);
}

/* Three paths at once; what is not animated keeps the node's own value. */
static void paths_work_together(void **state)
{
    (void)state;
    gn_scene *scene = make_scene();
    gn_node_desc node = gn_node_desc_default();
    memcpy(node.scale, (float[3]){2, 2, 2}, sizeof node.scale);
    add_node(scene, &node);
    node.parent = 0;
    add_node(scene, &node);
    static const float times[] = {0, 2}, moves[] = {0, 0, 0, 4, 0, 0};
    static const float turns[] = {0, 0, 0, 1, 0, 0, 1, 0}; /* half a turn about Z */
    gn_channel_desc channel = gn_channel_desc_default();
    channel.node = 0;
    channel.key_count = 2;
    channel.times = times;
    channel.values = moves;
    assert_int_equal(gn_scene_add_channel(scene, &channel), GN_OK);
    channel.path = GN_PATH_ROTATION;
    channel.values = turns;
    assert_int_equal(gn_scene_add_channel(scene, &channel), GN_OK);
    const float *world = at(scene, 1)->world;
    assert_vector(world, 0, 2, 0, "x axis");
    assert_vector(world + 4, -2, 0, 0, "y axis");
    assert_vector(world + 12, 2, 0, 0, "origin");
    assert_vector(scene->nodes[1].world, 0, 4, 0, "the child's x axis");
    assert_true(scene->nodes[1].animated);

    const uint64_t version = scene->transform_version;
    at(scene, 1);
    assert_int_equal(scene->transform_version, version);
    at(scene, 1.5);
    assert_true(scene->transform_version > version);
    gn_scene_destroy(&scene);
}

/* Many keys: the value at any time is on the line between its neighbours, found one by one. */
static void any_key_is_found(void **state)
{
    (void)state;
    float times[97], values[97 * 3] = {0};
    for (int i = 0; i < 97; i++) {
        times[i] = (float)(i * i) * 0.01f;
        values[3 * i] = (float)(i * 7919 % 101);
    }
    gn_scene *scene =
        make_animated(GN_PATH_TRANSLATION, GN_INTERPOLATION_LINEAR, 97, times, values);
    for (double t = 0; t < 92; t += 0.0731) {
        int key = 0;
        while (key < 95 && (double)times[key + 1] <= t)
            key++;
        const double span = (double)times[key + 1] - (double)times[key];
        const double share = fmin((t - (double)times[key]) / span, 1);
        const double from = (double)values[3 * key], to = (double)values[3 * key + 3];
        assert_near((double)at(scene, t)->world[12], from + share * (to - from), 1e-4, "the value");
    }
    gn_scene_destroy(&scene);
    assert_int_equal(context.bytes, 0);
}

/* An engine's matrix holds until the clock is set again. */
static void a_set_matrix_holds_until_the_clock_is_set(void **state)
{
    (void)state;
    static const float times[] = {0, 1}, values[] = {0, 0, 0, 1, 0, 0};
    gn_scene *scene = make_animated(GN_PATH_TRANSLATION, GN_INTERPOLATION_LINEAR, 2, times, values);
    const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 9, 0, 1};
    assert_int_equal(gn_scene_set_node_matrix(scene, 0, matrix), GN_OK);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_vector(scene->nodes[0].world + 12, 0, 9, 0, "the engine's place");
    assert_vector(at(scene, 0.5)->world + 12, 0.5, 0, 0, "the animation's place");
    gn_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_hold_until_the_next_key),
        cmocka_unit_test(lines_are_straight_and_clamped),
        cmocka_unit_test(scales_scale),
        cmocka_unit_test(rotations_turn_evenly_the_shorter_way),
        cmocka_unit_test(splines_are_the_specifications),
        cmocka_unit_test(splines_reproduce_parabolas),
        cmocka_unit_test(spline_rotations_stay_rotations),
        cmocka_unit_test(paths_work_together),
        cmocka_unit_test(any_key_is_found),
        cmocka_unit_test(a_set_matrix_holds_until_the_clock_is_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
