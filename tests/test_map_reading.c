/* Reading shadow maps: where light arrives, moving casters, vectors of plain depth, noise, and the
 * settings that a format resolves to. */
#include "map_reading_testing.h"

/* Where light arrives is what rays say, bit by bit. */
static void test_light_reaches_as_for_rays(void **state)
{
    (void)state;
    gn_scene *scene = new_scene();
    /* Nothing to block the light: one square far below. */
    place(scene, add_floor(scene, 0.01, -50, add_single_sided(scene)), false);
    add_sun(scene, v3(0.4, 1, -0.3));
    for (int type = GN_LIGHT_POINT; type <= GN_LIGHT_SPOT; type++) {
        gn_light_desc desc = gn_light_desc_default();
        desc.type = (gn_light_type)type;
        desc.intensity = 1;
        desc.range = 1.1f;
        desc.inner_cone_angle = 0.3f;
        desc.outer_cone_angle = 0.6f;
        add_light(scene, &desc, v3(0.5, 0.6, 0.4), v3(0, 0, 0));
    }
    ok(gn_scene_commit(scene));
    static float rays[PIXELS];
    for (uint32_t light = 0; light < 3; light++) {
        gn_visibility_desc desc = gn_visibility_desc_default();
        desc.light = light;
        ok(gn_scene_visibility(scene, &shared->g, &desc, rays, NULL));
        gn_map_desc map = gn_map_desc_default();
        map = gn_map_desc_resolve(&formats[0], &map);
        const gn_map_job job = {.format = formats[0],
                                .desc = map,
                                .gbuffer = &shared->g,
                                .light = scene->lights[light],
                                .visibility = shared->visibility,
                                .layer = shared->layer};
        read_map(&job);
        size_t lit = 0;
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (rays[i] != shared->visibility[i])
                fail_msg("light %u, pixel %u: %g by rays, %g by a map without layers", light, i,
                         (double)rays[i], (double)shared->visibility[i]);
            assert_true(shared->layer[i] == -1);
            lit += rays[i] == 1;
        }
        assert_in_range(lit, 20, PIXELS - 20);
    }
    gn_scene_destroy(&scene);
}

/* The nearer caster counts. */
static void test_moving_casters(void **state)
{
    (void)state;
    static float expected[PIXELS], nearer[TEXELS];
    const vec to = unit(v3(-0.2, -1, 0.5));
    for (int f = 0; f < FORMATS; f++) {
        if (gn_map_has_texels(&formats[f]))
            continue;
        layers *l = make_cascades(to, 1);
        gn_map_job job = make_job(l, &formats[f], GN_READING_BILINEAR, shared);
        job.light = make_sun(to);
        fill(l, &formats[f], &job.desc, true);
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        for (int i = 0; i < TEXELS; i++)
            nearer[i] = fminf(l->layer[0].depth[0][i], l->layer[0].depth[1][i]);
        l->layer[0].depth[0] = nearer;
        l->layer[0].depth[1] = NULL;
        read_map(&job);
        assert_memory_equal(expected, shared->visibility, sizeof expected);
        free_layers(l);
    }
}

/* Vectors made of four depths are what texels without a filter blend to. */
static void test_single_depth(void **state)
{
    (void)state;
    static float expected[PIXELS];
    static uint32_t texels[4 * TEXELS];
    const vec to = unit(v3(-0.2, -1, 0.5));
    for (int f = 0; f < FORMATS; f++) {
        if (!formats[f].single_depth)
            continue;
        layers *l = make_cascades(to, 1);
        gn_map_job job = make_job(l, &formats[f], GN_READING_BILINEAR, shared);
        job.light = make_sun(to);
        fill(l, &formats[f], &job.desc, true);
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        job.format.single_depth = false;
        const gn_filter_job filter = {.format = job.format,
                                      .resolution = SIZE,
                                      .samples = 1,
                                      .width = 1,
                                      .sigma = 1,
                                      .moment_bias = job.desc.moment_bias,
                                      .depth = l->layer[0].depth[0],
                                      .dynamic = l->layer[0].depth[1],
                                      .rect = {0, 0, SIZE, SIZE},
                                      .texels = texels};
        ok(gn_cpu_filter(&device->cpu, &filter));
        l->layer[0].texels = texels;
        job.desc.filter_width = 1; /* the same margin */
        read_map(&job);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (!near((double)expected[i], (double)shared->visibility[i], 2e-3))
                fail_msg("%s, pixel %u: %g, from texels %g", name_of(&formats[f]), i,
                         (double)expected[i], (double)shared->visibility[i]);
        free_layers(l);
    }
}

/* The mean over many frames is the bilinear blend of the four tests. */
static void test_noise(void **state)
{
    (void)state;
    enum { FRAMES = 400 };
    static double sums[PIXELS];
    static float expected[PIXELS];
    const vec to = unit(v3(-0.2, -1, 0.5));
    const gn_map_format *f = &formats[0];
    for (int reading = GN_READING_WHITE_NOISE; reading <= GN_READING_BLUE_NOISE; reading++) {
        layers *l = make_cascades(to, 1);
        gn_map_job job = make_job(l, f, GN_READING_BILINEAR, shared);
        job.light = make_sun(to);
        fill(l, f, &job.desc, false);
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        job.desc.reading = (gn_map_reading)reading;
        memset(sums, 0, sizeof sums);
        for (job.frame = 0; job.frame < FRAMES; job.frame++) {
            read_map(&job);
            for (uint32_t i = 0; i < PIXELS; i++)
                sums[i] += (double)shared->visibility[i];
        }
        double worst = 0, square = 0;
        size_t count = 0;
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (expected[i] < 0.02f || expected[i] > 0.98f)
                continue;
            const double error = sums[i] / FRAMES - (double)expected[i];
            worst = fmax(worst, fabs(error));
            square += error * error;
            count++;
        }
        assert_true(count > 100);
        /* Of independent choices: 0.5 / sqrt(400) = 0.025 at most, five times that at worst; blue
         * noise has 256 steps. */
        if (worst > 0.125 || sqrt(square / (double)count) > 0.026)
            fail_msg("reading %d: means are off by %g at worst, %g on the whole", reading, worst,
                     sqrt(square / (double)count));

        /* The seed and the frame matter. */
        job.frame = 1;
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        job.frame = 2;
        read_map(&job);
        assert_memory_not_equal(expected, shared->visibility, sizeof expected);
        job.frame = 1;
        job.desc.seed++;
        read_map(&job);
        assert_memory_not_equal(expected, shared->visibility, sizeof expected);
        free_layers(l);
    }
}

/* Settings ------------------------------------------------------------------------------------- */

static void test_resolved_settings(void **state)
{
    (void)state;
    for (int f = 0; f < FORMATS; f++) {
        gn_map_desc desc = gn_map_desc_default();
        gn_map_desc r = gn_map_desc_resolve(&formats[f], &desc);
        assert_int_equal(r.reading, formats[f].kind == GN_MAP_NLMSM   ? GN_READING_BLUE_NOISE
                                    : formats[f].kind == GN_MAP_DEPTH ? GN_READING_NEAREST
                                                                      : GN_READING_BILINEAR);
        assert_true(r.depth_bias >= 0 && r.depth_bias < 1e-3f);
        assert_true(r.normal_bias >= 0 && r.normal_bias <= 16);
        assert_true(r.minimum_variance >= 0 && r.moment_bias >= 0);
        ok(gn_map_desc_check(gn_device_context(device), &formats[f], &r));
        /* What is given stays, and so does what was resolved. */
        desc.depth_bias = 0.01f;
        desc.normal_bias = desc.minimum_variance = desc.moment_bias = 0;
        desc.reading = GN_READING_WHITE_NOISE;
        r = gn_map_desc_resolve(&formats[f], &desc);
        assert_memory_equal(&r, &desc, sizeof r);
    }
}

static void test_margin(void **state)
{
    (void)state;
    gn_map_desc desc = gn_map_desc_default();
    desc.filter_width = 5;
    const struct {
        gn_map_format format;
        gn_map_reading reading;
        uint32_t margin;
    } cases[] = {{{.kind = GN_MAP_DEPTH, .bits = 32}, GN_READING_NEAREST, 0},
                 {{.kind = GN_MAP_DEPTH, .bits = 32}, GN_READING_WHITE_NOISE, 1},
                 {{.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 2}, GN_READING_NEAREST, 1},
                 {{.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 9}, GN_READING_NEAREST, 4},
                 {{.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 9}, GN_READING_BILINEAR, 5},
                 {{.kind = GN_MAP_VSM, .bits = 64}, GN_READING_NEAREST, 2},
                 {{.kind = GN_MAP_VSM, .bits = 64}, GN_READING_BILINEAR, 3},
                 {{.kind = GN_MAP_VSM, .bits = 64, .single_depth = true}, GN_READING_BILINEAR, 1},
                 {{.kind = GN_MAP_NLMSM, .bits = 64}, GN_READING_BLUE_NOISE, 3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        desc.reading = cases[i].reading;
        assert_int_equal(gn_map_margin(&cases[i].format, &desc), cases[i].margin);
    }
}

static void test_empty_layers_are_refused(void **state)
{
    (void)state;
    const vec to = v3(0, -1, 0);
    layers *l = make_cascades(to, 1);
    gn_map_job job = make_job(l, &formats[0], GN_READING_NEAREST, shared);
    job.light = make_sun(to);
    assert_int_equal(gn_cpu_map_visibility(&device->cpu, &job), GN_ERROR_STATE);
    job.layer_count = GN_MAX_CASCADES + 1;
    assert_int_equal(gn_cpu_map_visibility(&device->cpu, &job), GN_ERROR_INVALID_ARGUMENT);
    free_layers(l);
}

/* Biases ----------------------------------------------------------------------------------------
 */

/* The darkest of many receivers on a plane in the light, and the brightest a thousandth of the
 * range behind it, read by a format with its own settings. angle: between the plane's normal and
 * the light, degrees; turn: around it; texel: metres; range: texels. */
typedef struct extremes {
    double darkest, behind;
} extremes;

static extremes look_at_plane(const gn_map_format *f, gn_map_reading reading, double angle,
                              double turn, double texel, double range)
{
    static float depth[TEXELS], visibility[PIXELS], layer[PIXELS];
    static uint32_t texels[4 * TEXELS];
    const double slope = tan(angle * M_PI / 180), sx = slope * cos(turn), sy = slope * sin(turn);
    const double far = range * texel, middle = 0.45 * far;
    gn_map_layer only = {.projection = {.right = {1, 0, 0},
                                        .up = {0, 1, 0},
                                        .forward = {0, 0, 1},
                                        .extent = (float)(texel * SIZE / 2),
                                        .far = (float)far,
                                        .resolution = SIZE},
                         .depth = {depth, NULL},
                         .texels = texels};
    for (int i = 0; i < TEXELS; i++) {
        const double x = (i % SIZE + 0.5 - SIZE / 2) * texel,
                     y = (SIZE / 2 - i / SIZE - 0.5) * texel;
        depth[i] = (float)((middle + sx * x + sy * y) / far);
    }
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = SIZE;
    desc.reading = reading;
    desc = gn_map_desc_resolve(f, &desc);
    if (gn_map_has_texels(f)) {
        const gn_filter_job filter = {.format = *f,
                                      .resolution = SIZE,
                                      .samples = 1,
                                      .width = desc.filter_width,
                                      .sigma = desc.filter_sigma,
                                      .moment_bias = desc.moment_bias,
                                      .depth = depth,
                                      .rect = {0, 0, SIZE, SIZE},
                                      .texels = texels};
        ok(gn_cpu_filter(&device->cpu, &filter));
    }
    const vec n = unit(v3(sx, sy, -1));
    const double normal[3] = {n.x, n.y, n.z};
    gn_map_job job = {.layers = &only,
                      .layer_count = 1,
                      .format = *f,
                      .desc = desc,
                      .gbuffer = &shared->g,
                      .light = make_sun(v3(0, 0, 1)),
                      .visibility = visibility,
                      .layer = layer};
    extremes e = {1, 0};
    for (int behind = 0; behind < 2; behind++) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            /* Away from the border by what the filter and the bias reach. */
            const double x = (next_random() - 0.5) * texel * (SIZE - 24);
            const double y = (next_random() - 0.5) * texel * (SIZE - 24);
            const double p[3] = {x, y, middle + sx * x + sy * y + behind * 0.05 * far};
            for (int axis = 0; axis < 3; axis++) {
                shared->position[axis][i] = (float)p[axis];
                shared->normal[axis][i] = (float)normal[axis];
            }
            shared->surface[i] = 1;
            shared->error[i] = 0;
        }
        read_map(&job);
        for (uint32_t i = 0; i < PIXELS; i++) {
            assert_true(layer[i] == 0);
            if (behind)
                e.behind = fmax(e.behind, (double)visibility[i]);
            else
                e.darkest = fmin(e.darkest, (double)visibility[i]);
        }
    }
    return e;
}

/* Planes in the light have no spots, whatever their slope, and a caster a twentieth of the range
 * away still shadows; a scene of any size gives the same. PCF may see 1 % of its window beyond the
 * bias on either side. */
static void test_biases(void **state)
{
    (void)state;
    for (int f = 0; f < FORMATS; f++) {
        const gn_map_format *format = &formats[f];
        if (format->kind == GN_MAP_PCF && format->pcf_width > 9)
            continue; /* need a larger map */
        for (int reading = GN_READING_NEAREST; reading <= GN_READING_BILINEAR; reading++)
            for (int step = 0; step < 3 && reading != GN_READING_WHITE_NOISE; step++) {
                const double angle = 40 * step, range = 2000, turn = 2 + 1.7 * step;
                for (int scale = step == 1 ? -3 : 0; scale <= (step == 1 ? 3 : 0); scale += 3) {
                    const extremes e = look_at_plane(format, (gn_map_reading)reading, angle, turn,
                                                     0.01 * pow(10, scale), range);
                    const double least = format->pcf_width > 2 ? 0.95 : 0.99;
                    if (e.darkest < least)
                        fail_msg("%s, reading %d, a plane at %g degrees: visibility falls to %g",
                                 name_of(format), reading, angle, e.darkest);
                    /* Bounds that leak much by nature. */
                    const bool leaks = format->kind == GN_MAP_ESM ||
                                       (format->kind == GN_MAP_VSM && format->bits == 32) ||
                                       (format->kind == GN_MAP_EVSM && format->bits == 64) ||
                                       (format->kind == GN_MAP_EVSM && angle > 60);
                    if (!leaks && e.behind > 0.1)
                        fail_msg("%s, reading %d, behind a plane at %g degrees: visibility is %g",
                                 name_of(format), reading, angle, e.behind);
                }
            }
    }
    scatter(shared, 0.7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_light_reaches_as_for_rays),
        cmocka_unit_test(test_moving_casters),
        cmocka_unit_test(test_single_depth),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_resolved_settings),
        cmocka_unit_test(test_margin),
        cmocka_unit_test(test_empty_layers_are_refused),
        cmocka_unit_test(test_biases),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
