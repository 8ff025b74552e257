/* Ray cones against geometry: the pixel's corners are sent through the scene in double, and what
 * they enclose on the occluder is measured in texels. */
#include <float.h>

#include <gnomon/shadow/ray_cone.h>

#include "ray_cone_testing.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* The first six of the eight steps. */
static gn_ray_cone chain(const setup *s)
{
    const float angle = gn_ray_cone_spread((float)s->tan_half_fov, (float)s->height);
    gn_ray_cone cone = {0.0f, angle};
    cone = gn_ray_cone_propagate(cone, (float)s->distance);
    cone = gn_ray_cone_hit(cone, (float)cos(s->tilt));
    cone = gn_ray_cone_reflect(cone, (float)cos(s->light_tilt));
    cone = isinf(s->light_distance) ? gn_ray_cone_ortho(cone)
                                    : gn_ray_cone_focus(cone, (float)s->light_distance);
    return gn_ray_cone_propagate(cone, (float)s->occluder_distance);
}

static void check_setup(const setup *s, size_t *checked)
{
    if (!is_small(s))
        return;
    const carried footprint = carry_pixel(s);
    const gn_ray_cone cone = chain(s);
    const float cosine = (float)cos(s->occluder_tilt);
    static const float scales[] = {0.01f, 1.0f, 40.0f};
    for (size_t i = 0; i < COUNT(scales); i++) {
        /* Half of a square of 512 texels and 0.3 metres, in an instance of uniform scale. */
        const float t_a = 512.0f * 512.0f, side = 0.3f * scales[i], p_a = side * side;
        const double texel = (double)side / 512;
        const double lod = (double)gn_ray_cone_lod(gn_ray_cone_hit(cone, -cosine).width, t_a, p_a);
        const double expected = log2(footprint.extent / texel);
        if (!(fabs(lod - expected) <= 0.05))
            fail_msg("LOD %.4f, the footprint has %.4f: fov tan %g height %g distance %g tilt %g "
                     "light %g at %g occluder %g at %g scale %g",
                     lod, expected, s->tan_half_fov, s->height, s->distance, s->tilt, s->light_tilt,
                     s->light_distance, s->occluder_tilt, s->occluder_distance, (double)scales[i]);
        /* Where the light mirrors the camera, Reflect undoes Hit, and the cone is as wide as deep:
         * then the area tells the level as well. */
        const double area_lod =
            log2((double)gn_ray_cone_footprint_area(cone.width, t_a, p_a * cosine));
        const double by_area = 0.5 * log2(footprint.area / (texel * texel));
        if (s->tilt == s->light_tilt && !(fabs(area_lod - by_area) <= 0.05))
            fail_msg("LOD %.4f, the footprint's area has %.4f: tilt %g occluder %g", area_lod,
                     by_area, s->tilt, s->occluder_tilt);
        ++*checked;
    }
}

/* Light distances; occluders at shares of them, or of 100 metres for a sun. */
static void sweep_lights(setup s, size_t *checked)
{
    static const double lights[] = {INFINITY, 0.5, 8, 300};
    static const double shares[] = {0.0, 0.02, 0.5, 0.95};
    for (size_t i = 0; i < COUNT(lights); i++)
        for (size_t j = 0; j < COUNT(shares); j++) {
            s.light_distance = lights[i];
            s.occluder_distance = shares[j] * (isinf(lights[i]) ? 100 : lights[i]);
            check_setup(&s, checked);
        }
}

static void test_lod_is_the_pixels_footprint(void **state)
{
    (void)state;
    static const double distances[] = {0.2, 2, 15, 120, 1000};
    static const double heights[] = {240, 480, 1080, 1440, 2160};
    static const double fovs[] = {20, 45, 60, 80, 100};
    static const double tilts[][3] = {{0, 0, 0},   {0, 60, 0},   {30, 30, 0},  {45, 10, 0},
                                      {60, 60, 0}, {75, 75, 0},  {80, -20, 0}, {10, 80, 0},
                                      {70, 0, 0},  {30, 30, 60}, {0, 50, -75}};
    size_t checked = 0, possible = 0;
    for (size_t d = 0; d < COUNT(distances); d++)
        for (size_t h = 0; h < COUNT(heights); h++)
            for (size_t f = 0; f < COUNT(fovs); f++)
                for (size_t t = 0; t < COUNT(tilts); t++) {
                    const setup s = {.tan_half_fov = tan(0.5 * fovs[f] * degrees),
                                     .height = heights[h],
                                     .distance = distances[d],
                                     .tilt = tilts[t][0] * degrees,
                                     .light_tilt = tilts[t][1] * degrees,
                                     .occluder_tilt = tilts[t][2] * degrees};
                    sweep_lights(s, &checked);
                    possible += 48;
                }
    if (checked < possible * 8 / 10)
        fail_msg("only %zu of %zu set-ups were checked", checked, possible);
}

/* The operations ----------------------------------------------------------------------------- */

static float uniform(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return (float)(*state >> 8) * (1.0f / 16777216.0f);
}

/* From low to high, as likely in each octave. */
static float scaled(uint32_t *state, double low, double high)
{
    return (float)(low * pow(high / low, (double)uniform(state)));
}

static void test_spread(void **state)
{
    (void)state;
    for (int fov = 5; fov <= 170; fov += 5)
        for (int height = 1; height <= 16384; height *= 2) {
            const float t = (float)tan(0.5 * fov * degrees);
            const double expected = atan(2.0 * (double)t / height);
            const float value = gn_ray_cone_spread(t, (float)height);
            if (!(fabs((double)value - expected) <= 4e-7 * expected))
                fail_msg("spread(%g, %d) is %.9g, expected %.9g", (double)t, height, (double)value,
                         expected);
        }
}

static void test_focus_closes_at_the_light(void **state)
{
    (void)state;
    uint32_t seed = 3;
    for (int i = 0; i < 200000; i++) {
        const gn_ray_cone start = {scaled(&seed, 1e-6, 1e3), 0.001f};
        const float light = scaled(&seed, 1e-3, 1e6), share = uniform(&seed);
        const gn_ray_cone cone = gn_ray_cone_focus(start, light);
        const double width = (double)start.width;

        /* Closes as similar triangles do. */
        const double there = (double)gn_ray_cone_propagate(cone, light * share).width;
        if (!(fabs(there - width * (1.0 - (double)share)) <= 2.5e-7 * width))
            fail_msg("width %.9g at %g of the way, started with %.9g", there, (double)share, width);
        const float end = gn_ray_cone_propagate(cone, light).width;
        if (!(end >= 0.0f && (double)end <= 2.5e-7 * width))
            fail_msg("width %.9g at the light, started with %.9g", (double)end, width);
        assert_true(gn_ray_cone_propagate(cone, 1.5f * light).width == 0.0f);

        if (start.width > 2.0f * light)
            continue;
        const gn_ray_cone exact = gn_ray_cone_focus_exact(start, light);
        const double angle = -2.0 * atan(0.5 * width / (double)light);
        assert_true(fabs((double)exact.angle - angle) <= 5e-7 * -angle);
        const float exact_end = gn_ray_cone_propagate_exact(exact, light).width;
        if (!(exact_end >= 0.0f && (double)exact_end <= 1e-6 * width))
            fail_msg("exact width %.9g at the light, started with %.9g", (double)exact_end, width);
    }
}

static void test_ortho_keeps_the_width(void **state)
{
    (void)state;
    uint32_t seed = 5;
    for (int i = 0; i < 10000; i++) {
        const gn_ray_cone start = {scaled(&seed, 1e-6, 1e3), uniform(&seed)};
        const gn_ray_cone cone = gn_ray_cone_ortho(start);
        assert_true(cone.angle == 0.0f);
        assert_true(gn_ray_cone_propagate(cone, scaled(&seed, 1e-6, 1e9)).width == start.width);
        assert_true(gn_ray_cone_propagate_exact(cone, scaled(&seed, 1e-6, 1e9)).width ==
                    start.width);
    }
}

static void test_exact_and_approximate_forms(void **state)
{
    (void)state;
    uint32_t seed = 9;
    for (int i = 0; i < 200000; i++) {
        const float angle = scaled(&seed, 1e-5, 1.57), distance = scaled(&seed, 1e-3, 1e4);
        const gn_ray_cone cone = {scaled(&seed, 1e-3, 10), angle};
        const double a = (double)angle, d = (double)distance, w = (double)cone.width;
        const double exact = w + 2.0 * d * tan(0.5 * a), approximate = w + d * a;
        const double got_exact = (double)gn_ray_cone_propagate_exact(cone, distance).width;
        const double got_approximate = (double)gn_ray_cone_propagate(cone, distance).width;
        if (!(fabs(got_exact - exact) <= 6e-7 * exact) ||
            !(fabs(got_approximate - approximate) <= 2e-7 * approximate))
            fail_msg("propagate(%g, %g, %g): %.9g and %.9g, expected %.9g and %.9g", w, a, d,
                     got_exact, got_approximate, exact, approximate);
        /* 2 tan(a/2) = a + a^3/12 + a^5/120 + ... */
        if (angle <= 0.1f)
            assert_true(fabs(got_exact - got_approximate) <= exact * (a * a / 11.9 + 8e-7));
    }
}

static void test_hit_and_reflect(void **state)
{
    (void)state;
    uint32_t seed = 11;
    for (int i = 0; i < 100000; i++) {
        const gn_ray_cone cone = {scaled(&seed, 1e-6, 1e3), uniform(&seed)};
        const float cosine = scaled(&seed, 1e-6, 1), other = -cosine;
        const gn_ray_cone hit = gn_ray_cone_hit(cone, cosine);
        const double expected = (double)cone.width / (double)cosine;
        assert_true(fabs((double)hit.width - expected) <= 1e-7 * expected);
        assert_true(gn_ray_cone_hit(cone, other).width == hit.width && hit.angle == cone.angle);
        /* Reflect undoes Hit, from either side. */
        const gn_ray_cone back = gn_ray_cone_reflect(hit, other);
        assert_true(fabs((double)back.width / (double)cone.width - 1.0) <= 2.4e-7);
    }
}

static void test_grazing_stays_finite(void **state)
{
    (void)state;
    const gn_ray_cone cone = {0.01f, 0.0f};
    const float cosines[] = {0.0f, -0.0f, 1e-30f, -1e-30f, 1e-7f, 1e-40f, NAN};
    for (size_t i = 0; i < COUNT(cosines); i++) {
        const gn_ray_cone hit = gn_ray_cone_hit(cone, cosines[i]);
        assert_true(hit.width >= cone.width && hit.width <= 1.001e6f * cone.width);
        assert_true(isfinite(gn_ray_cone_lod(hit.width, 4096.0f, 0.01f)));
    }
    /* The short form divides by N.d itself; the mip bounds it. */
    const float dots[] = {0.0f, -0.0f, 1e-44f, NAN, 1e-38f};
    for (size_t i = 0; i < COUNT(dots); i++)
        for (int last = 0; last <= 14; last++) {
            const float footprint = gn_ray_cone_footprint(0.01f, 100.0f, dots[i]);
            assert_true(gn_ray_cone_nearest_mip(footprint, (float)last) == (float)last);
            const float area = gn_ray_cone_footprint_area(0.01f, 1e30f, dots[i]);
            assert_true(gn_ray_cone_nearest_mip(area, (float)last) == (float)last);
            /* 0/0: a cone that has closed meets an edge. */
            const float none = gn_ray_cone_footprint(0.0f, 100.0f, 0.0f);
            assert_true(gn_ray_cone_nearest_mip(none, (float)last) == (float)last);
        }
    assert_true(gn_ray_cone_nearest_mip(gn_ray_cone_footprint(0.01f, 100.0f, INFINITY), 9.0f) ==
                0.0f);
    assert_true(gn_ray_cone_nearest_mip(INFINITY, 9.0f) == 9.0f);
    assert_true(gn_ray_cone_nearest_mip(FLT_MAX, 9.0f) == 9.0f);
    assert_true(gn_ray_cone_nearest_mip(NAN, 9.0f) == 9.0f);
    assert_true(gn_ray_cone_nearest_mip(-NAN, 9.0f) == 9.0f);
    assert_true(gn_ray_cone_nearest_mip(0.0f, 9.0f) == 0.0f);
    assert_true(gn_ray_cone_nearest_mip(1e-40f, 9.0f) == 0.0f);
}

static vec random_vector(uint32_t *seed)
{
    const double x = (double)uniform(seed), y = (double)uniform(seed), z = (double)uniform(seed);
    return v3(x - 0.5, y - 0.5, z - 0.5);
}

/* Random triangles, texture coordinates and directions. */
static void test_footprint_is_the_long_chain(void **state)
{
    (void)state;
    uint32_t seed = 13;
    for (int i = 0; i < 200000; i++) {
        const double size = (double)scaled(&seed, 1e-3, 1e3);
        const vec n = cross(mul(random_vector(&seed), size), random_vector(&seed));
        const vec d = unit(random_vector(&seed));
        const double uv = fabs((double)uniform(&seed) * (double)uniform(&seed) -
                               (double)uniform(&seed) * (double)uniform(&seed));
        const double t_a = 2048.0 * 512.0 * uv, p_a = length(n), n_d = dot(n, d);
        const double cosine = n_d / p_a;
        if (!(fabs(cosine) > 1e-5) || !(uv > 1e-6) || !(p_a > 1e-6))
            continue;
        const gn_ray_cone cone = {scaled(&seed, 1e-5, 10), 0.0f};
        const float lod =
            gn_ray_cone_lod(gn_ray_cone_hit(cone, (float)cosine).width, (float)t_a, (float)p_a);
        const float footprint =
            gn_ray_cone_footprint(cone.width, (float)sqrt(t_a * p_a), (float)n_d);
        /* Equations 3 and 5 in double, for both. */
        const double expected = (double)cone.width / fabs(cosine) * sqrt(t_a / p_a);
        const double area = expected * sqrt(fabs(cosine));
        const float by_area = gn_ray_cone_footprint_area(cone.width, (float)t_a, (float)n_d);
        assert_true(fabs((double)by_area / area - 1.0) <= 4e-7);
        if (!(fabs((double)footprint / expected - 1.0) <= 4e-7) ||
            !(fabs((double)lod - log2(expected)) <= 6e-7 + 6e-8 * fabs(log2(expected))))
            fail_msg("footprint %.9g, LOD %.9g, expected %.9g and %.9g", (double)footprint,
                     (double)lod, expected, log2(expected));
    }
}

static void test_nearest_mip_rounds(void **state)
{
    (void)state;
    uint32_t seed = 17;
    for (int i = 0; i < 1000000; i++) {
        const float footprint = scaled(&seed, 1e-6, 1e6), last = (float)(i % 15);
        const double level = log2((double)footprint), rounded = floor(level + 0.5);
        if (fabs(level + 0.5 - floor(level + 1.0)) < 2e-7) /* within rounding of a half */
            continue;
        const float expected = (float)fmin(fmax(rounded, 0.0), (double)last);
        const float mip = gn_ray_cone_nearest_mip(footprint, last);
        if (mip != expected)
            fail_msg("nearest_mip(%.9g, %g) is %g, expected %g", (double)footprint, (double)last,
                     (double)mip, (double)expected);
    }
    for (int mip = 0; mip < 14; mip++) {
        const double border = exp2(mip + 0.5);
        assert_true(gn_ray_cone_nearest_mip((float)(border * 0.999999), 14.0f) == (float)mip);
        assert_true(gn_ray_cone_nearest_mip((float)(border * 1.000001), 14.0f) == (float)(mip + 1));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lod_is_the_pixels_footprint),
        cmocka_unit_test(test_spread),
        cmocka_unit_test(test_focus_closes_at_the_light),
        cmocka_unit_test(test_ortho_keeps_the_width),
        cmocka_unit_test(test_exact_and_approximate_forms),
        cmocka_unit_test(test_hit_and_reflect),
        cmocka_unit_test(test_grazing_stays_finite),
        cmocka_unit_test(test_footprint_is_the_long_chain),
        cmocka_unit_test(test_nearest_mip_rounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
