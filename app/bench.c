/* gnomon bench: the command. */
#include "bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench_command {
    gn_app_options common;
    gn_bench_options bench;
    const char *scene, *methods, *path, *profile, *csv, *sweep;
    uint32_t lamps; /* GN_NONE: the scene's lights */
} bench_command;

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

/* Returns GN_GO_ON, or an exit code after saying what is wrong. */
static int parse(int argc, char **argv, bench_command *c)
{
    static const char *const names[] = {"SCENE", NULL};
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
        "--sweep size=1280x720,1920x1080 runs once for each value of --size, and so of any other",
        "option with one value: map-size, lamps, scale (triangles), threads.",
        "'gnomon bench --filter' measures the filter of shadow maps alone, 'gnomon bench SCENE",
        "--maps' their drawing, 'gnomon bench SCENE --evaluate' their reading; see the --help of",
        "each. 'gnomon bench --compare OLD.json NEW.json' compares two files of results.",
        NULL};
    const gn_usage usage = {
        "bench",
        "time, steadiness and error of methods on the frames of one camera",
        "SCENE [options]",
        names,
        notes,
        {"gnomon bench grove --camera CamWalk --frames 60 --reference 64",
         "gnomon bench scene.glb --methods naive,ray-mip0,ray-saturate --json > result.json"}};
    *c = (bench_command){.common = gn_app_options_default(),
                         .bench = {.frames = 12,
                                   .warm_up = GN_NONE,
                                   .repeats = 3,
                                   .fps = 60,
                                   .reference_frames = 3,
                                   .profile_row = GN_NONE},
                         .methods = GN_BENCH_BASELINE ",rays",
                         .lamps = GN_NONE};
    const gn_option options[] = {
        GN_TEXT("methods", 'm', "A,B,...", &c->methods,
                "methods to run; default: naive and the rays"),
        GN_COUNT("frames", 'f', "N", &c->bench.frames, 1, 100000, "frames to measure, default 12"),
        GN_REAL("fps", 0, "N", &c->bench.fps, 0.001, 100000,
                "frames a second of the animation, default 60"),
        GN_COUNT("repeats", 'r', "N", &c->bench.repeats, 1, 1000,
                 "runs of the path, default 3; of each frame the fastest counts"),
        GN_COUNT("warm-up", 0, "N", &c->bench.warm_up, 0, 1000,
                 "frames before the first, default 1, or 8 where a method has a mask"),
        GN_TEXT("path", 0, "CAMERA", &c->path,
                "the camera whose animation is the path; as --camera"),
        GN_COUNT("reference", 0, "SPP", &c->bench.reference, 0, 4096,
                 "also measure error against SPP samples a pixel; default 0: not"),
        GN_COUNT("reference-frames", 0, "N", &c->bench.reference_frames, 1, 100000,
                 "frames that get a reference, default 3; with all, residual flicker is shown too"),
        GN_TEXT("profile", 0, "OUT.png", &c->profile,
                "one row of pixels over time, a strip for each method"),
        GN_COUNT("profile-row", 0, "N", &c->bench.profile_row, 0, 16383,
                 "which row, from 0 at the top; default: the middle"),
        GN_TEXT("csv", 0, "OUT.csv", &c->csv, "also write the results as a table, a line a method"),
        GN_TEXT("sweep", 0, "NAME=A,B,...", &c->sweep,
                "run once for each value of the option --NAME"),
        GN_COUNT("lamps", 0, "N", &c->lamps, 1, 1000, "N point lights in place of the scene's"),
        GN_APP_SHOT_OPTIONS(c->common),
        GN_APP_TIME_OPTION(c->common),
        GN_APP_MAP_OPTIONS(c->common),
        GN_APP_TRACER_OPTIONS(c->common),
        GN_APP_DEVICE_OPTIONS(c->common),
        GN_OPTIONS_END};
    const int code = gn_options_parse(&usage, options, argc, argv, &c->scene);
    if (code != GN_GO_ON)
        return code;
    const gn_bench_options *bench = &c->bench;
    if (bench->profile_row != GN_NONE && !c->profile)
        return gn_usage_error("bench", "--profile-row needs --profile OUT.png");
    if (bench->profile_row != GN_NONE && bench->profile_row >= c->common.size[1])
        return gn_usage_error("bench", "--profile-row: %u is not below the height, %u",
                              bench->profile_row, c->common.size[1]);
    if (c->lamps != GN_NONE && (c->common.lights || c->common.sun.given))
        return gn_usage_error("bench", "--lamps and --%s exclude each other",
                              c->common.lights ? "light" : "sun");
    if (c->profile && c->sweep)
        return gn_usage_error("bench", "--profile and --sweep exclude each other");
    if (c->profile && bench->profile_row == GN_NONE)
        c->bench.profile_row = c->common.size[1] / 2;
    if (c->path)
        c->common.camera = c->path;
    c->bench.start = c->common.time;
    return GN_GO_ON;
}

/* One measurement, printed, and added to runs. value: of the sweep, or NULL. After an interrupt
 * what was finished is. */
static int run_once(bench_command *c, const char *value, cJSON *runs)
{
    static const char *const pseudo[] = {GN_BENCH_BASELINE, NULL};
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    uint32_t count = gn_app_parse_methods("bench", c->methods, pseudo, methods);
    if (count == 0)
        return GN_EXIT_USAGE;
    count = add_yardsticks(methods, count);
    if (c->bench.warm_up == GN_NONE)
        c->bench.warm_up = usual_warm_up(methods, count);

    gn_app app = {0};
    gn_machine machine;
    gn_bench_result result = {0};
    gn_machine_open(&machine);
    c->bench.machine = &machine;
    bool good = gn_app_open(&app, "bench", &c->common) &&
                gn_app_use_methods(&app, methods, count) && gn_app_load(&app, c->scene) &&
                gn_app_choose(&app) &&
                (c->lamps == GN_NONE || gn_bench_hang_lamps(&app, c->lamps)) &&
                gn_bench_run(&app, &c->bench, methods, count, &result);
    if (result.count > 0) {
        cJSON *json = gn_bench_json(&app, &c->bench, &result);
        if (value)
            cJSON_AddStringToObject(json, "value", value);
        cJSON_AddItemToArray(runs, json);
        if (!c->common.json)
            gn_bench_print(&app, &c->bench, &result);
        good = (!c->profile || gn_bench_write_profile(&app, &c->bench, &result, c->profile)) &&
               (!c->csv || gn_bench_write_csv(&app, runs, c->csv)) && gn_app_flush(&app) && good;
    }
    const int code = good ? GN_EXIT_OK : gn_app_fail(&app);
    if (app.device)
        gn_bench_free(&app, &result);
    gn_app_release_methods(methods, count);
    gn_app_close(&app);
    gn_machine_close(&machine);
    c->bench.machine = NULL;
    return code;
}

static int print_json(cJSON *json)
{
    gn_app app = {.command = "bench"};
    return gn_app_print_json(&app, json) ? GN_EXIT_OK : gn_app_fail(&app);
}

/* Sweeps -------------------------------------------------------------------------------------- */

#define MAX_VALUES 64

/* "NAME=A,B,C": its values, and the arguments with which each is parsed. */
typedef struct bench_sweep {
    char text[1024]; /* cut up */
    const char *name, *values[MAX_VALUES];
    uint32_t count;
    char option[1088]; /* --NAME=VALUE */
    char **argv;       /* of the command, with the option */
    int argc, place;
} bench_sweep;

static int read_sweep(const char *text, bench_sweep *s)
{
    static const char *const not [] = {"sweep", "csv", "profile", "methods", NULL};
    if (strlen(text) >= sizeof s->text)
        return gn_usage_error("bench", "--sweep: the text is too long");
    strcpy(s->text, text);
    s->name = s->text;
    char *cut = strchr(s->text, '=');
    if (!cut || cut == s->text || !cut[1])
        return gn_usage_error("bench",
                              "--sweep: '%s' is not NAME=A,B,..., such as "
                              "size=1280x720,1920x1080",
                              text);
    for (s->count = 0; cut && s->count < MAX_VALUES; cut = strchr(cut, ',')) {
        *cut++ = '\0';
        s->values[s->count++] = cut;
    }
    if (cut)
        return gn_usage_error("bench", "--sweep: more than %d values", MAX_VALUES);
    for (int i = 0; not [i]; i++)
        if (strcmp(s->name, not [i]) == 0)
            return gn_usage_error("bench", "--sweep does not take --%s", s->name);
    return GN_GO_ON;
}

/* The command with one value of the sweep. */
static int parse_value(bench_sweep *s, uint32_t i, bench_command *c)
{
    snprintf(s->option, sizeof s->option, "--%s=%s", s->name, s->values[i]);
    s->argv[s->place] = s->option;
    return parse(s->argc, s->argv, c);
}

/* Medians, a column a value. */
static void print_sweep(const bench_sweep *s, const cJSON *runs)
{
    const cJSON *first = cJSON_GetObjectItemCaseSensitive(runs->child, "methods");
    int width = 13;
    for (const cJSON *method = first->child; method; method = method->next) {
        const int length =
            (int)strlen(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(method, "name")));
        width = length > width ? length : width;
    }
    printf("\n%-*s", width + 1, "ms, medians");
    for (uint32_t i = 0; i < s->count; i++)
        printf("%12s", s->values[i]);
    printf("   by --%s\n", s->name);
    for (int m = 0; m < cJSON_GetArraySize(first); m++) {
        const cJSON *run, *method = cJSON_GetArrayItem(first, m);
        if (!cJSON_HasObjectItem(method, "ms_median"))
            continue;
        printf("%-*s", width + 1,
               cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(method, "name")));
        cJSON_ArrayForEach(run, runs)
        {
            method = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(run, "methods"), m);
            printf("%12.2f",
                   cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(method, "ms_median")));
        }
        printf("\n");
    }
}

static int sweep(bench_command *c, int argc, char **argv, cJSON *runs)
{
    static bench_sweep s;
    int code = read_sweep(c->sweep, &s);
    if (code != GN_GO_ON)
        return code;
    s.argv = malloc((size_t)(argc + 2) * sizeof *s.argv);
    if (!s.argv) {
        gn_app app = {.command = "bench"};
        gn_app_error(&app, "out of memory");
        return gn_app_fail(&app);
    }
    /* Last, so that it counts, but before what is no option any more. */
    for (s.place = 1; s.place < argc && strcmp(argv[s.place], "--") != 0;)
        s.place++;
    s.argc = argc + 1;
    memcpy(s.argv, argv, (size_t)s.place * sizeof *argv);
    memcpy(s.argv + s.place + 1, argv + s.place, (size_t)(argc - s.place) * sizeof *argv);
    s.argv[s.argc] = NULL;
    for (uint32_t i = 0; i < s.count && code == GN_GO_ON; i++) /* all, before any is run */
        code = parse_value(&s, i, c);
    for (uint32_t i = 0; i < s.count && (code == GN_GO_ON || code == GN_EXIT_OK); i++) {
        code = parse_value(&s, i, c);
        if (code != GN_GO_ON)
            break;
        if (!c->common.json)
            printf("%s--%s %s\n", i ? "\n" : "", s.name, s.values[i]);
        code = run_once(c, s.values[i], runs);
    }
    if (!c->common.json && code == GN_EXIT_OK)
        print_sweep(&s, runs);
    free(s.argv);
    return code;
}

/* {"sweep": NAME, "runs": [...]}; runs is emptied. */
static cJSON *sweep_json(const bench_command *c, cJSON *runs)
{
    const gn_app app = {.command = "bench"};
    cJSON *json = gn_app_json(&app), *list = cJSON_AddArrayToObject(json, "runs");
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(c->sweep, "="), c->sweep);
    cJSON_AddStringToObject(json, "sweep", name);
    while (runs->child)
        cJSON_AddItemToArray(list, cJSON_DetachItemFromArray(runs, 0));
    return json;
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
        else if (strcmp(argv[i], "--compare") == 0)
            return gn_app_bench_compare(argc, argv);
    bench_command c;
    int code = parse(argc, argv, &c);
    if (code != GN_GO_ON)
        return code;
    cJSON *runs = cJSON_CreateArray();
    code = c.sweep ? sweep(&c, argc, argv, runs) : run_once(&c, NULL, runs);
    if (c.common.json && cJSON_GetArraySize(runs) > 0) {
        const int printed =
            print_json(c.sweep ? sweep_json(&c, runs) : cJSON_DetachItemFromArray(runs, 0));
        code = code == GN_EXIT_OK ? printed : code;
    }
    cJSON_Delete(runs);
    return code;
}
