#include "render/map_refresh.h"

#include <math.h>

#include "render/device.h"

/* Rectangles ---------------------------------------------------------------------------------- */

static bool is_empty(gn_rect r)
{
    return r.x0 >= r.x1 || r.y0 >= r.y1;
}

static gn_rect unite(gn_rect a, gn_rect b)
{
    if (is_empty(a))
        return b;
    if (is_empty(b))
        return a;
    return (gn_rect){a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0,
                     a.x1 > b.x1 ? a.x1 : b.x1, a.y1 > b.y1 ? a.y1 : b.y1};
}

/* By what the filter reaches. */
static gn_rect widen(const gn_shadow_map *map, gn_rect r)
{
    const uint32_t resolution = map->desc.resolution;
    const uint32_t by = gn_map_has_texels(&map->format) ? map->desc.filter_width / 2 : 0;
    if (is_empty(r))
        return r;
    return (gn_rect){r.x0 > by ? r.x0 - by : 0, r.y0 > by ? r.y0 - by : 0,
                     r.x1 + by < resolution ? r.x1 + by : resolution,
                     r.y1 + by < resolution ? r.y1 + by : resolution};
}

/* Memory -------------------------------------------------------------------------------------- */

static gn_result reserve(const gn_shadow_map *map, void **memory, size_t count, size_t size)
{
    gn_context *context = gn_device_context(map->device);
    if (!*memory)
        *memory = gn_alloc(context, count, size);
    if (*memory)
        return GN_OK;
    return gn_fail(context, GN_ERROR_OUT_OF_MEMORY,
                   "out of memory for a shadow map of %u x %u texels", map->desc.resolution,
                   map->desc.resolution);
}

static size_t depths_of(const gn_shadow_map *map)
{
    return (size_t)map->desc.resolution * map->desc.resolution * map->desc.samples;
}

static size_t words_of(const gn_shadow_map *map)
{
    return gn_map_chain_texels(map->desc.resolution, map->desc.mip_maps) *
           gn_map_words(&map->format);
}

size_t gn_map_slot_bytes(const gn_shadow_map *map, const gn_map_slot *slot)
{
    const size_t depths = depths_of(map) * sizeof(float), texels = words_of(map) * sizeof(uint32_t);
    return (slot->layer.depth[GN_CASTERS_STATIC] ? depths : 0) + (slot->dynamic ? depths : 0) +
           (slot->back_depth ? depths : 0) + (slot->layer.texels ? texels : 0) +
           (slot->back_texels ? texels : 0);
}

void gn_map_slot_free(const gn_shadow_map *map, gn_map_slot *slot)
{
    gn_context *context = gn_device_context(map->device);
    gn_free(context, slot->layer.depth[GN_CASTERS_STATIC]);
    gn_free(context, slot->layer.texels);
    gn_free(context, slot->dynamic);
    gn_free(context, slot->back_depth);
    gn_free(context, slot->back_texels);
}

/* In the making ------------------------------------------------------------------------------- */

/* Of desc.refresh parts the last are rows to filter, where there are texels: filtering costs a
 * tenth (groves) to half (walls) of drawing. A single part is both. */
static uint32_t filter_parts(const gn_shadow_map *map)
{
    return gn_map_has_texels(&map->format) ? (map->desc.refresh + 3) / 4 : 0;
}

static void swap_buffers(gn_map_slot *slot)
{
    float *depth = slot->layer.depth[GN_CASTERS_STATIC];
    uint32_t *texels = slot->layer.texels;
    slot->layer.depth[GN_CASTERS_STATIC] = slot->back_depth;
    slot->layer.texels = slot->back_texels;
    slot->back_depth = depth;
    slot->back_texels = texels;
}

void gn_map_slot_begin(const gn_shadow_map *map, gn_map_slot *slot, const gn_cascade *place)
{
    if (map->desc.refresh == 1)
        slot->used = false;
    /* No second buffer where the first one is free. */
    if (!slot->used && !slot->back_depth)
        swap_buffers(slot);
    slot->back = *place;
    slot->begun = true;
    slot->parts = 0;
}

static gn_result draw(const gn_shadow_map *map, const gn_scene *scene,
                      const gn_map_projection *projection, gn_casters casters, uint32_t part,
                      uint32_t parts, float *depth, const gn_rect *stale, gn_rect *covered)
{
    gn_depth_job job = {.scene = scene,
                        .projection = *projection,
                        .casters = casters,
                        .alpha = map->desc.alpha,
                        .samples = map->desc.samples,
                        .part = part,
                        .parts = parts,
                        .depth = depth,
                        .stale = stale};
    GN_TRY(gn_cpu_depth(&map->device->cpu, &job));
    *covered = job.covered;
    return GN_OK;
}

static gn_result filter(const gn_shadow_map *map, const float *depth, const float *dynamic,
                        gn_rect rect, uint32_t **texels)
{
    GN_TRY(reserve(map, (void **)texels, words_of(map), sizeof **texels));
    const gn_filter_job job = {.format = map->format,
                               .resolution = map->desc.resolution,
                               .samples = map->desc.samples,
                               .width = map->desc.filter_width,
                               .sigma = map->desc.filter_sigma,
                               .moment_bias = map->desc.moment_bias,
                               .depth = depth,
                               .dynamic = dynamic,
                               .rect = rect,
                               .texels = *texels};
    return gn_cpu_filter(&map->device->cpu, &job);
}

static bool is_finite(const gn_map_projection *p)
{
    return gn_all_finite(p->origin, 3) && isfinite(p->extent) && isfinite(p->far);
}

/* Rows of the last part are left to what is in use, where they meet moving casters: *dirty. */
static gn_result draw_part(const gn_shadow_map *map, const gn_scene *scene, gn_map_slot *slot,
                           gn_rect *dirty, gn_map_update *update)
{
    const uint32_t parts = map->desc.refresh, rows = filter_parts(map);
    const uint32_t slices = parts > rows ? parts - rows : 1, part = slot->parts;
    const double start = gn_milliseconds();
    if (part < slices) {
        if (!is_finite(&slot->back.projection))
            return gn_fail(gn_device_context(map->device), GN_ERROR_UNSUPPORTED,
                           "the scene is too large for a shadow map in floats");
        GN_TRY(reserve(map, (void **)&slot->back_depth, depths_of(map), sizeof(float)));
        gn_rect covered;
        GN_TRY(draw(map, scene, &slot->back.projection, GN_CASTERS_STATIC, part, slices,
                    slot->back_depth, NULL, &covered));
        update->depth_ms += gn_milliseconds() - start;
    }
    if (part + rows >= parts) {
        const uint32_t band = part + rows - parts, resolution = map->desc.resolution;
        const gn_rect rect = {0, resolution * band / rows, resolution,
                              resolution * (band + 1) / rows};
        if (part + 1 == parts) {
            *dirty = rect;
        } else {
            GN_TRY(filter(map, slot->back_depth, NULL, rect, &slot->back_texels));
            update->filter_ms += gn_milliseconds() - start;
            update->filtered++;
        }
    }
    slot->parts++;
    return GN_OK;
}

/* What is whole takes the place of the old one. */
static void put_in_use(gn_map_slot *slot)
{
    swap_buffers(slot);
    slot->place = slot->back;
    slot->layer.projection = slot->back.projection;
    slot->begun = false;
    slot->parts = 0;
    slot->used = true;
    slot->moving = (gn_rect){0, 0, 0, 0};
    slot->still = true;
}

/* In use -------------------------------------------------------------------------------------- */

/* May a moving node cast into a layer? */
static bool is_cast_into(const gn_scene *scene, const gn_map_projection *projection)
{
    for (uint32_t n = 0; n < scene->node_count; n++) {
        const gn_node *node = &scene->nodes[n];
        if (!node->animated || node->desc.mesh == GN_NONE)
            continue;
        const gn_mesh *mesh = &scene->meshes[node->desc.mesh];
        gn_bounds box;
        for (int axis = 0; axis < 3; axis++) {
            box.low[axis] = box.high[axis] = (double)node->world[12 + axis];
            for (int k = 0; k < 3; k++) {
                const double m = (double)node->world[4 * k + axis];
                const double a = m * (double)mesh->bounds_min[k];
                const double b = m * (double)mesh->bounds_max[k];
                box.low[axis] += fmin(a, b);
                box.high[axis] += fmax(a, b);
            }
        }
        if (gn_projection_sees(projection, &box))
            return true;
    }
    return false;
}

/* Draws moving casters where something moved; *dirty grows by what they leave and enter. */
static gn_result draw_moving(const gn_shadow_map *map, const gn_scene *scene, gn_map_slot *slot,
                             gn_rect *dirty)
{
    if (!slot->still && slot->moving_version == scene->transform_version)
        return GN_OK;
    gn_rect now = {0};
    if (map->origin.moving > 0 && is_cast_into(scene, &slot->layer.projection)) {
        const bool kept = slot->dynamic != NULL;
        GN_TRY(reserve(map, (void **)&slot->dynamic, depths_of(map), sizeof(float)));
        const gn_result drawn = draw(map, scene, &slot->layer.projection, GN_CASTERS_DYNAMIC, 0, 1,
                                     slot->dynamic, kept ? &slot->shown : NULL, &now);
        slot->shown = drawn == GN_OK ? now : (gn_rect){0, 0, UINT32_MAX, UINT32_MAX};
        GN_TRY(drawn);
    }
    *dirty = unite(*dirty, widen(map, unite(slot->moving, now)));
    slot->layer.depth[GN_CASTERS_DYNAMIC] = is_empty(now) ? NULL : slot->dynamic;
    slot->layer.touched = widen(map, now);
    slot->moving = now;
    slot->moving_version = scene->transform_version;
    slot->still = false;
    return GN_OK;
}

static gn_result filter_layer(const gn_shadow_map *map, gn_map_slot *slot, gn_rect rect)
{
    gn_map_layer *layer = &slot->layer;
    GN_TRY(filter(map, layer->depth[GN_CASTERS_STATIC], layer->depth[GN_CASTERS_DYNAMIC], rect,
                  &layer->texels));
    if (map->desc.mip_maps)
        gn_cpu_map_mips(&map->device->cpu, &map->format, map->desc.resolution, layer->texels);
    return GN_OK;
}

gn_result gn_map_slot_update(const gn_shadow_map *map, const gn_scene *scene, gn_map_slot *slot,
                             bool advance, gn_map_update *update)
{
    gn_rect dirty = {0};
    const uint32_t filtered = update->filtered;
    if (advance && slot->begun) {
        GN_TRY(draw_part(map, scene, slot, &dirty, update));
        if (slot->parts == map->desc.refresh)
            put_in_use(slot);
        else
            update->pending++;
    }
    if (!slot->used)
        return GN_OK;
    const double start = gn_milliseconds();
    GN_TRY(draw_moving(map, scene, slot, &dirty));
    const double drawn = gn_milliseconds();
    update->depth_ms += drawn - start;
    if (!gn_map_has_texels(&map->format) || is_empty(dirty))
        return GN_OK;
    GN_TRY(filter_layer(map, slot, dirty));
    update->filter_ms += gn_milliseconds() - drawn;
    update->filtered = filtered + 1;
    return GN_OK;
}

gn_result gn_map_slot_restore(const gn_shadow_map *map, const gn_scene *scene, gn_map_slot *slot,
                              const gn_cascade *place, uint32_t parts)
{
    gn_map_update unused = {0};
    gn_rect last = {0};
    gn_map_slot_begin(map, slot, place);
    while (slot->parts < parts)
        GN_TRY(draw_part(map, scene, slot, &last, &unused));
    if (parts < map->desc.refresh)
        return GN_OK;
    put_in_use(slot);
    slot->layer.depth[GN_CASTERS_DYNAMIC] = NULL;
    return gn_map_has_texels(&map->format) ? filter_layer(map, slot, last) : GN_OK;
}
