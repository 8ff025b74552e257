/* gnomon render: a scene as pictures. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "picture.h"

typedef struct render_options {
    gn_app_options common;
    const char *output, *method, *aov;
    gn_app_parts parts; /* in place of method */
    const char *history_in, *history_out;
    uint32_t samples, warm_up;
    gn_frames frames;
    double fps;
} render_options;

/* AOVs that visibility gives on its way. */
#define FACTS                                                                                      \
    (1u << GN_AOV_LOD | 1u << GN_AOV_LOOKUPS | 1u << GN_AOV_RAYS | 1u << GN_AOV_CLASS |            \
     1u << GN_AOV_LISTS | 1u << GN_AOV_CASCADE | 1u << GN_AOV_TEST)

static bool ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text), b = strlen(end);
    return a > b && strcmp(text + a - b, end) == 0;
}

/* The run of '#' or the "%04d" that stands for the frame number: its start and length; NULL where
 * there is none. */
static const char *find_number(const char *path, size_t *length, int *digits)
{
    const char *hash = strchr(path, '#');
    if (hash) {
        *length = strspn(hash, "#");
        *digits = (int)*length;
        return hash;
    }
    for (const char *percent = strchr(path, '%'); percent; percent = strchr(percent + 1, '%')) {
        size_t width = strspn(percent + 1, "0123456789");
        if (percent[1 + width] == 'd' && width <= 2) {
            *length = width + 2;
            *digits = atoi(percent + 1);
            return percent;
        }
    }
    return NULL;
}

/* The name of one frame of a sequence: the number in place of "####" or "%04d", or else before the
 * extension. */
static bool frame_path(gn_app *app, const char *pattern, uint32_t frame, char *out, size_t size)
{
    size_t length;
    int digits;
    char number[32];
    const char *mark = find_number(pattern, &length, &digits);
    if (!mark) {
        snprintf(number, sizeof number, ".%04u", frame);
        return gn_insert_suffix(app, pattern, number, out, size);
    }
    const int used = snprintf(out, size, "%.*s%0*u%s", (int)(mark - pattern), pattern, digits,
                              frame, mark + length);
    return (used >= 0 && (size_t)used < size) ||
           gn_app_error(app, "%s: the name is too long", pattern);
}

static void report_frame(cJSON *frames, uint32_t number, double time, const gn_frame *frame,
                         const gn_visibility_stats *stats, double update, double write,
                         cJSON *files, cJSON *lists)
{
    const gn_app *app = frame->app;
    const gn_timings timings = gn_view_timings(frame->view);
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddNumberToObject(entry, "frame", number);
    cJSON_AddNumberToObject(entry, "time", time);
    cJSON *ms = cJSON_AddObjectToObject(entry, "ms");
    cJSON_AddNumberToObject(ms, "update", update);
    cJSON_AddNumberToObject(ms, "gbuffer", timings.gbuffer);
    cJSON_AddNumberToObject(ms, "visibility", timings.visibility);
    cJSON_AddNumberToObject(ms, "shadow_map", timings.shadow_map);
    cJSON_AddNumberToObject(ms, "filter", timings.filter);
    cJSON_AddNumberToObject(ms, "test", timings.test);
    cJSON_AddNumberToObject(ms, "trace", timings.trace);
    cJSON_AddNumberToObject(ms, "shade", timings.shade);
    cJSON_AddNumberToObject(ms, "write", write);
    cJSON *means = cJSON_AddArrayToObject(entry, "mean_visibility");
    gn_leak_counts leak = {0};
    for (uint32_t l = 0; l < app->light_count; l++) {
        gn_app_add_counts(&leak, &stats[l].leak);
        const float *visibility = gn_view_visibility(frame->view, l);
        double sum = 0;
        for (size_t i = 0; i < pixels; i++)
            sum += (double)visibility[i];
        cJSON_AddItemToArray(means, cJSON_CreateNumber(sum / (double)pixels));
    }
    cJSON_AddNumberToObject(entry, "rays", (double)frame->tracing.rays);
    if (gn_app_has_rays(frame->method))
        gn_app_add_tracing_json(entry, &frame->tracing);
    if (frame->method->method.trace == GN_TRACE_LEAK)
        cJSON_AddItemToObject(entry, "leak",
                              gn_app_leak_json(&leak, (double)pixels * app->light_count));
    cJSON_AddItemToObject(entry, "files", files);
    if (cJSON_GetArraySize(lists) > 0)
        cJSON_AddItemToObject(entry, "lists", lists);
    else
        cJSON_Delete(lists);
    cJSON_AddItemToArray(frames, entry);
}

/* Seconds; frames before the animation stand still at its start, those of one picture at its time.
 */
static double time_of(const render_options *o, int64_t number)
{
    return o->frames.given ? (number > 0 ? (double)number : 0) / o->fps : o->common.time;
}

/* One frame, up to its pictures. */
static bool render_view(const gn_frame *frame, const render_options *o, int64_t number,
                        double *update)
{
    gn_app *app = frame->app;
    app->frame = (uint32_t)number;
    const double start = gn_milliseconds();
    if (o->frames.given && !gn_app_set_time(app, time_of(o, number)))
        return false;
    *update = gn_milliseconds() - start;
    if (frame->method->no_reuse)
        gn_history_reset_maps(gn_view_history(frame->view));
    gn_visibility_desc desc = gn_app_visibility_desc(app, frame->method);
    desc.history = NULL; /* the view's, which can be saved */
    return gn_view_render(frame->view, app->scene, app->camera, &desc, app->lights,
                          app->light_count) == GN_OK &&
           !gn_app_interrupted();
}

/* What colours stand for, where no one reads the JSON. */
static void note_lists(gn_app *app, const cJSON *lists)
{
    const cJSON *entry;
    cJSON_ArrayForEach(entry, lists)
    {
        const cJSON *extent = cJSON_GetObjectItem(entry, "extent");
        char width[48] = "";
        if (extent)
            snprintf(width, sizeof width, "; %.4g m wide", extent->valuedouble);
        gn_app_note(app, "%s: %s, at most %.0f triangles in a list%s",
                    cJSON_GetStringValue(cJSON_GetObjectItem(entry, "file")),
                    cJSON_GetStringValue(cJSON_GetObjectItem(entry, "light")),
                    cJSON_GetObjectItem(entry, "most")->valuedouble, width);
    }
}

/* Renders and writes one frame. */
static bool render_frame(const render_options *o, gn_frame *frame, const gn_visibility_stats *stats,
                         uint32_t number, cJSON *frames)
{
    gn_app *app = frame->app;
    const bool exr = ends_with(o->output, ".exr");
    double update;
    if (!render_view(frame, o, number, &update))
        return false;

    char path[4096];
    snprintf(path, sizeof path, "%s", o->output);
    if (o->frames.given && !frame_path(app, o->output, number, path, sizeof path))
        return false;
    gn_settings settings;
    gn_settings_fill(&settings, app, frame->method->name, o->samples, time_of(o, number));
    gn_settings_add_method(&settings, frame->method);
    frame->tracing = (gn_app_tracing){0};
    for (uint32_t l = 0; l < app->light_count; l++)
        gn_app_add_stats(&frame->tracing, &stats[l]);
    if (gn_app_has_rays(frame->method))
        gn_settings_add_tracing(&settings, &frame->tracing);
    frame->settings = &settings;
    cJSON *files = cJSON_CreateArray();
    frame->lists = cJSON_CreateArray();
    const double start = gn_milliseconds();
    const bool written =
        exr ? gn_frame_write_exr(frame, path, files) : gn_frame_write_png(frame, path, files);
    frame->settings = NULL; /* they end with this function */
    if (!written) {
        cJSON_Delete(files);
        cJSON_Delete(frame->lists);
        return false;
    }
    if (!o->frames.given)
        note_lists(app, frame->lists);
    report_frame(frames, number, time_of(o, number), frame, stats, update,
                 gn_milliseconds() - start, files, frame->lists);
    return true;
}

/* The frames that are not shown: those of a history, or before the first. */
static bool warm_up(const render_options *o, const gn_frame *frame, uint32_t first)
{
    gn_app *app = frame->app;
    if (o->history_in)
        return (first == 0 || gn_app_set_time(app, time_of(o, (int64_t)first - 1))) &&
               gn_view_load_history(frame->view, app->scene, o->history_in) == GN_OK;
    double update;
    for (uint32_t i = o->warm_up; i > 0; i--)
        if (!render_view(frame, o, (int64_t)first - i, &update))
            return false;
    return true;
}

static bool render_frames(const render_options *o, gn_frame *frame,
                          const gn_visibility_stats *stats, cJSON *frames, gn_app_tracing *tracing)
{
    gn_app *app = frame->app;
    const uint32_t first = o->frames.given ? o->frames.first : 0;
    const uint32_t last = o->frames.given ? o->frames.last : 0;
    gn_bar_step(&app->bar, 0.1, 0.05, "frames before the first");
    bool good = warm_up(o, frame, first);
    for (uint32_t f = first; f <= last && good; f++) {
        const double share = 0.85 / (last - first + 1.0);
        gn_bar_step(&app->bar, 0.15 + share * (f - first), share,
                    o->frames.given ? "frame %u of %u to %u" : "rendering", f, first, last);
        good = render_frame(o, frame, stats, f, frames);
        gn_app_add_tracing(tracing, &frame->tracing);
        if (!good && gn_app_interrupted() && f > first)
            gn_app_note(app, "frames %u to %u are finished", first, f - 1);
    }
    char text[256];
    if (good && gn_app_fallback(app, frame->method, tracing, text))
        gn_app_note(app, "%s", text);
    return good && (!o->history_out || gn_view_save_history(frame->view, o->history_out) == GN_OK);
}

static bool render_all(gn_app *app, const render_options *o, const gn_app_method *method,
                       uint32_t aovs, cJSON *frames, gn_app_tracing *tracing)
{
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    const gn_view_desc desc = gn_app_view_desc(app, o->samples);
    gn_frame frame = {.app = app, .method = method, .aovs = aovs};
    gn_visibility_stats *stats = calloc(app->light_count, sizeof *stats);
    bool good = stats || gn_app_error(app, "out of memory");
    good = good && gn_view_create(app->device, &desc, &frame.view) == GN_OK;
    for (uint32_t aov = 0; aov < GN_AOV_COUNT && good; aov++)
        if (aovs & FACTS & 1u << aov)
            good = (frame.facts[aov] = malloc(pixels * app->light_count * sizeof(float))) ||
                   gn_app_error(app, "out of memory");
    for (uint32_t l = 0; l < app->light_count && good; l++) {
        float **const planes[] = {
            [GN_AOV_LOD] = &stats[l].lod,       [GN_AOV_LOOKUPS] = &stats[l].lookups,
            [GN_AOV_RAYS] = &stats[l].traced,   [GN_AOV_CLASS] = &stats[l].leak_class,
            [GN_AOV_LISTS] = &stats[l].entries, [GN_AOV_CASCADE] = &stats[l].layer,
            [GN_AOV_TEST] = &stats[l].test};
        for (uint32_t aov = 0; aov < sizeof planes / sizeof *planes; aov++)
            if (frame.facts[aov])
                *planes[aov] = frame.facts[aov] + l * pixels;
    }
    if (good) {
        gn_view_set_stats(frame.view, stats);
        good = render_frames(o, &frame, stats, frames, tracing);
    }
    for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
        free(frame.facts[aov]);
    gn_view_destroy(&frame.view);
    free(stats);
    return good;
}

/* One picture is soonest traced; in a sequence what was found in a frame serves the next (the
 * measurements are in docs/benchmarks.md). Several samples a pixel are as many pictures. */
static const char *default_method(const render_options *o)
{
    return o->frames.given && o->samples == 1 ? "lt-vsm:coverage" : "ray";
}

/* What the table cannot check by itself. */
static int check_options(render_options *o, gn_app_method *method, uint32_t *aovs)
{
    if (!o->output)
        return gn_usage_error("render", "-o OUT.png or OUT.exr is missing");
    const bool exr = ends_with(o->output, ".exr");
    if (!exr && !ends_with(o->output, ".png"))
        return gn_usage_error("render", "--output: '%s' ends neither in .png nor in .exr",
                              o->output);
    if (o->method && gn_app_parts_given(&o->parts))
        return gn_usage_error("render", "--method and its parts (--map, --trace, --alpha and what "
                                        "belongs to them) exclude each other");
    if (o->frames.given && o->common.time > 0)
        return gn_usage_error("render", "--time and --frames exclude each other");
    if (o->history_in && o->warm_up > 0)
        return gn_usage_error("render", "--history-in and --warm-up exclude each other");
    if (gn_app_parts_given(&o->parts)) {
        const int code = gn_app_combine_parts("render", &o->parts, method);
        if (code != GN_GO_ON)
            return code;
    } else if (!gn_app_parse_method("render", o->method ? o->method : default_method(o), NULL,
                                    method)) {
        return GN_EXIT_USAGE;
    }
    *aovs = exr ? 1u << GN_AOV_VISIBILITY : 0;
    if (o->aov && (!gn_aov_parse("render", o->aov, aovs) ||
                   !gn_aov_check("render", *aovs, method, o->common.tracer.kind)))
        return GN_EXIT_USAGE;
    return GN_GO_ON;
}

static int parse(int argc, char **argv, render_options *o, const char **scene)
{
    static const char *const words[] = {"SCENE", NULL};
    static const char *const notes[] = {
        "SCENE is a file, or a built-in scene: see 'gnomon scene --list'.",
        "Frame N is at time N / fps. Its number replaces #### or %04d in OUT, or else stands",
        "before the extension.",
        "AOVs: visibility, depth, normal, shading_normal, albedo, motion, position; of rays lod,",
        "lookups, rays; of the light buffer lists, light-buffer; of leak tracing class; of maps",
        "cascade, test, map, xi4 (nlmsm). A .png has each in a file of its own beside it, as",
        "colours; an .exr has them as layers (visibility unless others are named); map, xi4 and",
        "light-buffer, which have sizes of their own, go to files beside it.",
        "A sequence that goes on elsewhere takes up what --history-out left behind its last frame,",
        "and gets the same bits, or some frames of --warm-up, and gets nearly the same pictures.",
        NULL};
    const gn_usage usage = {"render",
                            "pictures of a scene: PNG or OpenEXR, one frame or many",
                            "SCENE -o OUT.png|OUT.exr [options]",
                            words,
                            notes,
                            {"gnomon render grove -o grove.png --size 1280x720",
                             "gnomon render scene.glb -o walk.####.exr --camera Walk --frames 0:59 "
                             "--aov visibility,motion"}};
    const gn_option options[] = {
        GN_TEXT("output", 'o', "OUT", &o->output, "the file to write, .png or .exr"),
        GN_TEXT("method", 'm', "NAME", &o->method,
                "how visibility is found; default: ray, of --frames lt-vsm:coverage; see 'gnomon "
                "methods'"),
        GN_APP_PARTS_OPTIONS(o->parts),
        GN_APP_SHOT_OPTIONS(o->common),
        GN_APP_TIME_OPTION(o->common),
        GN_FRAMES("frames", 'f', &o->frames, "frames A to B, both included, of the animation"),
        GN_REAL("fps", 0, "N", &o->fps, 0.001, 1e6, "frames a second, default 30"),
        GN_TEXT("aov", 0, "LIST", &o->aov, "more outputs, separated by commas; see below"),
        GN_COUNT("spp", 0, "N", &o->samples, 1, 4096,
                 "samples a pixel, default 1; more: a supersampled reference"),
        GN_COUNT("warm-up", 0, "N", &o->warm_up, 0, 1000,
                 "frames before the first, not written, default 0"),
        GN_TEXT("history-in", 0, "FILE", &o->history_in,
                "go on from what --history-out wrote after the frame before"),
        GN_TEXT("history-out", 0, "FILE", &o->history_out,
                "write what the frame after the last needs to go on"),
        GN_APP_MAP_OPTIONS(o->common),
        GN_APP_LEAK_OPTIONS(o->common),
        GN_APP_TRACER_OPTIONS(o->common),
        GN_APP_DEVICE_OPTIONS(o->common),
        GN_OPTIONS_END,
    };
    return gn_options_parse(&usage, options, argc, argv, scene);
}

int gn_app_render(int argc, char **argv)
{
    render_options o = {.common = gn_app_options_default(),
                        .parts = gn_app_parts_default(),
                        .samples = 1,
                        .fps = 30};
    const char *scene;
    gn_app_method method = {0};
    uint32_t aovs = 0;
    int code = parse(argc, argv, &o, &scene);
    if (code == GN_GO_ON)
        code = check_options(&o, &method, &aovs);
    if (code != GN_GO_ON)
        return code;

    gn_app app = {0};
    cJSON *frames = cJSON_CreateArray();
    gn_app_tracing tracing = {0};
    bool good = gn_app_open(&app, "render", &o.common) && gn_app_use_methods(&app, &method, 1) &&
                gn_app_load(&app, scene) && gn_app_choose(&app) &&
                render_all(&app, &o, &method, aovs, frames, &tracing);
    gn_bar_clear(&app.bar);
    if (good && o.common.json) {
        cJSON *json = gn_app_json(&app);
        cJSON_AddStringToObject(json, "method", method.name);
        cJSON_AddNumberToObject(json, "spp", o.samples);
        gn_app_add_fallback(json, &app, &method, &tracing);
        cJSON_AddItemToObject(json, "frames", frames);
        frames = NULL;
        good = gn_app_print_json(&app, json);
    }
    cJSON_Delete(frames);
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_release_methods(&method, 1);
    gn_app_close(&app);
    return code;
}
