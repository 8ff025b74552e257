/* Every filterable shadow test is an upper bound of the light that percentage-closer filtering
 * finds, and the inequalities behind them are sharp: linear programs over distributions with the
 * same moments reach them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <gnomon/shadow/depth.h>
#include <gnomon/shadow/exponential.h>
#include <gnomon/shadow/moments.h>
#include <gnomon/shadow/moments_nonlinear.h>
#include <gnomon/shadow/texel.h>
#include <gnomon/shadow/variance.h>

#include "distribution_testing.h"
#include "linear_program.h"

#define COUNT 150000

/* Filters: sums in single precision, as of a map ------------------------------------------------*/

static gn_variance mean_variance(const distribution *d, gn_variance (*of)(float, float), float c)
{
    gn_variance sum = {0};
    for (int i = 0; i < d->count; i++) {
        const gn_variance v = of(d->depth[i], c);
        sum.mean += (float)d->weight[i] * v.mean;
        sum.square += (float)d->weight[i] * v.square;
    }
    return sum;
}

static gn_variance variance_of(float depth, float unused)
{
    (void)unused;
    return gn_variance_of(depth);
}

static gn_evsm mean_evsm(const distribution *d, float c_positive, float c_negative)
{
    gn_evsm sum = {0};
    for (int i = 0; i < d->count; i++) {
        const gn_evsm v = gn_evsm_of(d->depth[i], c_positive, c_negative);
        sum.positive += (float)d->weight[i] * v.positive;
        sum.positive_square += (float)d->weight[i] * v.positive_square;
        sum.negative += (float)d->weight[i] * v.negative;
        sum.negative_square += (float)d->weight[i] * v.negative_square;
    }
    return sum;
}

static gn_moments mean_moments(const distribution *d)
{
    gn_moments sum = {0};
    for (int i = 0; i < d->count; i++) {
        const gn_moments m = gn_moments_of(d->depth[i]);
        sum.b1 += (float)d->weight[i] * m.b1;
        sum.b2 += (float)d->weight[i] * m.b2;
        sum.b3 += (float)d->weight[i] * m.b3;
        sum.b4 += (float)d->weight[i] * m.b4;
    }
    return sum;
}

/* Maps -------------------------------------------------------------------------------------------
 * One for each format: filters, quantizes, reads back, and tests. */

static float read_pcf(const distribution *d, float receiver)
{
    float sum = 0.0f;
    for (int i = 0; i < d->count; i++)
        sum += (float)d->weight[i] * gn_depth_test(d->depth[i], receiver);
    return sum;
}

static float read_vsm(const distribution *d, float receiver)
{
    return gn_vsm_visibility(mean_variance(d, variance_of, 0.0f), 1e-6f, receiver);
}

static float read_vsm32(const distribution *d, float receiver)
{
    const gn_variance v = mean_variance(d, variance_of, 0.0f);
    const uint32_t word = gn_unorm16_pack(v.mean, v.square);
    return gn_vsm_visibility((gn_variance){gn_unorm16_low(word), gn_unorm16_high(word)}, 3e-5f,
                             receiver);
}

static float read_evsm40(const distribution *d, float receiver)
{
    return gn_evsm_visibility(mean_evsm(d, 40.0f, 5.5f), 40.0f, 5.5f, 1e-8f, receiver);
}

static float read_evsm20(const distribution *d, float receiver)
{
    return gn_evsm_visibility(mean_evsm(d, 20.0f, 5.0f), 20.0f, 5.0f, 1e-8f, receiver);
}

static float read_evsm_positive(const distribution *d, float receiver)
{
    const gn_variance v = mean_variance(d, gn_evsm_positive_of, 40.0f);
    return gn_evsm_positive_visibility(v, 40.0f, 1e-10f, receiver);
}

static float read_evsm64(const distribution *d, float receiver)
{
    const gn_evsm v = mean_evsm(d, 5.5f, 5.5f);
    const uint32_t positive = gn_half_pack(v.positive, v.positive_square);
    const uint32_t negative = gn_half_pack(v.negative, v.negative_square);
    const gn_evsm back = {gn_half_low(positive), gn_half_high(positive), gn_half_low(negative),
                          gn_half_high(negative)};
    return gn_evsm_visibility(back, 5.5f, 5.5f, 3e-5f, receiver);
}

static float read_esm(const distribution *d, float receiver)
{
    float sum = 0.0f;
    for (int i = 0; i < d->count; i++)
        sum += (float)d->weight[i] * gn_esm_of(d->depth[i], 80.0f);
    return gn_esm_visibility(sum, 80.0f, receiver);
}

static float read_msm64(const distribution *d, float receiver)
{
    const gn_moments_fixed q = gn_moments_quantize(gn_moments_bias_fixed(mean_moments(d), 6e-5f));
    const uint32_t low = gn_unorm16_pack(q.q1, q.q2), high = gn_unorm16_pack(q.q3, q.q4);
    const gn_moments_fixed back = {gn_unorm16_low(low), gn_unorm16_high(low), gn_unorm16_low(high),
                                   gn_unorm16_high(high)};
    return gn_hamburger_visibility(gn_moments_dequantize(back), receiver);
}

static float read_msm128(const distribution *d, float receiver)
{
    return gn_hamburger_visibility(gn_moments_bias_float(mean_moments(d), 1e-6f), receiver);
}

static float read_hausdorff(const distribution *d, float receiver)
{
    return gn_hausdorff_visibility(gn_moments_bias_float(mean_moments(d), 1e-5f), receiver);
}

static gn_nonlinear mean_nonlinear(const distribution *d)
{
    return gn_nonlinear_of(gn_moments_bias_float(mean_moments(d), 1e-6f));
}

static float read_nonlinear(const distribution *d, float receiver)
{
    return gn_nonlinear_visibility(mean_nonlinear(d), receiver);
}

/* With a depth bias: rounded depths and weights move the steps. */
static float read_nlmsm64(const distribution *d, float receiver)
{
    const gn_nonlinear_words words = gn_nonlinear_pack64(mean_nonlinear(d));
    return gn_nonlinear_visibility(gn_nonlinear_unpack64(words.low, words.high), receiver - 0.001f);
}

static float read_nlmsm32(const distribution *d, float receiver)
{
    return gn_nonlinear_visibility(gn_nonlinear_unpack32(gn_nonlinear_pack32(mean_nonlinear(d))),
                                   receiver - 0.004f);
}

typedef struct map {
    const char *name;
    float (*read)(const distribution *d, float receiver);
    double error; /* visibility >= truth - error */
} map;

static const map maps[] = {
    {"pcf", read_pcf, 1e-6},
    {"vsm 64", read_vsm, 1e-6},
    {"vsm 32", read_vsm32, 1e-5},
    {"evsm 128, 40 and 5.5", read_evsm40, 1e-6},
    {"evsm 128, 20 and 5", read_evsm20, 1e-6},
    {"evsm 64, one-sided", read_evsm_positive, 1e-6},
    {"evsm 64, 5.5 and 5.5", read_evsm64, 3e-3},
    {"esm", read_esm, 1e-6},
    {"msm 64", read_msm64, 1e-4},
    {"msm 128", read_msm128, 3e-6},
    {"msm 128, hausdorff", read_hausdorff, 1e-3},
    {"nonlinear", read_nonlinear, 3e-6},
    {"nlmsm 64", read_nlmsm64, 0.03},
    {"nlmsm 32", read_nlmsm32, 0.25},
};
#define MAPS (sizeof maps / sizeof *maps)

static void test_bounds(void **state)
{
    (void)state;
    uint32_t seed = 1;
    for (int i = 0; i < COUNT; i++) {
        const int count = 2 + i % (MAX_SAMPLES - 1);
        const double width = i % 4 ? pow(10.0, -4.0 * random_unit(&seed)) : 1.0;
        const distribution d = random_distribution(&seed, count, width);
        const float receiver = random_receiver(&seed, &d);
        const double truth = lit_share(&d, receiver);
        for (size_t k = 0; k < MAPS; k++) {
            const double visibility = (double)maps[k].read(&d, receiver);
            if (!(visibility >= truth - maps[k].error && visibility <= 1.0 + 1e-6))
                fail_msg("%s lights %.9g of case %d (%d samples, width %.3g, receiver %.9g), the "
                         "truth is %.9g",
                         maps[k].name, visibility, i, count, width, (double)receiver, truth);
        }
    }
}

/* The paper's bias of 3e-7 is of the size of the sums' own rounding: rare cases fall short. */
static void test_smallest_moment_bias(void **state)
{
    (void)state;
    uint32_t seed = 2;
    int hamburger = 0, nonlinear = 0;
    for (int i = 0; i < COUNT; i++) {
        const double width = pow(10.0, -3.5 * random_unit(&seed));
        const distribution d = random_distribution(&seed, 2 + i % (MAX_SAMPLES - 1), width);
        const float receiver = random_receiver(&seed, &d);
        const double least = lit_share(&d, receiver) - 1e-3;
        const gn_moments biased = gn_moments_bias_float(mean_moments(&d), 3e-7f);
        hamburger += (double)gn_hamburger_visibility(biased, receiver) < least;
        nonlinear += (double)gn_nonlinear_visibility(gn_nonlinear_of(biased), receiver) < least;
    }
    if (hamburger > COUNT / 2000 || nonlinear > COUNT / 2000)
        fail_msg("%d and %d of %d cases are darker than the truth by more than 1e-3", hamburger,
                 nonlinear, COUNT);
}

/* Receivers at and beyond the ends of the depth range, and maps of one depth. */
static void test_ends(void **state)
{
    (void)state;
    const float receivers[] = {0.0f, 1.0f, -0.0f, -1.0f, 1.5f, -1e20f, 1e20f};
    for (int i = 0; i <= 256; i++) {
        const distribution d = {.count = 1, .depth = {(float)i / 256.0f}, .weight = {1.0}};
        for (size_t k = 0; k < MAPS; k++)
            for (size_t r = 0; r < sizeof receivers / sizeof *receivers; r++) {
                const double visibility = (double)maps[k].read(&d, receivers[r]);
                const double truth = lit_share(&d, receivers[r]);
                if (!(visibility >= truth - maps[k].error && visibility <= 1.0 + 1e-6))
                    fail_msg("%s lights %.9g of depth %.9g at %g", maps[k].name, visibility,
                             (double)d.depth[0], (double)receivers[r]);
            }
    }
}

/* Flat surfaces do not shadow themselves, wherever they lie: at the surface's own depth and a few
 * roundings behind it. A minimum variance that is not scaled to the warped space would not do. */
static void test_no_acne(void **state)
{
    (void)state;
    double unscaled = 1.0;
    for (int i = 0; i <= 4096; i++) {
        distribution d = {.count = 9};
        for (int k = 0; k < 9; k++) {
            d.depth[k] = (float)i / 4096.0f;
            d.weight[k] = 0.06 + 0.0125 * (double)k; /* sums to 0.99: filters round, too */
        }
        for (int k = 0; k < 9; k++)
            d.weight[k] /= 0.99;
        const float receiver = fminf(d.depth[0] + 2e-7f, 1.0f);
        const gn_evsm v = mean_evsm(&d, 40.0f, 5.5f);
        const double visibility = (double)gn_evsm_visibility(v, 40.0f, 5.5f, 1e-8f, receiver);
        const double positive = (double)gn_evsm_positive_visibility(
            (gn_variance){v.positive, v.positive_square}, 40.0f, 1e-10f, receiver);
        const double vsm = (double)read_vsm(&d, receiver);
        if (!(visibility > 0.999 && positive > 0.999 && vsm > 0.999))
            fail_msg("a surface at %.9g lights itself by %.9g (EVSM), %.9g (one-sided), %.9g (VSM)",
                     (double)d.depth[0], visibility, positive, vsm);
        const float warped = gn_exponential_warp(receiver, 40.0f);
        unscaled =
            fmin(unscaled, (double)gn_chebyshev(v.positive, v.positive_square, 1e-10f, warped));
    }
    if (!(unscaled < 0.5))
        fail_msg("an unscaled minimum variance would do: %.9g", unscaled);
}

/* The same for moments, with the paper's smallest bias as well. */
static void test_no_acne_of_moments(void **state)
{
    (void)state;
    for (int i = 0; i <= 4096; i++) {
        distribution d = {.count = 9};
        for (int k = 0; k < 9; k++) {
            d.depth[k] = (float)i / 4096.0f;
            d.weight[k] = (0.06 + 0.0125 * (double)k) / 0.99;
        }
        const float receiver = fminf(d.depth[0] + 2e-7f, 1.0f);
        const gn_moments biased = gn_moments_bias_float(mean_moments(&d), 3e-7f);
        const double hamburger = (double)gn_hamburger_visibility(biased, receiver);
        const double nonlinear = (double)gn_nonlinear_visibility(gn_nonlinear_of(biased), receiver);
        const double affine = (double)read_msm64(&d, receiver);
        const double coarse = (double)read_nlmsm64(&d, receiver);
        const double coarsest = (double)read_nlmsm32(&d, receiver);
        if (!(hamburger > 0.999 && nonlinear > 0.999 && affine > 0.999 && coarse > 0.999 &&
              coarsest > 0.999))
            fail_msg("a surface at %.9g lights itself by %.9g (MSM 128), %.9g (non-linear), %.9g "
                     "(MSM 64), %.9g (NLMSM 64), %.9g (NLMSM 32)",
                     (double)d.depth[0], hamburger, nonlinear, affine, coarse, coarsest);
    }
}

/* Cantelli's inequality in double, receivers right behind the mean included. */
static void test_chebyshev(void **state)
{
    (void)state;
    uint32_t seed = 5;
    for (int i = 0; i < COUNT; i++) {
        const float mean = (float)random_unit(&seed);
        const float variance = (float)pow(10.0, -6.0 * random_unit(&seed));
        const float distance = (float)(pow(10.0, -4.0 * random_unit(&seed)) - 1e-3);
        const float square = mean * mean + variance, receiver = mean + distance;
        const double v = (double)square - (double)mean * (double)mean + 1e-6;
        const double d = (double)receiver - (double)mean;
        const double expected = d > 0.0 ? v / (v + d * d) : 1.0;
        const double value = (double)gn_chebyshev(mean, square, 1e-6f, receiver);
        if (!(fabs(value - expected) <= 1e-6 + 0.25 * 1.2e-7 / v))
            fail_msg("Chebyshev of %.9g, %.9g at %.9g is %.9g, expected %.9g", (double)mean,
                     (double)square, (double)receiver, value, expected);
    }
}

/* The largest exponents stay in their formats (leak tracing paper's 42 and 84, 5.5 for halves). */
static void test_exponents(void **state)
{
    (void)state;
    assert_true(isfinite(gn_evsm_of(1.0f, 42.0f, 42.0f).positive_square));
    assert_true(gn_evsm_of(1.0f, 42.0f, 42.0f).negative_square > 1e-37f);
    assert_true(isfinite(gn_esm_of(1.0f, 84.0f)) && gn_esm_of(0.0f, 84.0f) > 1e-37f);
    const float square = gn_evsm_of(1.0f, 5.5f, 5.5f).positive_square;
    assert_true(square > 59800.0f && square < 65504.0f);
    for (int i = 0; i <= 1000; i++) {
        const float depth = (float)i / 1000.0f;
        for (int c = -84; c <= 84; c++) {
            const double exact = exp((double)c * (2.0 * (double)depth - 1.0));
            const double value = (double)gn_exponential_warp(depth, (float)c);
            if (!(fabs(value - exact) <= (1.7e-7 * fabs((double)c) + 3e-7) * exact))
                fail_msg("the warp of %.9g by %d is %.9g, expected %.9g", (double)depth, c, value,
                         exact);
        }
    }
}

/* Sharpness -------------------------------------------------------------------------------------*/

static double z_of(float depth)
{
    return 2.0 * (double)depth - 1.0;
}

/* The samples, the receiver and a fine net. stretch: 0 for [-1,1], else dense there and reaching
 * 0.5 sinh(stretch). */
static int lay_places(const distribution *d, float receiver, double stretch, double *places)
{
    int count = 0;
    for (int i = 0; i < d->count; i++)
        places[count++] = z_of(d->depth[i]);
    places[count++] = z_of(receiver);
    for (int i = -1000; i <= 1000; i++)
        places[count++] = stretch > 0.0 ? 0.5 * sinh(stretch * i / 1000.0) : i / 1000.0;
    return count;
}

static void assert_sharp(const char *name, double visibility, double light, double tolerance, int i)
{
    if (!(fabs(visibility - light) <= tolerance))
        fail_msg("%s of case %d is %.9g, a distribution with these moments lights %.9g", name, i,
                 visibility, light);
}

static void test_chebyshev_and_hamburger_are_sharp(void **state)
{
    (void)state;
    static double places[LP_PLACES];
    uint32_t seed = 3;
    int sharp = 0;
    for (int i = 0; i < 300; i++) {
        const distribution d = random_distribution(&seed, 3 + i % (MAX_SAMPLES - 2), 1.0);
        const float receiver = (float)random_unit(&seed);
        double b[5];
        for (int k = 0; k < 5; k++)
            b[k] = moment_of(&d, k);
        const int count = lay_places(&d, receiver, 5.0, places);
        /* Where it is 1 nearly, the sharp distribution reaches further than the net. */
        const double vsm =
            (double)gn_vsm_visibility(mean_variance(&d, variance_of, 0.0f), 0.0f, receiver);
        if (vsm < 0.99 && b[2] - b[1] * b[1] > 1e-3)
            assert_sharp("Chebyshev", vsm, most_light(3, b, count, places, z_of(receiver)), 1e-3,
                         i);

        const double variance = b[2] - b[1] * b[1], third = b[3] - b[1] * b[2];
        const double xi4 = b[4] - b[2] * b[2] - third * third / variance;
        if (variance < 0.05 || xi4 < 1e-3)
            continue; /* steps, which a net does not hit */
        const gn_moments m = mean_moments(&d);
        assert_sharp("Hamburger", (double)gn_hamburger_visibility(m, receiver),
                     most_light(5, b, count, places, z_of(receiver)), 3e-3, i);
        assert_sharp("Algorithm 3", (double)gn_nonlinear_visibility(gn_nonlinear_of(m), receiver),
                     (double)gn_hamburger_visibility(m, receiver), 1e-4, i);
        const int inside = lay_places(&d, receiver, 0.0, places);
        assert_sharp("Hausdorff", (double)gn_hausdorff_visibility(m, receiver),
                     most_light(5, b, inside, places, z_of(receiver)), 3e-3, i);
        sharp++;
    }
    assert_true(sharp > 150);
}

/* Markov's inequality, over distributions of the warped depth on [0, infinity). */
static void test_markov_is_sharp(void **state)
{
    (void)state;
    static double places[LP_PLACES];
    uint32_t seed = 4;
    for (int i = 0; i < 300; i++) {
        const distribution d = random_distribution(&seed, 2 + i % (MAX_SAMPLES - 1), 1.0);
        const float receiver = (float)random_unit(&seed),
                    c = 1.0f + 4.0f * (float)random_unit(&seed);
        double b[2] = {1.0, 0.0};
        float moment = 0.0f;
        int count = 0;
        for (int k = 0; k < d.count; k++) {
            places[count++] = exp((double)c * z_of(d.depth[k]));
            b[1] += d.weight[k] * places[count - 1];
            moment += (float)d.weight[k] * gn_esm_of(d.depth[k], c);
        }
        const double warped = exp((double)c * z_of(receiver));
        places[count++] = warped;
        places[count++] = 0.0;
        for (int k = 0; k <= 1000; k++)
            places[count++] = 1.5 * exp((double)c) * k / 1000.0;
        assert_sharp("Markov", (double)gn_esm_visibility(moment, c, receiver),
                     most_light(2, b, count, places, warped), 1e-5, i);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_smallest_moment_bias),
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_no_acne),
        cmocka_unit_test(test_no_acne_of_moments),
        cmocka_unit_test(test_chebyshev),
        cmocka_unit_test(test_exponents),
        cmocka_unit_test(test_chebyshev_and_hamburger_are_sharp),
        cmocka_unit_test(test_markov_is_sharp),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
