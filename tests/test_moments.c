/* Moments, their biases, quantization and reconstructions against the paper's algorithms in
 * double. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>

#include <gnomon/shadow/moments.h>
#include <gnomon/shadow/moments_nonlinear.h>

#include "distribution_testing.h"
#include "moments_testing.h"

#define COUNT 200000

static void assert_close(double value, double expected, double tolerance, const char *what, int i)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s of case %d is %.9g, expected %.9g within %g", what, i, value, expected,
                 tolerance);
}

static void moments_of(const distribution *d, double b[5])
{
    for (int i = 0; i < 5; i++)
        b[i] = moment_of(d, i);
}

static gn_moments single(const double b[5])
{
    return (gn_moments){(float)b[1], (float)b[2], (float)b[3], (float)b[4]};
}

static void from_single(gn_moments m, double b[5])
{
    b[0] = 1.0;
    b[1] = (double)m.b1;
    b[2] = (double)m.b2;
    b[3] = (double)m.b3;
    b[4] = (double)m.b4;
}

static void assert_moments(gn_moments m, const double b[5], double tolerance, const char *what,
                           int i)
{
    double own[5];
    from_single(m, own);
    for (int power = 1; power < 5; power++)
        assert_close(own[power], b[power], tolerance, what, i);
}

static void test_powers_and_biases(void **state)
{
    (void)state;
    uint32_t seed = 1;
    for (int i = 0; i < COUNT; i++) {
        const distribution d = random_distribution(&seed, 1, 1.0);
        double b[5], fixed[5] = {1.0}, floating[5] = {1.0};
        moments_of(&d, b);
        assert_moments(gn_moments_of(d.depth[0]), b, 2e-7, "power", i);
        const double alpha = (double)(float)pow(random_unit(&seed), 4.0);
        for (int power = 1; power < 5; power++) {
            const double even = power % 2 ? 0.0 : 1.0;
            fixed[power] = (1.0 - alpha) * b[power] + alpha * 0.628 * even;
            floating[power] = (1.0 - alpha) * b[power] + alpha * 0.375 * even;
        }
        assert_moments(gn_moments_bias_fixed(single(b), (float)alpha), fixed, 3e-7, "bias", i);
        assert_moments(gn_moments_bias_float(single(b), (float)alpha), floating, 3e-7, "bias", i);
    }
}

/* Every number stays in [0,1] and comes near both ends; the inverse undoes it. */
static void test_affine_quantization(void **state)
{
    (void)state;
    uint32_t seed = 2;
    double low[4] = {1.0, 1.0, 1.0, 1.0}, high[4] = {0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < COUNT; i++) {
        const int count = 1 + i % MAX_SAMPLES;
        const distribution d = random_distribution(&seed, count, random_unit(&seed));
        double b[5];
        moments_of(&d, b);
        const gn_moments_fixed q = gn_moments_quantize(single(b));
        const double values[4] = {(double)q.q1, (double)q.q2, (double)q.q3, (double)q.q4};
        for (int k = 0; k < 4; k++) {
            if (!(values[k] >= -2e-7 && values[k] <= 1.0 + 2e-7))
                fail_msg("q%d of case %d is %.9g", k + 1, i, values[k]);
            low[k] = fmin(low[k], values[k]);
            high[k] = fmax(high[k], values[k]);
        }
        assert_moments(gn_moments_dequantize(q), b, 5e-7, "round trip", i);

        /* Through 16 bits: half a step times the largest row sum of the inverse. */
        const gn_moments_fixed coarse = {gn_unorm16_low(gn_unorm16_pack(q.q1, 0.0f)),
                                         gn_unorm16_low(gn_unorm16_pack(q.q2, 0.0f)),
                                         gn_unorm16_low(gn_unorm16_pack(q.q3, 0.0f)),
                                         gn_unorm16_low(gn_unorm16_pack(q.q4, 0.0f))};
        assert_moments(gn_moments_dequantize(coarse), b, 0.5 / 65535.0 * 2.07, "16 bits", i);
    }
    for (int k = 0; k < 4; k++)
        if (!(low[k] < 0.01 && high[k] > 0.99))
            fail_msg("q%d only covers [%g, %g]", k + 1, low[k], high[k]);
}

/* Section 3.2: of two depths, xi4 is 0 before the bias and 2.8e-4 after it at worst. */
static double biased_xi4(double z1, double z2, double weight)
{
    double b[5];
    equation_4((nonlinear){z1, z2, weight, 0.0}, b);
    for (int i = 1; i < 5; i++)
        b[i] = (1.0 - 6e-5) * b[i] + (i % 2 ? 0.0 : 6e-5 * 0.628);
    return algorithm_2(b).xi4;
}

static void test_worst_bias(void **state)
{
    (void)state;
    const double expected = biased_xi4(0.915, 1.0, 0.5);
    assert_close(expected, 2.8e-4, 0.05e-4, "printed xi4", 0);
    const gn_moments near = gn_moments_of(0.9575f), far = gn_moments_of(1.0f);
    const gn_moments mean = {0.5f * (near.b1 + far.b1), 0.5f * (near.b2 + far.b2),
                             0.5f * (near.b3 + far.b3), 0.5f * (near.b4 + far.b4)};
    const gn_nonlinear n = gn_nonlinear_of(gn_moments_bias_fixed(mean, 6e-5f));
    assert_close((double)n.xi4, expected, 2e-6, "xi4", 0);

    double worst = 0.0;
    for (int i = 0; i <= 200; i++)
        for (int k = 0; k < i; k++)
            for (int w = 1; w < 20; w++)
                worst = fmax(worst, biased_xi4(0.01 * k - 1.0, 0.01 * i - 1.0, 0.05 * w));
    assert_close(worst, expected, 0.01e-4, "largest xi4", 0);
}

/* Algorithm 2 against the printed one; Equation 4 gives the moments back. */
static void test_algorithm_2(void **state)
{
    (void)state;
    uint32_t seed = 3;
    for (int i = 0; i < COUNT; i++) {
        const int count = 2 + i % (MAX_SAMPLES - 1);
        const distribution d =
            random_distribution(&seed, count, pow(10.0, -3.0 * random_unit(&seed)));
        double b[5];
        moments_of(&d, b);
        const gn_moments biased = gn_moments_bias_float(single(b), 3e-7f);
        from_single(biased, b);
        const gn_nonlinear n = gn_nonlinear_of(biased);
        if (!(n.y1 >= -1.0f && n.y1 <= n.y2 && n.y2 <= 1.0f && n.v2 >= 0.0f && n.v2 <= 1.0f &&
              n.xi4 >= 0.0f && n.xi4 <= 0.25f))
            fail_msg("case %d gives %.9g %.9g %.9g %.9g", i, (double)n.y1, (double)n.y2,
                     (double)n.v2, (double)n.xi4);
        assert_moments(gn_nonlinear_moments(n), b, 6e-7, "round trip", i);
        if (b[2] - b[1] * b[1] > 0.01) { /* narrower ones differ by the rounding of b */
            const nonlinear expected = algorithm_2(b);
            assert_close((double)n.y1, expected.y1, 2e-4, "y1", i);
            assert_close((double)n.y2, expected.y2, 2e-4, "y2", i);
            assert_close((double)n.v2, expected.v2, 2e-4, "v2", i);
            assert_close((double)n.xi4, fmax(expected.xi4, 1.2e-7), 1e-6, "xi4", i);
        }
    }
}

/* 0 <= xi4 <= 0.25, and both are reached. */
static void test_range_of_xi4(void **state)
{
    (void)state;
    uint32_t seed = 4;
    double b[5];
    for (int i = 0; i < COUNT; i++) {
        const distribution d = random_distribution(&seed, 2 + i % (MAX_SAMPLES - 1), 1.0);
        moments_of(&d, b);
        if (b[2] - b[1] * b[1] < 1e-3)
            continue;
        const double xi4 = algorithm_2(b).xi4;
        if (!(xi4 >= -1e-10 && xi4 <= 0.25 + 1e-10))
            fail_msg("xi4 of case %d is %.12g", i, xi4);
        const gn_nonlinear n = gn_nonlinear_of(single(b));
        assert_close((double)n.xi4, fmax(xi4, 1.2e-7), 3e-6, "xi4", i);
    }
    const gn_nonlinear widest = gn_nonlinear_of((gn_moments){0.0f, 0.5f, 0.0f, 0.5f});
    assert_close((double)widest.xi4, 0.25, 1e-7, "xi4 of a quarter, a half and a quarter", 0);
    /* Moments that are none: still in range. */
    const gn_nonlinear wrong = gn_nonlinear_of((gn_moments){0.9f, 0.1f, -0.9f, 0.0f});
    assert_true(wrong.xi4 >= 0.0f && wrong.xi4 <= 0.25f && wrong.v2 >= 0.0f && wrong.v2 <= 1.0f);
}

/* One or two depths are reconstructed exactly: 1, the farther one's weight, 0. */
static void test_two_points(void **state)
{
    (void)state;
    uint32_t seed = 5;
    for (int i = 0; i < COUNT; i++) {
        distribution d = random_distribution(&seed, 2, 1.0);
        const int near = d.depth[0] < d.depth[1] ? 0 : 1;
        if (d.depth[1 - near] - d.depth[near] < 0.25f)
            continue;
        double b[5];
        moments_of(&d, b);
        const nonlinear exact = {2.0 * (double)d.depth[near] - 1.0,
                                 2.0 * (double)d.depth[1 - near] - 1.0, d.weight[1 - near], 0.0};
        const gn_nonlinear given = {(float)exact.y1, (float)exact.y2, (float)exact.v2, 0.0f};
        const gn_nonlinear made = gn_nonlinear_of(single(b));
        assert_close((double)made.y1, exact.y1, 2e-5, "y1", i);
        assert_close((double)made.y2, exact.y2, 2e-5, "y2", i);
        assert_close((double)made.v2, exact.v2, 2e-5, "v2", i);

        /* A hundredth of the range away from the steps. */
        const float places[] = {d.depth[near] - 0.01f, d.depth[near] + 0.01f,
                                0.5f * (d.depth[0] + d.depth[1]), d.depth[1 - near] - 0.01f,
                                d.depth[1 - near] + 0.01f};
        for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
            if (places[k] < 0.0f || places[k] > 1.0f)
                continue;
            const double expected = lit_share(&d, places[k]);
            assert_close((double)gn_nonlinear_visibility(given, places[k]), expected, 2e-6,
                         "Algorithm 3 of two depths", i);
            assert_close((double)gn_nonlinear_visibility(made, places[k]), expected, 0.01,
                         "Algorithms 2 and 3 of two depths", i);
            assert_close((double)gn_hamburger_visibility(single(b), places[k]), expected, 0.01,
                         "Hamburger of two depths", i);
        }
        /* Exactly on the steps: stored >= receiver. */
        assert_true(gn_nonlinear_visibility((gn_nonlinear){-0.5f, 0.5f, 0.25f, 0.0f}, 0.25f) ==
                    1.0f);
        assert_close(
            (double)gn_nonlinear_visibility((gn_nonlinear){-0.5f, 0.5f, 0.25f, 0.0f}, 0.75f), 0.25,
            1e-6, "the farther depth itself", i);
    }
}

/* Is a value between the oracle's at receivers a little nearer and a little farther? Steps may be
 * steep. */
static void assert_between(double value, double a, double b, double tolerance, const char *what,
                           int i)
{
    if (!(value >= fmin(a, b) - tolerance && value <= fmax(a, b) + tolerance))
        fail_msg("%s of case %d is %.9g, expected within %g of [%.9g, %.9g]", what, i, value,
                 tolerance, a, b);
}

static double random_in(uint32_t *seed, double low, double high)
{
    return low + (high - low) * random_unit(seed);
}

static void test_algorithm_3(void **state)
{
    (void)state;
    uint32_t seed = 6;
    for (int i = 0; i < COUNT; i++) {
        const float y1 = (float)random_in(&seed, -1.0, 0.9);
        const float y2 = (float)random_in(&seed, (double)y1 + 0.01, 1.0);
        const float v2 = (float)random_in(&seed, 0.001, 0.999);
        const float xi4 = (float)pow(10.0, random_in(&seed, -6.9, -0.7));
        const gn_nonlinear n = {y1, y2, v2, xi4};
        const nonlinear exact = {(double)y1, (double)y2, (double)v2, (double)xi4};
        const float receiver = (float)random_unit(&seed);
        const double z = 2.0 * (double)receiver - 1.0, shift = 4e-7;
        if (fabs(z - exact.y1) < 1e-3 || fabs(z - exact.y2) < 1e-3)
            continue; /* a root goes to infinity there, which Algorithm 1 does not take */
        double b[5];
        equation_4(exact, b);
        const double value = (double)gn_nonlinear_visibility(n, receiver);
        assert_between(value, algorithm_3(exact, z - shift), algorithm_3(exact, z + shift), 2e-6,
                       "Algorithm 3", i);
        assert_between(value, algorithm_1(b, z - shift), algorithm_1(b, z + shift), 1e-5,
                       "Algorithm 3 against Algorithm 1", i);
    }
}

static void test_hamburger(void **state)
{
    (void)state;
    uint32_t seed = 7;
    for (int i = 0; i < COUNT; i++) {
        const distribution d = random_distribution(&seed, 2 + i % (MAX_SAMPLES - 1), 1.0);
        double b[5];
        moments_of(&d, b);
        const gn_moments biased = gn_moments_bias_fixed(single(b), 6e-5f);
        from_single(biased, b);
        const nonlinear n = algorithm_2(b);
        const float receiver = (float)random_unit(&seed);
        const double z = 2.0 * (double)receiver - 1.0, shift = 1e-5;
        if (fabs(z - n.y1) < 1e-3 || fabs(z - n.y2) < 1e-3)
            continue;
        const double value = (double)gn_hamburger_visibility(biased, receiver);
        assert_between(value, algorithm_1(b, z - shift), algorithm_1(b, z + shift), 2e-3,
                       "Hamburger", i);
        assert_between(value, algorithm_3(n, z - shift), algorithm_3(n, z + shift), 2e-3,
                       "Hamburger against Algorithms 2 and 3", i);
        const double tighter = (double)gn_hausdorff_visibility(biased, receiver);
        if (!(tighter <= value + 1e-6))
            fail_msg("Hausdorff of case %d is %.9g, Hamburger %.9g", i, tighter, value);
    }
}

/* Whatever is read back, visibility is a number of [0,1]. */
static void test_any_moments(void **state)
{
    (void)state;
    uint32_t seed = 8;
    const float ends[] = {0.0f, 1.0f, -1.0f, 2.0f, 0.5f, -1e30f, 1e30f, INFINITY, -INFINITY};
    for (int i = 0; i < COUNT; i++) {
        const gn_moments m = {
            (float)random_in(&seed, -1.1, 1.1), (float)random_in(&seed, -0.1, 1.1),
            (float)random_in(&seed, -1.1, 1.1), (float)random_in(&seed, -0.1, 1.1)};
        const gn_moments flat = gn_moments_of((float)(i % 65536) / 65535.0f);
        const float receiver = i % 2 ? ends[i / 2 % 9] : (float)(i % 65536) / 65535.0f;
        const float values[] = {
            gn_hamburger_visibility(m, receiver),
            gn_hausdorff_visibility(m, receiver),
            gn_hamburger_visibility(flat, receiver),
            gn_hausdorff_visibility(flat, receiver),
            gn_nonlinear_visibility(gn_nonlinear_of(m), receiver),
            gn_nonlinear_visibility(gn_nonlinear_of(flat), receiver),
            gn_nonlinear_visibility((gn_nonlinear){m.b1, m.b1, (float)(i % 3) * 0.5f, m.b4 * m.b4},
                                    receiver),
            gn_nonlinear_visibility((gn_nonlinear){m.b1, m.b1, (float)(i % 2), 0.0f}, receiver)};
        for (size_t k = 0; k < sizeof values / sizeof *values; k++)
            if (!(values[k] >= 0.0f && values[k] <= 1.0f))
                fail_msg("function %zu of case %d is %g at %g", k, i, (double)values[k],
                         (double)receiver);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_powers_and_biases), cmocka_unit_test(test_affine_quantization),
        cmocka_unit_test(test_worst_bias),        cmocka_unit_test(test_algorithm_2),
        cmocka_unit_test(test_range_of_xi4),      cmocka_unit_test(test_two_points),
        cmocka_unit_test(test_algorithm_3),       cmocka_unit_test(test_hamburger),
        cmocka_unit_test(test_any_moments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
