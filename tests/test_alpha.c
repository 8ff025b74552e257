/* The alpha rules against the paper's formulas in double, accumulation against the product of the
 * paper, and the ramp against an integral by brute force. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <gnomon/shadow/alpha.h>

#define STEPS 1000

static float uniform(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return (float)(*state >> 8) * (1.0f / 16777216.0f);
}

static void assert_close(float value, double expected, double tolerance, const char *what, float x,
                         float y)
{
    if (!(fabs((double)value - expected) <= tolerance))
        fail_msg("%s(%.9g, %.9g) is %.9g, expected %.9g within %g", what, (double)x, (double)y,
                 (double)value, expected, tolerance);
}

static void test_rules(void **state)
{
    (void)state;
    for (int c = 1; c <= 20; c++) {
        const float cutoff = (float)c / 20.0f;
        float before[3] = {0.0f, 0.0f, 0.0f};
        for (int i = 0; i <= STEPS; i++) {
            const float a = (float)i / STEPS;
            const float values[3] = {gn_alpha_raw(a), gn_alpha_test(a, cutoff),
                                     gn_alpha_saturate(a, cutoff)};
            assert_true(values[0] == a);
            assert_true(values[1] == (a >= cutoff ? 1.0f : 0.0f));
            assert_close(values[2], fmin((double)a / (double)cutoff, 1.0), 1e-7, "saturate", a,
                         cutoff);
            for (int rule = 0; rule < 3; rule++) {
                assert_true(values[rule] >= before[rule] && values[rule] <= 1.0f);
                before[rule] = values[rule];
            }
            /* Saturate never lets more light through than raw or the test. */
            assert_true(values[2] >= values[0] && values[2] >= values[1]);
        }
        assert_true(before[1] == 1.0f && before[2] == 1.0f);
    }
    /* The paper's min(2 alpha, 1). */
    for (int i = 0; i <= STEPS; i++) {
        const float a = (float)i / STEPS;
        assert_true(gn_alpha_saturate(a, 0.5f) == fminf(2.0f * a, 1.0f));
    }
    assert_true(gn_alpha_test(0.5f, 0.5f) == 1.0f);
    assert_true(gn_alpha_test(nextafterf(0.5f, 0.0f), 0.5f) == 0.0f);
}

/* Share of a square footprint, one side along the gradient, where alpha passes. */
static double integrate_ramp(double alpha, double cutoff, double slope, double footprint)
{
    const int samples = 20000;
    int passing = 0;
    for (int i = 0; i < samples; i++) {
        const double along = ((i + 0.5) / samples - 0.5) * footprint;
        passing += alpha + slope * along >= cutoff;
    }
    return (double)passing / samples;
}

static void test_ramp(void **state)
{
    (void)state;
    uint32_t seed = 1;
    for (int i = 0; i < 2000; i++) {
        const float alpha = uniform(&seed), cutoff = 0.05f + 0.95f * uniform(&seed);
        const float slope = 0.001f + uniform(&seed), footprint = 0.01f + uniform(&seed);
        const float share = gn_alpha_ramp(alpha, cutoff, slope, footprint);
        const double expected =
            integrate_ramp((double)alpha, (double)cutoff, (double)slope, (double)footprint);
        /* One sample, and alpha's own rounding as seen by the slope. */
        const double tolerance = 1.0 / 20000 + 1.2e-7 / (double)(slope * footprint);
        assert_close(share, expected, tolerance, "ramp", alpha, cutoff);
        assert_true(gn_alpha_ramp(alpha * 0.99f, cutoff, slope, footprint) <= share);
        assert_true(share >= 0.0f && share <= 1.0f);
    }
    /* Half of the footprint passes where alpha meets the cutoff. */
    assert_true(gn_alpha_ramp(0.5f, 0.5f, 0.3f, 0.2f) == 0.5f);
    /* Constant alpha is tested, the cutoff itself passing: a cutoff of 1 keeps what is opaque. */
    for (int i = 0; i <= STEPS; i++) {
        const float a = (float)i / STEPS;
        assert_true(gn_alpha_ramp(a, 1.0f, 0.0f, 0.5f) == (a >= 1.0f ? 1.0f : 0.0f));
        assert_true(gn_alpha_ramp(a, 0.5f, 0.0f, 0.5f) == gn_alpha_test(a, 0.5f));
    }
}

static void test_rescale(void **state)
{
    (void)state;
    for (int c = 0; c < 100; c += 3) {
        const float cutoff = (float)c / 100.0f;
        float before = 0.0f;
        assert_true(gn_visibility_rescale(cutoff, cutoff) == 0.0f);
        assert_true(gn_visibility_rescale(0.0f, cutoff) == 0.0f);
        assert_true(gn_visibility_rescale(1.0f, cutoff) == 1.0f);
        for (int i = 0; i <= STEPS; i++) {
            const float v = (float)i / STEPS;
            const float value = gn_visibility_rescale(v, cutoff);
            const double formula = ((double)v - (double)cutoff) / (1.0 - (double)cutoff);
            assert_close(value, fmin(fmax(formula, 0.0), 1.0), 2e-7, "rescale", v, cutoff);
            assert_true(value >= before);
            before = value;
        }
    }
}

/* Opacities as rules make them: some nothing, some whole, the rest in between. */
static float random_opacity(uint32_t *seed, float strength)
{
    const float kind = uniform(seed);
    return kind < 0.1f ? 0.0f : kind < 0.12f ? 1.0f : strength * uniform(seed);
}

static void test_accumulation(void **state)
{
    (void)state;
    uint32_t seed = 7;
    for (int run = 0; run < 20000; run++) {
        const int count = 1 + (int)(64.0f * uniform(&seed));
        const float strength = run % 3 == 0 ? 1.0f : run % 3 == 1 ? 0.3f : 0.02f;
        float opacities[65];
        double product = 1.0;
        float plain = 1.0f;
        int32_t depth = 0;
        int opaque = 0;
        for (int i = 0; i < count; i++) {
            opacities[i] = random_opacity(&seed, strength);
            product *= 1.0 - (double)opacities[i];
            plain = gn_visibility_accumulate(plain, opacities[i]);
            depth += gn_optical_depth(opacities[i]);
            opaque += opacities[i] > 1.0f - 0x1p-16f;
        }
        const float visibility = gn_optical_visibility(depth);

        /* A depth is rounded to a whole number of 1/16384 halvings, after a logarithm and a product
         * that are right to 1/20 of one: 0.55 ln 2 / 16384 < 2.4e-5 an occluder, relative. A whole
         * opaque one counts as 2^-16. Below 2^-126 the exponential is clamped. */
        const double bound =
            product * (expm1(2.4e-5 * count) + 3e-7) + (opaque ? 0x1p-16 : 0.0) + 0x1p-126;
        assert_close(visibility, product, bound, "visibility", (float)count, strength);
        assert_close(plain, product, product * 1.2e-7 * (count + 1) + 1e-37, "accumulate",
                     (float)count, strength);

        /* Any order, the same bits. */
        for (int i = count - 1; i > 0; i--) {
            const int j = (int)((float)(i + 1) * uniform(&seed));
            const float swapped = opacities[i];
            opacities[i] = opacities[j];
            opacities[j] = swapped;
        }
        int32_t shuffled = 0;
        for (int i = 0; i < count; i++)
            shuffled += gn_optical_depth(opacities[i]);
        assert_int_equal(shuffled, depth);
    }
}

static void test_optical_depth(void **state)
{
    (void)state;
    assert_int_equal(gn_optical_depth(0.0f), 0);
    assert_int_equal(gn_optical_depth(0.5f), (int)GN_OPTICAL_HALVING);
    assert_int_equal(gn_optical_depth(0.75f), (int)(2.0f * GN_OPTICAL_HALVING));
    assert_true(gn_optical_visibility(0) == 1.0f);
    int32_t before = 0;
    float most = 1.0f;
    for (int i = 0; i <= 100000; i++) {
        const int32_t depth = gn_optical_depth((float)i / 100000.0f);
        assert_true(depth >= before);
        assert_true(gn_optical_visibility(depth) <= most);
        before = depth;
        most = gn_optical_visibility(depth);
    }
    /* A wholly opaque occluder is the most; 4096 of them are still a 32-bit sum, and dark. */
    assert_int_equal(before, (int)(16.0f * GN_OPTICAL_HALVING));
    int64_t sum = 0;
    for (int i = 0; i < 4096; i++)
        sum += before;
    assert_true(sum <= 1 << 30);
    const float visibility = gn_optical_visibility((int32_t)sum);
    assert_true(visibility >= 0.0f && visibility <= 0x1p-126f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rules),         cmocka_unit_test(test_ramp),
        cmocka_unit_test(test_rescale),       cmocka_unit_test(test_accumulation),
        cmocka_unit_test(test_optical_depth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
