/* The built program with methods that read shadow maps: their options, pictures and numbers. */
#include "cli_testing.h"

#include <math.h>

/* Small and quick; a sun. */
#define SHOT  " railing --size 48x32 --quiet "
#define SMALL " --map-size 64 "

/* Width and height as a PNG says them. */
static void expect_png(const char *name, uint32_t width, uint32_t height)
{
    uint8_t head[24];
    FILE *file = fopen(name, "rb");
    if (!file)
        fail_msg("%s is not there", name);
    assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
    fclose(file);
    assert_memory_equal(head + 1, "PNG", 3);
    uint32_t size[2];
    for (int i = 0; i < 2; i++)
        size[i] = (uint32_t)head[16 + 4 * i] << 24 | (uint32_t)head[17 + 4 * i] << 16 |
                  (uint32_t)head[18 + 4 * i] << 8 | head[19 + 4 * i];
    if (size[0] != width || size[1] != height)
        fail_msg("%s has %u x %u pixels, not %u x %u", name, size[0], size[1], width, height);
}

static const cJSON *item(const cJSON *json, const char *key, int index)
{
    const cJSON *found = cJSON_GetArrayItem(cJSON_GetObjectItem(json, key), index);
    if (!found)
        fail_msg("no '%s' %d", key, index);
    return found;
}

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"--map-size 0", "range is 16 to 16384"},
        {"--map-size 65537", "range is 16 to 16384"},
        {"--map-size 16 --filter-width 33", "at least"}, /* too small for its borders */
        {"--map-size -1", "'-1' is not a whole number"},
        {"--cascades 0", "range is 1 to 8"},
        {"--cascades 9", "range is 1 to 8"},
        {"--splits 0.5,0.2,1", "splits grow"},
        {"--splits 0.2,0.5", "it must be 1"},
        {"--splits 0.2,1 --cascades 3", "2 splits for 3 cascades"},
        {"--splits 0.2,1,", "separated by commas"},
        {"--split-weight 2", "range is 0 to 1"},
        {"--shadow-distance -3", "0 or more"},
        {"--enlarge 3", "range is 0 to 1"},
        {"--map-samples 2", "1 or 4"},
        {"--map-alpha soft", "one of test, mip0, hashed, opaque"},
        {"--filter-width 8", "the width is odd, from 1 to 33"},
        {"--filter-width 35", "the width is odd, from 1 to 33"},
        {"--filter-sigma 0", "0 (not included) to 16"},
        {"--reading linear", "one of auto, nearest, white, blue, bilinear"},
        {"--depth-bias 1", "range is 0 to 0.1"},
        {"--depth-bias -1", "'-1' is not a number from 0"},
        {"--normal-bias 17", "range is 0 to 16"},
        {"--min-variance 2", "range is 0 to 1"},
        {"--moment-bias 2", "range is 0 to 1"},
        {"--evsm 43", "to 42"},
        {"--evsm 40,5,5", "1 to 2 numbers"},
        {"--esm 80", "--esm: no method of that kind"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char command[256];
        snprintf(command, sizeof command, "render" SHOT "-o a.png -m evsm128 %s",
                 cases[i].arguments);
        expect(2, command);
        expect_text(err, cases[i].message);
    }
    static const struct {
        const char *arguments, *message;
    } others[] = {
        {"render" SHOT "-o a.png --cascades 2", "--cascades: no method that reads a map"},
        {"render" SHOT "-o a.png -m evsm64 --evsm 40,5", "to 5.54"},
        {"render" SHOT "-o a.png -m nlmsm64 --mip-maps", "no mip maps"},
        {"render" SHOT "-o a.png -m sm --mip-maps", "no mip maps"},
        {"render" SHOT "-o a.png -m evsm128 --aov xi4", "does not store it"},
        {"render" SHOT "-o a.png -m evsm128 --aov visibility,lod", "--aov lod: evsm128"},
        {"render" SHOT "-o a.png --aov map", "--aov map: ray-coverage has no map"},
        {"render" SHOT "-o a.png -m sm --map evsm", "exclude each other"},
        {"render" SHOT "-o a.png --map evsm --trace all", "the map is never read"},
        {"render" SHOT "-o a.png --map none --trace none", "nothing finds the light"},
        {"render" SHOT "-o a.png --trace none", "nothing finds the light"},
        {"render" SHOT "-o a.png --map vsm --alpha raw", "see --map-alpha"},
        {"render" SHOT "-o a.png --map-bits 64", "--map-bits: no --map is given"},
        {"render" SHOT "-o a.png --map vsm --map-bits 128", "it has 32 or 64"},
        {"render" SHOT "-o a.png --map vsm --one-sided", "goes with --map evsm"},
        {"render" SHOT "-o a.png --map vsm --pcf-width 3", "goes with --map pcf"},
        {"render" SHOT "-o a.png --map pcf --pcf-width 4", "odd from 3 to 33"},
        {"render" SHOT "-o a.png --map vsm --bound hausdorff", "goes with --map msm"},
        {"render" SHOT "-o a.png --map nlmsm --single-depth", "cannot be built"},
        {"render" SHOT "-o a.png --map evsm --one-sided --evsm 40,5", "has one exponent"},
        {"render" SHOT "-o a.png --map ev", "one of none, depth"},
        {"bench" SHOT "-m 'xsm*'", "no method is like 'xsm*'"},
        {"bench" SHOT "-m rays --map-size 64", "--map-size: no method"},
        {"bench" SHOT "-m maps --map-size 8", "range is 16"},
        {"compare" SHOT "--a ray --b ray-raw --no-reuse", "--no-reuse: no method"},
        {"compare" SHOT "--a sm --b evsm9", "did you mean"},
        {"histogram" SHOT "-o a.png", "does not end in .svg"},
        {"histogram" SHOT "--sigmas 1,10", "range is 0 to 9"},
        {"histogram" SHOT "--sigmas a", "'a' is not A,B,..."},
        {"histogram" SHOT "--cascades 9", "range is 1 to 8"},
        {"histogram", "SCENE is missing"},
        {"methods evsm", "one argument too many"},
    };
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        expect(2, others[i].arguments);
        expect_text(err, others[i].message);
        assert_string_equal(out, "");
    }
    assert_int_equal(count_files(), 0);
}

static void test_failures(void **state)
{
    (void)state;
    assert_int_equal(symlink("/dev/full", "full.svg"), 0);
    assert_int_equal(mkdir("a.map.png", 0777), 0);
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"histogram" SHOT SMALL "--sigmas 0 -o full.svg", "full.svg: cannot write: No space left"},
        {"histogram" SHOT SMALL "--sigmas 0 -o nowhere/a.svg", "nowhere/a.svg: cannot write"},
        {"histogram missing.glb", "missing.glb"},
        {"render" SHOT SMALL "-m sm -o a.png --aov map", "a.map.png: cannot write: Is a dir"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(1, cases[i].arguments);
        expect_text(err, cases[i].message);
    }
    assert_int_equal(count_files(), 2); /* and not a.png, which appears last */
    const char *const printing[] = {"methods", "methods --json",
                                    "histogram" SHOT SMALL "--sigmas 0"};
    for (size_t i = 0; i < sizeof printing / sizeof *printing; i++) {
        char command[512];
        snprintf(command, sizeof command, "%s %s >/dev/full 2>.err", GNOMON_PROGRAM, printing[i]);
        const int status = system(command);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 1);
    }
}

/* Every method has all of its facts, and renders. */
static void test_methods(void **state)
{
    (void)state;
    expect(0, "methods");
    expect_text(out, "nlmsm64");
    expect(0, "methods --json");
    cJSON *json = parse_output();
    expect_text(get_string(json, "default"), "ray-");
    const cJSON *method;
    unsigned maps = 0, rays = 0;
    cJSON_ArrayForEach(method, member(json, "methods"))
    {
        const char *name = get_string(method, "name");
        assert_true(strlen(get_string(method, "description")) > 10);
        get_string(method, "paper");
        const cJSON *map = member(method, "map");
        const char *trace = get_string(method, "trace");
        const bool traces = strcmp(trace, "all") == 0;
        if (cJSON_IsNull(map) != traces ||
            cJSON_IsNull(member(method, "alpha")) != (strcmp(trace, "none") == 0))
            fail_msg("%s: map, trace and alpha do not fit", name);
        maps += strcmp(trace, "none") == 0;
        rays += traces;
        if (!traces) {
            get_string(map, "kind");
            assert_true(get_number(map, "bits") >= 32);
        }
        char command[256];
        snprintf(command, sizeof command, "render" SHOT "-o a.png -m %s %s --json", name,
                 traces ? "" : SMALL);
        expect(0, command);
        cJSON *result = parse_output();
        const double mean = item(item(result, "frames", 0), "mean_visibility", 0)->valuedouble;
        if (!(mean > 0.1 && mean < 0.95))
            fail_msg("%s: a mean visibility of %g", name, mean);
        cJSON_Delete(result);
    }
    cJSON_Delete(json);
    assert_true(maps >= 12);
    assert_true(rays >= 5);
}

/* Pictures of everything that a map has. */
static void test_aovs(void **state)
{
    (void)state;
    expect(0, "render" SHOT SMALL "-m nlmsm64 --cascades 3 -o a.png "
              "--aov visibility,cascade,test,map,xi4 --json");
    cJSON *json = parse_output();
    const cJSON *frame = item(json, "frames", 0), *ms = member(frame, "ms");
    assert_int_equal(cJSON_GetArraySize(member(frame, "files")), 6);
    assert_true(get_number(ms, "shadow_map") > 0 && get_number(ms, "filter") > 0 &&
                get_number(ms, "test") > 0);
    assert_true(get_number(ms, "trace") == 0);
    assert_true(get_number(ms, "visibility") >=
                get_number(ms, "shadow_map") + get_number(ms, "filter") + get_number(ms, "test"));
    cJSON_Delete(json);
    expect_png("a.png", 48, 32);
    expect_png("a.cascade.png", 48, 32);
    expect_png("a.test.png", 48, 32);
    expect_png("a.map.png", 3 * 64, 64);
    expect_png("a.xi4.png", 3 * 64, 64);
    /* Nothing is traced: the test is all there is. */
    assert_true(same_files("a.test.png", "a.visibility.png"));
    expect(0, "render" SHOT SMALL "-m nlmsm64 -o a.exr --aov cascade,test,map,xi4");
    assert_true(exists("a.exr") && exists("a.map.exr") && exists("a.xi4.exr"));
    assert_int_equal(count_files(), 9);
    /* A lamp has six faces. */
    expect(0, "render leafbox --size 48x32 --quiet -m sm --map-size 32 -o b.png --aov map");
    expect_png("b.map.png", 6 * 32, 32);
}

/* Mean visibility of a small picture. */
static double mean_of(const char *arguments)
{
    char command[512];
    snprintf(command, sizeof command, "render" SHOT SMALL "-o m.png --json %s", arguments);
    expect(0, command);
    cJSON *json = parse_output();
    const double mean = item(item(json, "frames", 0), "mean_visibility", 0)->valuedouble;
    cJSON_Delete(json);
    return mean;
}

/* A method and its parts are the same; options do something. */
static void test_parts(void **state)
{
    (void)state;
    static const struct {
        const char *a, *b;
        bool same;
    } pairs[] = {
        {"-m msm64", "--map msm --map-bits 64", true},
        {"-m nlmsm32", "--map nlmsm --map-bits 32 --trace none", true},
        {"-m sm", "--map depth", true},
        {"-m msm128", "--map msm --map-bits 128 --bound hausdorff", false},
        {"-m vsm", "--map vsm --single-depth", false},
        {"-m esm --map-size 512", "-m esm --esm 20 --map-size 512", false},
        {"-m evsm128", "-m evsm128 --evsm 10,2", false},
        {"-m evsm128", "--map evsm --one-sided --evsm 40", false},
        {"-m vsm", "-m vsm --cascades 1", false},
        {"-m vsm", "-m vsm --filter-width 3", false},
        {"-m vsm", "-m vsm --filter-sigma 0.5", false},
        {"-m vsm", "-m vsm --map-samples 4", false},
        {"-m vsm", "-m vsm --reading nearest", false},
        {"-m vsm", "-m vsm --mip-maps", false},
        {"-m vsm", "-m vsm --shadow-distance 3", false},
        {"-m vsm", "-m vsm --splits 0.1,0.2,0.5,1", false},
        {"-m vsm", "-m vsm --split-weight 0", false},
        {"-m vsm", "-m vsm --enlarge 0.5", false},
        {"-m vsm", "-m vsm --no-reuse", false}, /* fitted tightly */
        {"-m vsm", "-m vsm --no-reuse --enlarge 0.15", true},
        {"-m vsm", "-m vsm --depth-bias 0.01", false},
        {"-m vsm", "-m vsm --normal-bias 8", false},
        {"-m vsm", "-m vsm --min-variance 0.001", false},
        {"-m msm64", "-m msm64 --moment-bias 0.01", false},
        {"-m vsm", "-m vsm --map-alpha opaque", true}, /* nothing is masked */
    };
    double a = 0;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        if (i == 0 || strcmp(pairs[i].a, pairs[i - 1].a) != 0)
            a = mean_of(pairs[i].a);
        const double b = mean_of(pairs[i].b);
        if ((a == b) != pairs[i].same)
            fail_msg("'%s' gives %.9g, '%s' %.9g", pairs[i].a, a, pairs[i].b, b);
    }
}

static void test_same_bytes(void **state)
{
    (void)state;
    expect(0, "render" SHOT SMALL "-m nlmsm64 -o a.exr --threads 1");
    expect(0, "render" SHOT SMALL "-m nlmsm64 -o b.exr --threads 2");
    assert_true(same_files("a.exr", "b.exr"));
    /* Leaves: what is masked counts. */
    expect(0, "render leafbox --size 48x32 -q -m vsm" SMALL "-o f.exr");
    expect(0, "render leafbox --size 48x32 -q -m vsm" SMALL "-o g.exr --map-alpha mip0");
    expect(0, "render leafbox --size 48x32 -q -m vsm" SMALL "-o h.exr --map-alpha hashed");
    expect(0, "render leafbox --size 48x32 -q -m vsm" SMALL "-o i.exr --map-alpha opaque");
    assert_false(same_files("f.exr", "g.exr"));
    assert_false(same_files("f.exr", "h.exr"));
    assert_false(same_files("f.exr", "i.exr"));
    /* A frame does not depend on those before it, where nothing is kept. */
    expect(0, "render" SHOT SMALL "-m vsm -o d.exr --frames 0:2 --no-reuse");
    expect(0, "render" SHOT SMALL "-m vsm -o e.exr --frames 2:2 --no-reuse");
    assert_true(same_files("d.0002.exr", "e.0002.exr"));
}

static void test_compare(void **state)
{
    (void)state;
    expect(0, "compare" SHOT SMALL "--a msm128 --b nlmsm64 --reading nearest -o d --json");
    cJSON *json = parse_output();
    const cJSON *first = item(json, "differences", 0);
    assert_true(get_number(first, "max_abs") < 0.5);
    assert_true(get_number(member(json, "a"), "map_ms") > 0);
    assert_true(get_number(member(json, "a"), "ms_median") > 0);
    cJSON_Delete(json);
    expect_png("d/side-by-side.png", 3 * 48, 32);
    expect(0, "compare" SHOT SMALL "--a ray-mip0 --b sm --json");
    json = parse_output();
    assert_true(get_number(member(json, "a"), "map_ms") == 0);
    first = item(json, "differences", 0);
    const double wrong = get_number(first, "wrong_pixels");
    if (!(wrong > 0 && wrong < 0.3))
        fail_msg("a map of 64 texels has %g wrong pixels", wrong);
    cJSON_Delete(json);
}

static void test_bench(void **state)
{
    (void)state;
    expect(0,
           "bench" SHOT SMALL "-m sm,'evsm*',ray-test --cascades 3 --frames 3 --repeats 2 --json");
    cJSON *json = parse_output();
    const cJSON *methods = member(json, "methods");
    const cJSON *sm = named(methods, "sm"), *ray = named(methods, "ray-mip0"), *row;
    named(methods, "evsm64");
    named(methods, "evsm128");
    named(methods, "ray-test");
    cJSON_ArrayForEach(row, methods)
    {
        static const char *const keys[] = {"gbuffer", "shadow_map", "filter", "test", "trace"};
        const char *name = get_string(row, "name");
        const bool traces = strncmp(name, "ray", 3) == 0;
        double parts = 0;
        for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
            const cJSON *pass = member(member(row, "passes"), keys[i]);
            assert_true(get_number(pass, "ms_min") >= 0);
            assert_true(get_number(pass, "ms_min") <= get_number(pass, "ms_median") &&
                        get_number(pass, "ms_median") <= get_number(pass, "ms_max"));
            parts += i > 0 ? get_number(pass, "ms_mean") : 0;
        }
        /* The passes are the stage, but for small change. */
        if (parts > get_number(row, "ms_mean") * 1.001)
            fail_msg("%s: passes of %g ms in %g ms", name, parts, get_number(row, "ms_mean"));
        if (traces != (get_number(row, "rays_per_pixel") > 0))
            fail_msg("%s: %g rays a pixel", name, get_number(row, "rays_per_pixel"));
        if (traces == (cJSON_GetObjectItem(row, "map") != NULL))
            fail_msg("%s: map and rays do not fit", name);
        assert_true(get_number(row, "speedup") > 0);
        assert_true(get_number(row, "speedup_min") <= get_number(row, "speedup"));
        assert_true(get_number(row, "wrong_pixels") <= 2 * get_number(row, "mean_abs"));
    }
    assert_true(get_number(ray, "mean_abs") == 0 && get_number(ray, "speedup") == 1);
    assert_true(get_number(sm, "mean_abs") > 0);
    const cJSON *map = member(sm, "map");
    assert_true(get_number(map, "layers") == 3);
    assert_true(get_number(map, "bytes") >= 3 * 64 * 64 * 4);
    assert_true(get_number(map, "ns_per_pixel") > 0);
    /* The camera stands still: what the warm-up made is kept. */
    if (get_number(map, "fits") != 0)
        fail_msg("%g layers of a still view were placed anew", get_number(map, "fits"));
    cJSON_Delete(json);

    expect(0, "bench" SHOT SMALL "-m vsm --cascades 3 --frames 2 --repeats 1 --no-reuse --json");
    json = parse_output();
    const cJSON *vsm = named(member(json, "methods"), "vsm");
    assert_true(get_number(member(vsm, "map"), "fits") == 3);
    assert_true(get_number(member(member(vsm, "passes"), "filter"), "ms_min") > 0);
    cJSON_Delete(json);
    expect(0, "bench" SHOT SMALL "-m vsm --frames 1 --repeats 1");
    expect_text(out, "wrong and mean abs: against ray-mip0");
}

/* The filter alone, for every format with 1 and 4 samples. */
static void test_bench_filter(void **state)
{
    (void)state;
    expect(0, "bench --filter --map-size 64 --repeats 1 --quiet --json");
    cJSON *json = parse_output();
    assert_int_equal((int)get_number(json, "map_size"), 64);
    const cJSON *list = member(json, "filter"), *row;
    assert_int_equal(cJSON_GetArraySize(list) % 2, 0);
    assert_true(cJSON_GetArraySize(list) >= 18);
    unsigned samples = 0;
    cJSON_ArrayForEach(row, list)
    {
        get_string(row, "format");
        samples += (unsigned)get_number(row, "samples");
        const double fused = get_number(row, "fused_ms"), passes = get_number(row, "three_pass_ms");
        assert_true(fused > 0 && get_number(row, "memcpy_ms") > 0);
        if (fabs(get_number(row, "ratio") * fused / passes - 1) > 1e-9)
            fail_msg("a ratio of %g for %g and %g ms", get_number(row, "ratio"), passes, fused);
    }
    assert_int_equal(samples * 2, 5 * (unsigned)cJSON_GetArraySize(list));
    cJSON_Delete(json);
    expect(0, "bench --filter --map-size 64 --repeats 1 --quiet");
    expect_text(out, "nlmsm64");
    expect(2, "bench --filter --map-size 8");
    expect(2, "bench --filter railing");
}

/* Drawing alone: every layer by tiles and by rays. */
static void test_bench_maps(void **state)
{
    (void)state;
    expect(0, "bench railing --maps --map-size 64 --cascades 2 --repeats 1 --quiet --json");
    cJSON *json = parse_output();
    assert_int_equal(cJSON_GetArraySize(member(json, "layers")), 2);
    for (int i = 0; i < 2; i++) {
        const cJSON *row = item(json, "layers", i);
        const double raster = get_number(row, "raster_ms"), packets = get_number(row, "packets_ms");
        if (fabs(get_number(row, "ratio") * raster / packets - 1) > 1e-9)
            fail_msg("a ratio of %g for %g and %g ms", get_number(row, "ratio"), packets, raster);
        assert_true(get_number(row, "covered") > 0.1);
        assert_true(get_number(row, "different") <= 0.004);
    }
    assert_true(get_number(json, "raster_ms") == get_number(item(json, "layers", 0), "raster_ms"));
    assert_true(get_number(json, "cascades_ms") >= get_number(json, "cascades_depth_ms"));
    cJSON_Delete(json);
    expect(0, "bench leafbox --maps --map-size 64 --map-samples 4 --repeats 1 --quiet");
    expect_text(out, "6 layers of nlmsm64");
    expect(2, "bench railing --maps --map-samples 2");
    expect(2, "bench railing --maps --method sm");
    expect(2, "bench --maps");
}

static void test_bench_evaluate(void **state)
{
    (void)state;
    expect(0,
           "bench railing --evaluate --methods sm,nlmsm32 --map-size 64 --size 64x48 --repeats 1 "
           "--quiet --json");
    cJSON *json = parse_output();
    assert_int_equal(cJSON_GetArraySize(member(json, "evaluate")), 4);
    for (int i = 0; i < 4; i++) {
        const cJSON *row = item(json, "evaluate", i);
        const double ns = get_number(row, "ns_median"), pcf9 = get_number(row, "ns_pcf9");
        assert_string_equal(get_string(row, "name"), i < 2 ? "sm" : "nlmsm32");
        assert_int_equal((int)get_number(row, "cascades"), i % 2 ? 3 : 1);
        assert_int_equal((int)get_number(row, "width"), 64);
        if (!(ns > 0) || fabs(get_number(row, "ratio_pcf9") * pcf9 / ns - 1) > 1e-9)
            fail_msg("a ratio of %g for %g and %g ns", get_number(row, "ratio_pcf9"), ns, pcf9);
        assert_true(get_number(row, "read") > 0.3 && get_number(row, "read") <= 1);
    }
    cJSON_Delete(json);
    expect(1, "bench leafbox --evaluate --methods sm --map-size 64 --size 64x48 --quiet");
    expect(2, "bench railing --evaluate --methods ray");
    expect(2, "bench --evaluate");
}

static void test_histogram(void **state)
{
    (void)state;
    expect(0, "histogram" SHOT SMALL "--cascades 2 --sigmas 0,2.4 -o a.svg --json");
    cJSON *json = parse_output();
    assert_string_equal(get_string(json, "file"), "a.svg");
    assert_int_equal(cJSON_GetArraySize(member(json, "histograms")), 2);
    double below[2];
    for (int k = 0; k < 2; k++) {
        const cJSON *h = item(json, "histograms", k), *bin;
        const char *const keys[] = {"warped", "log10"};
        assert_int_equal((int)get_number(h, "texels"), 2 * 64 * 64);
        for (int i = 0; i < 2; i++) {
            double sum = 0;
            assert_int_equal(cJSON_GetArraySize(member(h, keys[i])), 64);
            cJSON_ArrayForEach(bin, member(h, keys[i])) sum += bin->valuedouble;
            if (sum != get_number(h, "texels"))
                fail_msg("%s has %g texels, not %g", keys[i], sum, get_number(h, "texels"));
        }
        below[k] = get_number(h, "below_1e_6");
        assert_true(below[k] + get_number(h, "above_6e_5") <= 1);
    }
    /* One depth a texel: there is nothing that two depths could not describe. */
    if (below[0] < 0.9 || below[1] >= below[0])
        fail_msg("below 1e-6 are %g, filtered %g of the texels", below[0], below[1]);
    assert_int_equal((int)get_number(item(json, "histograms", 1), "filter_width"), 9);
    cJSON_Delete(json);
    char text[200000];
    read_all("a.svg", text, sizeof text);
    expect_text(text, "<svg xmlns");
    expect_text(text, "railing");
    expect_text(text, "</svg>");
    expect(0, "histogram" SHOT SMALL "--sigmas 1.2");
    expect_text(out, "1.20");
    assert_int_equal(count_files(), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_methods, setup, teardown),
        cmocka_unit_test_setup_teardown(test_aovs, setup, teardown),
        cmocka_unit_test_setup_teardown(test_parts, setup, teardown),
        cmocka_unit_test_setup_teardown(test_same_bytes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_compare, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bench, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bench_filter, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bench_maps, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bench_evaluate, setup, teardown),
        cmocka_unit_test_setup_teardown(test_histogram, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
