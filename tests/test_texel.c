/* Words of a texel: every code, and halves against the compiler's own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/shadow/bilinear.h>
#include <gnomon/shadow/depth.h>
#include <gnomon/shadow/texel.h>

#include "bits_testing.h"
#include "distribution_testing.h"

static void test_unorm16_codes(void **state)
{
    (void)state;
    for (uint32_t code = 0; code <= 65535; code++) {
        const uint32_t word = code | (65535u - code) << 16;
        const float low = gn_unorm16_low(word), high = gn_unorm16_high(word);
        const double expected = (double)code / 65535.0;
        if (!(fabs((double)low - expected) <= 1.2e-7 * expected))
            fail_msg("code %u is %.9g, expected %.9g", code, (double)low, expected);
        if (gn_unorm16_pack(low, high) != word)
            fail_msg("%08x comes back as %08x", word, gn_unorm16_pack(low, high));
    }
    assert_true(gn_unorm16_low(0xffff0000u) == 0.0f && gn_unorm16_high(0xffff0000u) == 1.0f);
}

static void test_unorm16_nearest(void **state)
{
    (void)state;
    uint32_t seed = 1;
    for (int i = 0; i < 1000000; i++) {
        const float x = (float)random_unit(&seed) * (i % 2 ? 1.0f : 1e-3f);
        const double exact = (double)x * 65535.0, code = (double)gn_unorm16_code(x);
        if (!(fabs(code - exact) <= 0.504)) /* 65535 x is rounded to 1/256 at most */
            fail_msg("%.9g is %.9g, its code %.9g", (double)x, exact, code);
    }
    const struct {
        float x;
        uint32_t code;
    } bad[] = {{-1.0f, 0}, {-INFINITY, 0}, {NAN, 0}, {1.5f, 65535}, {INFINITY, 65535}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(gn_unorm16_code(bad[i].x), bad[i].code);
}

/* The value of a half from its definition. */
static double half_value(uint32_t code)
{
    const int exponent = (int)(code >> 10 & 31u);
    const double mantissa = (double)(code & 1023u) / 1024.0;
    const double x = exponent == 0 ? ldexp(mantissa, -14) : ldexp(1.0 + mantissa, exponent - 15);
    return code & 0x8000u ? -x : x;
}

static void test_half_codes(void **state)
{
    (void)state;
    for (uint32_t code = 0; code <= 65535; code++) {
        const float value = gn_half_value(code);
        if ((double)value != half_value(code))
            fail_msg("half %04x is %a, expected %a", code, (double)value, half_value(code));
        assert_int_equal(signbit(value) != 0, code >> 15);
        const uint32_t word = code | (code ^ 0x5555u) << 16;
        assert_true(to_bits(gn_half_low(word)) == to_bits(value));
        assert_true(to_bits(gn_half_high(word)) == to_bits(gn_half_value(code ^ 0x5555u)));
        if ((code & 0x7c00u) != 0x7c00u && gn_half_code(value) != code)
            fail_msg("half %04x comes back as %04x", code, gn_half_code(value));
    }
}

/* Nearest, ties to even, finite: by search among the halves around. */
static uint32_t half_code(float x)
{
    const double a = fmin(fabs((double)x), 65504.0);
    uint32_t low = 0, high = 0x7bffu;
    while (low < high) { /* the largest that is not above a */
        const uint32_t middle = (low + high + 1u) / 2u;
        if (half_value(middle) <= a)
            low = middle;
        else
            high = middle - 1u;
    }
    if (low < 0x7bffu) {
        const double below = a - half_value(low), above = half_value(low + 1u) - a;
        low += above < below || (above == below && low % 2u == 1u);
    }
    return low | (signbit(x) ? 0x8000u : 0u);
}

static void check_half(float x)
{
    const uint32_t code = gn_half_code(x), expected = half_code(x);
    if (code != expected)
        fail_msg("%a gives half %04x, expected %04x", (double)x, code, expected);
#ifdef __FLT16_MAX__
    __extension__ typedef _Float16 compiler_half;
    const compiler_half own = (compiler_half)x;
    uint16_t bits;
    memcpy(&bits, &own, sizeof bits);
    if ((bits & 0x7c00u) != 0x7c00u && code != bits)
        fail_msg("%a gives half %04x, the compiler's is %04x", (double)x, code, bits);
#endif
}

static void test_half_rounding(void **state)
{
    (void)state;
    for (uint32_t code = 0; code < 0x7bffu; code++) {
        /* The middle to the next half, and the floats beside it. */
        const float middle = (float)(0.5 * (half_value(code) + half_value(code + 1u)));
        check_half(middle);
        check_half(-middle);
        check_half(nextafterf(middle, 0.0f));
        check_half(nextafterf(middle, INFINITY));
    }
    uint32_t seed = 2;
    for (int i = 0; i < 300000; i++) {
        const uint32_t exponent = 90u + (uint32_t)(random_unit(&seed) * 60.0);
        const uint32_t mantissa = (uint32_t)(random_unit(&seed) * 8388608.0);
        check_half(from_bits((uint32_t)(i % 2) << 31 | exponent << 23 | mantissa));
    }
    const float special[] = {0.0f, -0.0f, 1e-45f, -1e-40f, 65504.0f, 65519.9f, 65520.0f, -1e30f};
    for (size_t i = 0; i < sizeof special / sizeof *special; i++) {
        const uint32_t code = gn_half_code(special[i]), expected = half_code(special[i]);
        assert_int_equal(code, expected);
    }
    assert_int_equal(gn_half_code(INFINITY), 0x7bff);
    assert_int_equal(gn_half_code(-INFINITY), 0xfbff);
    assert_int_equal(gn_half_code(NAN) & 0x7fffu, 0x7bff);
    assert_int_equal(gn_half_pack(1.0f, -2.0f), 0xc0003c00u);
}

static void test_real_words(void **state)
{
    (void)state;
    const float values[] = {0.0f, -0.0f, 1.0f, -3.5f, 1e-40f, 3e38f, INFINITY};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        assert_int_equal(gn_real_word(values[i]), to_bits(values[i]));
        assert_int_equal(to_bits(gn_word_real(to_bits(values[i]))), to_bits(values[i]));
    }
}

/* A plane is interpolated exactly, and each texel's centre gives the texel. */
static void test_bilinear(void **state)
{
    (void)state;
    uint32_t seed = 3;
    for (int i = 0; i < 100000; i++) {
        const float x = (float)random_unit(&seed) * 64.0f, y = (float)random_unit(&seed) * 64.0f;
        const float fx = gn_bilinear_fraction(x), fy = gn_bilinear_fraction(y);
        assert_true(fx >= 0.0f && fx < 1.0f);
        const float column = gn_bilinear_base(x), row = gn_bilinear_base(y);
        assert_true(column == floorf(column) && column + 0.5f <= x && x < column + 1.5f);
        const gn_bilinear w = gn_bilinear_weights(fx, fy);
        assert_true(w.w00 >= 0.0f && w.w10 >= 0.0f && w.w01 >= 0.0f && w.w11 >= 0.0f);
        const float sum = w.w00 + w.w10 + w.w01 + w.w11;
        if (!(fabsf(sum - 1.0f) <= 2e-7f))
            fail_msg("weights at %.9g, %.9g sum to %.9g", (double)x, (double)y, (double)sum);
        const float left = column + 0.5f, top = row + 0.5f; /* of the texels' centres */
        const float value =
            gn_bilinear_blend(w, 2.0f * left + 3.0f * top, 2.0f * left + 2.0f + 3.0f * top,
                              2.0f * left + 3.0f * top + 3.0f, 2.0f * left + 3.0f * top + 5.0f);
        if (!(fabsf(value - (2.0f * x + 3.0f * y)) <= 2e-4f))
            fail_msg("blend at %.9g, %.9g is %.9g", (double)x, (double)y, (double)value);
    }
    const gn_bilinear centre = gn_bilinear_weights(gn_bilinear_fraction(7.5f), 0.0f);
    assert_true(gn_bilinear_base(7.5f) == 7.0f && gn_bilinear_base(0.25f) == -1.0f);
    assert_true(gn_bilinear_blend(centre, 5.0f, 6.0f, 7.0f, 8.0f) == 5.0f);
}

static void test_depth(void **state)
{
    (void)state;
    assert_true(gn_depth_test(0.5f, 0.5f) == 1.0f);
    assert_true(gn_depth_test(0.5f, 0.4999f) == 1.0f);
    assert_true(gn_depth_test(0.5f, 0.5001f) == 0.0f);
    assert_true(gn_depth_test(0.0f, 1.0f) == 0.0f && gn_depth_test(1.0f, 1.0f) == 1.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_unorm16_codes), cmocka_unit_test(test_unorm16_nearest),
        cmocka_unit_test(test_half_codes),    cmocka_unit_test(test_half_rounding),
        cmocka_unit_test(test_real_words),    cmocka_unit_test(test_bilinear),
        cmocka_unit_test(test_depth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
