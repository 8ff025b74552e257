/* Histories: masks of many lights in one texel, and when they and the depth can be trusted. */
#include "history_testing.h"

enum { WIDTH = 7, HEIGHT = 5, PIXELS = WIDTH * HEIGHT };

static gn_gbuffer blank(void)
{
    return (gn_gbuffer){.width = WIDTH, .height = HEIGHT};
}

/* Room ---------------------------------------------------------------------------------------- */

static void test_bytes(void **state)
{
    (void)state;
    static const struct {
        uint32_t lights, bytes;
    } rows[] = {{1, 1},  {2, 1},  {3, 2},   {5, 2},   {6, 4}, {10, 4},
                {11, 8}, {21, 8}, {22, 16}, {42, 16}, {43, 0}};
    const gn_gbuffer g = blank();
    gn_scene *scene = many_lights(43);
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        const uint32_t lights = rows[row].lights;
        gn_history *history = new_history(device);
        assert_int_equal(gn_history_mask_bytes(history), 0);
        uint64_t bits[2] = {0, 0};
        for (uint32_t n = 0; n < 2; n++)
            for (uint32_t i = 0; i < lights; i++) {
                gn_leak_mask mask;
                const gn_result result = begin_mask(history, scene, i, &g, false, &mask);
                if (i >= GN_MAX_MASKS) {
                    assert_int_equal(result, GN_ERROR_UNSUPPORTED);
                    if (!strstr(gn_device_message(device), "light 42") ||
                        !strstr(gn_device_message(device), "at most 42"))
                        fail_msg("the message is \"%s\"", gn_device_message(device));
                    assert_null(mask.now);
                    continue;
                }
                ok(result);
                if (n == 0 || lights > GN_MAX_MASKS)
                    continue;
                /* Three bits that no other light has, inside the texel. */
                assert_int_equal(mask.texel_bytes, rows[row].bytes);
                for (uint32_t bit = mask.first_bit; bit < mask.first_bit + 3; bit++) {
                    assert_true(bit < 8 * rows[row].bytes);
                    assert_int_equal(bits[bit / 64] >> bit % 64 & 1, 0);
                    bits[bit / 64] |= (uint64_t)1 << bit % 64;
                }
            }
        const size_t bytes = gn_history_mask_bytes(history), expected = rows[row].bytes;
        if (expected > 0 && bytes != 2 * PIXELS * expected)
            fail_msg("%u lights: %zu bytes, expected %zu", lights, bytes, 2 * PIXELS * expected);
        const gn_gbuffer deep = {.width = WIDTH, .height = HEIGHT, .depth = (float[PIXELS]){0}};
        if (expected > 0) {
            begin(history, scene, 0, &deep, true);
            assert_int_equal(gn_history_mask_bytes(history), bytes + PIXELS * sizeof(float));
        }
        gn_history_destroy(&history);
    }
    gn_scene_destroy(&scene);
}

/* A light whose mask nobody asks for gives its bits to another. */
static void test_slots_come_back(void **state)
{
    (void)state;
    const gn_gbuffer g = blank();
    gn_scene *scene = many_lights(90);
    gn_history *history = new_history(device);
    for (uint32_t i = 0; i < 90; i++) { /* two lights a frame: at most four have a mask to keep */
        const gn_leak_mask mask = begin(history, scene, i, &g, false);
        assert_true(mask.texel_bytes <= 2);
        if (i % 2 == 1)
            gn_history_begin_frame(history);
    }
    /* 42 lights a frame, never the same twice in a row. */
    for (uint32_t n = 0; n < 4; n++) {
        gn_history_begin_frame(history);
        for (uint32_t i = 0; i < 42; i++)
            assert_null(begin(history, scene, 42 * (n % 2) + i, &g, false).before);
    }
    gn_history_destroy(&history);
    gn_scene_destroy(&scene);
}

/* Bits ---------------------------------------------------------------------------------------- */

/* Random lights in random order write random states; each finds those that it wrote in the frame
 * before, wherever they were moved to, and nothing where it wrote none. */
static void check_independence(const gn_scene *scene, uint32_t lights, uint32_t frames)
{
    const gn_gbuffer g = blank();
    gn_history *history = new_history(device);
    uint8_t *states = calloc(lights, PIXELS); /* as written last */
    uint32_t *written = calloc(lights, sizeof *written), *order = calloc(lights, sizeof *order);
    assert_true(states && written && order);
    uint64_t random = lights;
    uint32_t found = 0, lost = 0, most = 1, asked;
    for (uint32_t n = 1; n <= frames; n++) {
        gn_history_begin_frame(history);
        for (uint32_t i = 0; i < lights; i++) {
            const uint32_t k = random_below(&random, i + 1);
            order[i] = order[k];
            order[k] = i;
        }
        most += random_below(&random, 4);
        if (most > lights)
            most = lights;
        asked = n % 3 == 0 ? 1 + random_below(&random, most) : most;
        for (uint32_t i = 0; i < asked; i++) {
            const uint32_t light = order[i];
            uint8_t *expected = states + (size_t)light * PIXELS;
            const gn_leak_mask mask = begin(history, scene, light, &g, false);
            if ((mask.before != NULL) != (n > 1 && written[light] == n - 1))
                fail_msg("frame %u, light %u, written in %u: there is %s", n, light, written[light],
                         mask.before ? "a mask" : "none");
            for (size_t p = 0; p < PIXELS; p++) {
                if (mask.before && get_state(mask.before, &mask, p) != expected[p])
                    fail_msg("frame %u, light %u, pixel %zu: %u, expected %u", n, light, p,
                             get_state(mask.before, &mask, p), expected[p]);
                expected[p] = (uint8_t)random_below(&random, 8);
                set_state(&mask, p, expected[p]);
            }
            written[light] = n;
            found += mask.before != NULL;
            lost += mask.before == NULL;
        }
    }
    print_message("%u lights: %u masks found, %u lost\n", lights, found, lost);
    assert_true(found > frames / 2 && lost > 0);
    free(states);
    free(written);
    free(order);
    gn_history_destroy(&history);
}

static void test_lights_are_independent(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 5, 6, 10, 11, 21, 22, 42};
    gn_scene *scene = many_lights(42);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        check_independence(scene, counts[i], 60);
    gn_scene_destroy(&scene);
}

/* Trust --------------------------------------------------------------------------------------- */

/* Two frames of one light: its mask is there at the end. */
static void settle(gn_history *history, const gn_scene *scene, const gn_gbuffer *g)
{
    begin(history, scene, 0, g, true);
    const gn_leak_mask mask = begin(history, scene, 0, g, true);
    assert_non_null(mask.before);
    assert_non_null(mask.depth_before);
}

static void assert_lost(gn_history *history, const gn_scene *scene, const gn_gbuffer *g,
                        const char *what)
{
    const gn_leak_mask mask = begin(history, scene, 0, g, true);
    if (mask.before || mask.depth_before)
        fail_msg("%s: there is %s of another picture", what, mask.before ? "a mask" : "depth");
    settle(history, scene, g);
}

static void test_another_picture(void **state)
{
    (void)state;
    float plane[2 * PIXELS] = {0};
    const gn_gbuffer g = {.width = WIDTH, .height = HEIGHT, .depth = plane},
                     wide = {.width = 2 * WIDTH, .height = HEIGHT, .depth = plane},
                     turned = {.width = HEIGHT, .height = WIDTH, .depth = plane};
    gn_scene *scene = many_lights(2), *other = many_lights(2);
    gn_history *history = new_history(device);
    assert_lost(history, scene, &g, "the first frame");
    assert_lost(history, scene, &wide, "a wider picture");
    assert_int_equal(gn_history_mask_bytes(history), 2 * 2 * PIXELS * (1 + sizeof(float)));
    assert_lost(history, scene, &g, "a smaller picture");
    assert_lost(history, scene, &turned, "a picture on its side");
    settle(history, scene, &g);

    gn_history_cut(history);
    assert_lost(history, scene, &g, "a cut");
    const gn_shadow_map *map = gn_history_map(history, 0);
    assert_non_null(map);
    gn_history_cut(history);
    assert_ptr_equal(gn_history_map(history, 0), map);
    settle(history, scene, &g);

    /* Another camera and back. */
    const gn_map_desc desc = tiny_map();
    gn_shadow_map *kept;
    for (uint32_t camera = 1; camera < 3; camera++) {
        gn_leak_mask mask;
        ok(gn_history_reserve_map(history, scene, 0, &vsm, &desc, &kept));
        ok(gn_history_begin_mask(history, 0, camera % 2, &g, true, &mask));
        assert_true(!mask.before && !mask.depth_before && kept == map);
    }
    settle(history, scene, &g);

    /* A frame that the light is not part of. */
    gn_history_begin_frame(history);
    gn_history_begin_frame(history);
    assert_lost(history, scene, &g, "a frame without the light");
    for (int i = 0; i < 3; i++)
        begin(history, scene, 1, &g, true);
    assert_null(begin(history, scene, 0, &g, true).before);
    settle(history, scene, &g);

    gn_history_reset(history);
    assert_int_equal(gn_history_mask_bytes(history), 0);
    assert_null(gn_history_map(history, 0));
    assert_lost(history, scene, &g, "a reset");

    assert_lost(history, other, &g, "another scene");
    place(other, 0, false);
    ok(gn_scene_commit(other));
    assert_lost(history, other, &g, "a scene with one more node");

    gn_history_destroy(&history);
    gn_scene_destroy(&scene);
    gn_scene_destroy(&other);
}

/* A mask is of one map: others make other mistakes. */
static void test_another_map(void **state)
{
    (void)state;
    const gn_gbuffer g = blank();
    gn_scene *scene = many_lights(2);
    gn_history *history = new_history(device);
    gn_map_desc desc = tiny_map();
    gn_map_format format = vsm;
    for (int step = 0; step < 6; step++) {
        const bool change = step % 2 == 0;
        if (step == 2)
            desc.resolution = 64;
        if (step == 4)
            format = (gn_map_format){.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 2};
        for (uint32_t light = 0; light < 2; light++) {
            gn_shadow_map *map;
            gn_leak_mask mask;
            const gn_map_desc own = light == 0 ? desc : tiny_map();
            ok(gn_history_reserve_map(history, scene, light, light == 0 ? &format : &vsm, &own,
                                      &map));
            ok(gn_history_begin_mask(history, light, 0, &g, false, &mask));
            const bool expected = light == 0 ? !change : step > 0;
            if ((mask.before != NULL) != expected)
                fail_msg("step %d, light %u: %s", step, light, mask.before ? "a mask" : "no mask");
        }
    }
    /* A frame in which the light's map was only read. */
    gn_shadow_map *map;
    ok(gn_history_reserve_map(history, scene, 0, &format, &desc, &map));
    ok(gn_history_reserve_map(history, scene, 0, &format, &desc, &map));
    gn_leak_mask mask;
    ok(gn_history_begin_mask(history, 0, 0, &g, false, &mask));
    assert_null(mask.before);
    /* No frame, no mask. */
    gn_history_begin_frame(history);
    assert_int_equal(gn_history_begin_mask(history, 0, 0, &g, false, &mask), GN_ERROR_STATE);
    assert_int_equal(gn_history_begin_mask(history, 7, 0, &g, false, &mask), GN_ERROR_STATE);
    gn_history_destroy(&history);
    gn_scene_destroy(&scene);
}

/* Depth is that of the frame before, or none, for every light of the frame. */
static void test_depth(void **state)
{
    (void)state;
    float plane[PIXELS];
    const gn_gbuffer g = {.width = WIDTH, .height = HEIGHT, .depth = plane};
    gn_scene *scene = many_lights(3);
    gn_history *history = new_history(device);
    static const bool keeps[] = {true, true, false, true, true, true, false, false, true, true};
    for (uint32_t n = 0; n < 10; n++) {
        for (size_t p = 0; p < PIXELS; p++)
            plane[p] = (float)(100 * n + p);
        const bool expected = n > 0 && keeps[n] && keeps[n - 1];
        for (uint32_t light = 0; light < 3; light++) {
            const gn_leak_mask mask = begin(history, scene, light, &g, keeps[n] && light > 0);
            if ((mask.depth_before != NULL) != (expected && light > 0))
                fail_msg("frame %u, light %u: %s depth", n, light,
                         mask.depth_before ? "there is" : "no");
            for (size_t p = 0; p < PIXELS && mask.depth_before; p++)
                if (mask.depth_before[p] != plane[p] - 100)
                    fail_msg("frame %u, light %u, pixel %zu: depth %g, expected %g", n, light, p,
                             (double)mask.depth_before[p], (double)plane[p] - 100);
        }
    }
    const gn_gbuffer flat = blank();
    gn_leak_mask mask;
    assert_int_equal(begin_mask(history, scene, 0, &flat, true, &mask), GN_ERROR_INVALID_ARGUMENT);
    gn_history_destroy(&history);
    gn_scene_destroy(&scene);
}

/* Views --------------------------------------------------------------------------------------- */

typedef struct sight {
    gn_view *view;
    gn_visibility_desc desc;
    gn_visibility_stats stats;
} sight;

static sight look(uint32_t samples)
{
    sight s = {.desc = gn_visibility_desc_default()};
    gn_view_desc desc = gn_view_desc_default();
    desc.width = 64;
    desc.height = 48;
    desc.samples = samples;
    ok(gn_view_create(device, &desc, &s.view));
    s.desc.method = gn_method_find("lt-vsm");
    s.desc.map.resolution = 128;
    s.desc.map.refresh = 1;
    s.desc.map.undrawn = 0;
    return s;
}

/* Share of the tested pixels that no mask knew. */
static double render_lost(sight *s, const gn_scene *scene, uint32_t camera)
{
    gn_view_set_stats(s->view, &s->stats);
    ok(gn_view_render(s->view, scene, camera, &s->desc, (const uint32_t[]){0}, 1));
    gn_view_set_stats(s->view, NULL);
    s->desc.frame++;
    assert_true(s->stats.leak.tested > 500);
    return (double)s->stats.leak.lost / (double)s->stats.leak.tested;
}

static void test_views(void **state)
{
    (void)state;
    gn_scene *scene = many_lights(1), *other = many_lights(1);
    for (int own = 0; own < 2; own++) {
        sight s = look(1);
        gn_history *history = own ? new_history(device) : NULL;
        s.desc.history = history;
        assert_true(render_lost(&s, scene, 0) == 1);
        assert_true(render_lost(&s, scene, 0) == 0);
        assert_true(render_lost(&s, scene, 0) == 0);
        assert_true(s.stats.map.fitted == 0);

        gn_view_reset_history(s.view);
        assert_true(render_lost(&s, scene, 0) == 1);
        assert_int_equal(s.stats.map.fitted, 0); /* maps are of the world */
        assert_true(render_lost(&s, scene, 0) == 0);

        assert_true(render_lost(&s, scene, 1) == 1);
        assert_true(render_lost(&s, scene, 1) == 0);

        assert_true(render_lost(&s, other, 1) == 1);
        assert_true(render_lost(&s, scene, 1) == 1);
        assert_true(render_lost(&s, scene, 1) == 0);
        place(scene, 0, false);
        ok(gn_scene_commit(scene));
        assert_true(render_lost(&s, scene, 1) == 1);
        assert_true(render_lost(&s, scene, 1) == 0);

        /* A frame by another method, and one that only traced a G-buffer. */
        s.desc.method = gn_method_find("ray");
        ok(gn_view_render(s.view, scene, 1, &s.desc, (const uint32_t[]){0}, 1));
        s.desc.method = gn_method_find("lt-vsm");
        assert_true(render_lost(&s, scene, 1) == 1);
        assert_true(render_lost(&s, scene, 1) == 0);
        if (!own) {
            ok(gn_view_trace_gbuffer(s.view, scene, 1));
            assert_true(render_lost(&s, scene, 1) == 1);
        }
        /* A frame that failed in its second light. */
        assert_int_not_equal(
            gn_view_render(s.view, scene, 1, &s.desc, (const uint32_t[]){0, 99}, 2), GN_OK);
        assert_true(render_lost(&s, scene, 1) == 1);
        gn_view_destroy(&s.view);
        gn_history_destroy(&history);
    }
    gn_scene_destroy(&scene);
    gn_scene_destroy(&other);
}

/* Several samples a pixel are several pictures, without a mask: what is seen is what rays see. */
static void test_samples(void **state)
{
    (void)state;
    gn_scene *scene = many_lights(1);
    sight s = look(4), rays = look(4);
    rays.desc.method = gn_method_find("ray");
    for (uint32_t n = 0; n < 3; n++) {
        assert_true(render_lost(&s, scene, 0) == 1);
        ok(gn_view_render(rays.view, scene, 0, &rays.desc, (const uint32_t[]){0}, 1));
        assert_int_equal(count_different(gn_view_visibility(s.view, 0),
                                         gn_view_visibility(rays.view, 0), 64 * 48, 1e-6f),
                         0);
    }
    gn_view_destroy(&s.view);
    gn_view_destroy(&rays.view);
    gn_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bytes),
                                       cmocka_unit_test(test_slots_come_back),
                                       cmocka_unit_test(test_lights_are_independent),
                                       cmocka_unit_test(test_another_picture),
                                       cmocka_unit_test(test_another_map),
                                       cmocka_unit_test(test_depth),
                                       cmocka_unit_test(test_views),
                                       cmocka_unit_test(test_samples)};
    return cmocka_run_group_tests_name("history", tests, open_device, close_device);
}
