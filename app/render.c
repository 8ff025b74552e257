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
    uint32_t samples;
    gn_frames frames;
    double fps;
} render_options;

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

/* Finds visibility once more for what only rays and maps know. */
static bool collect_facts(gn_frame *frame)
{
    gn_app *app = frame->app;
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    const size_t pixels = (size_t)g->width * g->height;
    gn_visibility_desc desc = gn_app_visibility_desc(app, frame->method);
    float *unused = malloc(pixels * sizeof *unused);
    if (!unused)
        return gn_app_error(app, "out of memory");
    bool good = true;
    for (uint32_t i = 0; i < app->light_count && good; i++) {
        gn_visibility_stats stats = {.lod = frame->lod ? frame->lod + i * pixels : NULL,
                                     .lookups = frame->lookups ? frame->lookups + i * pixels : NULL,
                                     .layer = frame->cascade ? frame->cascade + i * pixels : NULL};
        desc.light = app->lights[i];
        /* Without rays the shadow test is all there is to visibility. */
        good =
            gn_scene_visibility(app->scene, g, &desc,
                                frame->test ? frame->test + i * pixels : unused, &stats) == GN_OK;
    }
    free(unused);
    return good;
}

static void report_frame(cJSON *frames, uint32_t number, double time, const gn_app *app,
                         const gn_view *view, double update, double write, cJSON *files)
{
    const gn_timings timings = gn_view_timings(view);
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
    for (uint32_t l = 0; l < app->light_count; l++) {
        const float *visibility = gn_view_visibility(view, l);
        double sum = 0;
        for (size_t i = 0; i < pixels; i++)
            sum += (double)visibility[i];
        cJSON_AddItemToArray(means, cJSON_CreateNumber(sum / (double)pixels));
    }
    cJSON_AddItemToObject(entry, "files", files);
    cJSON_AddItemToArray(frames, entry);
}

/* Renders and writes one frame. */
static bool render_frame(gn_app *app, const render_options *o, gn_view *view, gn_frame *frame,
                         uint32_t number, cJSON *frames)
{
    const bool exr = ends_with(o->output, ".exr");
    const double time = o->frames.given ? number / o->fps : o->common.time;
    double start = gn_milliseconds();
    if (o->frames.given && !gn_app_set_time(app, time))
        return false;
    const double update = gn_milliseconds() - start;
    app->frame = number;
    if (o->common.map.no_reuse && frame->method->history)
        gn_history_reset(frame->method->history);
    const gn_visibility_desc desc = gn_app_visibility_desc(app, frame->method);
    if (gn_view_render(view, app->scene, app->camera, &desc, app->lights, app->light_count) !=
        GN_OK)
        return false;
    if ((frame->lod || frame->lookups || frame->cascade || frame->test) && !collect_facts(frame))
        return false;
    if (gn_app_interrupted())
        return false;

    char path[4096];
    snprintf(path, sizeof path, "%s", o->output);
    if (o->frames.given && !frame_path(app, o->output, number, path, sizeof path))
        return false;
    gn_settings settings;
    gn_settings_fill(&settings, app, frame->method->name, o->samples, time);
    if (gn_app_has_map(frame->method))
        gn_settings_add_map(&settings, &app->map);
    frame->settings = &settings;
    cJSON *files = cJSON_CreateArray();
    start = gn_milliseconds();
    const bool written =
        exr ? gn_frame_write_exr(frame, path, files) : gn_frame_write_png(frame, path, files);
    frame->settings = NULL; /* they end with this function */
    if (!written) {
        cJSON_Delete(files);
        return false;
    }
    const double write = gn_milliseconds() - start;
    report_frame(frames, number, time, app, view, update, write, files);
    return true;
}

static bool render_all(gn_app *app, const render_options *o, const gn_app_method *method,
                       uint32_t aovs, cJSON *frames)
{
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    const size_t bytes = pixels * app->light_count * sizeof(float);
    const gn_view_desc desc = gn_app_view_desc(app, o->samples);
    gn_view *view = NULL;
    gn_frame frame = {.app = app, .method = method, .aovs = aovs};
    const struct {
        gn_aov aov;
        float **plane;
    } facts[] = {{GN_AOV_LOD, &frame.lod},
                 {GN_AOV_LOOKUPS, &frame.lookups},
                 {GN_AOV_CASCADE, &frame.cascade},
                 {GN_AOV_TEST, &frame.test}};
    bool good = gn_view_create(app->device, &desc, &view) == GN_OK;
    frame.view = view;
    for (size_t i = 0; i < sizeof facts / sizeof *facts && good; i++)
        if (aovs >> facts[i].aov & 1)
            good = (*facts[i].plane = malloc(bytes)) || gn_app_error(app, "out of memory");

    const uint32_t first = o->frames.given ? o->frames.first : 0;
    const uint32_t last = o->frames.given ? o->frames.last : 0;
    for (uint32_t f = first; f <= last && good; f++) {
        const double share = 0.9 / (last - first + 1.0);
        gn_bar_step(&app->bar, 0.1 + share * (f - first), share,
                    o->frames.given ? "frame %u of %u to %u" : "rendering", f, first, last);
        good = render_frame(app, o, view, &frame, f, frames);
        if (!good && gn_app_interrupted() && f > first)
            gn_app_note(app, "frames %u to %u are finished", first, f - 1);
    }
    for (size_t i = 0; i < sizeof facts / sizeof *facts; i++)
        free(*facts[i].plane);
    gn_view_destroy(&view);
    return good;
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
    if (gn_app_parts_given(&o->parts)) {
        const int code = gn_app_combine_parts("render", &o->parts, method);
        if (code != GN_GO_ON)
            return code;
    } else if (!gn_app_parse_method("render", o->method ? o->method : "ray", NULL, method)) {
        return GN_EXIT_USAGE;
    }
    *aovs = exr ? 1u << GN_AOV_VISIBILITY : 0;
    if (o->aov && (!gn_aov_parse("render", o->aov, aovs) || !gn_aov_check("render", *aovs, method)))
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
        "lookups; of maps cascade, test, map, xi4 (nlmsm). A .png gets each in a file of its own",
        "beside it, as colours; an .exr has them as layers (visibility unless others are named),",
        "and map and xi4, which have the map's size, in files beside it.",
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
                "how visibility is found, default ray; see 'gnomon methods'"),
        GN_APP_PARTS_OPTIONS(o->parts),
        GN_APP_SHOT_OPTIONS(o->common),
        GN_APP_TIME_OPTION(o->common),
        GN_FRAMES("frames", 'f', &o->frames, "frames A to B, both included, of the animation"),
        GN_REAL("fps", 0, "N", &o->fps, 0.001, 1e6, "frames a second, default 30"),
        GN_TEXT("aov", 0, "LIST", &o->aov, "more outputs, separated by commas; see below"),
        GN_COUNT("spp", 0, "N", &o->samples, 1, 4096,
                 "samples a pixel, default 1; more: a supersampled reference"),
        GN_APP_MAP_OPTIONS(o->common),
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
    bool good = gn_app_open(&app, "render", &o.common) && gn_app_use_methods(&app, &method, 1) &&
                gn_app_load(&app, scene) && gn_app_choose(&app) &&
                render_all(&app, &o, &method, aovs, frames);
    gn_bar_clear(&app.bar);
    if (good && o.common.json) {
        cJSON *json = gn_app_json(&app);
        cJSON_AddStringToObject(json, "method", method.name);
        cJSON_AddNumberToObject(json, "spp", o.samples);
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
