/* --camera-path from outside: where the camera is, and what is said of files that are wrong. */
#include "cli_testing.h"

#include <gnomon/gnomon.h>

#include "base/base.h"
#include "scene/scene.h"

static void write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

#define SIZE 48u

/* What the camera of these keys sees at a time, as bytes. */
static void render_at(const char *json, const char *time, uint8_t pixels[4 * SIZE * SIZE])
{
    static uint8_t bytes[1 << 16];
    char command[256];
    write_file("path.json", json);
    snprintf(command, sizeof command,
             "render leafbox --size 48x48 --quiet -m ray-mip0 --camera-path path.json --time %s "
             "-o shown.png",
             time);
    expect(0, command);
    FILE *file = fopen("shown.png", "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    gn_device *device;
    assert_int_equal(gn_device_create(NULL, &device), GN_OK);
    gn_context *context = gn_device_context(device);
    uint32_t width, height;
    uint8_t *rgba;
    if (gn_image_decode(context, "shown.png", bytes, size, &width, &height, &rgba) != GN_OK)
        fail_msg("%s", gn_device_message(device));
    assert_int_equal(width, SIZE);
    assert_int_equal(height, SIZE);
    memcpy(pixels, rgba, 4 * (size_t)width * height);
    gn_free(context, rgba);
    gn_device_destroy(&device);
}

/* Pixels that differ between what two files' cameras see. */
static unsigned count_different(const char *a, const char *time_a, const char *b,
                                const char *time_b)
{
    static uint8_t shown[2][4 * SIZE * SIZE];
    render_at(a, time_a, shown[0]);
    render_at(b, time_b, shown[1]);
    unsigned count = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++)
        count += memcmp(shown[0] + 4 * i, shown[1] + 4 * i, 4) != 0;
    return count;
}

static void expect_same(const char *a, const char *time_a, const char *b, const char *time_b)
{
    const unsigned count = count_different(a, time_a, b, time_b);
    if (count > SIZE * SIZE / 200) /* rounding, at edges */
        fail_msg("%u pixels differ between %s at %s s and %s at %s s", count, a, time_a, b, time_b);
}

#define FRONT                                                                                      \
    "{\"fov\": 40, \"keys\": [{\"time\": 0, \"position\": [0.5, 2.5, 8.2], \"look_at\": [0.5, "    \
    "2.5, "                                                                                        \
    "0]}]}"

/* The light stands still and nothing moves in the leaf box: only the camera counts. */
static void looking_at_a_point_is_looking_along_a_direction(void **state)
{
    (void)state;
    expect_same(FRONT, "0",
                "{\"keys\": [{\"direction\": [0, 0, -3], \"up\": [0, 7, 2], \"time\": 3, "
                "\"position\": [0.5, 2.5, 8.2]}], \"fov\": 40}",
                "1.5");
    /* A camera that lies on its side, or is elsewhere, or has another lens, sees something else. */
    static const char *const others[] = {
        "{\"fov\": 40, \"keys\": [{\"time\": 0, \"position\": [0.5, 2.5, 8.2], \"look_at\": [0.5, "
        "2.5, 0], \"up\": [1, 0, 0]}]}",
        "{\"fov\": 40, \"keys\": [{\"time\": 0, \"position\": [0, 2.5, 8.2], \"look_at\": [0.5, "
        "2.5, 0]}]}",
        "{\"keys\": [{\"time\": 0, \"position\": [0.5, 2.5, 8.2], \"look_at\": [0.5, 2.5, 0]}]}"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        const unsigned count = count_different(FRONT, "0", others[i], "0");
        if (count < SIZE * SIZE / 5)
            fail_msg("only %u pixels differ with %s", count, others[i]);
    }
}

static void a_camera_moves_between_its_keys(void **state)
{
    (void)state;
    /* A quarter of the way from 0 to 2, turning from straight ahead to the right by 40 degrees. */
    static const char path[] =
        "{\"fov\": 40, \"keys\": ["
        "{\"time\": 1, \"position\": [0, 2.5, 8.2], \"direction\": [0, 0, -1]},"
        "{\"time\": 3, \"position\": [2, 2.5, 8.2], \"direction\": [0.6427876, 0, -0.7660444]}]}";
    static const char quarter[] =
        "{\"fov\": 40, \"keys\": [{\"time\": 0, \"position\": [0.5, 2.5, 8.2], \"direction\": "
        "[0.1736482, 0, -0.9848078]}]}";
    expect_same(path, "1.5", quarter, "0");
    /* Before the first key and after the last it rests. */
    expect_same(path, "0", path, "1");
    expect_same(path, "9", path, "3");
}

/* Each wrong file is named with its field, and nothing is written. */
static void wrong_files_are_refused(void **state)
{
    (void)state;
#define KEY(text) "{\"keys\": [{" text "}]}"
    static const struct {
        const char *json, *message;
    } cases[] = {
        {"", "bad.json: line 1: not JSON"},
        {"{\"keys\":\n[,]}", "bad.json: line 2: not JSON"},
        {"[]", "bad.json: is not a JSON object"},
        {"{}", "bad.json: keys: is missing"},
        {"{\"keys\": 3}", "keys: is not a list"},
        {"{\"keys\": []}", "at least one key"},
        {"{\"keys\": [3]}", "keys[0]: is not an object"},
        {"{\"fov\": 180, \"keys\": []}", "fov: is not a number of degrees from 1 to 179"},
        {"{\"lens\": 1, \"keys\": []}", "lens: no such field"},
        {KEY("\"time\": 0, \"positon\": [0, 0, 1]"),
         "keys[0].positon: no such field; did you mean"},
        {KEY("\"position\": [0, 0, 1]"), "keys[0].time: is missing"},
        {KEY("\"time\": -1"), "keys[0].time: is not a number of seconds"},
        {KEY("\"time\": 0"), "keys[0].position: is missing"},
        {KEY("\"time\": 0, \"position\": [0, \"a\", 1]"), "keys[0].position: is not [x, y, z]"},
        {KEY("\"time\": 0, \"position\": [0, 1e300, 1]"), "keys[0].position: is not [x, y, z]"},
        {KEY("\"time\": 0, \"position\": [0, 0, 1]"), "keys[0]: needs either look_at or direction"},
        {KEY("\"time\": 0, \"position\": [0, 0, 1], \"look_at\": [0, 0, 1]"),
         "keys[0].look_at: is the position"},
        {KEY("\"time\": 0, \"position\": [0, 0, 1], \"direction\": [0, 0, 0]"),
         "keys[0].direction: has no length"},
        {KEY("\"time\": 0, \"position\": [0, 0, 1], \"direction\": [0, 2, 0]"),
         "keys[0].up: points where the camera looks"},
        {"{\"keys\": [{\"time\": 2, \"position\": [0, 0, 1], \"direction\": [0, 0, 1]}, {\"time\": "
         "2, \"position\": [0, 0, 1], \"direction\": [0, 0, 1]}]}",
         "keys[1].time: 2 is not later than the 2 of the key before"},
    };
    remove("shown.png");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_file("bad.json", cases[i].json);
        expect(1, "render leafbox --size 16x16 --quiet --camera-path bad.json -o shown.png");
        expect_text(err, cases[i].message);
    }
    assert_false(exists("shown.png"));
    expect(1, "bench leafbox --size 16x16 --quiet --camera-path nothing.json");
    expect_text(err, "nothing.json");
    expect(2, "render leafbox -q -c CamFront --camera-path bad.json -o shown.png");
    expect_text(err, "--camera and --camera-path exclude each other");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looking_at_a_point_is_looking_along_a_direction),
        cmocka_unit_test(a_camera_moves_between_its_keys),
        cmocka_unit_test(wrong_files_are_refused),
    };
    return cmocka_run_group_tests_name("command line, camera paths", tests, setup, teardown);
}
