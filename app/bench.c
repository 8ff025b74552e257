/* gnomon bench: the command. */
#include "bench.h"

#include <stdio.h>
#include <string.h>

/* What methods with maps, and tracers, are held against, where the list does not have it. */
static uint32_t add_yardsticks(gn_app_method methods[GN_APP_MAX_METHODS], uint32_t count)
{
    const uint32_t given = count;
    for (uint32_t i = 0; i < given && count < GN_APP_MAX_METHODS; i++) {
        if (!gn_app_has_map(&methods[i]) && methods[i].own.tracer == GN_NONE)
            continue;
        gn_app_yardstick_of(&methods[i], &methods[count]);
        uint32_t k = 0;
        while (strcmp(methods[k].name, methods[count].name) != 0)
            k++;
        count += k == count;
    }
    return count;
}

/* A mask takes some frames to settle, all else one. */
static uint32_t usual_warm_up(const gn_app_method *methods, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (gn_app_has_mask(&methods[i]))
            return GN_APP_WARM_UP;
    return 1;
}

int gn_app_bench(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], "--filter") == 0)
            return gn_app_bench_filter(argc, argv);
        else if (strcmp(argv[i], "--maps") == 0)
            return gn_app_bench_maps(argc, argv);
        else if (strcmp(argv[i], "--evaluate") == 0)
            return gn_app_bench_evaluate(argc, argv);
    static const char *const names[] = {"SCENE", NULL};
    static const char *const pseudo[] = {GN_BENCH_BASELINE, NULL};
    static const char *const notes[] = {
        "Methods take turns on the same frames. The path is run --repeats times, each from",
        "nothing; a frame's time is the fastest of them, and the table has the median, least and",
        "most over the frames. 'naive' is the baseline: one ray at a time, an instance a node,",
        "alpha test in mip 0. Ratios are to ray-mip0.",
        "Methods are names in 'gnomon methods', names with * and ?, or all, rays, maps, leaks;",
        "those with a map take modifiers: 'lt-vsm:mip0:no-remove', 'lt-*:size=1024'; see",
        "docs/cli.md. Those that trace rays take ':bvh' and ':light-buffer', and are then held",
        "against the same rays of the tree, ':bvh'.",
        "Maps are held against ray-mip0, leak tracing against a ray for every pixel with the same",
        "alpha rule; that is run too. Maps and masks are kept from frame to frame; a frame's time",
        "has what it took to bring them up to date.",
        "'gnomon bench --filter' measures the filter of shadow maps alone, 'gnomon bench SCENE",
        "--maps' their drawing, 'gnomon bench SCENE --evaluate' their reading; see the --help of",
        "each.",
        NULL};
    const gn_usage usage = {
        "bench",
        "time, steadiness and error of methods on the frames of one camera",
        "SCENE [options]",
        names,
        notes,
        {"gnomon bench grove --camera CamWalk --frames 60 --reference 64",
         "gnomon bench scene.glb --methods naive,ray-mip0,ray-saturate --json > result.json"}};
    gn_app_options common = gn_app_options_default();
    gn_bench_options bench = {.frames = 12,
                              .warm_up = GN_NONE,
                              .repeats = 3,
                              .fps = 60,
                              .reference_frames = 3,
                              .profile_row = GN_NONE};
    const char *list = GN_BENCH_BASELINE ",rays", *path = NULL, *profile = NULL;
    const gn_option options[] = {
        GN_TEXT("methods", 'm', "A,B,...", &list, "methods to run; default: naive and the rays"),
        GN_COUNT("frames", 'f', "N", &bench.frames, 1, 100000, "frames to measure, default 12"),
        GN_REAL("fps", 0, "N", &bench.fps, 0.001, 100000,
                "frames a second of the animation, default 60"),
        GN_COUNT("repeats", 'r', "N", &bench.repeats, 1, 1000,
                 "runs of the path, default 3; of each frame the fastest counts"),
        GN_COUNT("warm-up", 0, "N", &bench.warm_up, 0, 1000,
                 "frames before the first, default 1, or 8 where a method has a mask"),
        GN_TEXT("path", 0, "CAMERA", &path, "the camera whose animation is the path; as --camera"),
        GN_COUNT("reference", 0, "SPP", &bench.reference, 0, 4096,
                 "also measure error against SPP samples a pixel; default 0: not"),
        GN_COUNT("reference-frames", 0, "N", &bench.reference_frames, 1, 100000,
                 "frames that get a reference, default 3; with all, residual flicker is shown too"),
        GN_TEXT("profile", 0, "OUT.png", &profile,
                "one row of pixels over time, a strip for each method"),
        GN_COUNT("profile-row", 0, "N", &bench.profile_row, 0, 16383,
                 "which row, from 0 at the top; default: the middle"),
        GN_APP_SHOT_OPTIONS(common),
        GN_APP_TIME_OPTION(common),
        GN_APP_MAP_OPTIONS(common),
        GN_APP_TRACER_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END};
    const char *name;
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    if (code != GN_GO_ON)
        return code;
    if (bench.profile_row != GN_NONE && !profile)
        return gn_usage_error("bench", "--profile-row needs --profile OUT.png");
    if (bench.profile_row != GN_NONE && bench.profile_row >= common.size[1])
        return gn_usage_error("bench", "--profile-row: %u is not below the height, %u",
                              bench.profile_row, common.size[1]);
    if (profile && bench.profile_row == GN_NONE)
        bench.profile_row = common.size[1] / 2;
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    uint32_t count = gn_app_parse_methods("bench", list, pseudo, methods);
    if (count == 0)
        return GN_EXIT_USAGE;
    count = add_yardsticks(methods, count);
    if (bench.warm_up == GN_NONE)
        bench.warm_up = usual_warm_up(methods, count);
    if (path)
        common.camera = path;
    bench.start = common.time;

    gn_app app = {0};
    gn_bench_result result = {0};
    bool good = gn_app_open(&app, "bench", &common) && gn_app_use_methods(&app, methods, count) &&
                gn_app_load(&app, name) && gn_app_choose(&app) &&
                gn_bench_run(&app, &bench, methods, count, &result) &&
                (!profile || gn_bench_write_profile(&app, &bench, &result, profile));
    if (good) {
        if (common.json)
            good = gn_app_print_json(&app, gn_bench_json(&app, &bench, &result));
        else
            gn_bench_print(&app, &bench, &result);
    }
    if (good && (fflush(stdout) != 0 || ferror(stdout)))
        good = gn_app_error(&app, "standard output: cannot write");
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    if (app.device)
        gn_bench_free(&app, &result);
    gn_app_release_methods(methods, count);
    gn_app_close(&app);
    return code;
}
