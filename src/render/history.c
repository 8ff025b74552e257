#include "render/history.h"

#include <string.h>

#include "scene/scene.h"

/* One light's share. */
typedef struct entry {
    uint32_t light;
    gn_map_format format;
    gn_map_desc desc;
    gn_shadow_map *map;
} entry;

struct gn_history {
    gn_device *device;
    uint64_t scene; /* its number; 0: none yet */
    entry *entries;
    uint32_t count, capacity;
};

gn_result gn_history_create(gn_device *device, gn_history **history)
{
    gn_context *context = gn_device_context(device);
    *history = gn_alloc_zero(context, 1, sizeof **history);
    if (!*history)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a history");
    (*history)->device = device;
    return GN_OK;
}

void gn_history_reset(gn_history *history)
{
    for (uint32_t i = 0; i < history->count; i++)
        gn_shadow_map_destroy(&history->entries[i].map);
    history->count = 0;
    history->scene = 0;
}

void gn_history_reset_maps(gn_history *history)
{
    for (uint32_t i = 0; i < history->count; i++)
        if (history->entries[i].map)
            gn_shadow_map_reset(history->entries[i].map);
}

void gn_history_destroy(gn_history **history)
{
    if (!history || !*history)
        return;
    gn_history *h = *history;
    *history = NULL;
    gn_context *context = gn_device_context(h->device);
    gn_history_reset(h);
    gn_free(context, h->entries);
    gn_free(context, h);
}

static entry *find(const gn_history *history, uint32_t light)
{
    for (uint32_t i = 0; i < history->count; i++)
        if (history->entries[i].light == light)
            return &history->entries[i];
    return NULL;
}

const gn_shadow_map *gn_history_map(const gn_history *history, uint32_t light)
{
    const entry *e = find(history, light);
    return e ? e->map : NULL;
}

/* Field by field: padding may differ. */
static bool same_format(const gn_map_format *a, const gn_map_format *b)
{
    return a->kind == b->kind && a->bits == b->bits && a->single_depth == b->single_depth &&
           a->one_sided == b->one_sided && a->positive_exponent == b->positive_exponent &&
           a->negative_exponent == b->negative_exponent && a->pcf_width == b->pcf_width &&
           a->bound == b->bound;
}

static bool same_settings(const gn_map_desc *a, const gn_map_desc *b)
{
    return a->resolution == b->resolution && a->samples == b->samples && a->alpha == b->alpha &&
           a->cascades == b->cascades && a->distance == b->distance &&
           a->split_weight == b->split_weight && a->split_count == b->split_count &&
           memcmp(a->splits, b->splits, sizeof a->splits) == 0 && a->undrawn == b->undrawn &&
           a->enlarge == b->enlarge && a->filter_width == b->filter_width &&
           a->filter_sigma == b->filter_sigma && a->mip_maps == b->mip_maps &&
           a->reading == b->reading && a->depth_bias == b->depth_bias &&
           a->normal_bias == b->normal_bias && a->minimum_variance == b->minimum_variance &&
           a->moment_bias == b->moment_bias && a->refresh == b->refresh && a->seed == b->seed;
}

gn_result gn_history_reserve_map(gn_history *history, const gn_scene *scene, uint32_t light,
                                 const gn_map_format *format, const gn_map_desc *desc,
                                 gn_shadow_map **map)
{
    gn_context *context = gn_device_context(history->device);
    *map = NULL;
    if (scene->device != history->device)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "the history was made by another device than the scene");
    if (history->scene != scene->number)
        gn_history_reset(history);
    history->scene = scene->number;
    entry *e = find(history, light);
    if (e && (!same_format(&e->format, format) || !same_settings(&e->desc, desc)))
        gn_shadow_map_destroy(&e->map);
    if (!e) {
        if (!gn_grow(context, (void **)&history->entries, history->count, &history->capacity,
                     sizeof *history->entries))
            return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a shadow map");
        e = &history->entries[history->count++];
        *e = (entry){.light = light};
    }
    if (!e->map)
        GN_TRY(gn_shadow_map_create(history->device, format, desc, &e->map));
    e->format = *format;
    e->desc = *desc;
    *map = e->map;
    return GN_OK;
}
