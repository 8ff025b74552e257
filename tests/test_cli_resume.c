/* Work that is interrupted, and sequences that go on. */
#include "cli_testing.h"

#define SHOT "leafbox --size 64x48 --fps 4 -q "
#define LEAK "--map-size 64 -m lt-vsm "

/* First of the frames that are missing. */
static unsigned count_frames(const char *pattern)
{
    unsigned frame = 0;
    for (char name[64];; frame++) {
        snprintf(name, sizeof name, pattern, frame);
        if (!exists(name))
            return frame;
    }
}

/* The same sequence without interruption, and the same bytes. */
static void assert_uninterrupted(const char *options, unsigned last)
{
    char arguments[512], a[64], b[64];
    snprintf(arguments, sizeof arguments, "render " SHOT "%s -o whole.png --frames 0:%u", options,
             last);
    expect(0, arguments);
    for (unsigned f = 0; f <= last; f++) {
        snprintf(a, sizeof a, "whole.%04u.png", f);
        snprintf(b, sizeof b, "part.%04u.png", f);
        if (!same_files(a, b))
            fail_msg("%s: frame %u of %u differs", options, f, last);
    }
}

static void interrupted_sequence(const char *options, int number, bool keeps)
{
    char arguments[512];
    snprintf(arguments, sizeof arguments,
             "render " SHOT "%s -o part.%%04d.png --frames 0:99999 --resume", options);
    assert_int_equal(interrupt(start(arguments), "part.0002.png", number), 130);
    expect_text(err, "are finished");
    assert_no_partial_files();
    const unsigned done = count_frames("part.%04u.png");
    assert_true(done >= 3);
    char finished[64];
    snprintf(finished, sizeof finished, "frames 0 to %u are finished", done - 1);
    expect_text(err, finished);
    assert_int_equal(exists("part.resume.png.history"), keeps);

    snprintf(arguments, sizeof arguments,
             "render " SHOT "%s -o part.%%04d.png --frames 0:%u --resume --json", options,
             done + 2);
    expect(0, arguments);
    cJSON *json = parse_output();
    assert_int_equal((unsigned)get_number(json, "skipped"), done);
    const cJSON *frames = member(json, "frames");
    assert_int_equal(cJSON_GetArraySize(frames), 3);
    assert_int_equal((unsigned)get_number(cJSON_GetArrayItem(frames, 0), "frame"), done);
    cJSON_Delete(json);
    assert_int_equal(exists("part.resume.png.history"), 0);
    assert_uninterrupted(options, done + 2);
}

static void test_leak_tracing_goes_on(void **state)
{
    (void)state;
    interrupted_sequence(LEAK, SIGINT, true);
}

/* The frame before is looked at again, or motion would be zero. */
static void test_rays_go_on(void **state)
{
    (void)state;
    interrupted_sequence("-m ray --aov motion", SIGTERM, false);
    char a[64], b[64];
    for (unsigned f = 0; f < count_frames("whole.%04u.png"); f++) {
        snprintf(a, sizeof a, "whole.%04u.motion.png", f);
        snprintf(b, sizeof b, "part.%04u.motion.png", f);
        assert_true(same_files(a, b));
    }
}

/* Without what was kept, pictures that are missing are made by going through those before. */
static void test_holes(void **state)
{
    (void)state;
    expect(0, "render " SHOT "--map-size 64 -m lt-evsm -o part.png --frames 0:5");
    assert_int_equal(system("rm part.0002.png part.0004.png && echo kept > part.0003.png"), 0);
    expect(0, "render leafbox --size 64x48 --fps 4 --map-size 64 -m lt-evsm -o part.png "
              "--frames 0:5 --resume");
    expect_text(err, "4 of 6 frames are there already");
    expect_text(err, "frames 0 to 1 are rendered again, and not written");
    char text[16];
    read_all("part.0003.png", text, sizeof text);
    assert_string_equal(text, "kept\n"); /* not written again */
    assert_int_equal(system("rm part.0003.png"), 0);
    expect(0, "render " SHOT "--map-size 64 -m lt-evsm -o part.png --frames 0:5 --resume");
    assert_uninterrupted("--map-size 64 -m lt-evsm", 5);

    /* Nothing to do. */
    expect(0, "render " SHOT "--map-size 64 -m lt-evsm -o part.png --frames 0:5 --resume --json");
    cJSON *json = parse_output();
    assert_int_equal((int)get_number(json, "skipped"), 6);
    assert_int_equal(cJSON_GetArraySize(member(json, "frames")), 0);
    cJSON_Delete(json);
    assert_int_equal(count_files(), 12);
}

static void test_refusals(void **state)
{
    (void)state;
    expect(2, "render leafbox -o a.png --resume");
    expect_text(err, "--frames A:B is missing");
    expect(2, "render leafbox -o a.png --frames 0:2 --resume --history-out h");
    expect_text(err, "exclude each other");

    assert_int_equal(interrupt(start("render " SHOT LEAK "-o part.png --frames 0:9999 "
                                     "--resume"),
                               "part.0001.png", SIGINT),
                     130);
    const unsigned done = count_frames("part.%04u.png");
    static const struct {
        const char *options, *reason;
    } others[] = {{"-m lt-evsm --fps 4", "'method: lt-vsm', and now 'method: lt-evsm'"},
                  {"-m lt-vsm --fps 5", "'frames: 4 a second"},
                  {"-m lt-vsm --fps 4 --seed 2", "another scene"},
                  {"-m lt-vsm --fps 4 --depth-bias 0.01", "biases: depth=-1"},
                  {"-m lt-vsm --fps 4 --no-reuse", "enlarge=0 refresh=1"},
                  {"-m lt-vsm --fps 4 --leak-epsilon 0.02", "leak: "}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        char arguments[256];
        snprintf(arguments, sizeof arguments,
                 "render leafbox --size 64x48 --map-size 64 -o part.png --frames 0:9999 --resume "
                 "-q %s",
                 others[i].options);
        expect(1, arguments);
        expect_text(err, others[i].reason);
        expect_text(err, "part.resume.png.history");
    }
    /* A state that is no history. */
    assert_int_equal(system("echo junk > part.resume.png.history"), 0);
    expect(1, "render " SHOT LEAK "-o part.png --frames 0:9999 --resume");
    expect_text(err, "part.resume.png.history");
    assert_int_equal(count_frames("part.%04u.png"), done);
    assert_no_partial_files();
}

/* Other commands leave whole files too, and say how far they came. */
static void test_other_commands(void **state)
{
    (void)state;
    assert_int_equal(interrupt(start("demo -o page --size 96x64 --scale 0.02 -q"),
                               "page/grove.ray-mip0.png", SIGINT),
                     130);
    expect_text(err, "pictures of grove are written, and no page");
    assert_int_equal(system("ls page | grep -q -e part -e html"), 256);

    const pid_t bench = start("bench leafbox --size 64x48 --methods ray --repeats 1000 "
                              "--frames 500");
    assert_int_equal(interrupt(bench, ".err", SIGINT), 130);
    expect_text(err, "interrupted; ");
    assert_string_equal(out, "");
    const pid_t compare =
        start("compare grove --scale 0.02 --size 320x240 --a reference --b ray -o a.png");
    assert_int_equal(interrupt(compare, ".err", SIGTERM), 130);
    expect_text(err, "interrupted; ");
    assert_int_equal(exists("a.png"), 0);
    assert_no_partial_files();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_leak_tracing_goes_on, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rays_go_on, setup, teardown),
        cmocka_unit_test_setup_teardown(test_holes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_refusals, setup, teardown),
        cmocka_unit_test_setup_teardown(test_other_commands, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
