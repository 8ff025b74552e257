/* gnomon bench from outside: steadiness. */
#include <math.h>

#include "cli_testing.h"

#define WALK "bench grove --scale 0.03 --camera CamWalk --size 64x36 --repeats 1 --quiet "

static void assert_near(double value, double expected, double tolerance, const char *what)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s is %.17g, expected %.17g within %g", what, value, expected, tolerance);
}

/* Steadiness ---------------------------------------------------------------------------------- */

static void residual_flicker_needs_a_reference_in_every_frame(void **state)
{
    (void)state;
    expect(0, WALK "-m ray-mip0,ray-coverage -f 3 --reference 4 --reference-frames 2 --json");
    cJSON *json = parse_output();
    const cJSON *method = named(member(json, "methods"), "ray-mip0");
    assert_null(cJSON_GetObjectItem(method, "residual_flicker"));
    assert_true(get_number(method, "flicker") > 0);
    cJSON_Delete(json);

    expect(0, WALK "-m ray-mip0,ray-coverage -f 3 --reference 4 --reference-frames 3 --json");
    json = parse_output();
    method = named(member(json, "methods"), "ray-coverage");
    assert_true(get_number(method, "residual_flicker") > 0);
    assert_near(get_number(method, "residual_flicker_ratio"),
                get_number(method, "residual_flicker") /
                    get_number(named(member(json, "methods"), "ray-mip0"), "residual_flicker"),
                1e-12, "ratio");
    /* Frame by frame: nothing before the first; the mean of the others. */
    const cJSON *series = member(member(method, "series"), "flicker");
    assert_int_equal(cJSON_GetArraySize(series), 3);
    assert_true(cJSON_IsNull(cJSON_GetArrayItem(series, 0)));
    const double mean =
        (cJSON_GetArrayItem(series, 1)->valuedouble + cJSON_GetArrayItem(series, 2)->valuedouble) /
        2;
    assert_near(mean, get_number(method, "flicker"), 1e-12, "mean of the series");
    cJSON_Delete(json);

    expect(0, WALK "-m ray-mip0 -f 2 --reference 2 --reference-frames 2");
    expect_text(out, "\nresidual ");
}

/* The same view again: the method does not change, and neither does the reference. */
static void a_still_view_has_no_residual(void **state)
{
    (void)state;
    expect(0, "bench grove --scale 0.03 --size 64x36 --repeats 1 --quiet -m ray-coverage -f 2 "
              "--fps 100000 "
              "--time 1000 --reference 4 --reference-frames 2 --json");
    cJSON *json = parse_output();
    const cJSON *method = named(member(json, "methods"), "ray-coverage");
    assert_near(get_number(method, "flicker"), 0, 0, "flicker");
    assert_near(get_number(method, "residual_flicker"), 0, 0, "residual flicker");
    assert_near(get_number(method, "residual_toggles"), 0, 0, "residual toggles");
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(residual_flicker_needs_a_reference_in_every_frame),
        cmocka_unit_test(a_still_view_has_no_residual),
    };
    return cmocka_run_group_tests_name("command line, bench", tests, setup, teardown);
}
