/* gnomon compare --images from outside: numbers, the map, and what is refused. */
#include "cli_testing.h"

#include <math.h>

/* Small and quick. */
#define SHOT " leafbox --size 48x32 --quiet "

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"compare --images", "REFERENCE is missing"},
        {"compare --images a.png", "TEST is missing"},
        {"compare --images a.png b.png c.png", "'c.png' is one argument too many"},
        {"compare --images a.png b.png --ppd 0", "'0' is not a number from 1 to 1000"},
        {"compare --images a.png b.png --a ray", "no option '--a'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(2, cases[i].arguments);
        expect_text(err, cases[i].message);
        assert_string_equal(out, "");
    }
    expect(0, "compare --images --help");
    expect_text(out, "gnomon compare --images reference.exr test.exr -o flip.png");
    assert_int_equal(count_files(), 0);
}

static void write_text(const char *name, const char *text)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void test_failures(void **state)
{
    (void)state;
    expect(0, "render" SHOT "-o a.png");
    expect(0, "render" SHOT "-o a.exr");
    expect(0, "render leafbox --quiet --size 47x32 -o narrow.png");
    write_text("words.png", "no picture");
    write_text("empty.exr", "");
    write_text("cut.exr", "v/1\001\002");
    assert_int_equal(symlink("/dev/full", "full.png"), 0);
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"a.png missing.png", "missing.png: No such file"},
        {"missing.exr a.png", "missing.exr: No such file"},
        {"a.png .", ".: Is a directory"},
        {"a.png words.png", "words.png: neither PNG"},
        {"empty.exr a.png", "empty.exr: neither PNG"},
        {"a.png cut.exr", "cut.exr: OpenEXR: "},
        {"a.png narrow.png", "a.png has 48 x 32 pixels, narrow.png has 47 x 32"},
        {"narrow.png a.exr", "narrow.png has 47 x 32 pixels, a.exr has 48 x 32"},
        {"a.png a.exr -o full.png", "full.png: cannot write: No space left"},
    };
    const unsigned files = count_files();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char arguments[128];
        snprintf(arguments, sizeof arguments, "compare -q --images %s", cases[i].arguments);
        expect(1, arguments);
        expect_text(err, cases[i].message);
        assert_string_equal(out, "");
    }
    assert_int_equal(count_files(), files);
}

/* A picture against itself. */
static void expect_equal(const char *names)
{
    char arguments[128];
    snprintf(arguments, sizeof arguments, "compare --images %s -q --json", names);
    expect(0, arguments);
    cJSON *json = parse_output();
    const char *const zeros[] = {"flip_mean",      "flip_quartile1", "flip_median",
                                 "flip_quartile3", "flip_max",       "mean_abs"};
    for (size_t i = 0; i < sizeof zeros / sizeof *zeros; i++)
        if (get_number(json, zeros[i]) != 0)
            fail_msg("%s of %s is %g", zeros[i], names, get_number(json, zeros[i]));
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(json, "psnr")));
    if (!(fabs(get_number(json, "ssim") - 1) < 1e-12))
        fail_msg("ssim of %s is %g", names, get_number(json, "ssim"));
    cJSON_Delete(json);
}

static double get_mean(const char *names)
{
    char arguments[128];
    snprintf(arguments, sizeof arguments, "compare --images %s -q --json", names);
    expect(0, arguments);
    cJSON *json = parse_output();
    const double mean = get_number(json, "flip_mean");
    cJSON_Delete(json);
    return mean;
}

static void test_numbers(void **state)
{
    (void)state;
    expect(0, "render" SHOT "-o a.png");
    expect(0, "render" SHOT "-o a.exr");
    expect(0, "render" SHOT "-m ray-raw -o b.png");
    expect(0, "render" SHOT "-m ray-raw -o b.exr");
    expect_equal("a.png a.png");
    expect_equal("a.exr a.exr");

    expect(0, "compare --images a.png b.png -o map.png --json --ppd 40");
    cJSON *json = parse_output();
    assert_string_equal(get_string(json, "command"), "compare");
    assert_string_equal(get_string(json, "reference"), "a.png");
    assert_string_equal(get_string(json, "test"), "b.png");
    assert_int_equal((int)get_number(json, "width"), 48);
    assert_int_equal((int)get_number(json, "height"), 32);
    assert_true(get_number(json, "pixels_per_degree") == 40);
    const double mean = get_number(json, "flip_mean"), most = get_number(json, "flip_max");
    assert_true(0 < mean && mean < get_number(json, "flip_quartile1"));
    assert_true(get_number(json, "flip_quartile1") <= get_number(json, "flip_median"));
    assert_true(get_number(json, "flip_median") <= get_number(json, "flip_quartile3"));
    assert_true(get_number(json, "flip_quartile3") <= most && most < 1);
    const double psnr = get_number(json, "psnr"), ssim = get_number(json, "ssim");
    const double mean_abs = get_number(json, "mean_abs");
    assert_true(psnr > 10 && psnr < 60 && ssim > 0 && ssim < 1 && mean_abs > 0 && mean_abs < 0.2);
    const cJSON *files = member(json, "files");
    assert_int_equal(cJSON_GetArraySize(files), 1);
    assert_string_equal(cJSON_GetArrayItem(files, 0)->valuestring, "map.png");
    cJSON_Delete(json);

    /* The map is a picture of that size, and not black. */
    expect(0, "compare --images map.png map.png -q");
    expect_text(out, "48 x 32 pixels, 67 pixels per degree");
    expect_text(out, "quartile 1");
    assert_true(get_mean("a.png map.png") > 0.1);

    /* Whatever the kind of file, these are the same pictures, up to the rounding of PNG. */
    const double png = get_mean("a.png b.png"), exr = get_mean("a.exr b.exr");
    if (!(fabs(png - exr) < 0.1 * exr && exr > 0.001))
        fail_msg("FLIP of PNG files %g, of EXR files %g", png, exr);
    expect(0, "compare --images a.png a.exr -q --json");
    json = parse_output();
    if (!(get_number(json, "mean_abs") < 0.5 / 255))
        fail_msg("PNG and EXR differ by %g", get_number(json, "mean_abs"));
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_numbers, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
