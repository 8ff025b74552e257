/* Scalar, 8 and 16 lanes of the same text give the same bits, NaNs whatever their payload. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "lanes/lanes.h"

#define COUNT 400000 /* a multiple of 16 */

static uint32_t bits(float x)
{
    uint32_t i;
    memcpy(&i, &x, sizeof i);
    return isnan(x) ? 0x7fc00000u : i;
}

static void compare(const gn_lane_function *scalar, const gn_lane_function *lanes, int lane_count,
                    const float *const in[GN_LANE_INPUTS], float *const expected[GN_LANE_OUTPUTS],
                    float *const out[GN_LANE_OUTPUTS])
{
    assert_string_equal(scalar->name, lanes->name);
    for (int plane = 0; plane < GN_LANE_OUTPUTS; plane++)
        memset(out[plane], 0, COUNT * sizeof *out[plane]);
    lanes->run(in, out, COUNT);
    for (int plane = 0; plane < GN_LANE_OUTPUTS; plane++)
        for (size_t i = 0; i < COUNT; i++)
            if (bits(out[plane][i]) != bits(expected[plane][i]))
                fail_msg("%s(%a, %a, %a) value %d is %a with %d lanes, %a with one", scalar->name,
                         (double)in[0][i], (double)in[1][i], (double)in[2][i], plane,
                         (double)out[plane][i], lane_count, (double)expected[plane][i]);
}

static void test_lanes_agree(void **state)
{
    (void)state;
    float *in[GN_LANE_INPUTS], *expected[GN_LANE_OUTPUTS], *out[GN_LANE_OUTPUTS];
    float *memory = malloc((GN_LANE_INPUTS + 2 * GN_LANE_OUTPUTS) * COUNT * sizeof *memory);
    assert_non_null(memory);
    for (int i = 0; i < GN_LANE_INPUTS; i++)
        in[i] = memory + (size_t)i * COUNT;
    for (int i = 0; i < GN_LANE_OUTPUTS; i++) {
        expected[i] = memory + (size_t)(GN_LANE_INPUTS + i) * COUNT;
        out[i] = expected[i] + (size_t)GN_LANE_OUTPUTS * COUNT;
    }
    uint32_t f = 0;
    for (; gn_lane_functions_1[f].name; f++) {
        gn_lane_inputs(gn_lane_functions_1[f].domain, 100 + f, in, COUNT);
        for (int i = 0; i < GN_LANE_OUTPUTS; i++)
            memset(expected[i], 0, COUNT * sizeof *expected[i]);
        gn_lane_functions_1[f].run((const float *const *)in, expected, COUNT);
        compare(&gn_lane_functions_1[f], &gn_lane_functions_8[f], 8, (const float *const *)in,
                expected, out);
        compare(&gn_lane_functions_1[f], &gn_lane_functions_16[f], 16, (const float *const *)in,
                expected, out);
    }
    assert_true(f > 0);
    assert_null(gn_lane_functions_8[f].name);
    assert_null(gn_lane_functions_16[f].name);
    free(memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_lanes_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
