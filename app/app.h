/* What the commands share: options, opening a device and a scene, choosing camera and lights. */
#ifndef GN_APP_APP_H
#define GN_APP_APP_H

#include <cjson/cJSON.h>
#include <gnomon/gnomon.h>

#include "options.h"
#include "progress.h"

#include "base/base.h" /* gn_milliseconds */

enum { GN_EXIT_OK = 0, GN_EXIT_FAILURE = 1, GN_EXIT_USAGE = 2, GN_EXIT_INTERRUPTED = 130 };

/* The command that argv[0] names; GN_EXIT_USAGE after saying that there is none. */
int gn_app_command(int argc, char **argv);

int gn_app_render(int argc, char **argv);
int gn_app_compare(int argc, char **argv);
int gn_app_compare_images(int argc, char **argv); /* compare --images */
int gn_app_bench(int argc, char **argv);
int gn_app_demo(int argc, char **argv);
int gn_app_methods(int argc, char **argv);
int gn_app_histogram(int argc, char **argv);
int gn_app_make_report(int argc, char **argv);
int gn_app_bounds(int argc, char **argv);
int gn_app_mips(int argc, char **argv);
int gn_app_scene(int argc, char **argv);
int gn_app_info(int argc, char **argv);

/* Settings of shadow maps. Counts and choices are GN_NONE, numbers NAN, where not given. */
typedef struct gn_app_map_options {
    uint32_t resolution, cascades, undrawn, refresh, samples, filter_width;
    uint32_t alpha, reading; /* gn_map_alpha, gn_map_reading */
    double distance, split_weight, enlarge, filter_sigma;
    double depth_bias, normal_bias, minimum_variance, moment_bias;
    gn_reals splits, evsm, esm;
    bool mip_maps, no_reuse;
} gn_app_map_options;

/* Settings of leak tracing. Choices are GN_NONE, numbers NAN, where not given. */
typedef struct gn_app_leak_options {
    double epsilon;
    uint32_t kernel, depth_test; /* gn_leak_kernel, gn_switch */
    bool no_expand, no_remove;
} gn_app_leak_options;

gn_app_leak_options gn_app_leak_options_default(void);

/* What answers shadow rays. */
typedef struct gn_app_tracer_options {
    uint32_t kind;             /* gn_tracer_kind; GN_NONE: not given */
    double light_buffer_limit; /* megabytes; NAN: not given */
} gn_app_tracer_options;

/* Values of the options that several commands have. */
typedef struct gn_app_options {
    uint32_t threads; /* 0: one for each core */
    uint32_t isa;     /* gn_isa */
    bool quiet, json;
    uint32_t seed; /* built-in scenes */
    double scale;
    const char *camera, *lights; /* NULL: not given */
    const char *camera_path;     /* file of key frames; NULL: not given */
    gn_sun sun;
    uint32_t size[2];
    double time;
    bool no_alpha_rescale;
    gn_app_map_options map;
    gn_app_leak_options leak;
    gn_app_tracer_options tracer;
} gn_app_options;

gn_app_options gn_app_options_default(void);

/* In the order of gn_isa, gn_map_alpha and gn_map_reading. */
extern const char *const gn_app_isa_names[];
extern const char *const gn_app_map_alpha_names[];
extern const char *const gn_app_reading_names[];
/* In the order of gn_leak_kernel, gn_switch and gn_tracer_kind. */
extern const char *const gn_app_kernel_names[];
extern const char *const gn_app_switch_names[];
extern const char *const gn_app_tracer_names[];

/* Lines for a command's option table; o is its gn_app_options. */
#define GN_APP_DEVICE_OPTIONS(o)                                                                   \
    GN_COUNT("threads", 0, "N", &(o).threads, 0, 1024,                                             \
             "worker threads; 0, the default: one for each core"),                                 \
        GN_CHOICE("isa", 0, "NAME", &(o).isa, gn_app_isa_names,                                    \
                  "highest instruction set: auto, scalar, avx2, avx512"),                          \
        GN_FLAG("quiet", 'q', &(o).quiet, "no progress and no notes"),                             \
        GN_FLAG("json", 0, &(o).json, "results as JSON on standard output")

#define GN_APP_SCENE_OPTIONS(o)                                                                    \
    GN_COUNT("seed", 0, "N", &(o).seed, 0, UINT32_MAX, "seed of a built-in scene, default 1"),     \
        GN_REAL("scale", 0, "X", &(o).scale, 0.001, 1000,                                          \
                "X times the triangles of a built-in scene, default 1")

#define GN_APP_SHOT_OPTIONS(o)                                                                     \
    GN_APP_SCENE_OPTIONS(o),                                                                       \
        GN_TEXT("camera", 'c', "NAME", &(o).camera,                                                \
                "camera, by name or number; default: the first"),                                  \
        GN_TEXT("camera-path", 0, "FILE.json", &(o).camera_path,                                   \
                "a camera that follows key frames, in place of the scene's"),                      \
        GN_TEXT("light", 'l', "NAME|all", &(o).lights,                                             \
                "light, by name or number, or all; default: those that are on"),                   \
        GN_SUN("sun", 0, &(o).sun, "a sun in place of the scene's lights, in degrees"),            \
        GN_SIZE("size", 's', (o).size, "pixels, default 1920x1080"),                               \
        GN_FLAG("no-alpha-rescale", 0, &(o).no_alpha_rescale,                                      \
                "plain averages as mips of alpha, for comparison")

/* Ranges are the library's, which names them (gn_app_use_methods()). */
#define GN_APP_COUNT(name, argument, value, help)                                                  \
    GN_COUNT(name, 0, argument, value, 0, UINT32_MAX - 1, help)
#define GN_APP_REAL(name, argument, value, help)                                                   \
    GN_REAL(name, 0, argument, value, -1e30, 1e30, help)
/* Below 0 the library takes the format's own. */
#define GN_APP_BIAS(name, value, help) GN_REAL(name, 0, "X", value, 0, 1e30, help)

/* Where maps lie and how they are drawn. */
#define GN_APP_PLACE_OPTIONS(o)                                                                    \
    GN_APP_COUNT("map-size", "N", &(o).map.resolution, "texels a side, default 2048"),             \
        GN_APP_COUNT("cascades", "N", &(o).map.cascades, "cascades of a sun, default 4"),          \
        GN_REALS("splits", 0, "A,B,...", &(o).map.splits, 1, GN_MAX_CASCADES,                      \
                 "far end of each cascade as a share of the shadow distance, the last 1"),         \
        GN_APP_REAL("split-weight", "X", &(o).map.split_weight,                                    \
                    "cascades split evenly (0) to logarithmically (1), default 0.85"),             \
        GN_APP_REAL("shadow-distance", "M", &(o).map.distance,                                     \
                    "metres that the cascades reach; 0, the default: all that is seen"),           \
        GN_APP_REAL("enlarge", "X", &(o).map.enlarge,                                              \
                    "share by which cascades exceed their need, to be kept longer, default 0.15"), \
        GN_APP_COUNT("map-samples", "N", &(o).map.samples,                                         \
                     "depths a texel, 1 (the default) or 4, where they are filtered"),             \
        GN_CHOICE("map-alpha", 0, "RULE", &(o).map.alpha, gn_app_map_alpha_names,                  \
                  "masked occluders in a map: test (the default), mip0, hashed, opaque"),          \
        GN_APP_BIAS("moment-bias", &(o).map.moment_bias,                                           \
                    "of msm and nlmsm; default: the format's own")

/* All settings of maps. */
#define GN_APP_MAP_OPTIONS(o)                                                                      \
    GN_APP_PLACE_OPTIONS(o),                                                                       \
        GN_FLAG("no-reuse", 0, &(o).map.no_reuse, "make the maps anew in every frame"),            \
        GN_COUNT("refresh", 0, "N", &(o).map.refresh, 1, 64,                                       \
                 "frames over which a layer is drawn, default 1, in leak tracing 8"),              \
        GN_APP_COUNT("undrawn", "N", &(o).map.undrawn,                                             \
                     "cascades at the far end left out, default 0, in leak tracing 1"),            \
        GN_APP_COUNT("filter-width", "N", &(o).map.filter_width,                                   \
                     "texels of the Gaussian filter, odd, default 9; 1: no filter"),               \
        GN_APP_REAL("filter-sigma", "X", &(o).map.filter_sigma,                                    \
                    "its standard deviation in texels, default 2.4"),                              \
        GN_FLAG("mip-maps", 0, &(o).map.mip_maps, "mip maps of vsm, esm, evsm and msm"),           \
        GN_CHOICE("reading", 0, "HOW", &(o).map.reading, gn_app_reading_names,                     \
                  "of texels: auto (the default), nearest, white, blue, bilinear"),                \
        GN_APP_BIAS("depth-bias", &(o).map.depth_bias,                                             \
                    "parts of a layer's depth range; default: the format's own"),                  \
        GN_APP_BIAS("normal-bias", &(o).map.normal_bias,                                           \
                    "texels along the normal; default: the format's own"),                         \
        GN_APP_BIAS("min-variance", &(o).map.minimum_variance,                                     \
                    "of vsm and evsm; default: the format's own"),                                 \
        GN_REALS("evsm", 0, "C+[,C-]", &(o).map.evsm, 1, 2,                                        \
                 "exponents of evsm; default: the method's own"),                                  \
        GN_REALS("esm", 0, "C", &(o).map.esm, 1, 1, "exponent of esm; default: the method's own")

/* Settings of leak tracing. */
#define GN_APP_LEAK_OPTIONS(o)                                                                     \
    GN_REAL("leak-epsilon", 0, "X", &(o).leak.epsilon, 0, 0.49,                                    \
            "a map is unsure between X and 1 - X; default 0.01"),                                  \
        GN_CHOICE("leak-kernel", 0, "NAME", &(o).leak.kernel, gn_app_kernel_names,                 \
                  "neighbours in the mask: gather (2x2, the default) or full (3x3)"),              \
        GN_FLAG("no-expand", 0, &(o).leak.no_expand, "the mask adds no rays"),                     \
        GN_FLAG("no-remove", 0, &(o).leak.no_remove, "the mask takes no rays away"),               \
        GN_CHOICE("depth-test", 0, "WHEN", &(o).leak.depth_test, gn_app_switch_names,              \
                  "rays are taken away only at an unchanged depth: auto (the default), off, on")

/* What answers shadow rays. */
#define GN_APP_TRACER_OPTIONS(o)                                                                   \
    GN_CHOICE("tracer", 0, "NAME", &(o).tracer.kind, gn_app_tracer_names,                          \
              "what answers shadow rays: auto (the default), bvh (a tree), light-buffer"),         \
        GN_REAL("light-buffer-limit", 0, "MB", &(o).tracer.light_buffer_limit, 0, 1e6,             \
                "megabytes for the light buffers of a method, default 512")

#define GN_APP_TIME_OPTION(o)                                                                      \
    GN_REAL("time", 't', "S", &(o).time, 0, 1e6, "seconds into the animation, default 0")

/* A command at work. Zero-initialise; end with gn_app_close(). */
typedef struct gn_app {
    const char *command;
    gn_app_options options;
    gn_device *device;
    gn_scene *scene;
    const char *scene_name; /* as given */
    gn_scene_info info;     /* as loaded */
    uint32_t camera;
    uint32_t *lights; /* indices in the scene */
    uint32_t light_count;
    uint32_t frame;  /* number of the frame at hand */
    gn_map_desc map; /* settings of maps by the options, set by gn_app_use_methods() */
    gn_bar bar;
    bool wrong_usage;   /* the error is the user's, not the scene's or the machine's */
    bool keep_warnings; /* set before gn_app_open(): the command prints them itself */
    char message[1024]; /* the last error, for when there is no device to ask */
    char finished[128]; /* what an interrupt leaves, as a clause; "": nothing */
} gn_app;

/* Each returns true, or false after an error; then return gn_app_fail(). */
bool gn_app_open(gn_app *app, const char *command, const gn_app_options *options);
/* name: a file, or else a built-in scene. Committed at options.time. */
bool gn_app_load(gn_app *app, const char *name);
/* Camera and lights by the options; adds a sun or a camera where there is none, with a note. */
bool gn_app_choose(gn_app *app);
bool gn_app_set_time(gn_app *app, double seconds); /* and commits */
void gn_app_close(gn_app *app);

/* Says "gnomon COMMAND: message" for the last error; the exit code. */
int gn_app_fail(gn_app *app);
/* Sets the error that gn_app_fail() will say; returns false. */
bool gn_app_error(gn_app *app, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* A remark on standard error, unless --quiet. */
void gn_app_note(gn_app *app, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Sets what gn_app_fail() will say is finished after an interrupt: "3 of 8 pictures are finished".
 */
void gn_app_finished(gn_app *app, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The names of things as a person would give them: the name, or the number where there is none. */
const char *gn_app_camera_name(const gn_app *app, char text[32]);
const char *gn_app_light_name(const gn_app *app, uint32_t light, char text[32]);

gn_view_desc gn_app_view_desc(const gn_app *app, uint32_t samples);

/* Makes a folder unless it is there. */
bool gn_app_make_folder(gn_app *app, const char *path);

/* SIGINT and SIGTERM are noted, not obeyed at once: nothing half written stays behind. */
void gn_app_catch_interrupts(void);
bool gn_app_interrupted(void);
/* A file that is long in the making, which a second interrupt removes before it ends the process at
 * once; NULL: no more. "": it comes now, and until its name is told only the first interrupt
 * counts. One at a time. */
void gn_app_set_partial(const char *path);

/* JSON: facts that every command reports, and printing (which frees). */
cJSON *gn_app_json(const gn_app *app);
bool gn_app_print_json(gn_app *app, cJSON *json);

/* Standard output has taken everything that was printed. */
bool gn_app_flush(gn_app *app);

#endif
