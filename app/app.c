#include "app.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "camera_path.h"

const char *const gn_app_isa_names[] = {"auto", "scalar", "avx2", "avx512", NULL};
const char *const gn_app_map_alpha_names[] = {"test", "mip0", "hashed", "opaque", NULL};
const char *const gn_app_reading_names[] = {"auto", "nearest", "white", "blue", "bilinear", NULL};

const char *const gn_app_kernel_names[] = {"gather", "full", NULL};
const char *const gn_app_switch_names[] = {"auto", "off", "on", NULL};
const char *const gn_app_tracer_names[] = {"auto", "bvh", "light-buffer", NULL};

gn_app_leak_options gn_app_leak_options_default(void)
{
    return (gn_app_leak_options){.epsilon = NAN, .kernel = GN_NONE, .depth_test = GN_NONE};
}

gn_app_options gn_app_options_default(void)
{
    return (gn_app_options){.seed = 1,
                            .scale = 1,
                            .size = {1920, 1080},
                            .map = {.resolution = GN_NONE,
                                    .cascades = GN_NONE,
                                    .undrawn = GN_NONE,
                                    .refresh = GN_NONE,
                                    .samples = GN_NONE,
                                    .filter_width = GN_NONE,
                                    .alpha = GN_NONE,
                                    .reading = GN_NONE,
                                    .distance = NAN,
                                    .split_weight = NAN,
                                    .enlarge = NAN,
                                    .filter_sigma = NAN,
                                    .depth_bias = NAN,
                                    .normal_bias = NAN,
                                    .minimum_variance = NAN,
                                    .moment_bias = NAN},
                            .leak = gn_app_leak_options_default(),
                            .tracer = {.kind = GN_NONE, .light_buffer_limit = NAN}};
}

/* Interrupts -------------------------------------------------------------------------------- */

enum { PARTIAL_NONE, PARTIAL_UNNAMED, PARTIAL_NAMED };

static volatile sig_atomic_t interrupted, partial_state;
static char partial[8192];

static void note_interrupt(int number)
{
    (void)number;
    if (interrupted) { /* asked twice: at once */
        if (partial_state == PARTIAL_UNNAMED)
            return;
        if (partial_state == PARTIAL_NAMED)
            unlink(partial);
        _exit(GN_EXIT_INTERRUPTED);
    }
    interrupted = 1;
}

void gn_app_set_partial(const char *path)
{
    partial_state = PARTIAL_UNNAMED;
    const bool named = path && *path && strlen(path) < sizeof partial;
    if (named)
        strcpy(partial, path);
    if (named || !path)
        partial_state = named ? PARTIAL_NAMED : PARTIAL_NONE;
}

void gn_app_catch_interrupts(void)
{
    struct sigaction action = {.sa_handler = note_interrupt, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGPIPE, SIG_IGN); /* a closed pipe is an error like any other */
}

bool gn_app_interrupted(void)
{
    return interrupted != 0;
}

/* Messages ---------------------------------------------------------------------------------- */

bool gn_app_error(gn_app *app, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(app->message, sizeof app->message, format, arguments);
    va_end(arguments);
    return false;
}

int gn_app_fail(gn_app *app)
{
    gn_bar_clear(&app->bar);
    if (interrupted) {
        fprintf(stderr, "gnomon %s: interrupted; %s; no partial file is left\n", app->command,
                *app->finished ? app->finished : "nothing is finished");
        return GN_EXIT_INTERRUPTED;
    }
    fprintf(stderr, "gnomon %s: %s\n", app->command, app->message);
    return app->wrong_usage ? GN_EXIT_USAGE : GN_EXIT_FAILURE;
}

void gn_app_finished(gn_app *app, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(app->finished, sizeof app->finished, format, arguments);
    va_end(arguments);
}

void gn_app_note(gn_app *app, const char *format, ...)
{
    if (app->options.quiet)
        return;
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    gn_bar_clear(&app->bar);
    fprintf(stderr, "gnomon %s: note: %s\n", app->command, text);
}

static void log_message(gn_log_level level, const char *message, void *user)
{
    gn_app *app = user;
    if (level == GN_LOG_ERROR) {
        snprintf(app->message, sizeof app->message, "%s", message);
    } else if (level == GN_LOG_WARNING && !app->keep_warnings) {
        gn_bar_clear(&app->bar);
        fprintf(stderr, "gnomon %s: warning: %s\n", app->command, message);
    }
}

static int report_progress(double fraction, const char *what, void *user)
{
    (void)what;
    gn_app *app = user;
    gn_bar_update(&app->bar, fraction);
    return interrupted != 0;
}

/* Device and scene -------------------------------------------------------------------------- */

bool gn_app_open(gn_app *app, const char *command, const gn_app_options *options)
{
    app->command = command;
    app->options = *options;
    gn_bar_start(&app->bar, options->quiet);
    gn_bar_step(&app->bar, 0, 0.1, "reading the scene");
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = options->threads;
    desc.isa = (gn_isa)options->isa;
    desc.logger = (gn_logger){log_message, app};
    desc.progress = (gn_progress){report_progress, app};
    return gn_device_create(&desc, &app->device) == GN_OK;
}

void gn_app_close(gn_app *app)
{
    gn_bar_clear(&app->bar);
    free(app->lights);
    app->lights = NULL;
    gn_scene_destroy(&app->scene);
    gn_device_destroy(&app->device);
}

static bool is_built_in(const char *name)
{
    for (const gn_procedural *scene = gn_procedurals; scene->name; scene++) {
        if (strcmp(scene->name, name) == 0)
            return true;
    }
    return false;
}

bool gn_app_load(gn_app *app, const char *name)
{
    app->scene_name = name;
    gn_result result;
    if (access(name, F_OK) != 0 && is_built_in(name)) {
        gn_procedural_desc desc = gn_procedural_desc_default();
        desc.seed = app->options.seed;
        desc.scale = app->options.scale;
        result = gn_scene_create_procedural(app->device, name, &desc, &app->scene);
    } else {
        result = gn_scene_load(app->device, name, &app->scene);
    }
    if (result != GN_OK)
        return false;
    app->info = gn_scene_get_info(app->scene);
    return !interrupted && (app->options.time <= 0 || gn_app_set_time(app, app->options.time));
}

bool gn_app_set_time(gn_app *app, double seconds)
{
    return gn_scene_set_time(app->scene, seconds) == GN_OK && gn_scene_commit(app->scene) == GN_OK;
}

/* Camera and lights ------------------------------------------------------------------------- */

const char *gn_app_camera_name(const gn_app *app, char text[32])
{
    const char *name = gn_scene_camera_name(app->scene, app->camera);
    if (*name)
        return name;
    snprintf(text, 32, "%u", app->camera);
    return text;
}

const char *gn_app_light_name(const gn_app *app, uint32_t light, char text[32])
{
    const char *name = gn_scene_light_name(app->scene, light);
    if (*name)
        return name;
    snprintf(text, 32, "%u", light);
    return text;
}

/* "Road, Walk, 2": names, and the number where there is none. */
static void list_names(const gn_scene *scene, uint32_t count,
                       const char *(*get)(const gn_scene *, uint32_t), char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (uint32_t i = 0; i < count && used < size; i++) {
        const char *name = get(scene, i);
        const char *comma = i ? ", " : "";
        int written = *name ? snprintf(text + used, size - used, "%s%s", comma, name)
                            : snprintf(text + used, size - used, "%s%u", comma, i);
        used += written > 0 ? (size_t)written : 0;
    }
}

/* A number in [0, count), or GN_NONE. */
static uint32_t as_index(const char *text, uint32_t count)
{
    char *end;
    if (*text < '0' || *text > '9')
        return GN_NONE;
    unsigned long number = strtoul(text, &end, 10);
    return !*end && number < count ? (uint32_t)number : GN_NONE;
}

static bool choose_camera(gn_app *app)
{
    const char *wanted = app->options.camera;
    if (app->options.camera_path)
        return gn_app_add_camera_path(app, app->options.camera_path, &app->camera);
    if (app->info.cameras == 0) {
        if (wanted)
            return gn_app_error(app, "%s has no cameras, and so no '%s'", app->scene_name, wanted);
        gn_app_note(app, "%s has no camera; one that shows all of it is used", app->scene_name);
        return gn_scene_add_overview(app->scene, &app->camera) == GN_OK;
    }
    app->camera = 0;
    if (!wanted)
        return true;
    app->camera = gn_scene_find_camera(app->scene, wanted);
    if (app->camera == GN_NONE)
        app->camera = as_index(wanted, app->info.cameras);
    if (app->camera != GN_NONE)
        return true;
    char names[512];
    list_names(app->scene, app->info.cameras, gn_scene_camera_name, names, sizeof names);
    return gn_app_error(app, "%s has no camera '%s'; it has: %s", app->scene_name, wanted, names);
}

static bool use_sun(gn_app *app, double azimuth, double elevation)
{
    app->light_count = 1;
    return gn_scene_add_sun(app->scene, azimuth, elevation, &app->lights[0]) == GN_OK;
}

static bool choose_lights(gn_app *app)
{
    const char *wanted = app->options.lights;
    const uint32_t count = app->info.lights;
    app->lights = malloc((count + 1) * sizeof *app->lights);
    if (!app->lights)
        return gn_app_error(app, "out of memory");
    app->light_count = 0;
    if (app->options.sun.given)
        return use_sun(app, app->options.sun.azimuth, app->options.sun.elevation);
    const bool all = wanted && strcmp(wanted, "all") == 0;
    if (count == 0) {
        if (wanted && !all)
            return gn_app_error(app, "%s has no lights, and so no '%s'", app->scene_name, wanted);
        gn_app_note(app, "%s has no light; --sun 220,45 is used", app->scene_name);
        return use_sun(app, 220, 45);
    }
    if (wanted && !all) {
        uint32_t light = gn_scene_find_light(app->scene, wanted);
        if (light == GN_NONE)
            light = as_index(wanted, count);
        if (light == GN_NONE) {
            char names[512];
            list_names(app->scene, count, gn_scene_light_name, names, sizeof names);
            return gn_app_error(app, "%s has no light '%s'; it has: %s", app->scene_name, wanted,
                                names);
        }
        app->lights[app->light_count++] = light;
        return true;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (all || gn_scene_get_light(app->scene, i).on)
            app->lights[app->light_count++] = i;
    }
    if (app->light_count == 0) {
        gn_app_note(app, "no light of %s is on; all are used", app->scene_name);
        for (; app->light_count < count; app->light_count++)
            app->lights[app->light_count] = app->light_count;
    }
    return true;
}

bool gn_app_choose(gn_app *app)
{
    if (app->options.sun.given && app->options.lights) {
        app->wrong_usage = true;
        return gn_app_error(app, "--sun and --light exclude each other");
    }
    if (app->options.camera && app->options.camera_path) {
        app->wrong_usage = true;
        return gn_app_error(app, "--camera and --camera-path exclude each other");
    }
    return choose_camera(app) && choose_lights(app) && gn_scene_commit(app->scene) == GN_OK;
}

/* Views ------------------------------------------------------------------------------------- */

gn_view_desc gn_app_view_desc(const gn_app *app, uint32_t samples)
{
    gn_view_desc desc = gn_view_desc_default();
    desc.width = app->options.size[0];
    desc.height = app->options.size[1];
    desc.samples = samples;
    return desc;
}

/* Folders and JSON -------------------------------------------------------------------------- */

bool gn_app_make_folder(gn_app *app, const char *path)
{
    struct stat status;
    if (mkdir(path, 0777) == 0)
        return true;
    const int error = errno;
    if (error == EEXIST && stat(path, &status) == 0 && S_ISDIR(status.st_mode))
        return true;
    return gn_app_error(app, "%s: cannot make the folder: %s", path,
                        error == EEXIST ? "a file of that name is there" : strerror(error));
}

cJSON *gn_app_json(const gn_app *app)
{
    cJSON *json = cJSON_CreateObject();
    char version[32];
    snprintf(version, sizeof version, "%d.%d.%d", GN_VERSION_MAJOR, GN_VERSION_MINOR,
             GN_VERSION_PATCH);
    cJSON_AddStringToObject(json, "gnomon", version);
    cJSON_AddStringToObject(json, "command", app->command);
    if (app->scene_name)
        cJSON_AddStringToObject(json, "scene", app->scene_name);
    if (app->scene && app->light_count > 0) {
        char text[32];
        cJSON_AddStringToObject(json, "camera", gn_app_camera_name(app, text));
        cJSON *lights = cJSON_AddArrayToObject(json, "lights");
        for (uint32_t i = 0; i < app->light_count; i++)
            cJSON_AddItemToArray(lights,
                                 cJSON_CreateString(gn_app_light_name(app, app->lights[i], text)));
        cJSON_AddNumberToObject(json, "width", app->options.size[0]);
        cJSON_AddNumberToObject(json, "height", app->options.size[1]);
    }
    if (app->device) {
        const gn_device_info info = gn_device_get_info(app->device);
        cJSON_AddNumberToObject(json, "threads", info.threads);
        cJSON_AddStringToObject(json, "isa", info.isa_name);
    }
    return json;
}

bool gn_app_flush(gn_app *app)
{
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout))
        return true;
    return gn_app_error(app, "standard output: cannot write: %s",
                        errno ? strerror(errno) : "the data were not taken");
}

bool gn_app_print_json(gn_app *app, cJSON *json)
{
    char *text = cJSON_Print(json);
    cJSON_Delete(json);
    if (!text)
        return gn_app_error(app, "out of memory");
    puts(text);
    cJSON_free(text);
    return gn_app_flush(app);
}
