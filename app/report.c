/* gnomon report: scenes and methods as a page, in the shape of the papers' figures and tables. */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output/output.h"
#include "page.h"
#include "report.h"

#define METHODS                                                                                    \
    "ray-mip0,ray-raw,ray-test,ray-saturate,ray-coverage,sm,pcf9,evsm128,nlmsm64,lt-vsm,lt-evsm"

/* The folder, and one in it for what is not finished. */
static bool begin(gn_app_report *r)
{
    struct stat status;
    r->made_folder = stat(r->folder, &status) != 0;
    if (!gn_app_make_folder(&r->app, r->folder))
        return false;
    if (snprintf(r->work, sizeof r->work, "%.3900s/.report-XXXXXX", r->folder) > 3900 ||
        !mkdtemp(r->work)) {
        r->work[0] = '\0';
        return gn_app_error(&r->app, "%s: cannot make a folder in it: %s", r->folder,
                            strerror(errno));
    }
    return true;
}

/* Calls act for each file of the work folder, which has no folders. */
static bool for_each_file(gn_app_report *r, bool (*act)(gn_app_report *, const char *))
{
    DIR *folder = *r->work ? opendir(r->work) : NULL;
    bool good = true;
    for (const struct dirent *entry; folder && good && (entry = readdir(folder));)
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            good = act(r, entry->d_name);
    if (folder)
        closedir(folder);
    return good;
}

static bool drop(gn_app_report *r, const char *name)
{
    char path[8192];
    snprintf(path, sizeof path, "%s/%s", r->work, name);
    unlink(path);
    return true;
}

/* Pictures that the page does not name stay behind, as those of a sequence's other frames do. */
static bool move(gn_app_report *r, const char *name)
{
    char from[8192], to[8192];
    if (!strstr(r->page_text, name))
        return true;
    snprintf(from, sizeof from, "%s/%s", r->work, name);
    snprintf(to, sizeof to, "%s/images/%s", r->folder, name);
    return rename(from, to) == 0 ||
           gn_app_error(&r->app, "%s: cannot be written: %s", to, strerror(errno));
}

/* Nothing unfinished stays. */
static void end(gn_app_report *r)
{
    for_each_file(r, drop);
    if (*r->work)
        rmdir(r->work);
    if (r->made_folder)
        rmdir(r->folder); /* where it is empty */
    cJSON_Delete(r->runs);
    cJSON_Delete(r->comparisons);
    cJSON_Delete(r->figure_list);
    cJSON_Delete(r->papers);
}

/* About how long a command takes, in parts of a picture's time. */
static double weigh(const gn_app_report *r, const cJSON *run)
{
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(run, "argv")->child);
    if (cJSON_GetObjectItem(run, "line"))
        return 0; /* done */
    return !strcmp(name, "bench")       ? 4 + 0.6 * r->frames
           : !strcmp(name, "histogram") ? 6
           : !strcmp(name, "compare")   ? 0.5
                                        : 1;
}

static bool run_all(gn_app_report *r)
{
    double whole = 0, done = 0;
    int count = 0;
    cJSON *run;
    cJSON_ArrayForEach(run, r->runs) whole += weigh(r, run);
    cJSON_ArrayForEach(run, r->runs)
    {
        const double weight = weigh(r, run);
        if (weight > 0 && !gn_report_run(r, run, done / whole, weight / whole))
            return false;
        done += weight;
        gn_app_finished(&r->app, "%d of %d commands had run, and nothing is written", ++count,
                        cJSON_GetArraySize(r->runs));
        if (cJSON_GetObjectItem(run, "error"))
            gn_app_note(&r->app, "%s: %s", cJSON_GetStringValue(cJSON_GetObjectItem(run, "line")),
                        cJSON_GetStringValue(cJSON_GetObjectItem(run, "error")));
    }
    return true;
}

/* Of the pictures of many frames, only those that a figure names count. */
static void prune_sequences(cJSON *runs)
{
    const cJSON *run;
    cJSON_ArrayForEach(run, runs)
    {
        cJSON *frames = cJSON_GetObjectItem(cJSON_GetObjectItem(run, "result"), "frames"), *frame;
        const bool many = cJSON_IsArray(frames) && cJSON_GetArraySize(frames) > 1;
        for (frame = many ? frames->child : NULL; frame; frame = frame->next)
            cJSON_DeleteItemFromObject(frame, "files");
    }
}

/* Everything that the page shows, as data. */
static cJSON *collect(gn_app_report *r, const char *command_line)
{
    cJSON *data = gn_app_json(&r->app);
    cJSON_AddStringToObject(data, "commit", gn_build_commit);
    cJSON_AddItemToObject(data, "machine", gn_report_machine());
    cJSON_AddStringToObject(data, "command_line", command_line);
    cJSON_AddNumberToObject(data, "width", r->app.options.size[0]);
    cJSON_AddNumberToObject(data, "height", r->app.options.size[1]);
    cJSON_AddNumberToObject(data, "frames", r->frames);
    cJSON *run;
    cJSON_ArrayForEach(run, r->runs) cJSON_DeleteItemFromObject(run, "argv");
    prune_sequences(r->runs);
    cJSON_AddItemToObject(data, "papers", r->papers);
    cJSON_AddItemToObject(data, "comparisons", r->comparisons);
    cJSON_AddItemToObject(data, "figures", r->figure_list);
    cJSON_AddItemToObject(data, "runs", r->runs);
    r->papers = r->comparisons = r->figure_list = r->runs = NULL;
    return data;
}

/* The pictures first, and then the page that names them. */
static bool publish(gn_app_report *r, const cJSON *data)
{
    char path[4096];
    snprintf(path, sizeof path, "%.4000s/images", r->folder);
    r->page_text = cJSON_PrintUnformatted(data);
    const bool good = r->page_text && !gn_app_interrupted() && gn_app_make_folder(&r->app, path) &&
                      for_each_file(r, move);
    cJSON_free(r->page_text);
    if (!good)
        return false;
    snprintf(path, sizeof path, "%.4000s/index.html", r->folder);
    const gn_page_part parts[] = {{.mark = "STYLE", .text = gn_page_style},
                                  {.mark = "REPORT_STYLE", .text = gn_report_style},
                                  {.mark = "CHART", .text = gn_chart_library},
                                  {.mark = "VIEWER", .text = gn_page_viewer},
                                  {.mark = "PLOTS", .text = gn_report_plots},
                                  {.mark = "REPORT", .text = gn_report_script},
                                  {.mark = "DATA", .json = data}};
    return gn_page_write(&r->app, path, gn_report_page, parts, sizeof parts / sizeof *parts);
}

static bool run(gn_app_report *r, const gn_app_options *options, const char *const *scenes,
                int count, const char *command_line)
{
    gn_app *app = &r->app;
    app->options = *options;
    gn_bar_start(&app->bar, options->quiet);
    /* No device yet: processes are forked as long as there is one thread. */
    if (!begin(r) || !gn_report_plan(r, scenes, count) || !run_all(r))
        return false;
    if (!gn_app_open(app, "report", options))
        return false;
    cJSON *data = collect(r, command_line);
    bool good = publish(r, data);
    gn_bar_clear(&app->bar);
    if (good && options->json) {
        good = gn_app_print_json(app, data);
        data = NULL;
    } else if (good) {
        printf("%s/index.html\n", r->folder);
        good = gn_app_flush(app);
    }
    cJSON_Delete(data);
    if (good && r->failed > 0)
        good = gn_app_error(app, "%u commands failed; the page names them", r->failed);
    return good;
}

/* The arguments as they were typed, for the page. */
static char *join(int argc, char **argv)
{
    cJSON *words = cJSON_CreateArray();
    for (int i = 0; i < argc; i++)
        cJSON_AddItemToArray(words, cJSON_CreateString(argv[i]));
    char *line = gn_report_line(words, "{out}");
    cJSON_Delete(words);
    return line;
}

int gn_app_make_report(int argc, char **argv)
{
    enum { MOST = 16 };
    static const char *const words[] = {"[SCENE]", "[SCENE]", "[SCENE]", "[SCENE]", "[SCENE]",
                                        "[SCENE]", "[SCENE]", "[SCENE]", "[SCENE]", "[SCENE]",
                                        "[SCENE]", "[SCENE]", "[SCENE]", "[SCENE]", "[SCENE]",
                                        "[SCENE]", NULL};
    static const char *const notes[] = {
        "Without SCENE: the built-in scenes, with all figures of the papers. With scenes: those",
        "figures that any scene can be shown in, for each of them; cameras at rest are compared,",
        "and the last that moves is the path of the sequence. DIR gets index.html, which opens in",
        "any browser, and images/. Each command that the page names can be run by itself.", NULL};
    const gn_usage usage = {
        "report",
        "a page that compares the methods: pictures, plots, tables",
        "[SCENE...] -o DIR [options]",
        words,
        notes,
        {"gnomon report -o report", "gnomon report a.glb b.glb -o report --methods ray,lt-evsm"}};
    gn_app_report r = {.app.command = "report", .methods = METHODS, .figures = "*", .frames = 40};
    gn_app_options common = gn_app_options_default();
    common.size[0] = 640;
    common.size[1] = 360;
    const gn_option options[] = {
        GN_TEXT("output", 'o', "DIR", &r.folder, "where the page goes"),
        GN_TEXT("methods", 'm', "A,B,...", &r.methods,
                "methods of comparisons and sequences; default: the most telling 11"),
        GN_COUNT("frames", 'f', "N", &r.frames, 2, 10000, "frames of a sequence, default 40"),
        GN_TEXT("figures", 0, "A,B,...", &r.figures,
                "names of figures, with * and ?, or none; default: all"),
        GN_TEXT("camera", 'c', "NAME", &common.camera, "this camera alone"),
        GN_TEXT("light", 'l', "NAME|all", &common.lights, "as elsewhere"),
        GN_SUN("sun", 0, &common.sun, "a sun in place of the scene's lights, in degrees"),
        GN_SIZE("size", 's', common.size, "pixels, default 640x360"),
        GN_APP_SCENE_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END,
    };
    const char *scenes[MOST] = {NULL};
    int code = gn_options_parse(&usage, options, argc, argv, scenes);
    if (code != GN_GO_ON)
        return code;
    if (!r.folder)
        return gn_usage_error("report", "-o DIR is missing");
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    const uint32_t method_count = gn_app_parse_methods("report", r.methods, NULL, methods);
    if (method_count == 0)
        return GN_EXIT_USAGE;
    for (uint32_t i = 0; i < method_count; i++)
        r.has_maps |= gn_app_has_map(&methods[i]);
    int count = 0;
    while (count < MOST && scenes[count])
        count++;
    char *line = join(argc, argv);
    code = run(&r, &common, scenes, count, line ? line : "") ? GN_EXIT_OK : gn_app_fail(&r.app);
    free(line);
    end(&r);
    gn_app_close(&r.app);
    return code;
}
