/* gnomon render: a scene as pictures. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render.h"

enum { MAX_SHOTS = 8 }; /* side by side */

const char *const gn_app_antialias_names[] = {"none", "taa", "smaa-t2x", NULL};

/* Frames before a single picture: two turns of the places in the pixel, and one of two. */
static const uint32_t warm_ups[] = {0, 15, 1};

/* What the table cannot check by itself. */
static int check_options(gn_render_options *o, gn_app_method *method, uint32_t *aovs)
{
    if (!o->output)
        return gn_usage_error("render", "-o OUT.png, OUT.exr or OUT.mp4 is missing");
    const bool exr = gn_ends_with(o->output, ".exr"), video = gn_ends_with(o->output, ".mp4");
    if (!exr && !video && !gn_ends_with(o->output, ".png"))
        return gn_usage_error("render", "--output: '%s' ends neither in .png, .exr nor .mp4",
                              o->output);
    const char *const unfit = o->aov ? "--aov" : o->resume ? "--resume" : NULL;
    if (video && unfit)
        return gn_usage_error("render", "%s is for pictures: a video is one file", unfit);
    if (video && !o->frames.given)
        return gn_usage_error("render", "a video is of --frames A:B, which is missing");
    if (o->beside && !video)
        return gn_usage_error("render", "--beside is for a video, OUT.mp4; 'gnomon compare' puts "
                                        "two pictures side by side");
    if (o->beside && (o->history_in || o->history_out))
        return gn_usage_error("render",
                              "--beside and --%s exclude each other: a history is of one "
                              "method",
                              o->history_in ? "history-in" : "history-out");
    if (o->method && gn_app_parts_given(&o->parts))
        return gn_usage_error("render", "--method and its parts (--map, --trace, --alpha and what "
                                        "belongs to them) exclude each other");
    if (o->frames.given && o->common.time > 0)
        return gn_usage_error("render", "--time and --frames exclude each other");
    if (o->history_in && o->warm_up != GN_NONE && o->warm_up > 0)
        return gn_usage_error("render", "--history-in and --warm-up exclude each other");
    if (o->antialias != GN_APP_NO_ANTIALIAS && o->samples > 1)
        return gn_usage_error("render", "--antialias and --spp exclude each other: it has a sample "
                                        "a frame");
    if (o->antialias != GN_APP_NO_ANTIALIAS && (o->history_in || o->history_out))
        return gn_usage_error("render",
                              "--antialias and --%s exclude each other: its pictures are "
                              "not in a history",
                              o->history_in ? "history-in" : "history-out");
    if (o->warm_up == GN_NONE)
        o->warm_up = o->frames.given ? 0 : warm_ups[o->antialias];
    if (o->resume && (!o->frames.given || o->history_out))
        return gn_usage_error("render", "--resume %s",
                              o->history_out ? "and --history-out exclude each other"
                                             : "is for sequences: --frames A:B is missing");
    if (gn_app_parts_given(&o->parts)) {
        const int code = gn_app_combine_parts("render", &o->parts, method);
        if (code != GN_GO_ON)
            return code;
    } else if (!gn_app_parse_method("render", o->method ? o->method : "ray", NULL, method)) {
        return GN_EXIT_USAGE;
    }
    *aovs = exr ? 1u << GN_AOV_VISIBILITY : 0;
    if (o->aov && (!gn_aov_parse("render", o->aov, aovs) ||
                   !gn_aov_check("render", *aovs, method, o->common.tracer.kind)))
        return GN_EXIT_USAGE;
    return GN_GO_ON;
}

static int parse(int argc, char **argv, gn_render_options *o, const char **scene)
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
        "A .mp4 is a video of --frames: H.264, 8 bits, yuv420p, BT.709; a size that is odd is made",
        "even by doubling its last row or column.",
        "A sequence that goes on elsewhere takes up what --history-out left behind its last frame,",
        "and gets the same bits, or some frames of --warm-up, and gets nearly the same pictures.",
        "A sequence that was interrupted goes on with the same bits where --resume is given both",
        "times: what methods keep from frame to frame is saved beside OUT until all is there.",
        NULL};
    const gn_usage usage = {"render",
                            "pictures of a scene: PNG or OpenEXR, one frame or many; or a video",
                            "SCENE -o OUT.png|OUT.exr|OUT.mp4 [options]",
                            words,
                            notes,
                            {"gnomon render grove -o grove.png --size 1280x720",
                             "gnomon render scene.glb -o walk.####.exr --camera Walk --frames 0:59 "
                             "--aov visibility,motion"}};
    const gn_option options[] = {
        GN_TEXT("output", 'o', "OUT", &o->output, "the file to write: .png, .exr or .mp4"),
        GN_TEXT("method", 'm', "NAME", &o->method,
                "how visibility is found; default: ray; see 'gnomon methods'"),
        GN_APP_PARTS_OPTIONS(o->parts),
        GN_APP_SHOT_OPTIONS(o->common),
        GN_APP_TIME_OPTION(o->common),
        GN_FRAMES("frames", 'f', &o->frames, "frames A to B, both included, of the animation"),
        GN_TEXT(
            "beside", 0, "A,B,...", &o->beside,
            "of a video: methods to the right of the first, each perhaps with +taa or +smaa-t2x"),
        GN_REAL("fps", 0, "N", &o->fps, 0.001, 1e6, "frames a second, default 30"),
        GN_TEXT("aov", 0, "LIST", &o->aov, "more outputs, separated by commas; see below"),
        GN_COUNT("spp", 0, "N", &o->samples, 1, 4096,
                 "samples a pixel, default 1; more: a supersampled reference"),
        GN_CHOICE("antialias", 0, "HOW", &o->antialias, gn_app_antialias_names,
                  "none (the default), taa (over time) or smaa-t2x (edges, and two frames)"),
        GN_COUNT("warm-up", 0, "N", &o->warm_up, 0, 1000,
                 "frames before the first, not written, default 0; of a picture with taa 15"),
        GN_TEXT("history-in", 0, "FILE", &o->history_in,
                "go on from what --history-out wrote after the frame before"),
        GN_TEXT("history-out", 0, "FILE", &o->history_out,
                "write what the frame after the last needs to go on"),
        GN_FLAG("resume", 0, &o->resume,
                "skip the frames that are there, and keep what the next run needs to go on"),
        GN_APP_MAP_OPTIONS(o->common),
        GN_APP_LEAK_OPTIONS(o->common),
        GN_APP_TRACER_OPTIONS(o->common),
        GN_APP_DEVICE_OPTIONS(o->common),
        GN_OPTIONS_END,
    };
    return gn_options_parse(&usage, options, argc, argv, scene);
}

typedef struct job {
    gn_render_options o;
    gn_app_method methods[MAX_SHOTS];
    gn_app_antialias antialias[MAX_SHOTS];
    char names[MAX_SHOTS][160];
    gn_shot shots[MAX_SHOTS];
    uint32_t count, aovs, skipped;
    cJSON *frames;
} job;

/* "ray-mip0+taa": a method, and how its pictures are antialiased. */
static bool parse_shot(job *j, const char *text)
{
    char name[128];
    const size_t length = strcspn(text, "+");
    snprintf(name, sizeof name, "%.*s", (int)(length < 127 ? length : 127), text);
    if (text[length]) {
        uint32_t kind = GN_APP_TAA;
        while (gn_app_antialias_names[kind] &&
               strcmp(gn_app_antialias_names[kind], text + length + 1) != 0)
            kind++;
        if (!gn_app_antialias_names[kind]) {
            gn_usage_error("render", "--beside %s: behind '+' stands taa or smaa-t2x", text);
            return false;
        }
        j->antialias[j->count] = (gn_app_antialias)kind;
    }
    return gn_app_parse_method("render", name, NULL, &j->methods[j->count++]);
}

/* The methods of --beside. */
static bool parse_beside(job *j)
{
    for (const char *start = j->o.beside;; start++) {
        char text[160];
        const size_t length = strcspn(start, ",");
        if (j->count == MAX_SHOTS) {
            gn_usage_error("render", "--beside: at most %d methods fit beside the first",
                           MAX_SHOTS - 1);
            return false;
        }
        snprintf(text, sizeof text, "%.*s", (int)(length < 159 ? length : 159), start);
        if (!parse_shot(j, text))
            return false;
        start += length;
        if (!*start)
            return true;
    }
}

static bool run(job *j, gn_app *app, const char *scene)
{
    const gn_render_options *o = &j->o;
    bool good = gn_app_open(app, "render", &o->common) &&
                gn_app_use_methods(app, j->methods, j->count) && gn_app_load(app, scene) &&
                gn_app_choose(app);
    for (uint32_t k = 0; k < j->count && good; k++) {
        const bool plain = j->antialias[k] == GN_APP_NO_ANTIALIAS;
        snprintf(j->names[k], sizeof j->names[k], "%s%s%s", j->methods[k].name, plain ? "" : "+",
                 plain ? "" : gn_app_antialias_names[j->antialias[k]]);
        good = gn_shot_open(&j->shots[k], app, o, &j->methods[k], j->names[k], j->antialias[k],
                            j->aovs);
    }
    if (good && gn_ends_with(o->output, ".mp4"))
        good = gn_render_video(j->shots, j->count, o, j->frames);
    else
        good = good && gn_render_sequence(&j->shots[0], o, j->frames, &j->skipped);
    gn_bar_clear(&app->bar);
    char text[256];
    for (uint32_t k = 0; k < j->count && good; k++)
        if (gn_app_fallback(app, &j->methods[k], &j->shots[k].tracing, text))
            gn_app_note(app, "%s", text);
    return good;
}

static bool print(job *j, gn_app *app)
{
    cJSON *json = gn_app_json(app);
    cJSON_AddStringToObject(json, "method", j->methods[0].name);
    cJSON_AddNumberToObject(json, "spp", j->o.samples);
    cJSON_AddStringToObject(json, "antialias", gn_app_antialias_names[j->antialias[0]]);
    if (j->o.resume)
        cJSON_AddNumberToObject(json, "skipped", j->skipped);
    if (gn_ends_with(j->o.output, ".mp4"))
        cJSON_AddStringToObject(json, "file", j->o.output);
    gn_app_add_fallback(json, app, &j->methods[0], &j->shots[0].tracing);
    cJSON_AddItemToObject(json, "frames", j->frames);
    j->frames = NULL;
    return gn_app_print_json(app, json);
}

int gn_app_render(int argc, char **argv)
{
    job *j = calloc(1, sizeof *j);
    if (!j) {
        fprintf(stderr, "gnomon render: out of memory\n");
        return GN_EXIT_FAILURE;
    }
    j->o = (gn_render_options){.common = gn_app_options_default(),
                               .parts = gn_app_parts_default(),
                               .samples = 1,
                               .warm_up = GN_NONE,
                               .fps = 30};
    j->count = 1;
    const char *scene;
    int code = parse(argc, argv, &j->o, &scene);
    if (code == GN_GO_ON)
        code = check_options(&j->o, &j->methods[0], &j->aovs);
    j->antialias[0] = (gn_app_antialias)j->o.antialias;
    if (code == GN_GO_ON && j->o.beside && !parse_beside(j))
        code = GN_EXIT_USAGE;
    if (code == GN_GO_ON) {
        gn_app app = {0};
        j->frames = cJSON_CreateArray();
        const bool good = run(j, &app, scene) && (!j->o.common.json || print(j, &app));
        cJSON_Delete(j->frames);
        for (uint32_t k = 0; k < j->count; k++)
            gn_shot_close(&j->shots[k]);
        code = good ? GN_EXIT_OK : gn_app_fail(&app);
        gn_app_release_methods(j->methods, j->count);
        gn_app_close(&app);
    }
    free(j);
    return code;
}
