/* The built program with leak tracing: names with modifiers, parts, pictures, histories, numbers.
 */
#include "cli_testing.h"

#include <math.h>
#include <spng.h>

/* Small and quick; a camera that walks, an object that moves, a sun. */
#define SHOT   " court --camera CamWalk --size 96x64 --quiet "
#define SMALL  " --map-size 256 "
#define PIXELS (96 * 64)

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"render" SHOT "-o a.png -m lt-vsm:mip1", "did you mean 'mip0'"},
        {"render" SHOT "-o a.png -m lt-vsm:", "no modifier ''"},
        {"render" SHOT "-o a.png -m lt-vsm::full", "no modifier ''"},
        {"render" SHOT "-o a.png -m lt-vsn:full", "did you mean 'lt-vsm'"},
        {"render" SHOT "-o a.png -m ray-mip0:saturate", "the alpha rule of a ray is in its name"},
        {"render" SHOT "-o a.png -m ray:no-mask", "ray-coverage has no map"},
        {"render" SHOT "-o a.png -m vsm:mip0", "vsm traces no rays"},
        {"render" SHOT "-o a.png -m ltt-vsm:no-mask", "ltt-vsm has no mask"},
        {"render" SHOT "-o a.png -m ltt-vsm:full", "':full' is about a mask"},
        {"render" SHOT "-o a.png -m lt-vsm:no-expand:no-mask", "':no-expand' is about a mask"},
        {"render" SHOT "-o a.png -m lt-vsm:no-mask:no-expand", "':no-expand' is about a mask"},
        {"render" SHOT "-o a.png -m lt-vsm:mip0:raw", "exclude each other"},
        {"render" SHOT "-o a.png -m lt-vsm:depth-test:no-depth-test", "exclude each other"},
        {"render" SHOT "-o a.png -m lt-vsm:refresh=4:no-reuse", "exclude each other"},
        {"render" SHOT "-o a.png -m lt-nlmsm64:filtered", "reads filtered texels already"},
        {"render" SHOT "-o a.png -m hybrid-pcf:filtered", "cannot be filtered"},
        {"render" SHOT "-o a.png -m lt-vsm:size", "a whole number from 16 to 16384"},
        {"render" SHOT "-o a.png -m lt-vsm:size=64.5", "a whole number from 16 to 16384"},
        {"render" SHOT "-o a.png -m lt-vsm:size=64x", "a whole number from 16 to 16384"},
        {"render" SHOT "-o a.png -m lt-vsm:size=8", "a whole number from 16 to 16384"},
        {"render" SHOT "-o a.png -m lt-vsm:refresh=0", "a whole number from 1 to 64"},
        {"render" SHOT "-o a.png -m lt-vsm:undrawn=-1", "a whole number from 0 to 8"},
        {"render" SHOT "-o a.png -m lt-vsm:epsilon=nan", "a number from 0 to 0.49"},
        {"render" SHOT "-o a.png -m lt-vsm:full=1", "takes no number"},
        {"render" SHOT "-o a.png -m lt-vsm --leak-epsilon 0.5", "a number from 0 to 0.49"},
        {"render" SHOT "-o a.png -m lt-vsm --leak-kernel 3x3", "one of gather, full"},
        {"render" SHOT "-o a.png -m lt-vsm --depth-test yes", "one of auto, off, on"},
        {"render" SHOT "-o a.png -m ltt-vsm --no-expand", "no method with a mask"},
        {"render" SHOT "-o a.png -m vsm --leak-epsilon 0.1", "no method of leak tracing"},
        {"render" SHOT "-o a.png -m lt-vsm --refresh 65", "from 1 to 64"},
        {"render" SHOT "-o a.png -m lt-vsm --undrawn 5", "cascades"},
        {"render" SHOT "-o a.png --refresh 2", "--refresh: no method that reads a map"},
        {"render" SHOT "-o a.png --trace leak", "nothing says where a ray is needed"},
        {"render" SHOT "-o a.png --map depth --trace leak", "one depth is never unsure"},
        {"render" SHOT "-o a.png --map vsm --no-mask", "--no-mask goes with --trace leak"},
        {"render" SHOT "-o a.png --map vsm --trace some", "one of all, none, leak"},
        {"render" SHOT "-o a.png -m vsm --aov class", "vsm is no leak tracing"},
        {"render" SHOT "-o a.png -m ray --aov class", "ray-coverage is no leak tracing"},
        {"render" SHOT "-o a.png -m vsm --aov rays", "vsm traces no rays"},
        {"render" SHOT "-o a.png -m lt-vsm --history-in a --warm-up 2", "exclude each other"},
        {"bench" SHOT "-m leaks:full", "'ltt-vsm:full'"},
        {"bench" SHOT "-m naive:full", "naive has no map"},
        {"bench" SHOT "-m 'xt-*:full'", "no method is like 'xt-*'"},
        {"bench" SHOT "--evaluate -m lt-vsm", "maps alone are read here"},
        {"compare" SHOT "--a lt-vsm:foo --b ray", "no modifier 'foo' of methods; there are: mip0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(2, cases[i].arguments);
        expect_text(err, cases[i].message);
        assert_string_equal(out, "");
    }
    assert_int_equal(count_files(), 0);
}

/* Files of the past that are none, and places where none can be written. */
static void test_failures(void **state)
{
    (void)state;
    FILE *file = fopen("junk", "wb");
    assert_non_null(file);
    fputs("not what a view remembers", file);
    fclose(file);
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"render" SHOT SMALL "-m lt-vsm -o a.png --history-in nowhere", "nowhere: cannot read"},
        {"render" SHOT SMALL "-m lt-vsm -o a.png --history-in junk", "junk"},
        {"render" SHOT SMALL "-m lt-vsm -o a.png --history-out no/h", "no/h: cannot write"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(1, cases[i].arguments);
        expect_text(err, cases[i].message);
        assert_true(exists("a.png") == (i == 2));
    }
    assert_int_equal(count_files(), 2); /* with the picture, which was whole before */
}

/* Mean visibility, rays and what the map is unsure of, summed over some frames in motion, when the
 * maps are drawn and the mask has settled. */
typedef struct facts {
    double mean, rays, unsure;
} facts;

static facts facts_of(const char *arguments)
{
    char command[512];
    snprintf(command, sizeof command,
             "render" SHOT "-o m.png --json --frames 9:12 --warm-up 9 --fps 8 %s", arguments);
    expect(0, command);
    cJSON *json = parse_output();
    const cJSON *frame;
    facts f = {0};
    cJSON_ArrayForEach(frame, member(json, "frames"))
    {
        const cJSON *leak = cJSON_GetObjectItem(frame, "leak");
        f.mean += cJSON_GetArrayItem(member(frame, "mean_visibility"), 0)->valuedouble;
        f.rays += get_number(frame, "rays");
        f.unsure += leak ? get_number(leak, "unsure") : 0;
    }
    cJSON_Delete(json);
    return f;
}

/* A modifier, the option and the part that mean the same do the same; others do something. */
static void test_modifiers(void **state)
{
    (void)state;
    static const struct {
        const char *a, *b;
        bool same;
    } pairs[] = {
        {"-m lt-vsm" SMALL, "--map vsm --single-depth --trace leak" SMALL, true},
        {"-m lt-vsm" SMALL, "-m lt-vsm:size=256", true},
        {"-m lt-vsm" SMALL, "-m lt-vsm:saturate" SMALL, true},
        {"-m lt-vsm" SMALL, "-m lt-vsm --refresh 8 --undrawn 1" SMALL, true},
        {"-m lt-vsm" SMALL, "-m lt-vsm:epsilon=0.01:no-depth-test" SMALL, true},
        {"-m lt-vsm" SMALL, "-m lt-vsm:size=64" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:no-mask" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:no-expand" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:no-remove" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:full" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:depth-test" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:epsilon=0.2" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:filtered" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:undrawn=2" SMALL, false},
        {"-m lt-vsm" SMALL, "-m lt-vsm:no-reuse" SMALL, false},
        {"-m lt-vsm:no-mask" SMALL, "-m ltt-vsm" SMALL, true},
        {"-m lt-vsm:no-mask" SMALL, "--map vsm --single-depth --trace leak --no-mask" SMALL, true},
        {"-m lt-vsm:no-expand" SMALL, "-m lt-vsm --no-expand" SMALL, true},
        {"-m lt-vsm:no-remove" SMALL, "-m lt-vsm --no-remove" SMALL, true},
        {"-m lt-vsm:full" SMALL, "-m lt-vsm --leak-kernel full" SMALL, true},
        {"-m lt-vsm:depth-test" SMALL, "-m lt-vsm --depth-test on" SMALL, true},
        {"-m lt-vsm:epsilon=0.2" SMALL, "-m lt-vsm --leak-epsilon 0.2" SMALL, true},
        {"-m lt-vsm:filtered" SMALL, "--map vsm --map-bits 64 --trace leak" SMALL, true},
        {"-m lt-vsm:no-reuse" SMALL, "-m lt-vsm --no-reuse" SMALL, true},
        {"-m hybrid-pcf" SMALL, "--map pcf --trace leak" SMALL, true},
        {"-m vsm:size=128", "-m vsm --map-size 128", true},
    };
    facts a = {0};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        if (i == 0 || strcmp(pairs[i].a, pairs[i - 1].a) != 0)
            a = facts_of(pairs[i].a);
        const facts b = facts_of(pairs[i].b);
        if ((a.mean == b.mean && a.rays == b.rays && a.unsure == b.unsure) != pairs[i].same)
            fail_msg("'%s' gives %.9g with %g rays and %g unsure, '%s' %.9g with %g and %g",
                     pairs[i].a, a.mean, a.rays, a.unsure, pairs[i].b, b.mean, b.rays, b.unsure);
    }
}

/* The alpha rule is that of the rays. Leaves, lamp. */
static void test_alpha(void **state)
{
    (void)state;
    double means[4];
    static const char *const methods[] = {"ray-mip0:bvh", "ray-raw:bvh", "lt-vsm:mip0",
                                          "lt-vsm:raw"};
    for (int i = 0; i < 4; i++) {
        char command[256];
        snprintf(command, sizeof command,
                 "render leafbox --size 96x64 --quiet -m %s -o a.png --json", methods[i]);
        expect(0, command);
        cJSON *json = parse_output();
        const cJSON *frame = cJSON_GetArrayItem(member(json, "frames"), 0);
        means[i] = cJSON_GetArrayItem(member(frame, "mean_visibility"), 0)->valuedouble;
        cJSON_Delete(json);
    }
    /* Nothing was there before: all are traced. */
    for (int i = 0; i < 4; i++)
        if ((means[i] == means[0]) != (i % 2 == 0))
            fail_msg("%s gives %.9g, %s %.9g", methods[i], means[i], methods[0], means[0]);
    assert_true(means[1] == means[3]);
}

static uint32_t read_png(const char *name, uint8_t *pixels, size_t size)
{
    FILE *stream = fopen(name, "rb");
    if (!stream)
        fail_msg("%s is not there", name);
    spng_ctx *png = spng_ctx_new(0);
    assert_int_equal(spng_set_png_file(png, stream), 0);
    struct spng_ihdr header;
    assert_int_equal(spng_get_ihdr(png, &header), 0);
    assert_int_equal(header.width * header.height, PIXELS);
    size_t bytes;
    assert_int_equal(spng_decoded_image_size(png, SPNG_FMT_RAW, &bytes), 0);
    assert_true(bytes <= size);
    assert_int_equal(spng_decode_image(png, pixels, bytes, SPNG_FMT_RAW, 0), 0);
    spng_ctx_free(png);
    fclose(stream);
    return (uint32_t)(bytes / PIXELS);
}

/* Classes and rays of a sequence fit each other, the numbers and the paper's table. */
static void test_aovs(void **state)
{
    (void)state;
    expect(0, "render" SHOT SMALL "-m lt-vsm --frames 12:14 --warm-up 12 -o a.png --json "
              "--aov class,rays,test,cascade,lod,lookups");
    cJSON *json = parse_output();
    static uint8_t colors[3 * PIXELS], rays[PIXELS], test[PIXELS];
    const cJSON *frame;
    int number = 12;
    cJSON_ArrayForEach(frame, member(json, "frames"))
    {
        char name[64];
        assert_int_equal(cJSON_GetArraySize(member(frame, "files")), 7);
        snprintf(name, sizeof name, "a.%04d.class.png", number);
        assert_int_equal(read_png(name, colors, sizeof colors), 3);
        snprintf(name, sizeof name, "a.%04d.rays.png", number);
        assert_int_equal(read_png(name, rays, sizeof rays), 1);
        snprintf(name, sizeof name, "a.%04d.test.png", number++);
        assert_int_equal(read_png(name, test, sizeof test), 1);
        unsigned traced = 0, kinds[8] = {0};
        for (int i = 0; i < PIXELS; i++) {
            /* Bits of red, green, blue that are bright: every class has a colour of its own, and
             * the purple one alone is neither white nor red in its red part. */
            const uint8_t *c = colors + 3 * i;
            const unsigned kind =
                (c[0] > 128) | (unsigned)(c[1] > 128) << 1 | (unsigned)(c[2] > 128) << 2;
            const bool black = kind == 0, green = kind == 2, purple = kind == 5, red = kind == 1,
                       yellow = kind == 3, white = kind == 7;
            kinds[kind]++;
            traced += rays[i] == 255;
            if ((rays[i] == 255) == (black || green) ||
                !(black || green || purple || red || yellow || white))
                fail_msg("%s: pixel %d is %d,%d,%d, with a ray of %d", name, i, c[0], c[1], c[2],
                         rays[i]);
            /* The test says shadow where Table 1 has ST; 255 is where it was not asked, too. */
            if (!black && test[i] < 255 && (green || white || yellow) != (test[i] < 128))
                fail_msg("%s: pixel %d is %d,%d,%d, with a test of %d", name, i, c[0], c[1], c[2],
                         test[i]);
        }
        if (traced != (unsigned)get_number(frame, "rays") || traced == 0)
            fail_msg("%s: %u white pixels of %g rays", name, traced, get_number(frame, "rays"));
        assert_true(kinds[0] > 0 && kinds[2] > 0 && kinds[7] > 0 && kinds[1] > 0);
        const cJSON *leak = member(frame, "leak");
        const double tested = get_number(leak, "tested") * PIXELS;
        const double asked =
            get_number(leak, "unsure") + get_number(leak, "expanded") - get_number(leak, "removed");
        assert_true(tested > 0.3 * PIXELS && tested <= PIXELS);
        if (asked < 0 || asked * tested > traced * 1.0000001)
            fail_msg("%g rays asked for of %u", asked * tested, traced);
    }
    assert_int_equal(number, 15);
    cJSON_Delete(json);

    /* As numbers; a plain ray has its rays, too. */
    expect(0, "render" SHOT SMALL "-m lt-vsm -o a.exr --aov class,rays,test");
    expect(0, "render" SHOT "-o b.png --aov rays --json");
    json = parse_output();
    frame = cJSON_GetArrayItem(member(json, "frames"), 0);
    assert_int_equal(read_png("b.rays.png", rays, sizeof rays), 1);
    unsigned traced = 0;
    for (int i = 0; i < PIXELS; i++)
        traced += rays[i] == 255;
    if (traced != (unsigned)get_number(frame, "rays"))
        fail_msg("%u white pixels of %g rays", traced, get_number(frame, "rays"));
    cJSON_Delete(json);
}

#define LAYERS "--aov visibility,class,motion "

/* A sequence cut in two goes on with the same bits, and the same for any number of threads. */
static void test_histories(void **state)
{
    (void)state;
    static const char *const methods[] = {"lt-vsm", "lt-esm", "vsm"};
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        char command[512];
        const char *aovs = m < 2 ? LAYERS : "--aov visibility,motion ";
        snprintf(command, sizeof command,
                 "render" SHOT SMALL "%s-m %s -o s.exr --frames 0:4 --fps 4 --threads 1", aovs,
                 methods[m]);
        expect(0, command);
        snprintf(command, sizeof command,
                 "render" SHOT SMALL "%s-m %s -o t.exr --frames 0:2 --fps 4 --history-out h", aovs,
                 methods[m]);
        expect(0, command);
        snprintf(command, sizeof command,
                 "render" SHOT SMALL "%s-m %s -o t.exr --frames 3:4 --fps 4 --history-in h", aovs,
                 methods[m]);
        expect(0, command);
        for (int i = 0; i < 5; i++) {
            char a[32], b[32];
            snprintf(a, sizeof a, "s.%04d.exr", i);
            snprintf(b, sizeof b, "t.%04d.exr", i);
            if (!same_files(a, b))
                fail_msg("%s: frame %d differs", methods[m], i);
        }
    }
    /* Without them the first frame is another. */
    expect(0, "render" SHOT SMALL LAYERS "-m lt-esm -o u.exr --frames 3:3 --fps 4");
    expect(0, "render" SHOT SMALL LAYERS "-m lt-esm -o s.exr --frames 0:3 --fps 4");
    assert_false(same_files("s.0003.exr", "u.0003.exr"));
}

static void test_compare(void **state)
{
    (void)state;
    expect(0, "compare" SHOT SMALL "--a ray-saturate --b lt-vsm --json");
    cJSON *json = parse_output();
    const cJSON *difference = cJSON_GetArrayItem(member(json, "differences"), 0);
    const double rays = get_number(member(json, "b"), "rays_per_pixel"),
                 all = get_number(member(json, "a"), "rays_per_pixel"),
                 wrong = get_number(difference, "wrong_pixels");
    if (!(rays > 0 && rays < 0.5 * all))
        fail_msg("%g rays a pixel of %g", rays, all);
    if (wrong > 0.01)
        fail_msg("%g of the pixels are wrong", wrong);
    cJSON_Delete(json);
    expect(0, "compare" SHOT SMALL "--a ray-saturate --b lt-vsm:no-remove -o c.png");
    expect_text(out, "% rays");
    assert_true(exists("c.png"));
}

static double at(const cJSON *series, const char *key, int index)
{
    const cJSON *value = cJSON_GetArrayItem(member(series, key), index);
    if (!cJSON_IsNumber(value))
        fail_msg("no number %d in '%s'", index, key);
    return value->valuedouble;
}

/* The numbers of a method are those of its frames. */
static void check_row(const cJSON *row, const cJSON *yardstick, int frames)
{
    const char *name = get_string(row, "name");
    const cJSON *series = member(row, "series"), *all = member(yardstick, "series");
    const char *const keys[] = {"ms", "rays", "wrong", "mean_abs", "map_ms", "fitted", "pending"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        assert_int_equal(cJSON_GetArraySize(member(series, keys[i])), frames);
    double ms = 0, rays = 0, wrong = 0, wrong_max = 0, mean_abs_max = 0, ratio = 0, least = 1e9,
           most = 0;
    for (int f = 0; f < frames; f++) {
        const double times = at(all, "ms", f) / at(series, "ms", f);
        ms += at(series, "ms", f) / frames;
        rays += at(series, "rays", f) / frames / PIXELS;
        wrong += at(series, "wrong", f) / frames;
        wrong_max = fmax(wrong_max, at(series, "wrong", f));
        mean_abs_max = fmax(mean_abs_max, at(series, "mean_abs", f));
        ratio += times / frames;
        least = fmin(least, times);
        most = fmax(most, times);
        assert_true(at(series, "map_ms", f) <= at(series, "ms", f));
    }
    const struct {
        const char *key;
        double value;
    } sums[] = {{"ms_mean", ms},          {"rays_per_pixel", rays},      {"wrong_pixels", wrong},
                {"wrong_max", wrong_max}, {"speedup_mean", ratio},       {"speedup_min", least},
                {"speedup_max", most},    {"mean_abs_max", mean_abs_max}};
    for (size_t i = 0; i < sizeof sums / sizeof *sums; i++)
        if (fabs(get_number(row, sums[i].key) - sums[i].value) > 1e-9 * fmax(1, sums[i].value))
            fail_msg("%s: %s is %g, its frames say %g", name, sums[i].key,
                     get_number(row, sums[i].key), sums[i].value);
    assert_true(get_number(row, "mean_abs") <= mean_abs_max);
    assert_true(get_number(row, "speedup") >= least && get_number(row, "speedup") <= most);
}

#define METHODS "-m lt-vsm,lt-vsm:mip0:no-remove,ltt-vsm "

static void test_bench(void **state)
{
    (void)state;
    expect(0, "bench" SHOT SMALL METHODS "--frames 2 --repeats 1 --fps 8 --json");
    cJSON *once = parse_output();
    expect(0, "bench" SHOT SMALL METHODS "--frames 2 --repeats 2 --fps 8 --json --threads 1");
    cJSON *twice = parse_output();
    const cJSON *methods = member(once, "methods"), *row;
    assert_int_equal((int)get_number(once, "warm_up"), 8);
    /* What they are held against is run too. */
    assert_int_equal(cJSON_GetArraySize(methods), 5);
    cJSON_ArrayForEach(row, methods)
    {
        const char *name = get_string(row, "name"), *yardstick = get_string(row, "yardstick");
        const bool leak = strchr(name, '-') < strstr(name, "vsm"), hard = strstr(name, "mip0");
        assert_string_equal(yardstick, hard ? "ray-mip0" : "ray-saturate");
        check_row(row, named(methods, yardstick), 2);
        if (leak != (cJSON_GetObjectItem(row, "leak") != NULL))
            fail_msg("%s: leak counts are for leak tracing", name);
        if (!leak)
            continue;
        const cJSON *counts = member(row, "leak");
        const double tested = get_number(counts, "tested");
        const double asked = get_number(counts, "unsure") + get_number(counts, "expanded") -
                             get_number(counts, "removed");
        assert_true(tested > 0.3 && tested <= 1);
        assert_true(get_number(counts, "unsure") > 0 && get_number(counts, "unsure") < 0.5);
        assert_true(asked > 0 && asked * tested <= get_number(row, "rays_per_pixel") + 1e-9);
        if ((get_number(counts, "removed") > 0) != (strcmp(name, "lt-vsm") == 0))
            fail_msg("%s: %g are removed", name, get_number(counts, "removed"));
        if ((get_number(row, "mask_bytes") > 0) != (name[2] == '-'))
            fail_msg("%s: masks of %g bytes", name, get_number(row, "mask_bytes"));
        assert_true(get_number(row, "wrong_pixels") < 0.02);
        /* Every run of the path is the same. */
        const cJSON *again = named(member(twice, "methods"), name);
        const char *const keys[] = {"wrong_pixels", "wrong_max", "mean_abs", "rays_per_pixel",
                                    "flicker"};
        for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
            if (get_number(row, keys[i]) != get_number(again, keys[i]))
                fail_msg("%s: %s is %.17g once, and %.17g", name, keys[i], get_number(row, keys[i]),
                         get_number(again, keys[i]));
    }
    cJSON_Delete(once);
    cJSON_Delete(twice);

    expect(0, "bench" SHOT SMALL "-m 'lt-?sm:size=64,leaks:size=64' --frames 1 -r 1 --warm-up 1");
    expect_text(out, "x all");
    expect_text(out, "lt-esm:size=64");
    expect_text(out, "hybrid-pcf:size=64");
    expect_text(out, "ray-saturate");
    assert_null(strstr(out, "ray-mip0"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_modifiers, setup, teardown),
        cmocka_unit_test_setup_teardown(test_alpha, setup, teardown),
        cmocka_unit_test_setup_teardown(test_aovs, setup, teardown),
        cmocka_unit_test_setup_teardown(test_histories, setup, teardown),
        cmocka_unit_test_setup_teardown(test_compare, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bench, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
