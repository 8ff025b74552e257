/* gnomon bench --compare: two files of results, for regressions in time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/file.h"
#include "bench.h"

typedef struct result_file {
    const char *path;
    cJSON *json;
    const cJSON *run; /* the only one, or the first of a sweep */
} result_file;

typedef struct comparison {
    gn_app app;
    result_file files[2]; /* old, new */
    double threshold;     /* a share: 0.05 */
    const char *relative; /* times are multiples of this method's; NULL: milliseconds */
    uint32_t slower, missing;
    double worst; /* ratio */
    cJSON *rows;  /* name, value, old, new, ratio, noise_old, noise_new, verdict */
} comparison;

static const cJSON *get(const cJSON *json, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(json, key);
}

/* Files --------------------------------------------------------------------------------------- */

/* "NEW.json: methods[2].ms_median: ..."; false. */
static bool check_run(gn_app *app, const result_file *file, const cJSON *run)
{
    const cJSON *method, *methods = get(run, "methods");
    if (!cJSON_IsArray(methods))
        return gn_app_error(app, "%s: is no result of gnomon bench: it has no list of methods",
                            file->path);
    int i = 0;
    cJSON_ArrayForEach(method, methods)
    {
        const cJSON *name = get(method, "name"), *ms = get(method, "ms_median");
        if (!cJSON_IsString(name))
            return gn_app_error(app, "%s: methods[%d].name: is not a text", file->path, i);
        if (ms && !(cJSON_IsNumber(ms) && ms->valuedouble > 0))
            return gn_app_error(app, "%s: methods[%d].ms_median: is not a number above 0",
                                file->path, i);
        i++;
    }
    return true;
}

static bool read_results(gn_app *app, result_file *file)
{
    gn_context *context = gn_device_context(app->device);
    uint8_t *data;
    uint64_t size;
    const char *reason = gn_file_read(context, file->path, &data, &size);
    if (reason)
        return gn_app_error(app, "%s: %s", file->path, reason);
    file->json = cJSON_ParseWithLength((const char *)data, (size_t)size);
    gn_free(context, data);
    if (!file->json)
        return gn_app_error(app, "%s: not JSON", file->path);
    const cJSON *run, *runs = get(file->json, "runs");
    file->run = runs ? runs->child : file->json;
    if (!runs || !file->run)
        return check_run(app, file, file->json);
    cJSON_ArrayForEach(run, runs)
    {
        if (!check_run(app, file, run))
            return false;
        if (!cJSON_IsString(get(run, "value")))
            return gn_app_error(app, "%s: a run of its sweep has no value", file->path);
    }
    return true;
}

static void print_item(const cJSON *item, char text[160])
{
    if (!item || !cJSON_PrintPreallocated((cJSON *)item, text, 160, false))
        snprintf(text, 160, "%s", item ? "(long)" : "nothing");
}

/* The same work? What differs otherwise is said. */
static bool compare_settings(comparison *c)
{
    static const char *const work[] = {"sweep",
                                       "scene",
                                       "camera",
                                       "lights",
                                       "width",
                                       "height",
                                       "frames",
                                       "fps",
                                       "time",
                                       "warm_up",
                                       "instanced_triangles",
                                       NULL};
    static const char *const machine[] = {"gnomon", "threads", "isa", "repeats", NULL};
    const result_file *a = &c->files[0], *b = &c->files[1];
    char was[160], is[160];
    for (int kind = 0; kind < 2; kind++)
        for (const char *const *key = kind ? machine : work; *key; key++) {
            const bool top = strcmp(*key, "sweep") == 0;
            const cJSON *x = get(top ? a->json : a->run, *key);
            const cJSON *y = get(top ? b->json : b->run, *key);
            if ((!x && !y) || (x && y && cJSON_Compare(x, y, true)))
                continue;
            print_item(x, was);
            print_item(y, is);
            if (kind == 0)
                return gn_app_error(&c->app, "%s and %s measured different things: %s is %s and %s",
                                    a->path, b->path, *key, was, is);
            gn_app_note(&c->app, "%s is %s and %s", *key, was, is);
        }
    for (int k = 0; k < 2; k++)
        if (cJSON_IsTrue(get(c->files[k].run, "busy")))
            gn_app_note(&c->app, "the machine was busy when %s was measured", c->files[k].path);
    return true;
}

/* Methods ------------------------------------------------------------------------------------- */

/* The run of that value of the sweep; without one the only run. */
static const cJSON *find_run(const result_file *file, const cJSON *value)
{
    const cJSON *run, *runs = get(file->json, "runs");
    if (!runs)
        return value ? NULL : file->json;
    cJSON_ArrayForEach(run,
                       runs) if (value && cJSON_Compare(get(run, "value"), value, true)) return run;
    return NULL;
}

static const cJSON *find_method(const cJSON *run, const char *name)
{
    const cJSON *method;
    cJSON_ArrayForEach(method, get(run, "methods")) if (strcmp(get(method, "name")->valuestring,
                                                               name) == 0) return method;
    return NULL;
}

/* Milliseconds, or multiples of the method to which all are relative; 0: there is no such time. */
static double time_of(const comparison *c, const cJSON *run, const char *name)
{
    const cJSON *method = find_method(run, name), *ms = get(method, "ms_median");
    const cJSON *unit = c->relative ? get(find_method(run, c->relative), "ms_median") : NULL;
    if (!ms || (c->relative && !unit))
        return 0;
    return ms->valuedouble / (unit ? unit->valuedouble : 1);
}

static bool add_row(comparison *c, const cJSON *runs[2], const cJSON *value, const char *name)
{
    static const char *const keys[2] = {"old", "new"}, *const noises[2] = {"noise_old",
                                                                           "noise_new"};
    double times[2];
    cJSON *row = cJSON_CreateObject();
    cJSON_AddItemToArray(c->rows, row);
    cJSON_AddStringToObject(row, "name", name);
    if (value)
        cJSON_AddStringToObject(row, "value", value->valuestring);
    for (int k = 0; k < 2; k++) {
        times[k] = time_of(c, runs[k], name);
        if (times[k] > 0)
            cJSON_AddNumberToObject(row, keys[k], times[k]);
        const cJSON *noise = get(find_method(runs[k], name), "noise");
        if (cJSON_IsNumber(noise))
            cJSON_AddNumberToObject(row, noises[k], noise->valuedouble);
    }
    const char *verdict = times[0] > 0 ? "missing" : "new";
    c->missing += times[0] > 0 && !(times[1] > 0);
    if (times[0] > 0 && times[1] > 0) {
        const double ratio = times[1] / times[0];
        cJSON_AddNumberToObject(row, "ratio", ratio);
        c->worst = fmax(c->worst, ratio);
        c->slower += ratio > 1 + c->threshold;
        verdict = ratio > 1 + c->threshold         ? "slower"
                  : ratio * (1 + c->threshold) < 1 ? "faster"
                                                   : "same";
    }
    return cJSON_AddStringToObject(row, "verdict", verdict) != NULL;
}

/* Every method of the old file, then those that only the new one has. */
static bool add_rows(comparison *c)
{
    bool good = true;
    for (int pass = 0; pass < 2 && good; pass++) {
        const result_file *file = &c->files[pass];
        const cJSON *swept = get(file->json, "runs"), *run = swept ? swept->child : file->json;
        for (; run && good; run = swept ? run->next : NULL) {
            const cJSON *method, *value = swept ? get(run, "value") : NULL;
            const cJSON *runs[2] = {find_run(&c->files[0], value), find_run(&c->files[1], value)};
            cJSON_ArrayForEach(method, get(run, "methods"))
            {
                const char *name = get(method, "name")->valuestring;
                if (get(method, "ms_median") && (pass == 0 || !find_method(runs[0], name)))
                    good = good && add_row(c, runs, value, name);
            }
        }
    }
    return good || gn_app_error(&c->app, "out of memory");
}

/* Results ------------------------------------------------------------------------------------- */

static void print_number(const cJSON *row, const char *key, int width, int digits)
{
    const cJSON *number = get(row, key);
    if (cJSON_IsNumber(number))
        printf("%*.*f", width, digits, number->valuedouble);
    else
        printf("%*s", width, "-");
}

static void print_table(const comparison *c)
{
    const cJSON *row;
    printf("%s and %s, %s%s\n\n", c->files[0].path, c->files[1].path,
           c->relative ? "medians as multiples of " : "medians in ms",
           c->relative ? c->relative : "");
    printf("%-32s%10s%10s%8s%10s%8s\n", "", "old", "new", "ratio", "noise old", "new");
    cJSON_ArrayForEach(row, c->rows)
    {
        const cJSON *value = get(row, "value");
        char name[160];
        snprintf(name, sizeof name, "%s%s%s", value ? value->valuestring : "", value ? ", " : "",
                 get(row, "name")->valuestring);
        printf("%-32s", name);
        print_number(row, "old", 10, 2);
        print_number(row, "new", 10, 2);
        print_number(row, "ratio", 8, 3);
        print_number(row, "noise_old", 10, 2);
        print_number(row, "noise_new", 8, 2);
        const char *verdict = get(row, "verdict")->valuestring;
        const bool same = strcmp(verdict, "same") == 0;
        printf("%s%s\n", same ? "" : "  ", same ? "" : verdict);
    }
    printf("\nratio: new over old; noise: slowest over fastest repeat of a frame, median.\n");
}

static bool print_json(comparison *c)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "command", "bench");
    cJSON_AddStringToObject(json, "old", c->files[0].path);
    cJSON_AddStringToObject(json, "new", c->files[1].path);
    cJSON_AddNumberToObject(json, "threshold", c->threshold);
    if (c->relative)
        cJSON_AddStringToObject(json, "relative", c->relative);
    cJSON_AddNumberToObject(json, "slower", c->slower);
    cJSON_AddNumberToObject(json, "missing", c->missing);
    cJSON_AddItemToObject(json, "methods", c->rows);
    c->rows = NULL;
    return gn_app_print_json(&c->app, json);
}

/* A method that is gone is no success: it may be the slow one. */
static bool judge(comparison *c)
{
    if (c->slower == 0 && c->missing == 0)
        return true;
    char text[2][128] = {"", ""};
    if (c->slower > 0)
        snprintf(text[0], sizeof text[0], "%u slower by more than %g %%, the worst %.3f times",
                 c->slower, c->threshold * 100, c->worst);
    if (c->missing > 0)
        snprintf(text[1], sizeof text[1], "%u missing", c->missing);
    return gn_app_error(&c->app, "%s%s%s", text[0], *text[0] && *text[1] ? "; " : "", text[1]);
}

static bool run(comparison *c, const gn_app_options *options)
{
    gn_app *app = &c->app;
    bool good = gn_app_open(app, "bench", options);
    gn_bar_clear(&app->bar);
    for (int k = 0; k < 2 && good; k++)
        good = read_results(app, &c->files[k]);
    if (good && c->relative)
        for (int k = 0; k < 2 && good; k++)
            good = find_method(c->files[k].run, c->relative) ||
                   gn_app_error(app, "%s: has no method '%s'", c->files[k].path, c->relative);
    good = good && compare_settings(c) && add_rows(c);
    if (good && options->json)
        good = print_json(c);
    else if (good)
        print_table(c);
    return good && gn_app_flush(app) && judge(c);
}

/* "5%" or "5": a share. */
static bool parse_threshold(const char *text, double *share)
{
    char *end;
    const double number = strtod(text, &end);
    end += *end == '%';
    *share = number / 100;
    return end != text && !*end && number >= 0 && number <= 1000;
}

int gn_app_bench_compare(int argc, char **argv)
{
    static const char *const words[] = {"OLD.json", "NEW.json", NULL};
    static const char *const notes[] = {
        "Files that 'gnomon bench --json' wrote, also with --sweep. The exit code is 1 where a",
        "method's median is slower by more than the threshold, or is in OLD.json alone, and where",
        "the files are of different scenes, cameras, sizes or frames. With --relative METHOD the",
        "times are compared as multiples of METHOD's in the same file, which takes off much of",
        "what differs between two machines or moments.",
        NULL};
    const gn_usage usage = {"bench",
                            "two files of results: which methods have become slower",
                            "--compare OLD.json NEW.json [options]",
                            words,
                            notes,
                            {"gnomon bench --compare old.json new.json --threshold 5%",
                             "gnomon bench --compare old.json new.json --relative naive --json"}};
    gn_app_options common = gn_app_options_default();
    comparison c = {0};
    bool chosen = false;
    const char *threshold = "5%", *paths[2];
    const gn_option options[] = {
        GN_FLAG("compare", 0, &chosen, "compare two files of results"),
        GN_TEXT("threshold", 0, "P%", &threshold, "slower by more than that fails; default 5%"),
        GN_TEXT("relative", 0, "METHOD", &c.relative,
                "compare times as multiples of this method's"),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END,
    };
    int code = gn_options_parse(&usage, options, argc, argv, paths);
    if (code != GN_GO_ON)
        return code;
    if (!parse_threshold(threshold, &c.threshold))
        return gn_usage_error("bench", "--threshold: '%s' is not a percentage from 0%% to 1000%%",
                              threshold);
    for (int k = 0; k < 2; k++)
        c.files[k].path = paths[k];
    c.rows = cJSON_CreateArray();
    code = run(&c, &common) ? GN_EXIT_OK : gn_app_fail(&c.app);
    cJSON_Delete(c.rows);
    for (int k = 0; k < 2; k++)
        cJSON_Delete(c.files[k].json);
    gn_app_close(&c.app);
    return code;
}
