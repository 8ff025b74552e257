/* What the commands share: options, opening a device and a scene, choosing camera and lights. */
#ifndef GN_APP_APP_H
#define GN_APP_APP_H

#include <cjson/cJSON.h>
#include <gnomon/gnomon.h>

#include "options.h"
#include "progress.h"

#include "base/base.h" /* gn_milliseconds */

enum { GN_EXIT_OK = 0, GN_EXIT_FAILURE = 1, GN_EXIT_USAGE = 2, GN_EXIT_INTERRUPTED = 130 };

int gn_app_render(int argc, char **argv);
int gn_app_compare(int argc, char **argv);
int gn_app_bench(int argc, char **argv);
int gn_app_demo(int argc, char **argv);
int gn_app_scene(int argc, char **argv);
int gn_app_info(int argc, char **argv);

/* Values of the options that several commands have. */
typedef struct gn_app_options {
    uint32_t threads; /* 0: one for each core */
    uint32_t isa;     /* gn_isa */
    bool quiet, json;
    uint32_t seed; /* built-in scenes */
    double scale;
    const char *camera, *lights; /* NULL: not given */
    gn_sun sun;
    uint32_t size[2];
    double time;
    bool no_alpha_rescale;
} gn_app_options;

gn_app_options gn_app_options_default(void);

extern const char *const gn_app_isa_names[]; /* in the order of gn_isa */

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
        GN_TEXT("light", 'l', "NAME|all", &(o).lights,                                             \
                "light, by name or number, or all; default: those that are on"),                   \
        GN_SUN("sun", 0, &(o).sun, "a sun in place of the scene's lights, in degrees"),            \
        GN_SIZE("size", 's', (o).size, "pixels, default 1920x1080"),                               \
        GN_FLAG("no-alpha-rescale", 0, &(o).no_alpha_rescale,                                      \
                "plain averages as mips of alpha, for comparison")

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
    gn_bar bar;
    bool wrong_usage;   /* the error is the user's, not the scene's or the machine's */
    bool keep_warnings; /* set before gn_app_open(): the command prints them itself */
    char message[1024]; /* the last error, for when there is no device to ask */
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

/* The names of things as a person would give them: the name, or the number where there is none. */
const char *gn_app_camera_name(const gn_app *app, char text[32]);
const char *gn_app_light_name(const gn_app *app, uint32_t light, char text[32]);

/* One of gn_methods, or a pseudo-method that only some commands know (method is NULL then). */
typedef struct gn_app_method {
    const char *name;
    const gn_method *method;
} gn_app_method;

#define GN_APP_MAX_METHODS 16

/* Reads "a,b,c" into at most GN_APP_MAX_METHODS entries; pseudo: other names, ending with NULL, or
 * NULL. Returns the count, or 0 after saying what is wrong: exit with GN_EXIT_USAGE. */
uint32_t gn_app_parse_methods(const char *command, const char *list, const char *const *pseudo,
                              gn_app_method methods[GN_APP_MAX_METHODS]);

/* Views and visibility by the options. */
gn_view_desc gn_app_view_desc(const gn_app *app, uint32_t samples);
gn_visibility_desc gn_app_visibility_desc(const gn_app *app, const gn_method *method);

/* Runs the visibility of all chosen lights on a G-buffer into planes of width * height floats, one
 * a light; stats may be NULL, stats->rays is summed. Time in *milliseconds, which may be NULL. */
bool gn_app_visibility(gn_app *app, const gn_gbuffer *gbuffer, const gn_method *method,
                       float *planes, uint64_t *rays, double *milliseconds);

/* Makes a folder unless it is there. */
bool gn_app_make_folder(gn_app *app, const char *path);

/* SIGINT and SIGTERM are noted, not obeyed at once: nothing half written stays behind. */
void gn_app_catch_interrupts(void);
bool gn_app_interrupted(void);

/* JSON: facts that every command reports, and printing (which frees). */
cJSON *gn_app_json(const gn_app *app);
bool gn_app_print_json(gn_app *app, cJSON *json);

/* Standard output has taken everything that was printed. */
bool gn_app_flush(gn_app *app);

#endif
