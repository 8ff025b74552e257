/* The built program with its tracers: choices, one picture, limits that are told, AOVs, numbers. */
#include "cli_testing.h"

#include <math.h>
#include <spng.h>

/* A sun over opaque walls; a sun over foliage; a lamp among leaves. */
#define COURT   " court --size 96x64 --quiet "
#define GROVE   " grove --scale 0.01 --size 96x64 --quiet "
#define LEAFBOX " leafbox --size 96x64 --quiet "
#define PIXELS  (96 * 64)

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"render" COURT "-o a.png --tracer tree", "one of auto, bvh, light-buffer"},
        {"render" COURT "-o a.png --tracer", "needs a value: one of auto, bvh, light-buffer"},
        {"render" COURT "-o a.png --light-buffer-limit -1", "'-1' is not a number from 0"},
        {"render" COURT "-o a.png --light-buffer-limit nan", "'nan' is not a number from 0"},
        {"render" COURT "-o a.png --light-buffer-limit 1MB", "'1MB' is not a number from 0"},
        {"render" COURT "-o a.png --trace bvh", "one of all, none, leak"},
        {"render" COURT "-o a.png -m vsm --tracer bvh", "--tracer: no method that traces rays"},
        {"render" COURT "-o a.png -m ray:bvh --light-buffer-limit 9", "no method may use a light"},
        {"render" COURT "-o a.png -m ray:light-bufer", "did you mean 'light-buffer'"},
        {"render" COURT "-o a.png -m ray:bvh:light-buffer", "exclude each other"},
        {"render" COURT "-o a.png -m ray:bvh=1", "takes no number"},
        {"render" COURT "-o a.png -m vsm:bvh", "vsm traces no rays"},
        {"render" COURT "-o a.png -m vsm --aov lists", "vsm traces no rays"},
        {"render" COURT "-o a.png -m ray:bvh --aov lists", "traced by the tree"},
        {"render" COURT "-o a.png --tracer bvh --aov light-buffer", "traced by the tree"},
        {"render" COURT "-o a.png --aov light_buffer", "there are: visibility"},
        {"bench" COURT "-m naive:bvh", "naive takes no modifiers"},
        {"bench" COURT "-m 'maps:light-buffer'", "traces no rays"},
        {"compare" COURT "--a reference:bvh --b ray", "reference takes no modifiers"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(2, cases[i].arguments);
        expect_text(err, cases[i].message);
        assert_string_equal(out, "");
    }
    assert_int_equal(count_files(), 0);
}

/* The light buffer answers, and says what the tree says, but for rounding. */
static void test_same_picture(void **state)
{
    (void)state;
    static const char *const cases[] = {
        COURT "--a ray-saturate:bvh --b ray-saturate:light-buffer",
        GROVE "--a ray-saturate:bvh --b ray-saturate:light-buffer",
        LEAFBOX "--a ray-saturate:bvh --b ray-saturate:light-buffer",
        LEAFBOX "--a ray-raw:bvh --b ray-raw:light-buffer",
        LEAFBOX "--map-size 64 --warm-up 0 --a lt-vsm:bvh --b lt-vsm:light-buffer",
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char command[256];
        snprintf(command, sizeof command, "compare%s --json", cases[i]);
        expect(0, command);
        cJSON *json = parse_output();
        const cJSON *a = member(json, "a"), *b = member(json, "b"),
                    *difference = cJSON_GetArrayItem(member(json, "differences"), 0),
                    *buffer = member(b, "light_buffer");
        const double wrong = get_number(difference, "wrong_pixels");
        assert_string_equal(get_string(a, "tracer"), "bvh");
        assert_string_equal(get_string(b, "tracer"), "light-buffer");
        assert_null(cJSON_GetObjectItem(a, "light_buffer"));
        assert_null(cJSON_GetObjectItem(b, "fallback"));
        if (wrong > 1e-5 || get_number(difference, "mean_abs") > 1e-4)
            fail_msg("%s: %g of the pixels are wrong, mean error %g", cases[i], wrong,
                     get_number(difference, "mean_abs"));
        /* A view at rest: what was built before the runs is kept. */
        if (!(get_number(buffer, "tiles") > 0 && get_number(buffer, "entries") > 0 &&
              get_number(buffer, "bytes") > 0 && get_number(b, "build_ms") > 0) ||
            get_number(buffer, "built") != 0)
            fail_msg("%s: %g tiles, %g built again, %g entries, %g bytes, %g ms", cases[i],
                     get_number(buffer, "tiles"), get_number(buffer, "built"),
                     get_number(buffer, "entries"), get_number(buffer, "bytes"),
                     get_number(b, "build_ms"));
        cJSON_Delete(json);
    }
    expect(0, "compare" LEAFBOX "--a ray:bvh --b ray:light-buffer");
    expect_text(out, "by bvh\n");
    expect_text(out, "by light-buffer: ");
}

/* Without memory the tree answers, to the bit, and the user hears of it. */
static void test_limit(void **state)
{
    (void)state;
    expect(0, "compare" LEAFBOX "--a ray:bvh --b ray:light-buffer --light-buffer-limit 0 --json");
    cJSON *json = parse_output();
    const cJSON *b = member(json, "b"), *buffer = cJSON_GetObjectItem(b, "light_buffer");
    const cJSON *difference = cJSON_GetArrayItem(member(json, "differences"), 0);
    if (get_number(difference, "max_abs") != 0)
        fail_msg("a difference of %g", get_number(difference, "max_abs"));
    expect_text(get_string(b, "fallback"), "beyond 0 MB");
    expect_text(get_string(b, "fallback"), "the tree traced 100 % of the rays");
    if (buffer && get_number(buffer, "tree_rays") != get_number(b, "rays_per_pixel") * PIXELS)
        fail_msg("the tree traced %g of %g rays", get_number(buffer, "tree_rays"),
                 get_number(b, "rays_per_pixel") * PIXELS);
    cJSON_Delete(json);

    /* In between some tiles are there, and none is beyond the limit. */
    expect(0, "render court --size 96x64 -o a.png --tracer light-buffer "
              "--light-buffer-limit 1 --json");
    expect_text(err, "note: ray-coverage: ");
    expect_text(err, "beyond 1 MB");
    json = parse_output();
    const cJSON *frame = cJSON_GetArrayItem(member(json, "frames"), 0);
    buffer = member(frame, "light_buffer");
    expect_text(get_string(json, "fallback"), "beyond 1 MB");
    if (!(get_number(buffer, "bytes") <= 1048576 && get_number(buffer, "refused") > 0 &&
          get_number(buffer, "tree_rays") > 0 &&
          get_number(buffer, "tree_rays") <= get_number(frame, "rays")))
        fail_msg("%g bytes, %g refused, %g of %g rays", get_number(buffer, "bytes"),
                 get_number(buffer, "refused"), get_number(buffer, "tree_rays"),
                 get_number(frame, "rays"));
    cJSON_Delete(json);
    expect(0, "bench" LEAFBOX "-m ray:light-buffer --light-buffer-limit 0 --frames 1 -r 1");
    expect_text(out, "ray-coverage:light-buffer: ");
    expect_text(out, "beyond 0 MB");
}

/* Pixels of a picture of this size; 3 bytes each. */
static uint8_t *read_png(const char *name, uint32_t width, uint32_t height)
{
    FILE *stream = fopen(name, "rb");
    if (!stream)
        fail_msg("%s is not there", name);
    spng_ctx *png = spng_ctx_new(0);
    assert_int_equal(spng_set_png_file(png, stream), 0);
    struct spng_ihdr header;
    assert_int_equal(spng_get_ihdr(png, &header), 0);
    if (header.width != width || header.height != height)
        fail_msg("%s has %u x %u pixels", name, header.width, header.height);
    const size_t size = (size_t)width * height * 3;
    uint8_t *pixels = malloc(size);
    assert_non_null(pixels);
    assert_int_equal(spng_decode_image(png, pixels, size, SPNG_FMT_RGB8, 0), 0);
    spng_ctx_free(png);
    fclose(stream);
    return pixels;
}

/* Pixels of this grey: 0, a list that holds nothing; 96, none at all. */
static unsigned count_grey(const uint8_t *pixels, size_t count, uint8_t value)
{
    unsigned grey = 0;
    for (size_t i = 0; i < count; i++, pixels += 3)
        grey += pixels[0] == value && pixels[1] == value && pixels[2] == value;
    return grey;
}

static void test_aovs(void **state)
{
    (void)state;
    expect(0, "render" COURT "-o a.png --frames 0:1 --tracer light-buffer -m ray-saturate "
              "--aov lists,light-buffer,rays --json");
    cJSON *json = parse_output();
    const cJSON *frame;
    int number = 0;
    cJSON_ArrayForEach(frame, member(json, "frames"))
    {
        const cJSON *files = member(frame, "files"), *lists = member(frame, "lists");
        char name[64];
        assert_int_equal(cJSON_GetArraySize(files), 4);
        assert_int_equal(cJSON_GetArraySize(lists), 2);
        for (int i = 0; i < 2; i++) {
            const cJSON *entry = cJSON_GetArrayItem(lists, i);
            snprintf(name, sizeof name, "a.%04d.%s.png", number, i ? "light-buffer" : "lists");
            assert_string_equal(get_string(entry, "file"), name);
            assert_true(get_number(entry, "most") > 0);
            assert_true((cJSON_GetObjectItem(entry, "extent") != NULL) == (i == 1));
            uint8_t *pixels = read_png(name, i ? 1024 : 96, i ? 1024 : 64);
            const size_t count = i ? 1024 * 1024 : PIXELS;
            const unsigned nothing = count_grey(pixels, count, 0),
                           none = count_grey(pixels, count, 96);
            if (i == 0 &&
                !((double)(count - nothing) <= get_number(frame, "rays") && nothing < count))
                fail_msg("%s: %zu of %zu pixels have lists, of %g rays", name, count - nothing,
                         count, get_number(frame, "rays"));
            if (nothing + none == count || (i == 0 && none > 0))
                fail_msg("%s: of %zu pixels %u list nothing, %u are empty", name, count, nothing,
                         none);
            free(pixels);
        }
        number++;
    }
    assert_int_equal(number, 2);
    cJSON_Delete(json);

    /* A lamp has six faces. Beside an EXR only what has a size of its own stands in a file. */
    expect(0, "render leafbox --size 96x64 -o b.png --tracer light-buffer --aov light-buffer");
    expect_text(err, "b.light-buffer.png: Lamp, at most ");
    free(read_png("b.light-buffer.png", 6 * 512, 512));
    expect(0, "render" LEAFBOX "-o c.exr --tracer light-buffer --aov lists,light-buffer");
    assert_true(exists("c.exr") && exists("c.light-buffer.exr") && !exists("c.lists.exr"));
}

/* The numbers of a method are those of its frames. */
static void check_light_buffer(const cJSON *row, int frames)
{
    const cJSON *buffer = member(row, "light_buffer"),
                *series = member(member(row, "series"), "light_buffer");
    static const struct {
        const char *key;
        bool last; /* of the last frame, not a mean */
    } keys[] = {{"tiles", true},      {"entries", true},  {"bytes", true},
                {"built", false},     {"refused", false}, {"triangles", false},
                {"tree_rays", false}, {"build_ms", false}};
    for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
        const cJSON *list = member(series, keys[k].key), *value;
        assert_int_equal(cJSON_GetArraySize(list), frames);
        double mean = 0, last = 0;
        cJSON_ArrayForEach(value, list)
        {
            last = value->valuedouble;
            mean += last / frames;
        }
        const double expected = keys[k].last ? last : mean, got = get_number(buffer, keys[k].key);
        if (fabs(got - expected) > 1e-9 * fmax(1, expected))
            fail_msg("%s is %g, its frames say %g", keys[k].key, got, expected);
    }
    assert_true(get_number(buffer, "build_ms") <= get_number(row, "ms_mean"));
    assert_true(get_number(buffer, "build_ms") <= get_number(buffer, "build_ms_max"));
    assert_true(get_number(member(buffer, "warm_up"), "build_ms") > 0);
    assert_true(get_number(member(buffer, "warm_up"), "built") > 0);
}

static void test_bench(void **state)
{
    (void)state;
    expect(0, "bench court --camera CamWalk --size 96x64 --quiet --frames 3 --fps 8 -r 1 --json "
              "-m ray-mip0:light-buffer,vsm --map-size 64 --warm-up 1");
    cJSON *json = parse_output();
    const cJSON *methods = member(json, "methods");
    const cJSON *tree = named(methods, "ray-mip0:bvh"),
                *buffer = named(methods, "ray-mip0:light-buffer"), *map = named(methods, "vsm");
    assert_string_equal(get_string(tree, "tracer"), "bvh");
    assert_string_equal(get_string(buffer, "tracer"), "light-buffer");
    assert_null(cJSON_GetObjectItem(map, "tracer"));
    assert_null(cJSON_GetObjectItem(tree, "light_buffer"));
    assert_null(cJSON_GetObjectItem(member(tree, "series"), "light_buffer"));
    check_light_buffer(buffer, 3);
    /* The tree is run as what the light buffer is held against. */
    assert_string_equal(get_string(buffer, "yardstick"), "ray-mip0:bvh");
    if (get_number(buffer, "wrong_max") > 1e-4)
        fail_msg("%g of the pixels are wrong", get_number(buffer, "wrong_max"));
    assert_true(get_number(buffer, "ms_ratio") > 0);
    cJSON_Delete(json);

    expect(0, "bench" LEAFBOX "-m ray-raw:light-buffer --frames 1 -r 1");
    expect_text(out, "entries");
    expect_text(out, "ray-raw:bvh");
    expect(0, "bench" LEAFBOX "-m ray-raw --tracer bvh --frames 1 -r 1");
    expect_text(out, "All rays were answered by the tree");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_same_picture, setup, teardown),
        cmocka_unit_test_setup_teardown(test_limit, setup, teardown),
        cmocka_unit_test_setup_teardown(test_aovs, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bench, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
