/* Shadow maps saved without their texels: a restored one goes on as if nothing had happened. */
#include "shadow_map_testing.h"

static void check_restored(const gn_map_format *format, gn_map_desc desc, uint32_t which,
                           uint32_t at, uint32_t frames)
{
    yard y = make_yard(true), z = make_yard(true);
    const uint32_t light = which == 0 ? y.sun : which == 1 ? y.lamp : y.spot;
    gn_shadow_map *map = make_map(format, &desc), *again = make_map(format, &desc);
    for (uint32_t n = 0; n < at; n++) {
        show(&y, n);
        update(map, &y, light);
    }
    gn_map_state saved, twice;
    memset(&saved, 0xaa, sizeof saved);
    gn_shadow_map_save_state(map, &saved);
    show(&z, at - 1);
    ok(gn_shadow_map_restore_state(again, z.scene, light, &saved));
    gn_shadow_map_save_state(again, &twice);
    assert_memory_equal(&saved, &twice, sizeof saved);
    for (uint32_t n = at; n < at + frames; n++) {
        show(&y, n);
        show(&z, n);
        const gn_map_update a = update(map, &y, light), b = update(again, &z, light);
        char what[80];
        snprintf(what, sizeof what, "light %u, restored at %u, update %u", which, at, n);
        if (a.fitted != b.fitted || a.pending != b.pending)
            fail_msg("%s: %u placed, %u pending; saved: %u and %u", what, b.fitted, b.pending,
                     a.fitted, a.pending);
        assert_same(map, again, what);
    }
    gn_shadow_map_destroy(&map);
    gn_shadow_map_destroy(&again);
    gn_scene_destroy(&y.scene);
    gn_scene_destroy(&z.scene);
}

static void test_a_restored_map_goes_on(void **state)
{
    (void)state;
    gn_map_desc desc = sliced_desc(6);
    desc.resolution = 128;
    for (uint32_t at = 1; at < 20; at += 4)
        check_restored(&nlmsm64, desc, 0, at, 9);
    check_restored(&depth32, desc, 1, 4, 4);
    desc.mip_maps = true;
    check_restored(&vsm64, desc, 0, 13, 8);
    check_restored(&vsm64, desc, 2, 3, 5);
    desc.refresh = 1;
    check_restored(&vsm64, desc, 0, 3, 3);
    check_restored(&vsm64, desc, 1, 3, 3);
}

static void test_bad_states_are_refused(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = sliced_desc(4);
    gn_shadow_map *map = make_map(&nlmsm64, &desc);
    gn_map_state empty;
    gn_shadow_map_save_state(map, &empty);
    ok(gn_shadow_map_restore_state(map, y.scene, y.lamp, &empty));
    for (uint32_t n = 0; n < 6; n++) {
        show(&y, n);
        update(map, &y, y.sun);
    }
    gn_map_state good;
    gn_shadow_map_save_state(map, &good);
    assert_true(good.layers[0].used == 1 && good.layers[0].parts > 0);
    for (uint32_t n = 0; n < 14; n++) {
        gn_map_state bad = good;
        gn_map_layer_state *layer = &bad.layers[0];
        switch (n) {
        case 0:
            layer->used = 2;
            break;
        case 1:
            layer->parts = 4;
            break;
        case 2:
            layer->front.extent = 0;
            break;
        case 3:
            layer->front.extent = NAN;
            break;
        case 4:
            layer->back.far = layer->back.near;
            break;
        case 5:
            layer->back.far = INFINITY;
            break;
        case 6:
            layer->front.direction[1] = 0;
            break;
        case 7:
            layer->front.direction[2] = NAN;
            break;
        case 8:
            layer->front.origin[0] = NAN;
            break;
        case 9:
            layer->front.whole = 7;
            break;
        case 10:
            layer->back.low[1] = (double)INFINITY;
            break;
        case 11:
            bad.camera[3] = NAN;
            break;
        case 12:
            bad.has_camera = 2;
            break;
        default:
            bad.type = GN_LIGHT_SPOT;
            break;
        }
        const gn_result result = gn_shadow_map_restore_state(map, y.scene, y.sun, &bad);
        if (result != GN_ERROR_FORMAT)
            fail_msg("state %u is %s", n, gn_result_string(result));
        assert_int_equal(gn_shadow_map_layer_count(map), 0);
    }
    assert_int_equal(gn_shadow_map_restore_state(map, y.scene, y.lamp, &good), GN_ERROR_FORMAT);
    assert_int_equal(gn_shadow_map_restore_state(map, y.scene, 99, &good),
                     GN_ERROR_INVALID_ARGUMENT);
    ok(gn_shadow_map_restore_state(map, y.scene, y.sun, &good));
    update(map, &y, y.sun);
    assert_as_if_new(map, &y, "restored after all");
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_a_restored_map_goes_on),
                                       cmocka_unit_test(test_bad_states_are_refused)};
    return cmocka_run_group_tests_name("map_state", tests, open_device, close_device);
}
