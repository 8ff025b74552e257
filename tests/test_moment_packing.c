/* The warp of xi4 and both packings of non-linear moments over their whole range. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/shadow/moments_nonlinear.h>

#include "bits_testing.h"
#include "distribution_testing.h"

/* Section 3.3, as printed. */
static double psi4(double xi4)
{
    const double low = log(log(1.2)), high = log(log(0.25e7));
    return (log(log(fmax(1.2e-7, xi4) * 1e7)) - low) / (high - low);
}

static double psi4_inverse(double warped)
{
    const double low = log(log(1.2)), high = log(log(0.25e7));
    return exp(exp(low + warped * (high - low))) * 1e-7;
}

static void test_log2_polynomial(void **state)
{
    (void)state;
    double worst = 0.0;
    for (uint32_t bits = 0x00800000u; bits < 0x7f800000u; bits += 1021) {
        const float x = from_bits(bits);
        worst = fmax(worst, fabs((double)gn_log2_polynomial(x) - log2((double)x)));
    }
    for (uint32_t bits = to_bits(0.25f); bits < to_bits(32.0f); bits += 13) {
        const float x = from_bits(bits);
        const double error = fabs((double)gn_log2_polynomial(x) - log2((double)x));
        if (!(error < 3.2e-6))
            fail_msg("log2 %.9g is wrong by %g", (double)x, error);
    }
    if (!(worst < 1e-5)) /* an exponent of 127 has a last place of 7.6e-6 */
        fail_msg("log2 is wrong by %g", worst);
}

static void test_warp(void **state)
{
    (void)state;
    float highest = 0.0f;
    for (uint32_t bits = to_bits(1.2e-7f); bits <= to_bits(0.25f); bits += 31) {
        const float xi4 = from_bits(bits), warped = gn_xi4_warp(xi4);
        const double error = fabs((double)warped - psi4((double)xi4));
        if (!(error < 2.2e-6))
            fail_msg("the warp of %.9g is %.9g, wrong by %g", (double)xi4, (double)warped, error);
        if (!(warped >= highest))
            fail_msg("the warp falls from %.9g to %.9g at %.9g", (double)highest, (double)warped,
                     (double)xi4);
        highest = fmaxf(highest, warped);
    }
    assert_true(gn_xi4_warp(0.25f) == 1.0f || gn_xi4_warp(0.25f) >= 0.999996f);
    const float low[] = {0.0f, -1.0f, 1e-9f, 1.2e-7f, -INFINITY, NAN};
    for (size_t i = 0; i < sizeof low / sizeof *low; i++)
        if (!(gn_xi4_warp(low[i]) <= 4e-6f && gn_xi4_warp(low[i]) >= 0.0f))
            fail_msg("the warp of %g is %g", (double)low[i], (double)gn_xi4_warp(low[i]));
    assert_true(gn_xi4_warp(7.0f) <= 1.0f && gn_xi4_warp(7.0f) >= 0.999996f);
}

/* All 65536 codes: strictly increasing, near the exact inverse, and they come back. */
static void test_unwarp(void **state)
{
    (void)state;
    float before = 0.0f;
    for (uint32_t code = 0; code <= 65535; code++) {
        const float warped = gn_unorm16_low(code), xi4 = gn_xi4_unwarp(warped);
        const double exact = psi4_inverse((double)warped);
        if (!(fabs((double)xi4 - exact) < 1e-5 * exact))
            fail_msg("code %u gives %.9g, expected %.9g", code, (double)xi4, exact);
        if (!(xi4 > before))
            fail_msg("code %u gives %.9g, the one before %.9g", code, (double)xi4, (double)before);
        before = xi4;
        if (gn_unorm16_code(gn_xi4_warp(xi4)) != code)
            fail_msg("code %u comes back as %u", code, gn_unorm16_code(gn_xi4_warp(xi4)));
    }
}

static void assert_near(gn_nonlinear n, gn_nonlinear expected, double y, double v2)
{
    if (!(fabs((double)n.y1 - (double)expected.y1) <= y &&
          fabs((double)n.y2 - (double)expected.y2) <= y &&
          fabs((double)n.v2 - (double)expected.v2) <= v2))
        fail_msg("%.9g %.9g %.9g come back as %.9g %.9g %.9g", (double)expected.y1,
                 (double)expected.y2, (double)expected.v2, (double)n.y1, (double)n.y2,
                 (double)n.v2);
}

/* Values of the whole range, every corner among them. */
static gn_nonlinear random_nonlinear(uint32_t *seed)
{
    const float ends[] = {-1.0f, 1.0f, 0.0f, -0.00097752f, 0.00097752f};
    float y[2];
    for (int i = 0; i < 2; i++)
        y[i] = random_unit(seed) < 0.2 ? ends[(int)(random_unit(seed) * 5.0)]
                                       : 2.0f * (float)random_unit(seed) - 1.0f;
    if (random_unit(seed) < 0.1)
        y[1] = y[0];
    const double v = random_unit(seed);
    const float v2 = v < 0.1 ? 0.0f : v < 0.2 ? 1.0f : (float)random_unit(seed);
    const double x = random_unit(seed);
    const float xi4 = x < 0.1 ? 0.0f : x < 0.2 ? 0.25f : (float)psi4_inverse(random_unit(seed));
    return (gn_nonlinear){fminf(y[0], y[1]), fmaxf(y[0], y[1]), v2, xi4};
}

static void test_64_bits(void **state)
{
    (void)state;
    uint32_t seed = 1;
    for (int i = 0; i < 500000; i++) {
        const gn_nonlinear n = random_nonlinear(&seed);
        const gn_nonlinear_words words = gn_nonlinear_pack64(n);
        const gn_nonlinear back = gn_nonlinear_unpack64(words.low, words.high);
        assert_near(back, n, 1.0 / 65535.0 + 2e-7, 0.5 / 65535.0 + 1e-7);
        assert_true(back.y1 <= back.y2 && back.y1 >= -1.0f && back.y2 <= 1.0f);
        const double warped = psi4((double)back.xi4), expected = psi4((double)n.xi4);
        if (!(fabs(warped - expected) <= 0.5 / 65535.0 + 2.2e-6 + 2e-6))
            fail_msg("xi4 %.9g comes back as %.9g", (double)n.xi4, (double)back.xi4);
        const gn_nonlinear_words again = gn_nonlinear_pack64(back);
        if (again.low != words.low || again.high != words.high)
            fail_msg("%08x %08x come back as %08x %08x", words.low, words.high, again.low,
                     again.high);
    }
    for (uint32_t code = 0; code <= 65535; code++) {
        const uint32_t low = code | code << 16, high = code | (65535u - code) << 16;
        const gn_nonlinear_words words = gn_nonlinear_pack64(gn_nonlinear_unpack64(low, high));
        if (words.low != low || words.high != high)
            fail_msg("%08x %08x come back as %08x %08x", low, high, words.low, words.high);
    }
    const gn_nonlinear_words corner = gn_nonlinear_pack64((gn_nonlinear){-1.0f, 1.0f, 1.0f, 0.0f});
    assert_int_equal(corner.low, 0xffff0000u);
    assert_int_equal(corner.high, 0x0000ffffu);
    const gn_nonlinear back = gn_nonlinear_unpack64(corner.low, corner.high);
    assert_true(back.y1 == -1.0f && back.y2 == 1.0f && back.v2 == 1.0f);
}

/* Section 3.5 in integers: the pair's two numbers. */
static void fold(uint32_t y1, uint32_t y2, uint32_t *first, uint32_t *second)
{
    *first = y1 >= 512 ? 1023 - y1 : y1;
    *second = y1 >= 512 ? 1022 - y2 : y2;
}

/* Every pair of integers, where they are read back and at both ends of their steps. */
static void test_32_bit_depths(void **state)
{
    (void)state;
    uint8_t *used = calloc(1u << 19, 1);
    assert_non_null(used);
    uint32_t pairs = 0;
    for (uint32_t y1 = 0; y1 <= 1022; y1++)
        for (uint32_t y2 = y1; y2 <= 1022; y2++) {
            const double place = (double)((y1 * 7 + y2) % 101) / 101.0 * 0.998 + 0.001;
            const gn_nonlinear n = {(float)(((double)y1 + place) / 511.5 - 1.0),
                                    (float)(((double)y2 + place) / 511.5 - 1.0), 0.5f, 1e-5f};
            const uint32_t word = gn_nonlinear_pack32(n);
            uint32_t first, second;
            fold(y1, y2, &first, &second);
            if ((word & 0x3ffu) != second || (word >> 10 & 0x1ffu) != first)
                fail_msg("%u, %u are stored as %u, %u, expected %u, %u", y1, y2,
                         word >> 10 & 0x1ffu, word & 0x3ffu, first, second);
            assert_false(used[word & 0x7ffffu]);
            used[word & 0x7ffffu] = 1;
            const gn_nonlinear back = gn_nonlinear_unpack32(word);
            assert_near(back, n, 1.0 / 1023.0 + 2e-7, 0.005);
            assert_int_equal(gn_nonlinear_pack32(back) & 0x3ffffffu,
                             word & 0x3ffffffu); /* xi4 rises */
            pairs++;
        }
    assert_int_equal(pairs, 1023 * 1024 / 2);
    free(used);
}

/* Every code of v2 with every one of xi4. */
static void test_32_bit_weights(void **state)
{
    (void)state;
    for (uint32_t v2 = 0; v2 <= 127; v2++)
        for (uint32_t xi4 = 0; xi4 <= 63; xi4++) {
            const uint32_t depths = (v2 * 64 + xi4) * 61 % 512 * 1025; /* a pair with y1 = y2 */
            const uint32_t word = v2 << 19 | xi4 << 26 | depths;
            const gn_nonlinear n = gn_nonlinear_unpack32(word);
            const double root = (double)v2 / 127.0;
            if (!(fabs((double)n.v2 - root * root) < 2e-7 && n.v2 <= 1.0f))
                fail_msg("v2 of code %u is %.9g", v2, (double)n.v2);
            const double exact = psi4_inverse((double)(xi4 + 1) / 64.0); /* the step's upper end */
            if (!(fabs((double)n.xi4 - exact) < 1e-5 * exact))
                fail_msg("xi4 of code %u is %.9g, expected %.9g", xi4, (double)n.xi4, exact);
            /* The upper end itself belongs to the next step. */
            const uint32_t again = gn_nonlinear_pack32(
                (gn_nonlinear){n.y1, n.y2, n.v2, (float)psi4_inverse((xi4 + 0.5) / 64.0)});
            if (again != word)
                fail_msg("%08x comes back as %08x", word, again);
        }
    const gn_nonlinear lit =
        gn_nonlinear_unpack32(gn_nonlinear_pack32((gn_nonlinear){-1.0f, 1.0f, 1.0f, 0.25f}));
    assert_true(lit.v2 == 1.0f && lit.y1 >= -1.0f && lit.y2 <= 1.0f && lit.y2 > 0.998f);
    const gn_nonlinear dark =
        gn_nonlinear_unpack32(gn_nonlinear_pack32((gn_nonlinear){1.0f, 1.0f, 0.0f, 0.0f}));
    assert_true(dark.v2 == 0.0f && dark.y1 == dark.y2 && dark.y1 > 0.998f && dark.y1 <= 1.0f);
}

/* xi4 is rounded up, so the visibility of the same depths and weight never falls. */
static void test_32_bits_light_no_less(void **state)
{
    (void)state;
    uint32_t seed = 2;
    for (int i = 0; i < 500000; i++) {
        const gn_nonlinear n = random_nonlinear(&seed);
        const gn_nonlinear back = gn_nonlinear_unpack32(gn_nonlinear_pack32(n));
        const double error = fabs(sqrt((double)back.v2) - sqrt((double)n.v2));
        if (!(error <= 0.5 / 127.0 + 1e-6))
            fail_msg("v2 %.9g comes back as %.9g", (double)n.v2, (double)back.v2);
        assert_near(back, n, 1.0 / 1023.0 + 2e-7, 1.0);
        if (!((double)back.xi4 >= (double)n.xi4 * (1.0 - 4e-5)))
            fail_msg("xi4 %.9g comes back as %.9g", (double)n.xi4, (double)back.xi4);
        const gn_nonlinear raised = {n.y1, n.y2, n.v2, back.xi4};
        const float receiver = (float)random_unit(&seed);
        const float before = gn_nonlinear_visibility(n, receiver);
        const float after = gn_nonlinear_visibility(raised, receiver);
        if (!(after >= before - 1e-5f))
            fail_msg("visibility falls from %.9g to %.9g at %.9g (%.9g %.9g %.9g %.9g)",
                     (double)before, (double)after, (double)receiver, (double)n.y1, (double)n.y2,
                     (double)n.v2, (double)n.xi4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_log2_polynomial),

        cmocka_unit_test(test_warp),
        cmocka_unit_test(test_unwarp),
        cmocka_unit_test(test_64_bits),
        cmocka_unit_test(test_32_bit_depths),
        cmocka_unit_test(test_32_bit_weights),
        cmocka_unit_test(test_32_bits_light_no_less),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
