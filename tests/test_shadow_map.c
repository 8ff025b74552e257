/* Shadow maps: settings, calls, scenes of all kinds, memory. */
#include "shadow_map_testing.h"

static const gn_map_format evsm64 = {
    .kind = GN_MAP_EVSM, .bits = 64, .positive_exponent = 5, .negative_exponent = 5};

/* Settings ------------------------------------------------------------------------------------ */

static void refused(const gn_map_format *format, const gn_map_desc *desc, const char *words)
{
    gn_shadow_map *map = (gn_shadow_map *)&map;
    const gn_result result = gn_shadow_map_create(device, format, desc, &map);
    if (result != GN_ERROR_INVALID_ARGUMENT && result != GN_ERROR_INVALID_DESC)
        fail_msg("\"%s\": %s", words, gn_result_string(result));
    assert_null(map);
    if (!strstr(gn_device_message(device), words))
        fail_msg("the message is \"%s\", expected \"%s\" in it", gn_device_message(device), words);
}

static void test_bad_settings_are_refused(void **state)
{
    (void)state;
    static const uint32_t cascades[] = {0, 9}, resolutions[] = {0, 15, 16385, 65537},
                          widths[] = {0, 2, 8, 34, 35}, samples[] = {0, 2, 3, 8};
    gn_map_desc desc;
    for (uint32_t i = 0; i < 2; i++) {
        desc = small_desc();
        desc.cascades = cascades[i];
        refused(&nlmsm64, &desc, "the range is 1 to 8");
    }
    for (uint32_t i = 0; i < 4; i++) {
        desc = small_desc();
        desc.resolution = resolutions[i];
        refused(&nlmsm64, &desc, "the range is 16 to 16384");
    }
    for (uint32_t i = 0; i < 5; i++) {
        desc = small_desc();
        desc.filter_width = widths[i];
        refused(&nlmsm64, &desc, "odd, from 1 to 33");
    }
    for (uint32_t i = 0; i < 4; i++) {
        desc = small_desc();
        desc.samples = samples[i];
        refused(&nlmsm64, &desc, "1 or 4");
    }
    desc = small_desc();
    gn_map_format format = evsm64;
    format.positive_exponent = 40;
    refused(&format, &desc, "0 (not included) to 5.54");
    format = evsm64;
    format.negative_exponent = 40;
    refused(&format, &desc, "0 (not included) to 5.54");
    format = nlmsm64;
    format.bits = 16;
    refused(&format, &desc, "32 or 64");
    desc.mip_maps = true;
    refused(&nlmsm64, &desc, "mip");
    desc = small_desc();
    desc.enlarge = NAN;
    refused(&nlmsm64, &desc, "0 to 1");
    desc = small_desc();
    desc.distance = -1;
    refused(&nlmsm64, &desc, "0 or more");
    desc = small_desc();
    desc.cookie = 0;
    refused(&nlmsm64, &desc, "gn_map_desc_default");
    refused(NULL, NULL, "format");
    /* All texels would belong to the border. */
    desc = small_desc();
    desc.resolution = 32;
    desc.filter_width = 33;
    refused(&nlmsm64, &desc, "32 texels a side");
}

static void test_plain_depth_takes_one_sample(void **state)
{
    (void)state;
    yard y = make_yard(false);
    gn_map_desc desc = small_desc();
    desc.samples = 4;
    gn_map_format single = msm64;
    single.single_depth = true;
    const gn_map_format *formats[] = {&depth32, &single, &nlmsm64};
    for (uint32_t i = 0; i < 3; i++) {
        gn_shadow_map *map = make_map(formats[i], &desc);
        const gn_map_update u = update(map, &y, y.sun);
        assert_int_equal(gn_shadow_map_layer(map, 0).samples, i == 2 ? 4 : 1);
        assert_int_equal(u.filtered, i == 2 ? u.fitted : 0);
        assert_as_if_new(map, &y, "samples");
        gn_shadow_map_destroy(&map);
    }
    gn_scene_destroy(&y.scene);
}

static void test_bad_calls_are_refused(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = small_desc();
    gn_shadow_map *map = make_map(&depth32, &desc);
    update(map, &y, y.sun);
    assert_true(gn_shadow_map_layer_count(map) > 0);
    assert_int_equal(gn_shadow_map_update(map, y.scene, 3, 0, 1, NULL), GN_ERROR_INVALID_ARGUMENT);
    assert_int_equal(gn_shadow_map_layer_count(map), 0); /* empty until an update succeeds */
    assert_int_equal(gn_shadow_map_update(map, y.scene, y.sun, 1, 1, NULL),
                     GN_ERROR_INVALID_ARGUMENT);
    static const float aspects[] = {0, -1, NAN, INFINITY};
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(gn_shadow_map_update(map, y.scene, y.sun, 0, aspects[i], NULL),
                         GN_ERROR_INVALID_ARGUMENT);
    /* A lamp needs no camera. */
    ok(gn_shadow_map_update(map, y.scene, y.lamp, 99, NAN, NULL));
    assert_int_equal(gn_shadow_map_layer_count(map), 6);
    gn_device *other;
    ok(gn_device_create(NULL, &other));
    gn_shadow_map *foreign;
    ok(gn_shadow_map_create(other, &depth32, &desc, &foreign));
    assert_int_equal(gn_shadow_map_update(foreign, y.scene, y.sun, 0, 1, NULL),
                     GN_ERROR_INVALID_ARGUMENT);
    gn_shadow_map_destroy(&foreign);
    gn_device_destroy(&other);
    const gn_map_layer_info none = gn_shadow_map_layer(map, 6);
    assert_null(none.depth);
    move_ball(&y, 0, v3(1, 1, 1));
    assert_int_equal(gn_shadow_map_update(map, y.scene, y.sun, 0, 1, NULL), GN_ERROR_STATE);
    ok(gn_scene_commit(y.scene));
    const gn_map_update u = update(map, &y, y.sun);
    assert_int_equal(u.fitted, gn_shadow_map_layer_count(map));
    gn_shadow_map_destroy(&map);
    gn_shadow_map_destroy(&map); /* NULL is fine */
    gn_scene_destroy(&y.scene);
}

static void test_empty_and_tiny_scenes(void **state)
{
    (void)state;
    for (int triangles = 0; triangles < 2; triangles++) {
        yard y = {.scene = new_scene()};
        if (triangles) {
            const gn_mesh_part part = {.vertex_count = 3,
                                       .positions = (const float[]){0, 0, 0, 1, 0, 0, 0, 2, 0},
                                       .index_count = 3,
                                       .indices = (const uint32_t[]){0, 1, 2},
                                       .material = GN_NONE};
            uint32_t mesh;
            ok(gn_scene_add_mesh(y.scene, "triangle", &part, 1, &mesh));
            place(y.scene, mesh, false);
        }
        const uint32_t lights[] = {add_sun(y.scene, v3(0, 1, 0)), add_sun(y.scene, v3(0, -1, 0)),
                                   add_sun(y.scene, v3(0, 0, 1)), add_lamp(y.scene, v3(0, 1, 1)),
                                   add_lamp(y.scene, v3(0, 0, 0))};
        y.camera = add_camera(y.scene, v3(0.3, 0.5, 3), v3(0.3, 0.5, 0), 0.8, 0.1);
        ok(gn_scene_commit(y.scene));
        for (uint32_t i = 0; i < 5; i++) {
            const gn_map_desc desc = small_desc();
            gn_shadow_map *map = make_map(&nlmsm64, &desc);
            update(map, &y, lights[i]);
            assert_int_equal(gn_shadow_map_layer_count(map), triangles == 0 ? 0 : i < 3 ? 1 : 6);
            assert_as_if_new(map, &y, "tiny");
            uint32_t covered = 0;
            for (uint32_t k = 0; triangles && k < RESOLUTION * RESOLUTION; k++)
                covered += gn_shadow_map_layer(map, 0).depth[k] < 1;
            if (triangles && i == 2) /* half of a square of 2 m, with its border */
                assert_true(covered > RESOLUTION * RESOLUTION / 5);
            gn_shadow_map_destroy(&map);
        }
        gn_scene_destroy(&y.scene);
    }
}

/* A triangle of any size is drawn, or refused in words; nothing overflows. */
static void test_scenes_of_any_size(void **state)
{
    (void)state;
    static const double sizes[] = {1e-35, 1e-20, 1e-6, 1e6, 1e15, 1e30, 3e37};
    for (uint32_t n = 0; n < 7; n++) {
        const float s = (float)sizes[n];
        const gn_mesh_part part = {.vertex_count = 3,
                                   .positions = (const float[]){0, 0, 0, s, 0, 0, 0, 2 * s, s},
                                   .index_count = 3,
                                   .indices = (const uint32_t[]){0, 1, 2},
                                   .material = GN_NONE};
        yard y = {.scene = new_scene()};
        uint32_t mesh;
        ok(gn_scene_add_mesh(y.scene, "triangle", &part, 1, &mesh));
        place(y.scene, mesh, false);
        gn_light_desc lamp = gn_light_desc_default();
        lamp.type = GN_LIGHT_POINT;
        const uint32_t lights[] = {
            add_sun(y.scene, v3(0.1, 1, 0.4)),
            add_light(y.scene, &lamp, v3(0, sizes[n], sizes[n] / 2), v3(0, 0, 0))};
        y.camera = add_camera(y.scene, v3(0.3 * sizes[n], 0.5 * sizes[n], 3 * sizes[n]),
                              v3(0.3 * sizes[n], 0.5 * sizes[n], 0), 0.8, 0.1 * sizes[n]);
        ok(gn_scene_commit(y.scene));
        for (uint32_t i = 0; i < 2; i++) {
            const gn_map_desc desc = small_desc();
            gn_shadow_map *map = make_map(&nlmsm64, &desc);
            const gn_result result = gn_shadow_map_update(map, y.scene, lights[i], 0, 1, NULL);
            if (result != GN_OK)
                print_message("size %g, light %u: %s\n", sizes[n], i, gn_device_message(device));
            assert_true(result == GN_OK || (result == GN_ERROR_UNSUPPORTED && sizes[n] > 1e18));
            gn_shadow_map_destroy(&map);
        }
        gn_scene_destroy(&y.scene);
    }
}

static void test_xi4(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = small_desc();
    float *xi4 = malloc(sizeof *xi4 * RESOLUTION * RESOLUTION);
    assert_non_null(xi4);
    for (uint32_t bits = 32; bits <= 64; bits += 32) {
        const gn_map_format format = {.kind = GN_MAP_NLMSM, .bits = bits};
        gn_shadow_map *map = make_map(&format, &desc);
        assert_int_equal(gn_shadow_map_xi4(map, 0, xi4), GN_ERROR_INVALID_ARGUMENT);
        update(map, &y, y.sun);
        ok(gn_shadow_map_xi4(map, 0, xi4));
        float least = 1, most = 0;
        for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; i++) {
            least = fminf(least, xi4[i]);
            most = fmaxf(most, xi4[i]);
        }
        print_message("%u bits: xi4 from %g to %g\n", bits, (double)least, (double)most);
        assert_true(least >= 0 && most <= 0.25f && most > least);
        assert_int_equal(gn_shadow_map_xi4(map, gn_shadow_map_layer_count(map), xi4),
                         GN_ERROR_INVALID_ARGUMENT);
        gn_shadow_map_destroy(&map);
    }
    gn_shadow_map *other = make_map(&vsm64, &desc);
    update(other, &y, y.sun);
    assert_int_equal(gn_shadow_map_xi4(other, 0, xi4), GN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(gn_device_message(device), "nlmsm"));
    gn_shadow_map_destroy(&other);
    free(xi4);
    gn_scene_destroy(&y.scene);
}

/* Memory -------------------------------------------------------------------------------------- */

static void test_memory_is_taken_where_it_is_needed(void **state)
{
    (void)state;
    const size_t held = gn_device_bytes(device), plane = RESOLUTION * RESOLUTION * 4;
    yard y = make_yard(true);
    const gn_map_desc desc = small_desc();
    gn_shadow_map *map = make_map(&nlmsm64, &desc);
    assert_int_equal(gn_shadow_map_bytes(map), 0);
    move_ball(&y, 0, v3(0, 1, -25)); /* both outside of the cone */
    move_ball(&y, 1, v3(0, 1, -25));
    ok(gn_scene_commit(y.scene));
    update(map, &y, y.spot);
    assert_int_equal(gn_shadow_map_bytes(map), 3 * plane); /* depth, two words */
    move_ball(&y, 1, v3(-2, 1, 3));
    ok(gn_scene_commit(y.scene));
    update(map, &y, y.spot);
    assert_int_equal(gn_shadow_map_bytes(map), 4 * plane);
    update(map, &y, y.lamp);
    const size_t six = gn_shadow_map_bytes(map);
    assert_true(six > 18 * plane && six <= 24 * plane);
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
    assert_int_equal(gn_device_bytes(device), held);
}

static int allocations_left;

static void *scarce_alloc(size_t size, void *user)
{
    (void)user;
    if (__atomic_sub_fetch(&allocations_left, 1, __ATOMIC_SEQ_CST) < 0)
        return NULL;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void scarce_free(void *pointer, size_t size, void *user)
{
    (void)size;
    (void)user;
    free(pointer);
}

static void test_lack_of_memory(void **state)
{
    (void)state;
    gn_device *const plenty = device;
    gn_device_desc device_desc = gn_device_desc_default();
    device_desc.allocator = (gn_allocator){scarce_alloc, scarce_free, NULL};
    allocations_left = 1000000;
    ok(gn_device_create(&device_desc, &device));
    const size_t held = gn_device_bytes(device);
    gn_map_desc desc = small_desc();
    desc.resolution = 64;
    uint32_t failures = 0;
    gn_result result = GN_ERROR_OUT_OF_MEMORY;
    for (int allowed = 0; result != GN_OK && allowed < 1000; allowed++) {
        yard y = make_yard(true);
        gn_shadow_map *map = NULL;
        allocations_left = allowed;
        result = gn_shadow_map_create(device, &nlmsm64, &desc, &map);
        if (result == GN_OK)
            result = gn_shadow_map_update(map, y.scene, y.sun, y.camera, 1, NULL);
        allocations_left = 1000000;
        failures += result != GN_OK;
        if (result != GN_OK) {
            assert_int_equal(result, GN_ERROR_OUT_OF_MEMORY);
            assert_true(!map || gn_shadow_map_layer_count(map) == 0);
        }
        if (result != GN_OK && map) {
            update(map, &y, y.sun); /* it recovers */
            assert_as_if_new(map, &y, "after a lack of memory");
        }
        gn_shadow_map_destroy(&map);
        gn_scene_destroy(&y.scene);
        assert_int_equal(gn_device_bytes(device), held);
    }
    print_message("%u allocations failed\n", failures);
    assert_true(failures > 8 && result == GN_OK);
    gn_device_destroy(&device);
    device = plenty;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bad_settings_are_refused),
                                       cmocka_unit_test(test_plain_depth_takes_one_sample),
                                       cmocka_unit_test(test_bad_calls_are_refused),
                                       cmocka_unit_test(test_empty_and_tiny_scenes),
                                       cmocka_unit_test(test_scenes_of_any_size),
                                       cmocka_unit_test(test_xi4),
                                       cmocka_unit_test(test_memory_is_taken_where_it_is_needed),
                                       cmocka_unit_test(test_lack_of_memory)};
    return cmocka_run_group_tests_name("shadow_map", tests, open_device, close_device);
}
