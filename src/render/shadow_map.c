/* Shadow maps from frame to frame: which layers are placed anew, what is drawn, what is filtered.
 */
#include "render/shadow_map.h"

#include <math.h>
#include <string.h>

#include <gnomon/shadow/moments_nonlinear.h>

#include "render/cascade.h"
#include "render/device.h"

/* What a layer's static depth was drawn of: as long as it is the same, a layer that stays in its
 * place stays as it is. Static nodes cannot move: a node that moves counts as moving for good. */
typedef struct origin {
    uint64_t scene, structure_version;
    uint32_t moving;         /* nodes with a mesh that may move */
    uint32_t type;           /* of the light, and what matters of it; zero elsewhere */
    float light[3], axis[3]; /* position, direction */
    float range, outer;
} origin;

/* What a layer remembers beside what is read. */
typedef struct layer_state {
    bool placed, fresh;      /* fresh: in this update */
    gn_cascade cascade;      /* directional lights */
    float *dynamic;          /* shown in the layer where moving casters touch it */
    gn_rect touched;         /* by moving casters as of transform_version */
    uint64_t moving_version; /* scene->transform_version of what is drawn */
} layer_state;

struct gn_shadow_map {
    gn_device *device;
    gn_map_format format;
    gn_map_desc desc; /* resolved */
    uint32_t margin;  /* texels that fitting keeps free at a layer's border */
    origin origin;
    uint32_t layer_count;
    gn_map_layer layers[GN_MAX_CASCADES]; /* six at most for a lamp */
    layer_state states[GN_MAX_CASCADES];
};

/* Life ---------------------------------------------------------------------------------------- */

gn_result gn_shadow_map_create(gn_device *device, const gn_map_format *format,
                               const gn_map_desc *desc, gn_shadow_map **map)
{
    gn_context *context = gn_device_context(device);
    *map = NULL;
    const gn_map_desc defaults = gn_map_desc_default();
    if (!desc)
        desc = &defaults;
    if (!format)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "a shadow map without a format");
    GN_TRY(gn_map_desc_check(context, format, desc));
    gn_map_desc resolved = gn_map_desc_resolve(format, desc);
    if (!gn_map_has_texels(format))
        resolved.samples = 1;
    /* Receivers are moved along their normals before they are looked up. */
    const uint32_t margin =
        gn_map_margin(format, &resolved) + (uint32_t)ceilf(resolved.normal_bias);
    if (resolved.resolution <= 2 * (margin + 1))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a shadow map of %u texels a side: filter, reading and bias take %u at each "
                       "border, so that at least %u are needed",
                       resolved.resolution, margin, 2 * (margin + 1) + 1);
    gn_shadow_map *made = gn_alloc_zero(context, 1, sizeof *made);
    if (!made)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a shadow map");
    made->device = device;
    made->format = *format;
    made->desc = resolved;
    made->margin = margin;
    *map = made;
    return GN_OK;
}

void gn_shadow_map_destroy(gn_shadow_map **map)
{
    if (!map || !*map)
        return;
    gn_shadow_map *m = *map;
    *map = NULL;
    gn_context *context = gn_device_context(m->device);
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++) {
        gn_free(context, m->layers[i].depth[GN_CASTERS_STATIC]);
        gn_free(context, m->layers[i].texels);
        gn_free(context, m->states[i].dynamic);
    }
    gn_free(context, m);
}

void gn_shadow_map_reset(gn_shadow_map *map)
{
    map->layer_count = 0;
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
        map->states[i].placed = false;
}

/* Placing ------------------------------------------------------------------------------------- */

static bool has_meshes(const gn_scene *scene)
{
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (scene->nodes[i].desc.mesh != GN_NONE)
            return true;
    return false;
}

static origin origin_of(const gn_scene *scene, const gn_light *light)
{
    origin made = {.scene = scene->number,
                   .structure_version = scene->structure_version,
                   .type = (uint32_t)light->desc.type};
    for (uint32_t i = 0; i < scene->node_count; i++)
        made.moving += scene->nodes[i].animated && scene->nodes[i].desc.mesh != GN_NONE;
    if (light->desc.type != GN_LIGHT_POINT)
        memcpy(made.axis, light->direction, sizeof made.axis);
    if (light->desc.type != GN_LIGHT_DIRECTIONAL) {
        memcpy(made.light, light->position, sizeof made.light);
        made.range = light->desc.range;
    }
    if (light->desc.type == GN_LIGHT_SPOT)
        made.outer = light->desc.outer_cone_angle;
    return made;
}

static void place(gn_shadow_map *map, uint32_t i, const gn_map_projection *projection)
{
    map->layers[i].projection = *projection;
    map->states[i].placed = true;
    map->states[i].fresh = true;
}

static void place_cascades(gn_shadow_map *map, const gn_scene *scene, const gn_light *light,
                           const gn_camera *camera, float aspect)
{
    const gn_cascades cascades =
        gn_cascades_make(camera, aspect, scene->bounds_min, scene->bounds_max,
                         map->origin.moving > 0, light->direction, &map->desc, map->margin);
    bool whole = false;
    for (uint32_t i = 0; i < cascades.count && !whole; i++) {
        layer_state *state = &map->states[i];
        if (!state->placed || !gn_cascade_serves(&state->cascade, &cascades, i)) {
            state->cascade = gn_cascade_fit(&cascades, i);
            place(map, i, &state->cascade.projection);
        }
        whole = state->cascade.whole;
        map->layer_count++;
    }
}

static void place_lamp(gn_shadow_map *map, const gn_scene *scene, const gn_light *light)
{
    const gn_lamp lamp = gn_lamp_make(light, scene->bounds_min, scene->bounds_max,
                                      map->origin.moving > 0, &map->desc, map->margin);
    map->layer_count = lamp.count;
    for (uint32_t i = 0; i < lamp.count; i++)
        if (!map->states[i].placed || !gn_lamp_serves(&map->layers[i].projection, &lamp))
            place(map, i, &lamp.faces[i]);
}

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

static gn_rect widen(gn_rect r, uint32_t by, uint32_t resolution)
{
    if (is_empty(r))
        return r;
    return (gn_rect){r.x0 > by ? r.x0 - by : 0, r.y0 > by ? r.y0 - by : 0,
                     r.x1 + by < resolution ? r.x1 + by : resolution,
                     r.y1 + by < resolution ? r.y1 + by : resolution};
}

/* Drawing ------------------------------------------------------------------------------------- */

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

static gn_result draw(const gn_shadow_map *map, const gn_scene *scene, uint32_t i,
                      gn_casters casters, float *depth, gn_rect *covered)
{
    gn_depth_job job = {.scene = scene,
                        .projection = map->layers[i].projection,
                        .casters = casters,
                        .alpha = map->desc.alpha,
                        .samples = map->desc.samples,
                        .depth = depth};
    GN_TRY(gn_cpu_depth(&map->device->cpu, &job));
    *covered = job.covered;
    return GN_OK;
}

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

/* Draws what changed in a layer; *dirty: the texels that are no longer right. */
static gn_result draw_layer(gn_shadow_map *map, const gn_scene *scene, uint32_t i, gn_rect *dirty)
{
    gn_map_layer *layer = &map->layers[i];
    layer_state *state = &map->states[i];
    const uint32_t resolution = map->desc.resolution;
    gn_rect before = state->touched, now = {0};
    if (state->fresh) {
        GN_TRY(
            reserve(map, (void **)&layer->depth[GN_CASTERS_STATIC], depths_of(map), sizeof(float)));
        gn_rect covered;
        GN_TRY(draw(map, scene, i, GN_CASTERS_STATIC, layer->depth[GN_CASTERS_STATIC], &covered));
        before = (gn_rect){0, 0, resolution, resolution};
    } else if (state->moving_version == scene->transform_version) {
        *dirty = now;
        return GN_OK;
    }
    if (map->origin.moving > 0 && is_cast_into(scene, &layer->projection)) {
        GN_TRY(reserve(map, (void **)&state->dynamic, depths_of(map), sizeof(float)));
        GN_TRY(draw(map, scene, i, GN_CASTERS_DYNAMIC, state->dynamic, &now));
    }
    layer->depth[GN_CASTERS_DYNAMIC] = is_empty(now) ? NULL : state->dynamic;
    state->touched = now;
    state->moving_version = scene->transform_version;
    *dirty = widen(unite(before, now), map->desc.filter_width / 2, resolution);
    return GN_OK;
}

static gn_result filter_layer(gn_shadow_map *map, uint32_t i, gn_rect rect)
{
    gn_map_layer *layer = &map->layers[i];
    const gn_cpu *cpu = &map->device->cpu;
    GN_TRY(reserve(map, (void **)&layer->texels, words_of(map), sizeof(uint32_t)));
    const gn_filter_job job = {.format = map->format,
                               .resolution = map->desc.resolution,
                               .samples = map->desc.samples,
                               .width = map->desc.filter_width,
                               .sigma = map->desc.filter_sigma,
                               .moment_bias = map->desc.moment_bias,
                               .depth = layer->depth[GN_CASTERS_STATIC],
                               .dynamic = layer->depth[GN_CASTERS_DYNAMIC],
                               .rect = rect,
                               .texels = layer->texels};
    GN_TRY(gn_cpu_filter(cpu, &job));
    if (map->desc.mip_maps)
        gn_cpu_map_mips(cpu, &map->format, map->desc.resolution, layer->texels);
    return GN_OK;
}

static bool is_finite(const gn_map_projection *p)
{
    return gn_all_finite(p->origin, 3) && isfinite(p->extent) && isfinite(p->far);
}

static gn_result refresh(gn_shadow_map *map, const gn_scene *scene, gn_map_update *update)
{
    for (uint32_t i = 0; i < map->layer_count; i++) {
        if (!is_finite(&map->layers[i].projection))
            return gn_fail(gn_device_context(map->device), GN_ERROR_UNSUPPORTED,
                           "the scene is too large for a shadow map in floats");
        gn_rect dirty;
        const double start = gn_milliseconds();
        GN_TRY(draw_layer(map, scene, i, &dirty));
        const double drawn = gn_milliseconds();
        update->depth_ms += drawn - start;
        update->fitted += map->states[i].fresh;
        if (!gn_map_has_texels(&map->format) || is_empty(dirty))
            continue;
        GN_TRY(filter_layer(map, i, dirty));
        update->filter_ms += gn_milliseconds() - drawn;
        update->filtered++;
    }
    return GN_OK;
}

static gn_result check(const gn_shadow_map *map, const gn_scene *scene, uint32_t light,
                       uint32_t camera, float aspect)
{
    gn_context *context = gn_device_context(map->device);
    if (scene->device != map->device)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "the shadow map was made by another device than the scene");
    if (!scene->accel || scene->edits != scene->committed)
        return gn_fail(context, GN_ERROR_STATE, "the scene has edits that are not committed");
    if (light >= scene->light_count)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "light %u does not exist: the scene has %u", light, scene->light_count);
    if (scene->lights[light].desc.type != GN_LIGHT_DIRECTIONAL)
        return GN_OK;
    if (camera >= scene->camera_count)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "camera %u does not exist: the scene has %u", camera, scene->camera_count);
    if (!(aspect > 0.0f && isfinite(aspect)))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "an aspect of %g: it must be more than 0, and finite", (double)aspect);
    return GN_OK;
}

gn_result gn_shadow_map_update(gn_shadow_map *map, const gn_scene *scene, uint32_t light,
                               uint32_t camera, float aspect, gn_map_update *update)
{
    gn_map_update unused;
    if (!update)
        update = &unused;
    *update = (gn_map_update){0};
    gn_result result = check(map, scene, light, camera, aspect);
    if (result == GN_OK) {
        const gn_light *of = &scene->lights[light];
        const origin now = origin_of(scene, of);
        if (memcmp(&now, &map->origin, sizeof now) != 0)
            gn_shadow_map_reset(map);
        map->origin = now;
        map->layer_count = 0;
        for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
            map->states[i].fresh = false;
        if (has_meshes(scene) && of->desc.type == GN_LIGHT_DIRECTIONAL)
            place_cascades(map, scene, of, &scene->cameras[camera], aspect);
        else if (has_meshes(scene))
            place_lamp(map, scene, of);
        result = refresh(map, scene, update);
    }
    if (result != GN_OK)
        gn_shadow_map_reset(map);
    return result;
}

/* Reading ------------------------------------------------------------------------------------- */

void gn_shadow_map_fill_job(const gn_shadow_map *map, gn_map_job *job)
{
    job->layers = map->layers;
    job->layer_count = map->layer_count;
    job->format = map->format;
    job->desc = map->desc;
}

uint32_t gn_shadow_map_layer_count(const gn_shadow_map *map)
{
    return map->layer_count;
}

gn_map_layer_info gn_shadow_map_layer(const gn_shadow_map *map, uint32_t layer)
{
    if (layer >= map->layer_count)
        return (gn_map_layer_info){0};
    const gn_map_layer *l = &map->layers[layer];
    const gn_map_projection *p = &l->projection;
    gn_map_layer_info info = {.perspective = p->perspective,
                              .extent = p->extent,
                              .near = p->near,
                              .far = p->far,
                              .resolution = p->resolution,
                              .samples = map->desc.samples,
                              .depth = l->depth[GN_CASTERS_STATIC],
                              .dynamic_depth = l->depth[GN_CASTERS_DYNAMIC]};
    for (int i = 0; i < 3; i++) {
        info.origin[i] = p->origin[i];
        info.right[i] = p->right[i];
        info.up[i] = p->up[i];
        info.forward[i] = p->forward[i];
    }
    return info;
}

size_t gn_shadow_map_bytes(const gn_shadow_map *map)
{
    size_t bytes = 0;
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++) {
        bytes += map->layers[i].depth[GN_CASTERS_STATIC] ? depths_of(map) * sizeof(float) : 0;
        bytes += map->states[i].dynamic ? depths_of(map) * sizeof(float) : 0;
        bytes += map->layers[i].texels ? words_of(map) * sizeof(uint32_t) : 0;
    }
    return bytes;
}

gn_result gn_shadow_map_xi4(const gn_shadow_map *map, uint32_t layer, float *xi4)
{
    gn_context *context = gn_device_context(map->device);
    if (map->format.kind != GN_MAP_NLMSM)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "xi4: only maps of non-linearly quantized moments (nlmsm) have it");
    if (layer >= map->layer_count)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "layer %u does not exist: the map has %u", layer, map->layer_count);
    const uint32_t *texels = map->layers[layer].texels;
    const size_t count = (size_t)map->desc.resolution * map->desc.resolution;
    for (size_t i = 0; i < count; i++)
        xi4[i] = map->format.bits == 64
                     ? gn_nonlinear_unpack64(texels[2 * i], texels[2 * i + 1]).xi4
                     : gn_nonlinear_unpack32(texels[i]).xi4;
    return GN_OK;
}
