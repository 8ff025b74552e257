/* Light buffers as pictures: how many triangles the lists hold. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "picture.h"

enum { SUN_SIZE = 1024, FACE_SIZE = 512, FACES = 6 }; /* pixels a side */

/* Where there is no list. */
static const uint8_t background[3] = {96, 96, 96};

void gn_list_color(float length, uint8_t rgb[3])
{
    gn_heat_color(log2f(1 + length) / 12, rgb);
}

/* extent: metres, or 0 where that means nothing. */
static void report(const gn_frame *frame, uint32_t light, const char *file, const float *lengths,
                   size_t count, float extent)
{
    float most = 0;
    for (size_t i = 0; i < count; i++)
        most = fmaxf(most, lengths[i]);
    char number[32];
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "file", file);
    cJSON_AddStringToObject(json, "light",
                            gn_app_light_name(frame->app, frame->app->lights[light], number));
    cJSON_AddNumberToObject(json, "most", (double)most);
    if (extent > 0)
        cJSON_AddNumberToObject(json, "extent", (double)extent);
    cJSON_AddItemToArray(frame->lists, json);
}

void gn_report_lists(const gn_frame *frame, uint32_t light, const char *file)
{
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    const size_t pixels = (size_t)g->width * g->height;
    report(frame, light, file, frame->facts[GN_AOV_LISTS] + light * pixels, pixels, 0);
}

typedef struct sheet {
    uint32_t size, faces;
    float extent;   /* metres, of a sun; else 0 */
    float *lengths; /* faces * size^2 */
} sheet;

static bool draw_sheet(const gn_frame *frame, uint32_t light, const char *name, sheet *s)
{
    gn_app *app = frame->app;
    const uint32_t index = app->lights[light];
    const bool sun = gn_scene_get_light(app->scene, index).type == GN_LIGHT_DIRECTIONAL;
    s->faces = sun ? 1 : FACES;
    s->size = sun ? SUN_SIZE : FACE_SIZE;
    const size_t pixels = (size_t)s->size * s->size;
    s->lengths = malloc(s->faces * pixels * sizeof *s->lengths);
    if (!s->lengths)
        return gn_app_error(app, "%s: out of memory", name);
    for (uint32_t face = 0; face < s->faces; face++) {
        const gn_result result =
            gn_history_draw_light_buffer(gn_view_history(frame->view), index, face, s->size,
                                         s->lengths + face * pixels, &s->extent);
        if (result == GN_ERROR_INVALID_ARGUMENT)
            return gn_app_error(app,
                                "%s: the light has no light buffer, the tree traces its rays; see "
                                "--tracer light-buffer",
                                name);
        if (result != GN_OK)
            return false;
    }
    s->extent = sun ? s->extent : 0;
    return true;
}

static bool write_png(const gn_frame *frame, const sheet *s, const char *name)
{
    uint8_t *picture = malloc((size_t)s->size * s->size * s->faces * 3), *rgb = picture;
    if (!picture)
        return gn_app_error(frame->app, "%s: out of memory", name);
    for (uint32_t y = 0; y < s->size; y++)
        for (uint32_t face = 0; face < s->faces; face++)
            for (uint32_t x = 0; x < s->size; x++, rgb += 3) {
                const float length = s->lengths[((size_t)face * s->size + y) * s->size + x];
                if (length < 0)
                    memcpy(rgb, background, 3);
                else
                    gn_list_color(length, rgb);
            }
    const bool good =
        gn_write_png(frame->app->device, name, s->size * s->faces, s->size, 3, picture,
                     frame->settings->attributes, frame->settings->count) == GN_OK;
    free(picture);
    return good;
}

static bool write_exr(const gn_frame *frame, const sheet *s, const char *name)
{
    gn_layer layers[FACES];
    char names[FACES][24];
    for (uint32_t face = 0; face < s->faces; face++) {
        snprintf(names[face], sizeof names[face], "%s.%u", gn_aov_names[GN_AOV_LIGHT_BUFFER], face);
        layers[face] = (gn_layer){.name = names[face],
                                  .channels = "Y",
                                  .planes = {s->lengths + (size_t)face * s->size * s->size},
                                  .stride = 1,
                                  .full_precision = 1};
    }
    return gn_write_exr(frame->app->device, name, s->size, s->size, layers, s->faces,
                        frame->settings->attributes, frame->settings->count) == GN_OK;
}

bool gn_frame_write_light_buffer(const gn_frame *frame, uint32_t light, const char *path,
                                 cJSON *files)
{
    char suffix[320], name[4096];
    gn_aov_suffix(frame->app, GN_AOV_LIGHT_BUFFER, light, suffix, sizeof suffix);
    if (!gn_insert_suffix(frame->app, path, suffix, name, sizeof name))
        return false;
    const size_t length = strlen(path);
    const bool exr = length > 4 && strcmp(path + length - 4, ".exr") == 0;
    sheet s = {0};
    const bool good = draw_sheet(frame, light, name, &s) &&
                      (exr ? write_exr(frame, &s, name) : write_png(frame, &s, name));
    if (good) {
        report(frame, light, name, s.lengths, (size_t)s.faces * s.size * s.size, s.extent);
        cJSON_AddItemToArray(files, cJSON_CreateString(name));
    }
    free(s.lengths);
    return good;
}
