/* gnomon mips: what an alpha test makes of a texture's mips (ray cone paper, section 2.3 and its
 * Figure 3). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "scene/scene.h"

enum { MOST_LEVELS = 7, CELL = 160, GAP = 4, ROWS = 3 };

/* What is behind holes. */
static const float background[3] = {235, 232, 224};

typedef struct mip_sheet {
    const gn_material *material;
    const gn_texture *texture;
    uint32_t levels, width, height; /* pixels of the whole */
    uint8_t *rgb;
} mip_sheet;

static bool choose_material(gn_app *app, const char *name, mip_sheet *s)
{
    const gn_scene *scene = app->scene;
    for (uint32_t i = 0; i < scene->material_count && !s->material; i++) {
        const gn_material *m = &scene->materials[i];
        const bool named = name && m->name && strcmp(m->name, name) == 0;
        if (m->desc.texture == GN_NONE || m->alpha.levels == 0 ||
            m->desc.alpha_mode != GN_ALPHA_MASK) {
            if (named)
                return gn_app_error(app, "%s has no mask with a texture", name);
            continue;
        }
        if (!name || named) {
            s->material = m;
            s->texture = &scene->textures[m->desc.texture];
        }
    }
    if (!s->material && name)
        return gn_app_error(app, "%s has no material '%s'", app->scene_name, name);
    return s->material || gn_app_error(app, "%s has no alpha-tested texture", app->scene_name);
}

/* Share of the texels of a level that pass. */
static double passing(const mip_sheet *s, const uint8_t *alpha, uint32_t level)
{
    const gn_alpha_map *map = &s->material->alpha;
    const size_t texels =
        (size_t)gn_level_size(map->width, level) * gn_level_size(map->height, level);
    const uint32_t threshold = gn_alpha_threshold(s->material->desc.alpha_cutoff);
    size_t count = 0;
    for (size_t i = 0; i < texels; i++)
        count += alpha[i] >= threshold;
    return (double)count / (double)texels;
}

/* A level as large as all others: colour over the background. */
static void paint(mip_sheet *s, uint32_t level, uint32_t row)
{
    const gn_alpha_map *map = &s->material->alpha;
    const uint8_t *alpha = row == 2 ? map->rescaled[level] : map->averaged[level];
    const uint32_t width = gn_level_size(map->width, level),
                   height = gn_level_size(map->height, level),
                   threshold = gn_alpha_threshold(s->material->desc.alpha_cutoff);
    for (uint32_t y = 0; y < CELL; y++)
        for (uint32_t x = 0; x < CELL; x++) {
            const size_t texel = (size_t)(y * height / CELL) * width + x * width / CELL;
            const uint8_t *color = s->texture->rgba[level] + 4 * texel;
            const float share = row == 0                    ? (float)alpha[texel] / 255.0f
                                : alpha[texel] >= threshold ? 1.0f
                                                            : 0.0f;
            uint8_t *rgb = s->rgb + 3 * ((size_t)(row * (CELL + GAP) + y) * s->width +
                                         level * (CELL + GAP) + x);
            for (int c = 0; c < 3; c++)
                rgb[c] =
                    (uint8_t)(background[c] + ((float)color[c] - background[c]) * share + 0.5f);
        }
}

static bool write_sheet(gn_app *app, mip_sheet *s, const char *output)
{
    const uint32_t available = s->material->alpha.levels < s->texture->levels
                                   ? s->material->alpha.levels
                                   : s->texture->levels;
    s->levels = available < MOST_LEVELS ? available : MOST_LEVELS;
    s->width = s->levels * (CELL + GAP) - GAP;
    s->height = ROWS * (CELL + GAP) - GAP;
    if (!output)
        return true;
    s->rgb = malloc((size_t)s->width * s->height * 3);
    if (!s->rgb)
        return gn_app_error(app, "out of memory");
    memset(s->rgb, 255, (size_t)s->width * s->height * 3);
    for (uint32_t level = 0; level < s->levels; level++)
        for (uint32_t row = 0; row < ROWS; row++)
            paint(s, level, row);
    const gn_attribute attributes[] = {{"scene", app->scene_name}, {"material", s->material->name}};
    const bool good =
        gn_write_png(app->device, output, s->width, s->height, 3, s->rgb, attributes, 2) == GN_OK;
    free(s->rgb);
    return good;
}

static bool print_results(gn_app *app, const mip_sheet *s, const char *output)
{
    cJSON *json = gn_app_json(app);
    cJSON_AddStringToObject(json, "material", s->material->name);
    cJSON_AddNumberToObject(json, "cutoff", (double)s->material->desc.alpha_cutoff);
    if (output)
        cJSON_AddStringToObject(json, "file", output);
    cJSON *levels = cJSON_AddArrayToObject(json, "levels");
    if (!app->options.json)
        printf("%s\n%8s%14s%16s%16s\n", s->material->name, "level", "texels", "averaged, %",
               "rescaled, %");
    for (uint32_t l = 0; l < s->levels; l++) {
        const gn_alpha_map *map = &s->material->alpha;
        const uint32_t width = gn_level_size(map->width, l), height = gn_level_size(map->height, l);
        const double averaged = passing(s, map->averaged[l], l),
                     rescaled = passing(s, map->rescaled[l], l);
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(levels, item);
        cJSON_AddNumberToObject(item, "width", width);
        cJSON_AddNumberToObject(item, "height", height);
        cJSON_AddNumberToObject(item, "averaged", averaged);
        cJSON_AddNumberToObject(item, "rescaled", rescaled);
        if (!app->options.json)
            printf("%8u%7u x%5u%16.2f%16.2f\n", l, width, height, averaged * 100, rescaled * 100);
    }
    if (app->options.json)
        return gn_app_print_json(app, json);
    cJSON_Delete(json);
    return gn_app_flush(app);
}

int gn_app_mips(int argc, char **argv)
{
    static const char *const words[] = {"SCENE", NULL};
    static const char *const notes[] = {
        "The picture has a column for each mip, from the largest on, all as wide. Top: blended "
        "with",
        "alpha; middle: alpha tested, alpha averaged; below: alpha tested, alpha scaled so that "
        "the",
        "share of texels that pass is that of the largest mip. The table has these shares.", NULL};
    const gn_usage usage = {
        "mips",
        "what an alpha test makes of a texture's mips",
        "SCENE [-o OUT.png] [options]",
        words,
        notes,
        {"gnomon mips grove -o mips.png", "gnomon mips scene.glb --material Leaves --json"}};
    gn_app_options common = gn_app_options_default();
    const char *output = NULL, *material = NULL, *name;
    const gn_option options[] = {
        GN_TEXT("output", 'o', "OUT.png", &output, "the picture to write"),
        GN_TEXT("material", 0, "NAME", &material, "its texture; default: the first with a mask"),
        GN_APP_SCENE_OPTIONS(common),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END,
    };
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    if (code != GN_GO_ON)
        return code;
    gn_app app = {0};
    mip_sheet s = {0};
    const bool good = gn_app_open(&app, "mips", &common) && gn_app_load(&app, name) &&
                      choose_material(&app, material, &s) && write_sheet(&app, &s, output) &&
                      !gn_app_interrupted();
    gn_bar_clear(&app.bar);
    code = good && print_results(&app, &s, output) ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_close(&app);
    return code;
}
