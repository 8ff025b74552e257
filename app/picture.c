#include "picture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const gn_aov_names[] = {
    "visibility",   "depth", "normal", "shading_normal", "albedo",  "motion", "position", "lod",
    "lookups",      "rays",  "lists",  "class",          "cascade", "test",   "map",      "xi4",
    "light-buffer", NULL};

bool gn_aov_parse(const char *command, const char *list, uint32_t *set)
{
    *set = 0;
    for (const char *start = list;; start++) {
        char name[32];
        const size_t length = strcspn(start, ",");
        snprintf(name, sizeof name, "%.*s", (int)(length < 31 ? length : 31), start);
        uint32_t aov = 0;
        while (aov < GN_AOV_COUNT && strcmp(name, gn_aov_names[aov]) != 0)
            aov++;
        if (aov == GN_AOV_COUNT) {
            char names[256] = "";
            for (uint32_t i = 0; i < GN_AOV_COUNT; i++) {
                strcat(names, i ? ", " : "");
                strcat(names, gn_aov_names[i]);
            }
            gn_usage_error(command, "--aov: no '%s'; there are: %s", name, names);
            return false;
        }
        *set |= 1u << aov;
        start += length;
        if (!*start)
            return true;
    }
}

bool gn_aov_check(const char *command, uint32_t set, const gn_app_method *method, uint32_t tracer)
{
    static const uint32_t of_lists = 1u << GN_AOV_LISTS | 1u << GN_AOV_LIGHT_BUFFER,
                          of_rays = 1u << GN_AOV_LOD | 1u << GN_AOV_LOOKUPS | 1u << GN_AOV_RAYS |
                                    of_lists,
                          of_maps = 1u << GN_AOV_CASCADE | 1u << GN_AOV_TEST | 1u << GN_AOV_MAP;
    const char *reason = "";
    uint32_t wrong = 0;
    if (method->own.tracer != GN_NONE)
        tracer = method->own.tracer;
    if (method->method.trace == GN_TRACE_NONE && set & of_rays) {
        wrong = set & of_rays;
        reason = "traces no rays";
    } else if (tracer == GN_TRACER_BVH && set & of_lists) {
        wrong = set & of_lists;
        reason = "is traced by the tree, which has no lists";
    } else if (!gn_app_has_map(method) && set & of_maps) {
        wrong = set & of_maps;
        reason = "has no map";
    } else if (method->method.trace != GN_TRACE_LEAK && set >> GN_AOV_CLASS & 1) {
        wrong = 1u << GN_AOV_CLASS;
        reason = "is no leak tracing; lt-*, ltt-* and hybrid-pcf are";
    } else if (method->method.map.kind != GN_MAP_NLMSM && set >> GN_AOV_XI4 & 1) {
        wrong = 1u << GN_AOV_XI4;
        reason = "does not store it; nlmsm does";
    }
    for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
        if (wrong >> aov & 1) {
            gn_usage_error(command, "--aov %s: %s %s", gn_aov_names[aov], method->name, reason);
            return false;
        }
    return true;
}

void gn_settings_add_method(gn_settings *settings, const gn_app_method *method)
{
    if (!gn_app_has_map(method))
        return;
    const gn_map_desc *map = &method->map;
    snprintf(settings->map, sizeof settings->map,
             "size=%u cascades=%u samples=%u alpha=%s filter=%u sigma=%g reading=%s%s",
             map->resolution, map->cascades, map->samples, gn_app_map_alpha_names[map->alpha],
             map->filter_width, (double)map->filter_sigma, gn_app_reading_names[map->reading],
             map->mip_maps ? " mips" : "");
    settings->attributes[settings->count++] = (gn_attribute){"map", settings->map};
    if (method->method.trace != GN_TRACE_LEAK)
        return;
    const gn_leak_desc *leak = &method->leak;
    int used = snprintf(settings->leak, sizeof settings->leak, "alpha=%s epsilon=%g",
                        gn_app_alpha_names[method->method.alpha], (double)leak->epsilon);
    if (method->method.mask)
        snprintf(settings->leak + used, sizeof settings->leak - (size_t)used,
                 " mask kernel=%s%s%s depth-test=%s", gn_app_kernel_names[leak->kernel],
                 leak->expand ? " expand" : "", leak->remove ? " remove" : "",
                 gn_app_switch_names[leak->depth_test]);
    settings->attributes[settings->count++] = (gn_attribute){"leak", settings->leak};
}

void gn_settings_add(gn_settings *settings, const char *key, const char *value)
{
    settings->attributes[settings->count++] = (gn_attribute){key, value};
}

void gn_settings_add_tracing(gn_settings *settings, const gn_app_tracing *tracing)
{
    gn_settings_add(settings, "tracer", gn_app_answered(tracing));
}

void gn_settings_fill(gn_settings *settings, const gn_app *app, const char *method,
                      uint32_t samples, double time)
{
    memset(settings, 0, sizeof *settings);
    size_t used = 0;
    for (uint32_t i = 0; i < app->light_count && used < sizeof settings->lights; i++) {
        char number[32];
        used += (size_t)snprintf(settings->lights + used, sizeof settings->lights - used, "%s%s",
                                 i ? "," : "", gn_app_light_name(app, app->lights[i], number));
    }
    const struct {
        const char *key, *value;
    } texts[] = {{"scene", app->scene_name},
                 {"camera", gn_app_camera_name(app, settings->camera)},
                 {"lights", settings->lights},
                 {"method", method}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        settings->attributes[settings->count++] = (gn_attribute){texts[i].key, texts[i].value};

    static const char *const keys[] = {"version", "size", "spp", "time"};
    char(*text)[32] = settings->text;
    snprintf(text[0], 32, "%d.%d.%d", GN_VERSION_MAJOR, GN_VERSION_MINOR, GN_VERSION_PATCH);
    snprintf(text[1], 32, "%ux%u", app->options.size[0], app->options.size[1]);
    snprintf(text[2], 32, "%u", samples);
    snprintf(text[3], 32, "%.9g", time);
    for (int i = 0; i < 4; i++)
        settings->attributes[settings->count++] = (gn_attribute){keys[i], text[i]};
}

bool gn_insert_suffix(gn_app *app, const char *path, const char *text, char *out, size_t size)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    const size_t stem = dot ? (size_t)(dot - path) : strlen(path);
    const int used = snprintf(out, size, "%.*s%s%s", (int)stem, path, text, path + stem);
    return (used >= 0 && (size_t)used < size) ||
           gn_app_error(app, "%s: the name is too long", path);
}

/* Colours ----------------------------------------------------------------------------------- */

static uint8_t to_byte(float value)
{
    return (uint8_t)((value > 0 ? (value < 1 ? value : 1) : 0) * 255.0f + 0.5f);
}

void gn_heat_color(float value, uint8_t rgb[3])
{
    static const float stops[5][3] = {
        {0, 0, 0}, {0.15f, 0.15f, 0.7f}, {0.85f, 0.15f, 0.2f}, {1, 0.8f, 0.1f}, {1, 1, 1}};
    const float at = (value > 0 ? (value < 1 ? value : 1) : 0) * 4;
    const int low = at < 3 ? (int)at : 3;
    for (int c = 0; c < 3; c++)
        rgb[c] = to_byte(stops[low][c] + (stops[low + 1][c] - stops[low][c]) * (at - (float)low));
}

/* PNG --------------------------------------------------------------------------------------- */

bool gn_write_shaded(gn_app *app, const char *path, uint32_t width, uint32_t height,
                     const float *image, const gn_settings *settings)
{
    const size_t values = (size_t)width * height * 3;
    uint8_t *pixels = malloc(values);
    if (!pixels)
        return gn_app_error(app, "%s: out of memory", path);
    gn_encode_srgb(image, pixels, values);
    const bool good = gn_write_png(app->device, path, width, height, 3, pixels,
                                   settings->attributes, settings->count) == GN_OK;
    free(pixels);
    return good;
}

/* Coarsest level and most lookups that the colours tell apart. */
#define LOD_RANGE     8.0f
#define LOOKUPS_RANGE 16.0f
#define MOTION_RANGE  32.0f /* pixels to either side of grey */

/* A colour a layer, darker in shadow; black where none was read. */
static void paint_cascade(float layer, float visibility, uint8_t rgb[3])
{
    static const float colors[GN_MAX_CASCADES][3] = {
        {0.90f, 0.30f, 0.25f}, {0.35f, 0.75f, 0.35f}, {0.30f, 0.50f, 0.95f}, {0.95f, 0.80f, 0.25f},
        {0.70f, 0.40f, 0.85f}, {0.25f, 0.80f, 0.80f}, {0.95f, 0.55f, 0.20f}, {0.75f, 0.75f, 0.75f}};
    for (int c = 0; c < 3; c++)
        rgb[c] = layer < 0 ? 0
                           : to_byte(colors[(uint32_t)layer % GN_MAX_CASCADES][c] *
                                     (0.4f + 0.6f * visibility));
}

/* The colours of Table 1 of the leak tracing paper; what faces no light is black there. */
static void paint_class(float leak_class, uint8_t rgb[3])
{
    static const uint8_t colors[8][3] = {[GN_LEAK_RED] = {230, 40, 40},
                                         [GN_LEAK_GREEN] = {40, 160, 60},
                                         [GN_LEAK_YELLOW] = {245, 215, 40},
                                         [GN_LEAK_PURPLE] = {160, 60, 200},
                                         [GN_LEAK_WHITE] = {255, 255, 255}};
    memcpy(rgb, colors[(uint32_t)leak_class & 7], 3);
}

static bool is_grey(gn_aov aov)
{
    return aov == GN_AOV_VISIBILITY || aov == GN_AOV_DEPTH || aov == GN_AOV_TEST ||
           aov == GN_AOV_RAYS;
}

/* One AOV in a form made for looking; 3 bytes a pixel, or 1 where it is grey. */
static void paint(const gn_frame *frame, gn_aov aov, uint32_t light, uint8_t *out)
{
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    const size_t pixels = (size_t)g->width * g->height;
    const float *visibility = gn_view_visibility(frame->view, light);
    const float *fact = frame->facts[aov] ? frame->facts[aov] + light * pixels : NULL;
    const gn_scene_info info = gn_scene_get_info(frame->app->scene);
    float nearest = INFINITY;
    for (size_t i = 0; i < pixels && aov == GN_AOV_DEPTH; i++) {
        if (g->surface[i] != GN_NONE && g->depth[i] > 0 && g->depth[i] < nearest)
            nearest = g->depth[i];
    }
    for (size_t i = 0; i < pixels; i++) {
        uint8_t *rgb = out + 3 * i;
        const bool sky = g->surface[i] == GN_NONE;
        switch (aov) {
        case GN_AOV_VISIBILITY:
            out[i] = to_byte(visibility[i]);
            break;
        case GN_AOV_DEPTH:
            out[i] = sky || !(g->depth[i] > 0) ? 0 : to_byte(nearest / g->depth[i]);
            break;
        case GN_AOV_NORMAL:
        case GN_AOV_SHADING_NORMAL: {
            float *const *n = aov == GN_AOV_NORMAL ? g->normal : g->shading_normal;
            for (int c = 0; c < 3; c++)
                rgb[c] = sky ? 0 : to_byte(0.5f + 0.5f * n[c][i]);
            break;
        }
        case GN_AOV_ALBEDO:
            for (int c = 0; c < 3; c++)
                rgb[c] = sky ? 0 : (uint8_t)(g->albedo[i] >> (8 * c));
            break;
        case GN_AOV_MOTION:
            for (int c = 0; c < 2; c++)
                rgb[c] = to_byte(0.5f + 0.5f * g->motion[c][i] / MOTION_RANGE);
            rgb[2] = 128;
            break;
        case GN_AOV_POSITION:
            for (int c = 0; c < 3; c++) {
                const float extent = info.bounds_max[c] - info.bounds_min[c];
                rgb[c] = sky || !(extent > 0)
                             ? 0
                             : to_byte((g->position[c][i] - info.bounds_min[c]) / extent);
            }
            break;
        case GN_AOV_LOD:
            gn_heat_color(fact[i] / LOD_RANGE, rgb);
            break;
        case GN_AOV_LOOKUPS:
            gn_heat_color(fact[i] / LOOKUPS_RANGE, rgb);
            break;
        case GN_AOV_LISTS:
            gn_list_color(fact[i], rgb);
            break;
        case GN_AOV_CLASS:
            paint_class(fact[i], rgb);
            break;
        case GN_AOV_CASCADE:
            paint_cascade(fact[i], visibility[i], rgb);
            break;
        case GN_AOV_TEST:
        case GN_AOV_RAYS:
            out[i] = to_byte(fact[i]);
            break;
        case GN_AOV_MAP:
        case GN_AOV_XI4:
        case GN_AOV_LIGHT_BUFFER:
        case GN_AOV_COUNT:
            break;
        }
    }
}

static bool depends_on_light(gn_aov aov)
{
    return aov == GN_AOV_VISIBILITY || aov >= GN_AOV_LOD;
}

static bool has_own_size(gn_aov aov)
{
    return aov == GN_AOV_MAP || aov == GN_AOV_XI4 || aov == GN_AOV_LIGHT_BUFFER;
}

static bool write_own_size(const gn_frame *frame, gn_aov aov, uint32_t light, const char *path,
                           cJSON *files)
{
    return aov == GN_AOV_LIGHT_BUFFER ? gn_frame_write_light_buffer(frame, light, path, files)
                                      : gn_frame_write_map(frame, aov, light, path, files);
}

void gn_aov_suffix(const gn_app *app, gn_aov aov, uint32_t light, char *text, size_t size)
{
    if (!depends_on_light(aov) || app->light_count == 1) {
        snprintf(text, size, ".%s", gn_aov_names[aov]);
        return;
    }
    char number[32];
    int prefix = snprintf(text, size, ".%s.", gn_aov_names[aov]);
    snprintf(text + prefix, size - (size_t)prefix, "%s",
             gn_app_light_name(app, app->lights[light], number));
    /* A light's name may hold anything; a file's may not. */
    for (char *c = text + prefix; *c; c++) {
        if (*c == '/' || (unsigned char)*c < 0x20)
            *c = '_';
    }
}

static bool add_file(cJSON *files, const char *path)
{
    if (files)
        cJSON_AddItemToArray(files, cJSON_CreateString(path));
    return true;
}

static bool write_aov(const gn_frame *frame, gn_aov aov, uint32_t light, const char *path,
                      uint8_t *pixels, cJSON *files)
{
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    char suffix[320], name[4096];
    gn_aov_suffix(frame->app, aov, light, suffix, sizeof suffix);
    if (!gn_insert_suffix(frame->app, path, suffix, name, sizeof name))
        return false;
    paint(frame, aov, light, pixels);
    if (aov == GN_AOV_LISTS)
        gn_report_lists(frame, light, name);
    const uint32_t channels = is_grey(aov) ? 1 : 3;
    return gn_write_png(frame->app->device, name, g->width, g->height, channels, pixels,
                        frame->settings->attributes, frame->settings->count) == GN_OK &&
           add_file(files, name);
}

bool gn_frame_write_png(const gn_frame *frame, const char *path, cJSON *files)
{
    gn_app *app = frame->app;
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    uint8_t *pixels = malloc((size_t)g->width * g->height * 3);
    bool good = (pixels || gn_app_error(app, "%s: out of memory", path)) && add_file(files, path);
    for (uint32_t aov = 0; aov < GN_AOV_COUNT && good; aov++) {
        const uint32_t count = depends_on_light((gn_aov)aov) ? app->light_count : 1;
        for (uint32_t light = 0; light < count && good && frame->aovs >> aov & 1; light++)
            good = has_own_size((gn_aov)aov)
                       ? write_own_size(frame, (gn_aov)aov, light, path, files)
                       : write_aov(frame, (gn_aov)aov, light, path, pixels, files);
    }
    free(pixels);
    return good && gn_write_shaded(app, path, g->width, g->height, frame->image, frame->settings);
}

/* OpenEXR ----------------------------------------------------------------------------------- */

typedef struct layer_list {
    gn_layer *layers;
    char (*names)[48];
    uint32_t count;
} layer_list;

static gn_layer *add_layer(layer_list *list, const char *channels, int full_precision)
{
    gn_layer *layer = &list->layers[list->count];
    layer->name = list->names[list->count++];
    layer->channels = channels;
    layer->stride = 1;
    layer->full_precision = full_precision;
    return layer;
}

static void add_planes(layer_list *list, const char *name, const char *channels,
                       float *const planes[3], int full_precision)
{
    gn_layer *layer = add_layer(list, channels, full_precision);
    snprintf(list->names[list->count - 1], sizeof *list->names, "%s", name);
    for (int c = 0; channels[c]; c++)
        layer->planes[c] = planes[c];
}

static void add_light_plane(layer_list *list, uint32_t light, const char *name, const float *plane)
{
    gn_layer *layer = add_layer(list, "Y", 0);
    snprintf(list->names[list->count - 1], sizeof *list->names, "light%u.%s", light, name);
    layer->planes[0] = plane;
}

/* albedo: 3 linear values a pixel, or NULL. */
static void collect_layers(const gn_frame *frame, const float *albedo, layer_list *list)
{
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    const size_t pixels = (size_t)g->width * g->height;
    const float *image = frame->image;
    const uint32_t aovs = frame->aovs;
    gn_layer *shaded = add_layer(list, "RGB", 0);
    shaded->stride = 3;
    for (int c = 0; c < 3; c++)
        shaded->planes[c] = image + c;
    for (uint32_t l = 0; l < frame->app->light_count; l++) {
        if (aovs >> GN_AOV_VISIBILITY & 1)
            add_light_plane(list, l, "visibility", gn_view_visibility(frame->view, l));
        for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
            if (frame->facts[aov])
                add_light_plane(list, l, gn_aov_names[aov], frame->facts[aov] + l * pixels);
    }
    if (aovs >> GN_AOV_DEPTH & 1)
        add_planes(list, "depth", "Z", (float *[3]){g->depth}, 1);
    if (aovs >> GN_AOV_NORMAL & 1)
        add_planes(list, "normal", "XYZ", g->normal, 0);
    if (aovs >> GN_AOV_SHADING_NORMAL & 1)
        add_planes(list, "shading_normal", "XYZ", g->shading_normal, 0);
    if (aovs >> GN_AOV_MOTION & 1)
        add_planes(list, "motion", "XYZ", g->motion, 1);
    if (aovs >> GN_AOV_POSITION & 1)
        add_planes(list, "position", "XYZ", g->position, 1);
    if (albedo) {
        gn_layer *layer = add_layer(list, "RGB", 0);
        snprintf(list->names[list->count - 1], sizeof *list->names, "albedo");
        layer->stride = 3;
        for (int c = 0; c < 3; c++)
            layer->planes[c] = albedo + c;
    }
}

static float *linear_albedo(const gn_gbuffer *g)
{
    float table[256];
    for (int i = 0; i < 256; i++) {
        const float s = (float)i / 255.0f;
        table[i] = s <= 0.04045f ? s / 12.92f : powf((s + 0.055f) / 1.055f, 2.4f);
    }
    const size_t pixels = (size_t)g->width * g->height;
    float *albedo = malloc(pixels * 3 * sizeof *albedo);
    for (size_t i = 0; albedo && i < pixels; i++) {
        for (int c = 0; c < 3; c++)
            albedo[3 * i + (size_t)c] = table[g->albedo[i] >> (8 * c) & 255];
    }
    return albedo;
}

bool gn_frame_write_exr(const gn_frame *frame, const char *path, cJSON *files)
{
    gn_app *app = frame->app;
    const gn_gbuffer *g = gn_view_gbuffer(frame->view);
    const bool wants_albedo = frame->aovs >> GN_AOV_ALBEDO & 1;
    const size_t most = GN_AOV_COUNT * ((size_t)app->light_count + 1) + 1;
    layer_list list = {calloc(most, sizeof(gn_layer)), calloc(most, 48), 0};
    float *albedo = wants_albedo ? linear_albedo(g) : NULL;
    bool good = ((list.layers && list.names && (albedo || !wants_albedo)) ||
                 gn_app_error(app, "%s: out of memory", path)) &&
                add_file(files, path);
    for (uint32_t l = 0; l < app->light_count && good && frame->facts[GN_AOV_LISTS]; l++)
        gn_report_lists(frame, l, path);
    for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
        for (uint32_t l = 0; l < app->light_count && good && frame->aovs >> aov & 1; l++)
            good = !has_own_size((gn_aov)aov) || write_own_size(frame, (gn_aov)aov, l, path, files);
    if (good) {
        collect_layers(frame, albedo, &list);
        good = gn_write_exr(app->device, path, g->width, g->height, list.layers, list.count,
                            frame->settings->attributes, frame->settings->count) == GN_OK;
    }
    free(list.layers);
    free(list.names);
    free(albedo);
    return good;
}
