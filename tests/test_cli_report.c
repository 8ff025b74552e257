/* The built program's report, and the two commands that only figures need: data, files, failures.
 * The page itself is opened in a browser by tests/report. */
#include "cli_testing.h"

#include <math.h>

#define SMALL " --size 48x32 --frames 2 --methods ray-mip0,lt-vsm --camera CamRailing --quiet "

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"report railing", "-o DIR is missing"},
        {"report railing -o r --methods ray-mip1", "did you mean 'ray-mip0'"},
        {"report railing -o r --frames 1", "2 to 10000"},
        {"mips", "SCENE is missing"},
        {"bounds --depths 0.4,-0.8", "Y1 < Y2"},
        {"bounds --depths 0.4", "2 numbers"},
        {"bounds --xi4 0.3", "the range is 0 to 0.25"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(2, cases[i].arguments);
        expect_text(err, cases[i].message);
    }
    assert_int_equal(count_files(), 0);
}

/* Nothing is left of a report that cannot be made; what was there stays. */
static void test_failures(void **state)
{
    (void)state;
    expect(1, "report no-such-scene.glb -o r -q");
    expect_text(err, "no-such-scene.glb");
    expect(1, "report railing -o r -q --camera CamNone --figures none");
    assert_int_equal(count_files(), 1); /* a page that names the commands that failed */
    expect_text(err, "commands failed; the page names them");
    FILE *file = fopen("taken", "wb");
    assert_non_null(file);
    fclose(file);
    expect(1, "report railing -o taken -q");
    expect_text(err, "a file of that name is there");
    expect(1, "mips railing -q");
    expect_text(err, "no alpha-tested texture");
    expect(1, "mips grove --material None -q");
    expect_text(err, "no material 'None'");
}

/* Ctrl-C: the processes end, and the folder is as before. */
static void test_interrupt(void **state)
{
    (void)state;
    const pid_t child = start("report railing -o r --quiet");
    while (!exists("r"))
        usleep(10000);
    usleep(300000);
    assert_int_equal(kill(child, SIGTERM), 0);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    read_all(".err", err, sizeof err);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 130)
        fail_msg("status %d; it said: %s", status, err);
    expect_text(err, "no partial file is left");
    assert_false(exists("r"));
}

static cJSON *read_json(const char *name)
{
    FILE *file = fopen(name, "rb");
    assert_non_null(file);
    static char text[1 << 21];
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    return json;
}

static const cJSON *run_of(const cJSON *data, double number)
{
    const cJSON *run = cJSON_GetArrayItem(member(data, "runs"), (int)number);
    assert_non_null(run);
    if (cJSON_GetObjectItem(run, "error"))
        fail_msg("%s: %s", get_string(run, "line"), get_string(run, "error"));
    return run;
}

static void expect_picture(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "r/images/%s", name);
    if (!exists(path))
        fail_msg("%s is not there", path);
}

static void test_report(void **state)
{
    (void)state;
    expect(0, "report railing -o r --json --figures sequence,moment3,moment8" SMALL);
    cJSON *data = read_json(".out");
    const cJSON *comparisons = member(data, "comparisons"), *figures = member(data, "figures");
    assert_int_equal(cJSON_GetArraySize(comparisons), 1);
    const cJSON *comparison = cJSON_GetArrayItem(comparisons, 0);
    assert_string_equal(get_string(comparison, "camera"), "CamRailing");
    for (const char *const *m = (const char *const[]){"ray-mip0", "lt-vsm", NULL}; *m; m++) {
        const cJSON *method = named(member(comparison, "methods"), *m);
        const cJSON *flip = member(run_of(data, get_number(method, "flip")), "result");
        const double mean = get_number(flip, "flip_mean");
        if (!(mean > 0 && mean < 0.5))
            fail_msg("FLIP of %s: %g", *m, mean);
        char name[128];
        snprintf(name, sizeof name, "railing.CamRailing.%s.png", *m);
        expect_picture(name);
    }
    expect_picture("railing.CamRailing.lt-vsm.class.png");
    expect_picture("railing.CamRailing.lt-vsm.flip.png");
    expect_picture("railing.bands.png");

    /* The figures that were asked for, in the order of the list, each with its commands. */
    static const char *const ids[] = {"sequence", "moment3", "moment8"};
    assert_int_equal(cJSON_GetArraySize(figures), 3);
    for (int i = 0; i < 3; i++) {
        const cJSON *figure = cJSON_GetArrayItem(figures, i), *number;
        assert_string_equal(get_string(figure, "id"), ids[i]);
        assert_true(cJSON_GetArraySize(member(figure, "runs")) > 0);
        cJSON_ArrayForEach(number, member(figure, "runs"))
            expect_text(get_string(run_of(data, number->valuedouble), "line"), "gnomon ");
    }
    const cJSON *first = cJSON_GetArrayItem(member(cJSON_GetArrayItem(figures, 0), "runs"), 0);
    const cJSON *bench = member(run_of(data, first->valuedouble), "result");
    const cJSON *series = member(named(member(bench, "methods"), "lt-vsm"), "series");
    assert_int_equal(cJSON_GetArraySize(member(series, "ms")), 2);

    /* A command can be run as it is printed, and makes the same picture. */
    const cJSON *shot = named(member(comparison, "methods"), "lt-vsm");
    const char *line = get_string(run_of(data, get_number(shot, "run")), "line");
    assert_int_equal(system("cp r/images/railing.CamRailing.lt-vsm.png before.png"), 0);
    assert_true(strncmp(line, "gnomon ", 7) == 0);
    expect(0, line + 7);
    assert_true(same_files("before.png", "r/images/railing.CamRailing.lt-vsm.png"));

    /* One page, nothing from elsewhere, nothing unfinished beside it. */
    static char page[1 << 21];
    read_all("r/index.html", page, sizeof page);
    expect_text(page, "Chart.js v");
    expect_text(page, "<h1>gnomon: report</h1>");
    assert_null(strstr(page, "src=\"http"));
    assert_null(strstr(page, "href=\"http"));
    assert_int_equal(system("test \"$(ls -A r | tr '\\n' ' ')\" = 'images index.html '"), 0);
    cJSON_Delete(data);
}

/* What Figure 3 of the moment paper shows: steps where xi4 is 0, and less shadow the larger it is.
 */
static void test_bounds(void **state)
{
    (void)state;
    expect(0, "bounds --xi4 0,1e-2,1e-1 --json");
    cJSON *json = parse_output();
    const cJSON *curves = member(json, "bounds"), *z = member(json, "z");
    const cJSON *shadow[3];
    for (int c = 0; c < 3; c++)
        shadow[c] = member(cJSON_GetArrayItem(curves, c), "shadow");
    for (int i = 0; i < cJSON_GetArraySize(z); i++) {
        const double depth = cJSON_GetArrayItem(z, i)->valuedouble;
        double value[3];
        for (int c = 0; c < 3; c++)
            value[c] = cJSON_GetArrayItem(shadow[c], i)->valuedouble;
        const double step = depth < -0.8 ? 0 : depth < 0.4 ? 0.4 : 1;
        const bool edge = fabs(depth + 0.8) < 0.02 || fabs(depth - 0.4) < 0.02;
        if (!edge && fabs(value[0] - step) > 1e-4)
            fail_msg("xi4 0, z %g: shadow %g, not %g", depth, value[0], step);
        if (!(value[1] <= value[0] + 1e-5 && value[2] <= value[1] + 1e-5))
            fail_msg("z %g: shadow %g, %g, %g", depth, value[0], value[1], value[2]);
    }
    cJSON_Delete(json);
}

/* Scaled alpha keeps the share of texels that pass (R11); averages do not. */
static void test_mips(void **state)
{
    (void)state;
    expect(0, "mips grove -o mips.png --json -q");
    cJSON *json = parse_output();
    const cJSON *levels = member(json, "levels"), *level;
    const double share = get_number(levels->child, "averaged");
    double farthest = 0;
    cJSON_ArrayForEach(level, levels)
    {
        const double texel = 1 / (get_number(level, "width") * get_number(level, "height"));
        const double rescaled = get_number(level, "rescaled");
        if (!(fabs(rescaled - share) <= texel))
            fail_msg("a share of %g, not %g", rescaled, share);
        farthest = fmax(farthest, fabs(get_number(level, "averaged") - share));
    }
    if (!(farthest > 0.02))
        fail_msg("averages differ by %g at most", farthest);
    assert_true(exists("mips.png"));
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_interrupt, setup, teardown),
        cmocka_unit_test_setup_teardown(test_report, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bounds, setup, teardown),
        cmocka_unit_test_setup_teardown(test_mips, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
