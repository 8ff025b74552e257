/* Shadow maps from frame to frame: which layers are placed anew, what is drawn, what is filtered.
 */
#include "render/shadow_map.h"

#include <math.h>
#include <string.h>

#include <gnomon/shadow/moments_nonlinear.h>

#include "render/device.h"
#include "render/map_refresh.h"

/* Shadows of a layer that was drawn for another direction of the sun may lie off by so many texels:
 * as far as one that reads four texels is unsure anyway. */
#define MOST_SHIFT 1.5

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
    if (resolved.undrawn == GN_NONE)
        resolved.undrawn = 0;
    if (resolved.refresh == 0)
        resolved.refresh = 1;
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
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
        gn_map_slot_free(m, &m->slots[i]);
    gn_free(context, m);
}

void gn_shadow_map_reset(gn_shadow_map *map)
{
    map->layer_count = 0;
    map->has_before = false;
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
        map->slots[i].used = map->slots[i].begun = false;
}

/* Placing ------------------------------------------------------------------------------------- */

static bool has_meshes(const gn_scene *scene)
{
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (scene->nodes[i].desc.mesh != GN_NONE)
            return true;
    return false;
}

/* A sun's direction belongs to each layer where old ones stay in use. */
static gn_map_origin origin_of(const gn_shadow_map *map, const gn_scene *scene,
                               const gn_light *light)
{
    gn_map_origin made = {.scene = scene->number,
                          .structure_version = scene->structure_version,
                          .type = (uint32_t)light->desc.type};
    for (uint32_t i = 0; i < scene->node_count; i++)
        made.moving += scene->nodes[i].animated && scene->nodes[i].desc.mesh != GN_NONE;
    if (light->desc.type == GN_LIGHT_SPOT ||
        (light->desc.type == GN_LIGHT_DIRECTIONAL && map->desc.refresh == 1))
        memcpy(made.axis, light->direction, sizeof made.axis);
    if (light->desc.type != GN_LIGHT_DIRECTIONAL) {
        memcpy(made.light, light->position, sizeof made.light);
        made.range = light->desc.range;
    }
    if (light->desc.type == GN_LIGHT_SPOT)
        made.outer = light->desc.outer_cone_angle;
    return made;
}

/* What an update does with a layer. */
typedef struct work {
    bool advance[GN_MAX_CASCADES]; /* draw at what is in the making */
    bool read[GN_MAX_CASCADES];    /* read it where it is in use */
} work;

static void begin(gn_shadow_map *map, uint32_t i, const gn_cascade *place, gn_map_update *update)
{
    gn_map_slot_begin(map, &map->slots[i], place);
    update->fitted++;
}

/* A view of the cascades, and how it goes on if camera and sun move on as they came from the update
 * before: at the time when a layer that is begun now comes in use, and in the midst of its use. */
typedef struct outlook {
    gn_cascades now, ready, later;
    bool still; /* the sun does not turn */
} outlook;

/* Where the sun will be: along a straight line, which is right for small turns; others are
 * jumps, of which nothing follows. */
static void sun_ahead(const gn_shadow_map *map, const float now[3], uint32_t updates,
                      float ahead[3])
{
    double moved[3], square = 0.0;
    for (int i = 0; i < 3; i++) {
        const double by = map->has_before ? (double)now[i] - (double)map->sun[i] : 0.0;
        moved[i] = (double)now[i] + updates * by;
        square += moved[i] * moved[i];
    }
    const bool moves =
        updates > 0 && map->has_before && memcmp(now, map->sun, sizeof map->sun) != 0;
    for (int i = 0; i < 3; i++)
        ahead[i] = moves && square > 0.0 ? (float)(moved[i] / sqrt(square)) : now[i];
}

/* Where the camera will be: along a line, turning on about the same axis. */
static gn_camera camera_ahead(const gn_shadow_map *map, const gn_camera *now, uint32_t updates)
{
    gn_camera ahead = *now;
    const float *before = map->camera, *here = now->world;
    if (!map->has_before || memcmp(here, before, sizeof map->camera) == 0)
        return ahead;
    double turn[3][3]; /* from axes before to axes now, in the world */
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) {
            turn[row][k] = 0.0;
            for (int axis = 0; axis < 12; axis += 4)
                turn[row][k] += (double)here[axis + row] * (double)before[axis + k];
        }
    for (int axis = 0; axis < 12; axis += 4) {
        double a[3] = {(double)here[axis], (double)here[axis + 1], (double)here[axis + 2]};
        for (uint32_t n = 0; n < updates; n++) {
            double b[3] = {0, 0, 0};
            for (int row = 0; row < 3; row++)
                for (int k = 0; k < 3; k++)
                    b[row] += turn[row][k] * a[k];
            memcpy(a, b, sizeof a);
        }
        for (int k = 0; k < 3; k++)
            ahead.world[axis + k] = (float)a[k];
    }
    for (int k = 12; k < 15; k++)
        ahead.world[k] = (float)((double)here[k] + updates * ((double)here[k] - (double)before[k]));
    return ahead;
}

static gn_cascades look_ahead(const gn_shadow_map *map, const gn_scene *scene,
                              const float direction[3], const gn_camera *camera, float aspect,
                              uint32_t updates)
{
    float sun[3];
    sun_ahead(map, direction, updates, sun);
    const gn_camera ahead = camera_ahead(map, camera, updates);
    return gn_cascades_make(&ahead, aspect, scene->bounds_min, scene->bounds_max,
                            map->origin.moving > 0, sun, &map->desc, map->margin);
}

static outlook make_outlook(const gn_shadow_map *map, const gn_scene *scene,
                            const float direction[3], const gn_camera *camera, float aspect)
{
    const uint32_t refresh = map->desc.refresh;
    outlook made = {.now = look_ahead(map, scene, direction, camera, aspect, 0)};
    made.ready = made.later = made.now;
    made.still = !map->has_before || memcmp(map->sun, direction, sizeof map->sun) == 0;
    if (refresh == 1)
        return made;
    made.ready = look_ahead(map, scene, direction, camera, aspect, refresh);
    made.later = look_ahead(map, scene, direction, camera, aspect, refresh + refresh / 2);
    return made;
}

/* For the sun in the midst of its use; or as it is now, where that is too far off to be
 * foreseen. */
static gn_cascade place_cascade(const outlook *view, uint32_t i)
{
    const gn_cascades now = gn_cascades_turned(&view->now, view->later.direction);
    const gn_cascade made = gn_cascade_fit_ahead(&now, &view->later, i);
    if (gn_cascade_shift(&made, &view->now, view->now.direction) <= 3.0 * MOST_SHIFT)
        return made;
    const gn_cascades later = gn_cascades_turned(&view->later, view->now.direction);
    return gn_cascade_fit_ahead(&view->now, &later, i);
}

/* Is a layer right for the sun? */
static bool is_right(const gn_cascade *placed, const gn_cascades *view, const float direction[3])
{
    return gn_cascade_shift(placed, view, direction) <= MOST_SHIFT;
}

/* What is in the making stays so until it is whole, however the camera turns: begun anew, it might
 * never be. It is given up where it became of no use at all. */
static bool is_wanted(const gn_shadow_map *map, const outlook *view, const gn_map_slot *slot,
                      uint32_t i)
{
    const uint32_t left = map->desc.refresh - slot->parts - 1;
    float sun[3];
    sun_ahead(map, view->now.direction, left, sun);
    if (!is_right(&slot->back, &view->now, sun) || !gn_cascade_meets(&slot->back, &view->now, i))
        return false;
    const bool old_serves = slot->used && gn_cascade_serves(&slot->place, &view->now, i);
    return left > 0 || !old_serves || gn_cascade_serves(&slot->back, &view->now, i);
}

/* Must a layer in use be drawn anew, so that the new one is ready when the old one fails? */
static bool is_failing(const gn_map_slot *slot, const outlook *view, uint32_t i)
{
    return !slot->used || !gn_cascade_serves(&slot->place, &view->now, i) ||
           (i < view->ready.count && !gn_cascade_serves(&slot->place, &view->ready, i)) ||
           !is_right(&slot->place, &view->now, view->ready.direction) ||
           (view->still &&
            memcmp(slot->place.direction, view->now.direction, sizeof slot->place.direction) != 0);
}

static void place_cascades(gn_shadow_map *map, const gn_scene *scene, const gn_light *light,
                           const gn_camera *camera, float aspect, work *todo, gn_map_update *update)
{
    const outlook view = make_outlook(map, scene, light->direction, camera, aspect);
    const gn_cascades now = view.now;
    const uint32_t drawn = map->desc.cascades - map->desc.undrawn;
    bool whole = false, placed = false; /* one in use holds the scene; one at all does */
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++) {
        gn_map_slot *slot = &map->slots[i];
        if (slot->used && !is_right(&slot->place, &now, now.direction))
            slot->used = false;
        if (i >= now.count || i >= drawn || whole)
            continue;
        todo->read[i] = true;
        if (!placed) {
            todo->advance[i] = true;
            if (slot->begun && !is_wanted(map, &view, slot, i))
                slot->begun = false;
            if (!slot->begun && is_failing(slot, &view, i)) {
                const gn_cascade place = place_cascade(&view, i);
                begin(map, i, &place, update);
            }
        }
        placed = placed || (slot->begun ? slot->back.whole : slot->place.whole);
        whole = slot->begun && slot->parts + 1 == map->desc.refresh
                    ? slot->back.whole
                    : slot->used && slot->place.whole;
    }
    memcpy(map->camera, camera->world, sizeof map->camera);
    memcpy(map->sun, light->direction, sizeof map->sun);
    map->has_before = true;
}

static void place_lamp(gn_shadow_map *map, const gn_scene *scene, const gn_light *light, work *todo,
                       gn_map_update *update)
{
    const gn_lamp lamp = gn_lamp_make(light, scene->bounds_min, scene->bounds_max,
                                      map->origin.moving > 0, &map->desc, map->margin);
    for (uint32_t i = 0; i < lamp.count; i++) {
        gn_map_slot *slot = &map->slots[i];
        todo->advance[i] = todo->read[i] = true;
        /* What is nearer than its near end is not in it. */
        if (slot->used && (double)slot->place.projection.near > lamp.near)
            slot->used = false;
        if (slot->begun && !gn_lamp_serves(&slot->back.projection, &lamp))
            slot->begun = false;
        const gn_cascade place = {.projection = lamp.faces[i]};
        if (!slot->begun && !(slot->used && gn_lamp_serves(&slot->place.projection, &lamp)))
            begin(map, i, &place, update);
    }
}

/* Updating ------------------------------------------------------------------------------------ */

static gn_result refresh(gn_shadow_map *map, const gn_scene *scene, const work *todo,
                         gn_map_update *update)
{
    map->layer_count = 0;
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++) {
        gn_map_slot *slot = &map->slots[i];
        if (!todo->read[i])
            continue;
        GN_TRY(gn_map_slot_update(map, scene, slot, todo->advance[i], update));
        if (!slot->used)
            continue;
        map->layers[map->layer_count] = slot->layer;
        map->layers[map->layer_count++].index = i;
    }
    return GN_OK;
}

gn_result gn_shadow_map_check_scene(const gn_shadow_map *map, const gn_scene *scene, uint32_t light)
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
    return GN_OK;
}

static gn_result check(const gn_shadow_map *map, const gn_scene *scene, uint32_t light,
                       uint32_t camera, float aspect)
{
    gn_context *context = gn_device_context(map->device);
    GN_TRY(gn_shadow_map_check_scene(map, scene, light));
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
        const gn_map_origin now = origin_of(map, scene, of);
        if (memcmp(&now, &map->origin, sizeof now) != 0)
            gn_shadow_map_reset(map);
        map->origin = now;
        work todo = {0};
        if (has_meshes(scene) && of->desc.type == GN_LIGHT_DIRECTIONAL)
            place_cascades(map, scene, of, &scene->cameras[camera], aspect, &todo, update);
        else if (has_meshes(scene))
            place_lamp(map, scene, of, &todo, update);
        result = refresh(map, scene, &todo, update);
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
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
        bytes += gn_map_slot_bytes(map, &map->slots[i]);
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
