/* The dialect's functions against the C library in double, within the bounds that dialect.h
 * states, and what it says about NaN, infinity, zero and denormals. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/shadow/dialect.h>
#include <gnomon/shadow/dialect_end.h>

#include "bits_testing.h"

#define EXPONENT(e) ((uint32_t)((e) + 127) << 23) /* bits of 2^e */

static uint32_t random_bits(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    return *state ^= *state << 5;
}

static void assert_same(float value, float expected, const char *what)
{
    if (to_bits(value) != to_bits(expected))
        fail_msg("%s is %a, expected %a", what, (double)value, (double)expected);
}

/* Calls check for every stride-th float of [first, last] given by their bits, and for as many at
 * random; stride 1 is all of them. */
static void sweep(void (*check)(float), uint32_t first, uint32_t last, uint32_t stride)
{
    uint32_t state = first ^ 0x9e3779b9u;
    check(from_bits(first));
    check(from_bits(last));
    for (uint64_t bits = first; bits <= last; bits += stride) {
        check(from_bits((uint32_t)bits));
        if (stride > 1)
            check(
                from_bits(first + (uint32_t)(random_bits(&state) % ((uint64_t)last - first + 1))));
    }
}

static void check_log2(float x)
{
    const double expected = log2((double)x), size = fabs(expected);
    const double error = fabs((double)gn_log2(x) - expected);
    if (!(error <= 0.0) && !(error < 1e-7 + 6e-8 * size && error < 2.4e-7 * size))
        fail_msg("gn_log2(%a) is %.9g, expected %.12g", (double)x, (double)gn_log2(x), expected);
}

static void test_log2(void **state)
{
    (void)state;
    /* Every mantissa around 1, where relative accuracy is hardest; then the whole range. */
    sweep(check_log2, to_bits(0.984375f), to_bits(1.03125f), 1);
    sweep(check_log2, EXPONENT(-1), EXPONENT(1), 11);
    sweep(check_log2, EXPONENT(-126), to_bits(FLT_MAX), 2003);
    for (int e = -126; e <= 127; e++)
        assert_same(gn_log2(from_bits(EXPONENT(e))), (float)e, "gn_log2 of a power of two");
    assert_same(gn_log2(INFINITY), 128.0f, "gn_log2(infinity)");
    assert_same(gn_log2(0.0f), -127.0f, "gn_log2(0)");
    for (uint32_t bits = 1; bits < EXPONENT(-126); bits += 997) {
        const float value = gn_log2(from_bits(bits));
        if (!(value >= -127.0f && value <= -126.0f))
            fail_msg("gn_log2(%a) is %.9g", (double)from_bits(bits), (double)value);
    }
}

static void check_exp2(float x)
{
    const double expected = exp2((double)x), error = fabs((double)gn_exp2(x) - expected);
    if (!(error < 2.5e-7 * expected))
        fail_msg("gn_exp2(%a) is %.9g, expected %.12g", (double)x, (double)gn_exp2(x), expected);
    const float inside = gn_exp2_inside(x);
    if (!(fabs((double)inside - expected) < 2e-7 * expected))
        fail_msg("gn_exp2_inside(%a) is %.9g, expected %.12g", (double)x, (double)inside, expected);
}

static void test_exp2(void **state)
{
    (void)state;
    const uint32_t minus = 0x80000000u;
    sweep(check_exp2, EXPONENT(-30), EXPONENT(-2), 101);
    sweep(check_exp2, EXPONENT(-2), to_bits(3.0f), 11);
    sweep(check_exp2, to_bits(3.0f), to_bits(127.0f), 41);
    sweep(check_exp2, minus | EXPONENT(-30), minus | EXPONENT(-2), 101);
    sweep(check_exp2, minus | EXPONENT(-2), minus | to_bits(3.0f), 11);
    sweep(check_exp2, minus | to_bits(3.0f), minus | to_bits(126.0f), 41);
    for (int e = -126; e <= 127; e++) {
        assert_same(gn_exp2((float)e), from_bits(EXPONENT(e)), "gn_exp2 of a whole number");
        assert_same(gn_exp2_inside((float)e), from_bits(EXPONENT(e)), "gn_exp2_inside of one");
    }
    assert_same(gn_exp2(0.0f), 1.0f, "gn_exp2(0)");
    assert_same(gn_exp2(-0.0f), 1.0f, "gn_exp2(-0)");
    assert_same(gn_exp2(1e-40f), 1.0f, "gn_exp2(denormal)");
    assert_same(gn_exp2(127.5f), from_bits(EXPONENT(127)), "gn_exp2(127.5)");
    assert_same(gn_exp2(INFINITY), from_bits(EXPONENT(127)), "gn_exp2(infinity)");
    assert_same(gn_exp2(-126.5f), FLT_MIN, "gn_exp2(-126.5)");
    assert_same(gn_exp2(-INFINITY), FLT_MIN, "gn_exp2(-infinity)");
}

static void check_atan(float x)
{
    const double expected = atan((double)x), error = fabs((double)gn_atan(x) - expected);
    if (!(error < 1.5e-7 && error < 2.1e-7 * fabs(expected)))
        fail_msg("gn_atan(%a) is %.9g, expected %.12g", (double)x, (double)gn_atan(x), expected);
    assert_same(gn_atan(-x), -gn_atan(x), "gn_atan(-x)");
}

static void test_atan(void **state)
{
    (void)state;
    sweep(check_atan, to_bits(FLT_MIN), EXPONENT(-8), 1009);
    sweep(check_atan, EXPONENT(-8), EXPONENT(4), 31);
    sweep(check_atan, EXPONENT(4), to_bits(FLT_MAX), 1009);
    /* Both borders of the range reduction, float by float. */
    sweep(check_atan, to_bits(0.41421356f) - 5000, to_bits(0.41421356f) + 5000, 1);
    sweep(check_atan, to_bits(2.41421356f) - 5000, to_bits(2.41421356f) + 5000, 1);
    assert_true(gn_atan(0.0f) == 0.0f && gn_atan(-0.0f) == 0.0f);
    assert_true(gn_atan(1e-40f) > 0.0f && gn_atan(1e-40f) <= 1e-40f);
    assert_same(gn_atan(INFINITY), 1.57079633f, "gn_atan(infinity)");
    assert_same(gn_atan(-INFINITY), -1.57079633f, "gn_atan(-infinity)");
    assert_true(isnan(gn_atan(NAN)));
}

static void check_tan(float x)
{
    const double expected = tan((double)x), error = fabs((double)gn_tan(x) - expected);
    if (!(error < 2.5e-7 * fabs(expected)))
        fail_msg("gn_tan(%a) is %.9g, expected %.12g", (double)x, (double)gn_tan(x), expected);
    assert_same(gn_tan(-x), -gn_tan(x), "gn_tan(-x)");
}

static void test_tan(void **state)
{
    (void)state;
    sweep(check_tan, to_bits(FLT_MIN), EXPONENT(-8), 1009);
    sweep(check_tan, EXPONENT(-8), to_bits(0.785398163f), 29);
    assert_same(gn_tan(0.0f), 0.0f, "gn_tan(0)");
    assert_true(isnan(gn_tan(NAN)));
}

static void check_basics(float x)
{
    assert_same(gn_abs(x), fabsf(x), "gn_abs");
    assert_same(gn_from_bits(gn_bits(x)), x, "gn_from_bits(gn_bits(x))");
    if (isnan(x))
        return;
    assert_same(gn_floor(x), floorf(x), "gn_floor");
    if (x >= 0.0f)
        assert_same(gn_sqrt(x), (float)sqrt((double)x), "gn_sqrt");
    if (fabsf(x) < 2147483648.0f)
        assert_int_equal(gn_to_int(x), (int32_t)trunc((double)x));
}

static void test_basics(void **state)
{
    (void)state;
    sweep(check_basics, 0, 0xffffffffu, 9973);
    assert_int_equal(gn_to_int(-1.75f), -1);
    assert_same(gn_to_real(-2147483647 - 1), -2147483648.0f, "gn_to_real");
    assert_same(gn_splat(-0.0f), -0.0f, "gn_splat");
    /* Masks: selecting by each combination. */
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++) {
            assert_int_equal(gn_and(a, b), a && b);
            assert_int_equal(gn_or(a, b), a || b);
        }
    assert_int_equal(gn_not(0), 1);
    assert_int_equal(gn_not(1), 0);
    assert_same(gn_select(1.0f < 2.0f, 3.0f, 4.0f), 3.0f, "gn_select(true)");
    assert_same(gn_select(2.0f < 1.0f, 3.0f, 4.0f), 4.0f, "gn_select(false)");
}

static void test_min_max_clamp(void **state)
{
    (void)state;
    const float values[] = {-INFINITY, -FLT_MAX, -1.0f,   -1e-40f, -0.0f,   0.0f,
                            1e-40f,    FLT_MIN,  0.9999f, 1.0f,    FLT_MAX, INFINITY};
    const size_t count = sizeof values / sizeof *values;
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j < count; j++) {
            const float a = values[i], b = values[j];
            assert_same(gn_min(a, b), a < b ? a : b, "gn_min");
            assert_same(gn_max(a, b), a > b ? a : b, "gn_max");
            if (a <= b)
                assert_true(gn_clamp(0.5f, a, b) >= a && gn_clamp(0.5f, a, b) <= b);
        }
        /* Of a NaN and a number, the second. */
        assert_same(gn_min(NAN, values[i]), values[i], "gn_min(NaN, x)");
        assert_same(gn_max(NAN, values[i]), values[i], "gn_max(NaN, x)");
        assert_true(isnan(gn_min(values[i], NAN)));
        assert_true(isnan(gn_max(values[i], NAN)));
    }
    assert_same(gn_clamp(NAN, 2.0f, 3.0f), 2.0f, "gn_clamp(NaN)");
    assert_same(gn_clamp(-INFINITY, 2.0f, 3.0f), 2.0f, "gn_clamp(-infinity)");
    assert_same(gn_clamp(INFINITY, 2.0f, 3.0f), 3.0f, "gn_clamp(infinity)");
    assert_same(gn_clamp(2.5f, 2.0f, 3.0f), 2.5f, "gn_clamp(2.5)");

    static const float any[] = {NAN,    -NAN,  INFINITY, -INFINITY, -1.0f, -0.0f,   0.0f,
                                1e-40f, 0.25f, 0.5f,     0.75f,     1.0f,  1.0001f, 3e38f};
    for (size_t i = 0; i < sizeof any / sizeof *any; i++) {
        assert_same(gn_clamp_positive(any[i], 0.0f, 1.0f), gn_clamp(any[i], 0.0f, 1.0f),
                    "gn_clamp_positive from 0");
        assert_same(gn_clamp_positive(any[i], 0.5f, 0.75f), gn_clamp(any[i], 0.5f, 0.75f),
                    "gn_clamp_positive");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_log2),   cmocka_unit_test(test_exp2),
        cmocka_unit_test(test_atan),   cmocka_unit_test(test_tan),
        cmocka_unit_test(test_basics), cmocka_unit_test(test_min_max_clamp),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
