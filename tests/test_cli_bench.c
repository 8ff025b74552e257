/* gnomon bench from outside: steadiness, profiles, tables, sweeps, and two files of results
 * compared.
 */
#include <math.h>

#include "cli_testing.h"

#include <gnomon/gnomon.h>

#include "base/base.h"
#include "scene/scene.h"

#define WALK "bench leafbox --camera CamOrbit --fps 4 --size 64x36 --repeats 1 --quiet "

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
    expect(0, "bench leafbox --size 64x36 --repeats 1 --quiet -m ray-coverage -f 2 "
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
    expect(0, WALK "-m ray-mip0,ray-coverage -f 3 --profile p.png --profile-row 25");
    picture profile = read_picture(device, "p.png");
    assert_int_equal(profile.width, 64);
    assert_int_equal(profile.height, 3 + 3 + 3);
    expect(0, "render leafbox --camera CamOrbit --size 64x36 --frames 0:2 --fps 4 -m "
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

/* Tables and sweeps --------------------------------------------------------------------------- */

#define TINY "bench leafbox --size 24x16 --repeats 1 -f 2 --quiet "

/* The cell of a column in a line (from 1) of a file without quotes. */
static void read_cell(const char *path, unsigned line, const char *column, char cell[128])
{
    char text[1 << 14], *rest = text, *row, *name;
    read_all(path, text, sizeof text);
    char *head = strsep(&rest, "\n");
    unsigned index = 0;
    bool found = false;
    while (!found && (name = strsep(&head, ",\r"))) {
        found = strcmp(name, column) == 0;
        index += !found;
    }
    if (!found)
        fail_msg("%s has no column %s", path, column);
    for (row = NULL; line > 0; line--)
        row = strsep(&rest, "\n");
    if (!row)
        fail_msg("%s is too short", path);
    for (unsigned i = 0; i <= index; i++)
        name = strsep(&row, ",\r");
    snprintf(cell, 128, "%s", name ? name : "(none)");
}

static void a_table_has_the_numbers_of_the_json(void **state)
{
    (void)state;
    char cell[128];
    expect(0, TINY "-m ray-mip0,vsm,lt-vsm:size=64 --map-size 64 --csv t.csv --json");
    cJSON *json = parse_output();
    static const char *const keys[] = {"ms_median", "noise", "rays_per_pixel", "mean_abs"};
    const cJSON *method;
    unsigned line = 0;
    cJSON_ArrayForEach(method, member(json, "methods"))
    {
        line++;
        read_cell("t.csv", line, "name", cell);
        assert_string_equal(cell, get_string(method, "name"));
        for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
            read_cell("t.csv", line, keys[k], cell);
            assert_near(strtod(cell, NULL), get_number(method, keys[k]), 1e-12, keys[k]);
        }
        read_cell("t.csv", line, "passes.test.ms_mean", cell);
        assert_near(strtod(cell, NULL),
                    get_number(member(member(method, "passes"), "test"), "ms_mean"), 1e-12, "test");
        read_cell("t.csv", line, "width", cell);
        assert_string_equal(cell, "24");
        /* Rays have no map: the cell is empty. */
        read_cell("t.csv", line, "map.bytes", cell);
        assert_true((*cell == '\0') == (cJSON_GetObjectItem(method, "map") == NULL));
    }
    assert_true(line >= 3);
    cJSON_Delete(json);
    expect(1, TINY "-m ray-mip0 --csv missing/t.csv");
    expect_text(err, "missing/t.csv");
    assert_false(exists("missing"));
}

/* What the machine did is told, whatever it can tell. */
static void counters_or_the_reason_why_not(void **state)
{
    (void)state;
    expect(0, TINY "-m ray-mip0 --json");
    cJSON *json = parse_output();
    const cJSON *counters =
        cJSON_GetObjectItem(named(member(json, "methods"), "ray-mip0"), "counters");
    if (counters)
        assert_true(get_number(counters->child ? counters : json, "instructions") > 1000);
    else
        assert_true(strlen(get_string(json, "no_counters")) > 10);
    assert_true(cJSON_IsBool(member(json, "busy")));
    const cJSON *load = member(json, "other_load");
    assert_true(cJSON_IsNull(load) || (load->valuedouble >= 0 && load->valuedouble <= 1));
    cJSON_Delete(json);
}

static void a_sweep_runs_once_for_each_value(void **state)
{
    (void)state;
    expect(0, TINY "-m ray-mip0 --sweep size=16x12,24x16,8x8 --csv s.csv --json");
    cJSON *json = parse_output();
    assert_string_equal(get_string(json, "sweep"), "size");
    const cJSON *runs = member(json, "runs");
    assert_int_equal(cJSON_GetArraySize(runs), 3);
    static const double widths[] = {16, 24, 8};
    char cell[128];
    for (int i = 0; i < 3; i++) {
        const cJSON *one = cJSON_GetArrayItem(runs, i);
        assert_near(get_number(one, "width"), widths[i], 0, "width");
        read_cell("s.csv", (unsigned)i + 1, "value", cell);
        assert_string_equal(cell, get_string(one, "value"));
    }
    cJSON_Delete(json);

    /* More lamps: more lights, whose rays grow with them; as much light in all. */
    expect(0, TINY "-m ray-mip0 --sweep lamps=1,5 --json");
    json = parse_output();
    runs = member(json, "runs");
    const cJSON *one = cJSON_GetArrayItem(runs, 0), *five = cJSON_GetArrayItem(runs, 1);
    assert_int_equal(cJSON_GetArraySize(member(one, "lights")), 1);
    assert_int_equal(cJSON_GetArraySize(member(five, "lights")), 5);
    assert_true(get_number(five, "rays") > 4 * get_number(one, "rays"));
    cJSON_Delete(json);

    /* Triangles, threads, as text: a table each and one of all. */
    expect(0, TINY "-m ray-mip0 --sweep scale=0.1,1");
    expect_text(out, "--scale 0.1\n");
    expect_text(out, "\n--scale 1\n");
    expect_text(out, "by --scale");
    expect(0, TINY "-m ray-mip0 --sweep threads=1,2 -- ");
    expect_text(out, "1 threads");
    expect_text(out, "2 threads");
}

/* Two files ----------------------------------------------------------------------------------- */

static void write_result(const char *name, const char *settings, const char *methods)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    fprintf(file, "{\"scene\": \"grove\", \"width\": 64, %s\"methods\": [%s]}", settings, methods);
    assert_int_equal(fclose(file), 0);
}

#define METHOD(name, ms) "{\"name\": \"" name "\", \"noise\": 1.01, \"ms_median\": " #ms "}"

static void slower_methods_are_found(void **state)
{
    (void)state;
    write_result("old.json", "", METHOD("a", 10) "," METHOD("b", 10) "," METHOD("c", 10));
    write_result("new.json", "", METHOD("a", 10.4) "," METHOD("b", 10.6) "," METHOD("c", 9));
    expect(0, "bench --compare old.json old.json -q");
    expect(1, "bench --compare old.json new.json -q");
    expect_text(err, "1 slower by more than 5 %, the worst 1.060 times");
    expect(1, "bench --compare old.json new.json -q --threshold 3.9%");
    expect_text(err, "2 slower");
    expect(0, "bench --compare old.json new.json -q --threshold 6.1%");
    /* Backwards c is the slower one. */
    expect(1, "bench --compare new.json old.json -q");
    expect_text(err, "1 slower by more than 5 %, the worst 1.111 times");

    expect(1, "bench --compare old.json new.json -q --json");
    cJSON *json = parse_output();
    assert_near(get_number(json, "threshold"), 0.05, 1e-15, "threshold");
    assert_near(get_number(json, "slower"), 1, 0, "slower");
    const cJSON *methods = member(json, "methods");
    assert_string_equal(get_string(named(methods, "a"), "verdict"), "same");
    assert_string_equal(get_string(named(methods, "b"), "verdict"), "slower");
    assert_string_equal(get_string(named(methods, "c"), "verdict"), "faster");
    assert_near(get_number(named(methods, "b"), "ratio"), 1.06, 1e-12, "ratio");
    cJSON_Delete(json);

    /* A machine half as fast, with one method slower than that. */
    write_result("half.json", "", METHOD("a", 20) "," METHOD("b", 21.2) "," METHOD("c", 20));
    expect(1, "bench --compare old.json half.json -q --relative a");
    expect_text(err, "1 slower");
    expect(0, "bench --compare old.json half.json -q --relative a --threshold 7");
}

static void what_is_missing_or_new_is_told(void **state)
{
    (void)state;
    write_result("old.json", "", METHOD("a", 10) "," METHOD("b", 10) ",{\"name\": \"reference\"}");
    write_result("new.json", "", METHOD("c", 10) "," METHOD("a", 10));
    expect(1, "bench --compare old.json new.json -q");
    expect_text(err, "1 missing");
    expect_text(out, "missing\n");
    expect_text(out, "new\n");
    assert_null(strstr(out, "reference"));
    write_result("old.json", "", METHOD("a", 10));
    expect(0, "bench --compare old.json new.json -q");
}

static void files_that_cannot_be_compared_are_refused(void **state)
{
    (void)state;
    write_result("old.json", "\"frames\": 3, \"threads\": 2, ", METHOD("a", 10));
    static const struct {
        const char *settings, *methods, *message;
    } cases[] = {
        {"\"frames\": 4, ", METHOD("a", 10), "measured different things: frames is 3 and 4"},
        {"\"frames\": 3, ", METHOD("a", 0), "methods[0].ms_median: is not a number above 0"},
        {"\"frames\": 3, ", METHOD("a", "1"), "methods[0].ms_median"},
        {"\"frames\": 3, ", "{}", "methods[0].name: is not a text"},
        {"\"frames\": 3, ", "{", "new.json: not JSON"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_result("new.json", cases[i].settings, cases[i].methods);
        expect(1, "bench --compare old.json new.json -q");
        expect_text(err, cases[i].message);
    }
    static const char *const sweeps[] = {"{\"runs\": []}", "{\"runs\": 3}", "{\"runs\": [3]}", "[]",
                                         "{\"runs\": [{\"methods\": []}]}"};
    for (size_t i = 0; i < sizeof sweeps / sizeof *sweeps; i++) {
        FILE *file = fopen("new.json", "wb");
        assert_non_null(file);
        fputs(sweeps[i], file);
        assert_int_equal(fclose(file), 0);
        expect(1, "bench --compare old.json new.json -q");
        expect_text(err, i < 4 ? "new.json: is no result of gnomon bench" : "has no value");
        expect(1, "bench --compare new.json old.json -q");
    }
    expect(1, "bench --compare old.json no.json");
    expect_text(err, "no.json");
    expect(1, "bench --compare old.json old.json --relative b");
    expect_text(err, "has no method 'b'");
    /* Another machine is no other measurement. */
    write_result("new.json", "\"frames\": 3, \"threads\": 8, ", METHOD("a", 10));
    expect(0, "bench --compare old.json new.json");
    expect_text(err, "note: threads is 2 and 8");
}

/* What bench writes is what it compares. */
static void results_of_a_sweep_can_be_compared(void **state)
{
    (void)state;
    expect(0, TINY "-m ray-mip0 --sweep size=16x12,24x16 --json");
    assert_int_equal(system("cp .out sweep.json"), 0);
    expect(0, "bench --compare sweep.json sweep.json -q --json");
    cJSON *json = parse_output();
    assert_int_equal(cJSON_GetArraySize(member(json, "methods")), 2);
    assert_string_equal(get_string(cJSON_GetArrayItem(member(json, "methods"), 1), "value"),
                        "24x16");
    cJSON_Delete(json);
}

/* Ctrl-C: the runs of the path that were finished are printed. */
static void an_interrupt_prints_what_is_finished(void **state)
{
    (void)state;
    /* A slow machine may not have begun, or not even be in main(), after the first of these. */
    static const char *const seconds[] = {"0.8", "2", "5"};
    unsigned finished = 0;
    for (int i = 0; i < 3 && finished == 0; i++) {
        char command[512];
        snprintf(command, sizeof command,
                 "timeout --preserve-status -s INT %s %s bench leafbox --size 64x48 -f 1 -r 1000 "
                 "-m ray-mip0 --json --quiet >.out 2>.err",
                 seconds[i], GNOMON_PROGRAM);
        const int status = system(command);
        read_all(".out", out, sizeof out);
        read_all(".err", err, sizeof err);
        assert_int_equal(WEXITSTATUS(status), 130);
        const char *said = strstr(err, "interrupted; ");
        if (!said || sscanf(said, "interrupted; %u of 1000 runs", &finished) != 1)
            finished = 0;
    }
    assert_true(finished > 0);
    cJSON *json = parse_output();
    assert_near(get_number(json, "repeats"), finished, 0, "repeats");
    assert_true(get_number(named(member(json, "methods"), "ray-mip0"), "ms_median") > 0);
    cJSON_Delete(json);
}

static void wrong_usage_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {WALK "--profile-row 3", "--profile-row needs --profile"},
        {WALK "--profile p.png --profile-row 36", "36 is not below the height, 36"},
        {TINY "--sweep size", "'size' is not NAME=A,B"},
        {TINY "--sweep =3", "'=3' is not NAME=A,B"},
        {TINY "--sweep size=24x16,12", "--size: '12' is not WIDTHxHEIGHT"},
        {TINY "--sweep size=24x16,", "--size: '' is not WIDTHxHEIGHT"},
        {TINY "--sweep map-szie=3", "did you mean '--map-size'"},
        {TINY "--sweep json=1,2", "--json takes no value"},
        {TINY "--sweep csv=a,b", "--sweep does not take --csv"},
        {TINY "--sweep size=8x8 --profile p.png", "exclude each other"},
        {TINY "--lamps 3 --sun 0,40", "exclude each other"},
        {"bench --compare a.json", "NEW.json is missing"},
        {"bench --compare a.json b.json --threshold x", "'x' is not a percentage"},
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
        cmocka_unit_test(a_table_has_the_numbers_of_the_json),
        cmocka_unit_test(counters_or_the_reason_why_not),
        cmocka_unit_test(a_sweep_runs_once_for_each_value),
        cmocka_unit_test(slower_methods_are_found),
        cmocka_unit_test(what_is_missing_or_new_is_told),
        cmocka_unit_test(files_that_cannot_be_compared_are_refused),
        cmocka_unit_test(results_of_a_sweep_can_be_compared),
        cmocka_unit_test(an_interrupt_prints_what_is_finished),
        cmocka_unit_test(wrong_usage_is_refused),
    };
    return cmocka_run_group_tests_name("command line, bench", tests, setup, teardown);
}
