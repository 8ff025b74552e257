/* What a rendered frame looks like on disk: shaded picture, AOVs, header. */
#ifndef GN_APP_PICTURE_H
#define GN_APP_PICTURE_H

#include "method.h"

typedef enum gn_aov {
    GN_AOV_VISIBILITY,
    GN_AOV_DEPTH,
    GN_AOV_NORMAL,
    GN_AOV_SHADING_NORMAL,
    GN_AOV_ALBEDO,
    GN_AOV_MOTION,
    GN_AOV_POSITION,
    GN_AOV_LOD,
    GN_AOV_LOOKUPS,
    GN_AOV_RAYS,
    GN_AOV_LISTS,   /* the light buffer */
    GN_AOV_CLASS,   /* leak tracing */
    GN_AOV_CASCADE, /* methods with a map, as the rest */
    GN_AOV_TEST,
    GN_AOV_MAP, /* of the map's size, as the next */
    GN_AOV_XI4,
    GN_AOV_LIGHT_BUFFER, /* of a size of its own */
    GN_AOV_COUNT
} gn_aov;

extern const char *const gn_aov_names[]; /* in the order of gn_aov, ending with NULL */

/* "visibility,depth" as a set of bits 1u << gn_aov. False after saying what is wrong. */
bool gn_aov_parse(const char *command, const char *list, uint32_t *set);
/* False after saying which of them a method does not have, and why. tracer: the options'
 * gn_tracer_kind or GN_NONE. */
bool gn_aov_check(const char *command, uint32_t set, const gn_app_method *method, uint32_t tracer);

#define GN_MAX_ATTRIBUTES 12

/* How a picture was made, for its header. */
typedef struct gn_settings {
    gn_attribute attributes[GN_MAX_ATTRIBUTES];
    uint32_t count;
    char lights[1024], camera[32], text[GN_MAX_ATTRIBUTES][32], map[160], leak[96];
} gn_settings;

void gn_settings_fill(gn_settings *settings, const gn_app *app, const char *method,
                      uint32_t samples, double time);
/* Adds what a method has set: its map, its leak tracing. */
void gn_settings_add_method(gn_settings *settings, const gn_app_method *method);
/* Adds a line of the header's own; both live as long. */
void gn_settings_add(gn_settings *settings, const char *key, const char *value);
/* Adds what answered its rays. */
void gn_settings_add_tracing(gn_settings *settings, const gn_app_tracing *tracing);

/* A rendered view, ready to be written. */
typedef struct gn_frame {
    gn_app *app;
    gn_view *view; /* with its own history */
    const gn_settings *settings;
    const float *image; /* the shaded picture: the view's, or what was made of it */
    const gn_app_method *method;
    uint32_t aovs;              /* a set of bits */
    float *facts[GN_AOV_COUNT]; /* what only visibility knows: a plane for each light; NULL unless
                                   in aovs */
    gn_app_tracing tracing;
    cJSON *lists; /* of pictures of lists: file, light, most, a sun's extent */
} gn_frame;

/* Linear RGB, 3 floats a pixel, as 8-bit sRGB. */
bool gn_write_shaded(gn_app *app, const char *path, uint32_t width, uint32_t height,
                     const float *image, const gn_settings *settings);
/* The shaded picture at path, and each AOV in a file beside it. The files' names are added to
 * files (a JSON array) where it is not NULL. path appears last: where it is, all is. */
bool gn_frame_write_png(const gn_frame *frame, const char *path, cJSON *files);
/* Everything as layers of one file, but for what has a size of its own. path appears last. */
bool gn_frame_write_exr(const gn_frame *frame, const char *path, cJSON *files);

/* The layers of a light's map, side by side in a .png, each a layer in an .exr; aov is GN_AOV_MAP
 * or GN_AOV_XI4. The file's name is added to files. */
bool gn_frame_write_map(const gn_frame *frame, gn_aov aov, uint32_t light, const char *path,
                        cJSON *files);
/* A light's view with the lengths of the lists of its light buffer: a sun's whole grid, a lamp's
 * six faces side by side in a .png, each a layer in an .exr. The file's name is added to files. */
bool gn_frame_write_light_buffer(const gn_frame *frame, uint32_t light, const char *path,
                                 cJSON *files);
/* The colour of a list's length: black 0, blue 8, red 64, yellow 512, white 4096. */
void gn_list_color(float length, uint8_t rgb[3]);
/* Adds to frame->lists what a file's pixels of GN_AOV_LISTS show. */
void gn_report_lists(const gn_frame *frame, uint32_t light, const char *file);

/* ".visibility", or ".visibility.Sun" where there are several lights. */
void gn_aov_suffix(const gn_app *app, gn_aov aov, uint32_t light, char *text, size_t size);

/* path with text before its extension: "a/b.png", ".depth" -> "a/b.depth.png". */
bool gn_insert_suffix(gn_app *app, const char *path, const char *text, char *out, size_t size);

/* value in [0,1] as black, blue, red, yellow, white. */
void gn_heat_color(float value, uint8_t rgb[3]);

#endif
