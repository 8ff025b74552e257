/* Shadow maps from frame to frame: what is kept is what a new map would hold. */
#include "render_testing.h"

#include "cpu/cpu.h"
#include "render/device.h"
#include "render/shadow_map.h"

#define RESOLUTION 256u

static const gn_map_format depth32 = {.kind = GN_MAP_DEPTH, .bits = 32};
static const gn_map_format vsm64 = {.kind = GN_MAP_VSM, .bits = 64};
static const gn_map_format msm64 = {.kind = GN_MAP_MSM, .bits = 64};
static const gn_map_format nlmsm64 = {.kind = GN_MAP_NLMSM, .bits = 64};
static const gn_map_format evsm64 = {
    .kind = GN_MAP_EVSM, .bits = 64, .positive_exponent = 5, .negative_exponent = 5};

static gn_map_desc small_desc(void)
{
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = RESOLUTION;
    return desc;
}

static gn_shadow_map *make_map(const gn_map_format *format, const gn_map_desc *desc)
{
    gn_shadow_map *map = NULL;
    ok(gn_shadow_map_create(device, format, desc, &map));
    return map;
}

/* A yard: floor, pillars that stand, two balls that move. */
typedef struct yard {
    gn_scene *scene;
    uint32_t balls[2], sun_node, camera_node, pillar; /* nodes */
    uint32_t camera, sun, lamp, spot;
} yard;

static void look(yard *y, vec eye, vec target)
{
    float m[16];
    aim(eye, target, m);
    ok(gn_scene_set_node_matrix(y->scene, y->camera_node, m));
}

static void move_ball(yard *y, uint32_t ball, vec to)
{
    const float m[16] = {1, 0, 0, 0, 0,           1,           0,           0,
                         0, 0, 1, 0, (float)to.x, (float)to.y, (float)to.z, 1};
    ok(gn_scene_set_node_matrix(y->scene, y->balls[ball], m));
}

static yard make_yard(bool balls)
{
    yard y = {.scene = new_scene()};
    place(y.scene, add_floor(y.scene, 30, 0, GN_NONE), false);
    const uint32_t pillar = add_box(y.scene, v3(-0.3, 0, -0.3), v3(0.3, 3, 0.3), GN_NONE);
    for (int i = 0; i < 25; i++) {
        gn_node_desc node = gn_node_desc_default();
        node.mesh = pillar;
        node.translation[0] = (float)(10 * (i % 5) - 20);
        node.translation[2] = (float)(10 * (i / 5) - 20);
        ok(gn_scene_add_node(y.scene, &node, &y.pillar));
    }
    const uint32_t ball = add_sphere(y.scene, v3(0, 0, 0), 0.7, 6, GN_NONE);
    for (int i = 0; balls && i < 2; i++) {
        gn_node_desc node = gn_node_desc_default();
        node.mesh = ball;
        ok(gn_scene_add_node(y.scene, &node, &y.balls[i]));
        move_ball(&y, (uint32_t)i, v3(3 + i, 1, 2));
    }
    y.sun = add_sun(y.scene, v3(0.4, 1, 0.3));
    y.sun_node = y.scene->node_count - 1;
    y.lamp = add_lamp(y.scene, v3(1, 4, -2));
    gn_light_desc desc = gn_light_desc_default();
    desc.type = GN_LIGHT_SPOT;
    desc.outer_cone_angle = 0.6f;
    y.spot = add_light(y.scene, &desc, v3(-4, 6, 3), v3(1, 0, 1));
    y.camera = add_camera(y.scene, v3(2, 1.7, 10), v3(2, 1, 0), 0.9, 0.1);
    y.camera_node = y.scene->node_count - 1;
    ok(gn_scene_commit(y.scene));
    return y;
}

static gn_map_update update(gn_shadow_map *map, const yard *y, uint32_t light)
{
    gn_map_update u;
    ok(gn_shadow_map_update(map, y->scene, light, y->camera, 16.0f / 9.0f, &u));
    return u;
}

/* Draws and filters every layer of a map from nothing, with its own projections, and compares bit
 * by bit. */
static void assert_as_if_new(const gn_shadow_map *map, const yard *y, const char *what)
{
    gn_map_job job = {.layers = NULL};
    gn_shadow_map_fill_job(map, &job);
    const gn_cpu *cpu = &device->cpu;
    const uint32_t resolution = job.desc.resolution;
    const size_t count = (size_t)resolution * resolution * job.desc.samples;
    const size_t words =
        gn_map_chain_texels(resolution, job.desc.mip_maps) * gn_map_words(&job.format);
    float *depth[2] = {malloc(count * sizeof(float)), malloc(count * sizeof(float))};
    uint32_t *texels = malloc(words * sizeof *texels);
    assert_true(depth[0] && depth[1] && texels);
    for (uint32_t i = 0; i < job.layer_count; i++) {
        const gn_map_layer *layer = &job.layers[i];
        gn_depth_job draw = {.scene = y->scene,
                             .projection = layer->projection,
                             .alpha = job.desc.alpha,
                             .samples = job.desc.samples};
        for (int casters = 0; casters < 2; casters++) {
            draw.casters = (gn_casters)casters;
            draw.depth = depth[casters];
            ok(gn_cpu_depth(cpu, &draw));
        }
        for (size_t k = 0; k < count; k++) {
            const float moving = layer->depth[1] ? layer->depth[1][k] : 1.0f;
            if (layer->depth[0][k] != depth[0][k] || moving != depth[1][k])
                fail_msg("%s: layer %u, depth %zu: %g and %g, drawn anew %g and %g", what, i, k,
                         (double)layer->depth[0][k], (double)moving, (double)depth[0][k],
                         (double)depth[1][k]);
        }
        if (!gn_map_has_texels(&job.format))
            continue;
        const gn_filter_job filter = {.format = job.format,
                                      .resolution = resolution,
                                      .samples = job.desc.samples,
                                      .width = job.desc.filter_width,
                                      .sigma = job.desc.filter_sigma,
                                      .moment_bias = job.desc.moment_bias,
                                      .depth = depth[0],
                                      .dynamic = depth[1],
                                      .rect = {0, 0, resolution, resolution},
                                      .texels = texels};
        ok(gn_cpu_filter(cpu, &filter));
        if (job.desc.mip_maps)
            gn_cpu_map_mips(cpu, &job.format, resolution, texels);
        for (size_t k = 0; k < words; k++)
            if (texels[k] != layer->texels[k])
                fail_msg("%s: layer %u, word %zu: %08x, made anew %08x", what, i, k,
                         layer->texels[k], texels[k]);
    }
    free(depth[0]);
    free(depth[1]);
    free(texels);
}

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

/* Reading ------------------------------------------------------------------------------------- */

/* Visibility of a light by a map of some format, and the layer of each pixel. */
static frame read_by(const yard *y, uint32_t light, const gn_map_format *format,
                     const gn_map_desc *desc, float *layer)
{
    const gn_method method = {"test", "", "", *format, GN_TRACE_NONE, GN_ALPHA_RULE_MIP0};
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
                                       cmocka_unit_test(test_a_slow_camera_keeps_levels),
                                       cmocka_unit_test(test_moving_casters_leave_nothing_behind),
                                       cmocka_unit_test(test_what_did_not_change_costs_nothing),
                                       cmocka_unit_test(test_changes_that_need_a_new_map),
                                       cmocka_unit_test(test_looking_away),
                                       cmocka_unit_test(test_empty_and_tiny_scenes),
                                       cmocka_unit_test(test_scenes_of_any_size),
                                       cmocka_unit_test(test_xi4),
                                       cmocka_unit_test(test_a_lamp_has_no_seams),
                                       cmocka_unit_test(test_cascades_hold_the_picture),
                                       cmocka_unit_test(test_memory_is_taken_where_it_is_needed),
                                       cmocka_unit_test(test_lack_of_memory)};
    return cmocka_run_group_tests_name("shadow_map", tests, open_device, close_device);
}
