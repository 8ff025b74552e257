/* What a rendered frame looks like on disk: shaded picture, AOVs, header. */
#ifndef GN_APP_PICTURE_H
#define GN_APP_PICTURE_H

#include "app.h"

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
    GN_AOV_COUNT
} gn_aov;

extern const char *const gn_aov_names[]; /* in the order of gn_aov, ending with NULL */

/* "visibility,depth" as a set of bits 1u << gn_aov. False after saying what is wrong. */
bool gn_aov_parse(const char *command, const char *list, uint32_t *set);

#define GN_MAX_ATTRIBUTES 12

/* How a picture was made, for its header. */
typedef struct gn_settings {
    gn_attribute attributes[GN_MAX_ATTRIBUTES];
    uint32_t count;
    char lights[1024], camera[32], text[GN_MAX_ATTRIBUTES][32];
} gn_settings;

void gn_settings_fill(gn_settings *settings, const gn_app *app, const char *method,
                      uint32_t samples, double time);

/* A rendered view, ready to be written. */
typedef struct gn_frame {
    gn_app *app;
    const gn_view *view;
    const gn_settings *settings;
    uint32_t aovs;        /* a set of bits */
    float *lod, *lookups; /* a plane for each light; NULL unless in aovs */
} gn_frame;

/* Linear RGB, 3 floats a pixel, as 8-bit sRGB. */
bool gn_write_shaded(gn_app *app, const char *path, uint32_t width, uint32_t height,
                     const float *image, const gn_settings *settings);
/* The shaded picture at path, and each AOV in a file beside it. The files' names are added to
 * files (a JSON array) where it is not NULL. */
bool gn_frame_write_png(const gn_frame *frame, const char *path, cJSON *files);
/* Everything as layers of one file. */
bool gn_frame_write_exr(const gn_frame *frame, const char *path, cJSON *files);

/* path with text before its extension: "a/b.png", ".depth" -> "a/b.depth.png". */
bool gn_insert_suffix(gn_app *app, const char *path, const char *text, char *out, size_t size);

/* value in [0,1] as black, blue, red, yellow, white. */
void gn_heat_color(float value, uint8_t rgb[3]);

#endif
