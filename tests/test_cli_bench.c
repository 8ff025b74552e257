/* gnomon bench from outside: steadiness. */
#include <math.h>

#include "cli_testing.h"

#include <gnomon/gnomon.h>

#include "base/base.h"
#include "scene/scene.h"

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

/* Profiles ------------------------------------------------------------------------------------ */

typedef struct picture {
    uint32_t width, height;
    uint8_t *rgba;
} picture;

static picture read_picture(gn_device *device, const char *path)
{
    static uint8_t bytes[1 << 20];
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("no file %s", path);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    picture p;
    if (gn_image_decode(gn_device_context(device), path, bytes, size, &p.width, &p.height,
                        &p.rgba) != GN_OK)
        fail_msg("%s", gn_device_message(device));
    return p;
}

/* Each line of a strip is that row of what `render` shows of that frame. */
static void a_profile_is_a_row_of_each_frame(void **state)
{
    (void)state;
    gn_device *device;
    assert_int_equal(gn_device_create(NULL, &device), GN_OK);
    expect(0, WALK "-m ray-mip0,ray-coverage -f 3 --fps 4 --profile p.png --profile-row 25");
    picture profile = read_picture(device, "p.png");
    assert_int_equal(profile.width, 64);
    assert_int_equal(profile.height, 3 + 3 + 3);
    expect(0, "render grove --scale 0.03 --camera CamWalk --size 64x36 --frames 0:2 --fps 4 -m "
              "ray-coverage --aov visibility --quiet -o f.png");
    unsigned different = 0, lit = 0, shadowed = 0;
    for (uint32_t frame = 0; frame < 3; frame++) {
        char name[64];
        snprintf(name, sizeof name, "f.%04u.visibility.png", frame);
        picture shown = read_picture(device, name);
        const uint8_t *a = profile.rgba + 4 * (size_t)((6 + frame) * 64),
                      *b = shown.rgba + 4 * (size_t)(25 * 64);
        for (uint32_t x = 0; x < 64; x++) {
            const bool sky = a[4 * x] != a[4 * x + 2];
            different += !sky && a[4 * x] != b[4 * x];
            lit += !sky && a[4 * x] == 255;
            shadowed += !sky && a[4 * x] == 0;
        }
        gn_free(gn_device_context(device), shown.rgba);
    }
    if (different > 0 || lit < 5 || shadowed < 5)
        fail_msg("%u pixels differ; %u are lit and %u in shadow", different, lit, shadowed);
    gn_free(gn_device_context(device), profile.rgba);
    gn_device_destroy(&device);
}

static void wrong_usage_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {WALK "--profile-row 3", "--profile-row needs --profile"},
        {WALK "--profile p.png --profile-row 36", "36 is not below the height, 36"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(2, cases[i].arguments);
        expect_text(err, cases[i].message);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(residual_flicker_needs_a_reference_in_every_frame),
        cmocka_unit_test(a_still_view_has_no_residual),
        cmocka_unit_test(a_profile_is_a_row_of_each_frame),
        cmocka_unit_test(wrong_usage_is_refused),
    };
    return cmocka_run_group_tests_name("command line, bench", tests, setup, teardown);
}
