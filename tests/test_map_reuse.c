/* Shadow maps from frame to frame: what is kept is what a new map would hold. */
#include "shadow_map_testing.h"

/* Reuse --------------------------------------------------------------------------------------- */

static uint64_t hash(const float *depth)
{
    uint64_t h = 14695981039346656037u;
    for (size_t i = 0; i < (size_t)RESOLUTION * RESOLUTION; i++) {
        uint32_t word;
        memcpy(&word, depth + i, sizeof word);
        h = (h ^ word) * 1099511628211u;
    }
    return h;
}

/* A walk of 8 seconds: levels that are kept are untouched, and few are placed anew. */
static void test_a_slow_camera_keeps_levels(void **state)
{
    (void)state;
    yard y = make_yard(false);
    const gn_map_desc desc = small_desc();
    gn_shadow_map *map = make_map(&nlmsm64, &desc);
    gn_map_layer_info before[GN_MAX_CASCADES];
    uint64_t hashes[GN_MAX_CASCADES] = {0};
    uint32_t fitted = 0, kept = 0, quiet = 0, count = 0, frames = 240;
    for (uint32_t n = 0; n < frames; n++) {
        const double t = n / 30.0; /* 1.4 m/s, turning at up to 29 degrees a second */
        const vec eye = v3(1.4 * t - 5, 1.7, 12 - 0.3 * t);
        look(&y, eye, add(eye, v3(sin(0.5 * sin(t)), -0.1, -cos(0.5 * sin(t)))));
        ok(gn_scene_commit(y.scene));
        const gn_map_update u = update(map, &y, y.sun);
        uint32_t changed = 0;
        for (uint32_t i = 0; i < gn_shadow_map_layer_count(map); i++) {
            const gn_map_layer_info info = gn_shadow_map_layer(map, i);
            const uint64_t h = hash(info.depth);
            /* Its texels lie where they lay, to the bit. */
            const bool same = i < count &&
                              memcmp(before[i].origin, info.origin, sizeof info.origin) == 0 &&
                              memcmp(before[i].right, info.right, sizeof info.right) == 0 &&
                              memcmp(before[i].up, info.up, sizeof info.up) == 0 &&
                              before[i].extent == info.extent && before[i].near == info.near &&
                              before[i].far == info.far && hashes[i] == h;
            changed += same ? 0 : 1;
            before[i] = info;
            hashes[i] = h;
        }
        count = gn_shadow_map_layer_count(map);
        if (changed > u.fitted)
            fail_msg("frame %u: %u layers changed, %u were placed anew", n, changed, u.fitted);
        assert_int_equal(u.filtered, u.fitted);
        fitted += u.fitted;
        kept += count - u.fitted;
        quiet += u.fitted == 0;
    }
    print_message("%u frames: %u levels placed, %u kept; nothing to do in %u frames\n", frames,
                  fitted, kept, quiet);
    assert_true(fitted * 20 < kept && quiet * 10 > frames * 7);
    assert_as_if_new(map, &y, "after the walk");
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

/* Balls fly about, out of some layers and back, the camera walks and turns: at any time the map is
 * as if made anew. */
static void check_moving(const gn_map_format *format, const gn_map_desc *desc, uint32_t which,
                         uint32_t frames)
{
    yard y = make_yard(true);
    const uint32_t light = which == 0 ? y.sun : which == 1 ? y.lamp : y.spot;
    gn_shadow_map *map = make_map(format, desc);
    uint32_t fitted = 0, filtered = 0, layers = 0, away = 0;
    for (uint32_t n = 0; n < frames; n++) {
        const double t = n / 5.0;
        look(&y, v3(sin(0.1 * t), 1.7, 10 - 0.2 * t), v3(4 * sin(0.4 * t), 1, 0));
        move_ball(&y, 0, v3(6 * sin(1.1 * t), 1 + sin(t), 4 * cos(0.9 * t)));
        /* The second one jumps far off and back. */
        move_ball(&y, 1, n % 6 < 3 ? v3(2 * cos(t), 2, 5) : v3(-25, 1, -25 + 0.1 * t));
        ok(gn_scene_commit(y.scene));
        const gn_map_update u = update(map, &y, light);
        fitted += u.fitted;
        filtered += u.filtered;
        layers += gn_shadow_map_layer_count(map);
        for (uint32_t i = 0; i < gn_shadow_map_layer_count(map); i++)
            away += gn_shadow_map_layer(map, i).dynamic_depth == NULL;
        char what[40];
        snprintf(what, sizeof what, "light %u, frame %u", which, n);
        assert_as_if_new(map, &y, what);
    }
    print_message("%u layers: %u placed, %u filtered, %u out of reach of moving casters\n", layers,
                  fitted, filtered, away);
    assert_true(fitted < layers / 2);
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

static void test_moving_casters_leave_nothing_behind(void **state)
{
    (void)state;
    gn_map_desc desc = small_desc();
    desc.resolution = 128;
    desc.filter_width = 5;
    check_moving(&nlmsm64, &desc, 0, 40);
    check_moving(&depth32, &desc, 1, 12);
    check_moving(&vsm64, &desc, 1, 12);
    desc.filter_width = 9;
    check_moving(&msm64, &desc, 2, 20);
    desc.samples = 4;
    desc.mip_maps = true;
    check_moving(&vsm64, &desc, 0, 12);
}

static void test_what_did_not_change_costs_nothing(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = small_desc();
    gn_shadow_map *map = make_map(&nlmsm64, &desc);
    gn_map_update u = update(map, &y, y.sun);
    assert_int_equal(u.fitted, gn_shadow_map_layer_count(map));
    assert_int_equal(u.filtered, u.fitted);
    u = update(map, &y, y.sun);
    assert_int_equal(u.fitted, 0);
    assert_int_equal(u.filtered, 0);
    move_ball(&y, 0, v3(-1, 1, 3));
    ok(gn_scene_commit(y.scene));
    u = update(map, &y, y.sun);
    assert_int_equal(u.fitted, 0);
    assert_true(u.filtered > 0);
    assert_as_if_new(map, &y, "a ball moved");
    assert_int_equal(update(map, &y, y.sun).filtered, 0);
    gn_shadow_map_reset(map);
    assert_int_equal(gn_shadow_map_layer_count(map), 0);
    u = update(map, &y, y.sun);
    assert_int_equal(u.fitted, gn_shadow_map_layer_count(map));
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

static void assert_anew(gn_shadow_map *map, const yard *y, uint32_t light, const char *what)
{
    const gn_map_update u = update(map, y, light);
    if (u.fitted == 0 || u.fitted != gn_shadow_map_layer_count(map))
        fail_msg("%s: %u of %u layers were placed anew", what, u.fitted,
                 gn_shadow_map_layer_count(map));
    assert_as_if_new(map, y, what);
    assert_int_equal(update(map, y, light).fitted, 0);
}

static void test_changes_that_need_a_new_map(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = small_desc();
    gn_shadow_map *map = make_map(&nlmsm64, &desc);
    assert_anew(map, &y, y.sun, "first");
    /* Another scene, at the same address as likely as not, and of the same size. */
    gn_scene_destroy(&y.scene);
    y = make_yard(true);
    assert_anew(map, &y, y.sun, "another scene");
    float m[16];
    aim(v3(0.41, 1, 0.3), v3(0, 0, 0), m);
    ok(gn_scene_set_node_matrix(y.scene, y.sun_node, m));
    ok(gn_scene_commit(y.scene));
    assert_anew(map, &y, y.sun, "the sun moved");
    aim(v3(100.41, 101, 100.3), v3(100, 100, 100), m);
    ok(gn_scene_set_node_matrix(y.scene, y.sun_node, m));
    ok(gn_scene_commit(y.scene));
    assert_anew(map, &y, y.lamp, "another light");
    assert_anew(map, &y, y.spot, "a third light");
    assert_anew(map, &y, y.sun, "back to the sun");
    gn_node_desc node = gn_node_desc_default();
    node.mesh = 1;
    node.translation[0] = 5;
    ok(gn_scene_add_node(y.scene, &node, NULL));
    ok(gn_scene_commit(y.scene));
    assert_anew(map, &y, y.sun, "a new pillar");
    /* A pillar that stood begins to move: it leaves the static depth. */
    const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 6, 1};
    ok(gn_scene_set_node_matrix(y.scene, y.pillar, matrix));
    ok(gn_scene_commit(y.scene));
    assert_anew(map, &y, y.sun, "a pillar that begins to move");
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

/* Looking away and back keeps what was there; turning about places what is needed. */
static void test_looking_away(void **state)
{
    (void)state;
    yard y = make_yard(true);
    gn_map_desc desc = small_desc();
    desc.distance = 40;
    gn_shadow_map *map = make_map(&vsm64, &desc);
    const vec eye = v3(0, 1.7, 34);
    look(&y, eye, v3(0, 1, 0));
    ok(gn_scene_commit(y.scene));
    const gn_map_update first = update(map, &y, y.sun);
    const uint32_t count = gn_shadow_map_layer_count(map);
    assert_int_equal(first.fitted, count);
    look(&y, eye, v3(0, 1.7, 50));
    ok(gn_scene_commit(y.scene));
    assert_int_equal(update(map, &y, y.sun).fitted, 0);
    assert_int_equal(gn_shadow_map_layer_count(map), 0);
    move_ball(&y, 0, v3(-1, 1, 5)); /* unseen */
    ok(gn_scene_commit(y.scene));
    update(map, &y, y.sun);
    look(&y, eye, v3(0, 1, 0));
    ok(gn_scene_commit(y.scene));
    assert_int_equal(update(map, &y, y.sun).fitted, 0);
    assert_int_equal(gn_shadow_map_layer_count(map), count);
    assert_as_if_new(map, &y, "looked away and back");
    look(&y, v3(0, 1.7, 10), v3(0, 1, 20));
    ok(gn_scene_commit(y.scene));
    assert_true(update(map, &y, y.sun).fitted > 0);
    assert_as_if_new(map, &y, "turned about");
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

/* Reading ------------------------------------------------------------------------------------- */

/* Visibility of a light by a map of some format, and the layer of each pixel. */
static frame read_by(const yard *y, uint32_t light, const gn_map_format *format,
                     const gn_map_desc *desc, float *layer)
{
    const gn_method method = {.name = "test",
                              .description = "",
                              .paper = "",
                              .map = *format,
                              .trace = GN_TRACE_NONE,
                              .alpha = GN_ALPHA_RULE_MIP0};
    gn_visibility_desc visibility = gn_visibility_desc_default();
    visibility.method = &method;
    visibility.map = *desc;
    visibility.light = light;
    visibility.camera = y->camera;
    gn_visibility_stats stats = {.layer = layer};
    frame f = render(y->scene, y->camera, light, 192, 108);
    ok(gn_scene_visibility(y->scene, f.g, &visibility, (float *)f.visibility, &stats));
    return f;
}

/* Inside an empty room everything is lit: edges of faces would show as dark lines across its walls,
 * or as pixels that no face holds. Where two walls meet, filters darken what lies behind. */
static void test_a_lamp_has_no_seams(void **state)
{
    (void)state;
    static const gn_map_format pcf = {.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 5};
    const gn_map_format *formats[] = {&depth32, &pcf, &vsm64, &msm64, &nlmsm64};
    float *layer = malloc(192 * 108 * sizeof *layer);
    assert_non_null(layer);
    uint32_t used = 0;
    for (uint32_t n = 0; n < 6; n++) {
        yard y = {.scene = new_scene()};
        place(y.scene, add_box(y.scene, v3(-4, -3, -5), v3(4, 3, 5), GN_NONE), false);
        y.lamp = add_lamp(y.scene, v3(0.3, 0.2, -0.5));
        const double sign = n % 2 ? 1 : -1;
        const vec ahead = v3(n / 2 == 0 ? sign : 0, n / 2 == 1 ? sign : 0, n / 2 == 2 ? sign : 0);
        y.camera = add_camera(y.scene, v3(0, 0, 0), ahead, 1.8, 0.01);
        ok(gn_scene_commit(y.scene));
        gn_map_desc desc = small_desc();
        for (uint32_t i = 0; i < 5; i++) {
            frame f = read_by(&y, y.lamp, formats[i], &desc, layer);
            for (size_t k = 0; k < f.pixels; k++) {
                const vec p = position_at(f.g, k);
                const int walls = (fabs(p.x) > 3.5) + (fabs(p.y) > 2.5) + (fabs(p.z) > 4.5);
                if (walls != 1)
                    continue;
                if (layer[k] < 0 || !(f.visibility[k] > 0.98f))
                    fail_msg("map kind %d, camera %u, pixel %zu, layer %g: visibility %g",
                             (int)formats[i]->kind, n, k, (double)layer[k],
                             (double)f.visibility[k]);
                used |= 1u << (uint32_t)layer[k];
            }
            end(&f);
        }
        gn_scene_destroy(&y.scene);
    }
    assert_int_equal(used, 63);
    free(layer);
}

/* Any pixel that the sun can reach is held by a level, near ones by finer levels. */
static void test_cascades_hold_the_picture(void **state)
{
    (void)state;
    yard y = make_yard(true);
    float *layer = malloc(192 * 108 * sizeof *layer);
    assert_non_null(layer);
    static const vec eyes[] = {{3, 1.7, 9}, {0, 40, 1}, {29, 0.1, 29}, {90, 30, 70}};
    const gn_map_desc desc = small_desc();
    for (uint32_t n = 0; n < 4; n++) {
        look(&y, eyes[n], v3(0, 1, 0));
        ok(gn_scene_commit(y.scene));
        frame truth = render(y.scene, y.camera, y.sun, 192, 108);
        frame f = read_by(&y, y.sun, &depth32, &desc, layer);
        picture(&f, (const char *[]){"cascades-0", "cascades-1", "cascades-2", "cascades-3"}[n]);
        size_t lost = 0, wrong = 0, seen = 0;
        for (size_t k = 0; k < f.pixels; k++) {
            if (f.g->surface[k] == GN_NONE || !(dot(normal_at(f.g, k), v3(0.4, 1, 0.3)) > 1e-3))
                continue;
            seen++;
            lost += layer[k] < 0;
            wrong += fabsf(truth.visibility[k] - f.visibility[k]) > 0.5f;
        }
        print_message("view %u: %zu pixels in the sun, %zu held by no level, %zu wrong\n", n, seen,
                      lost, wrong);
        assert_int_equal(lost, 0);
        few(wrong, seen, 0.05, "view %u: wrong", n);
        end(&f);
        end(&truth);
    }
    free(layer);
    gn_scene_destroy(&y.scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_a_slow_camera_keeps_levels),
                                       cmocka_unit_test(test_moving_casters_leave_nothing_behind),
                                       cmocka_unit_test(test_what_did_not_change_costs_nothing),
                                       cmocka_unit_test(test_changes_that_need_a_new_map),
                                       cmocka_unit_test(test_looking_away),
                                       cmocka_unit_test(test_a_lamp_has_no_seams),
                                       cmocka_unit_test(test_cascades_hold_the_picture)};
    return cmocka_run_group_tests_name("map_reuse", tests, open_device, close_device);
}
