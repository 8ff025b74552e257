/* Maps without their texels, for files. */
#include <math.h>
#include <string.h>

#include "render/device.h"
#include "render/map_refresh.h"

static gn_map_place place_of(const gn_cascade *cascade)
{
    const gn_map_projection *p = &cascade->projection;
    gn_map_place place = {
        .extent = p->extent, .near = p->near, .far = p->far, .whole = cascade->whole};
    memcpy(place.direction, cascade->direction, sizeof place.direction);
    memcpy(place.origin, p->origin, sizeof place.origin);
    memcpy(place.low, cascade->box.low, sizeof place.low);
    memcpy(place.high, cascade->box.high, sizeof place.high);
    return place;
}

void gn_shadow_map_save_state(const gn_shadow_map *map, gn_map_state *state)
{
    const gn_map_origin *o = &map->origin;
    *state = (gn_map_state){.moving = o->moving,
                            .type = o->type,
                            .range = o->range,
                            .outer = o->outer,
                            .has_camera = map->has_before};
    memcpy(state->light, o->light, sizeof state->light);
    memcpy(state->axis, o->axis, sizeof state->axis);
    memcpy(state->camera, map->camera, sizeof state->camera);
    memcpy(state->sun, map->sun, sizeof state->sun);
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++) {
        const gn_map_slot *slot = &map->slots[i];
        gn_map_layer_state *layer = &state->layers[i];
        layer->used = slot->used;
        layer->parts = slot->begun ? slot->parts : 0;
        if (slot->used)
            layer->front = place_of(&slot->place);
        if (slot->begun)
            layer->back = place_of(&slot->back);
    }
}

static bool is_unit(const float v[3])
{
    double square = 0.0;
    for (int i = 0; i < 3; i++)
        square += (double)v[i] * (double)v[i];
    return fabs(square - 1.0) < 1e-3;
}

static bool is_sane(const gn_map_place *place, bool directional)
{
    for (int i = 0; i < 3; i++)
        if (!isfinite(place->origin[i]) || !isfinite(place->low[i]) || !isfinite(place->high[i]))
            return false;
    return place->extent > 0.0f && isfinite(place->extent) && place->near >= 0.0f &&
           place->far > place->near && isfinite(place->far) && place->whole <= 1 &&
           (!directional || is_unit(place->direction));
}

/* What a place leaves out follows from the light: axes of a sun from the direction, those of a
 * lamp's faces from the lamp. */
static bool read_place(const gn_shadow_map *map, const gn_map_place *place, const gn_lamp *lamp,
                       uint32_t i, gn_cascade *cascade)
{
    if (!is_sane(place, !lamp))
        return false;
    *cascade = (gn_cascade){.whole = place->whole == 1};
    gn_map_projection *p = &cascade->projection;
    if (lamp) {
        if (i >= lamp->count || memcmp(place->origin, lamp->faces[i].origin, sizeof p->origin) != 0)
            return false;
        *p = lamp->faces[i];
    } else {
        const gn_axes axes = gn_light_axes(place->direction);
        for (int k = 0; k < 3; k++) {
            p->right[k] = (float)axes.right[k];
            p->up[k] = (float)axes.up[k];
            p->forward[k] = (float)axes.forward[k];
        }
        memcpy(cascade->direction, place->direction, sizeof cascade->direction);
        memcpy(p->origin, place->origin, sizeof p->origin);
        p->resolution = map->desc.resolution;
    }
    p->extent = place->extent;
    p->near = place->near;
    p->far = place->far;
    memcpy(cascade->box.low, place->low, sizeof place->low);
    memcpy(cascade->box.high, place->high, sizeof place->high);
    return true;
}

static gn_result refuse(const gn_shadow_map *map, const char *what)
{
    return gn_fail(gn_device_context(map->device), GN_ERROR_FORMAT,
                   "the state of a shadow map is damaged: %s", what);
}

static gn_result restore_slot(gn_shadow_map *map, const gn_scene *scene, const gn_lamp *lamp,
                              uint32_t i, const gn_map_layer_state *layer)
{
    gn_map_slot *slot = &map->slots[i];
    if (layer->used > 1 || layer->parts >= map->desc.refresh)
        return refuse(map, "its progress");
    gn_cascade place;
    if (layer->used) {
        if (!read_place(map, &layer->front, lamp, i, &place))
            return refuse(map, "the place of a layer");
        GN_TRY(gn_map_slot_restore(map, scene, slot, &place, map->desc.refresh));
    }
    if (layer->parts > 0) {
        if (!read_place(map, &layer->back, lamp, i, &place))
            return refuse(map, "the place of a layer in the making");
        GN_TRY(gn_map_slot_restore(map, scene, slot, &place, layer->parts));
    }
    return GN_OK;
}

static bool is_empty(const gn_map_state *state)
{
    bool empty = state->has_camera == 0;
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
        empty = empty && state->layers[i].used == 0 && state->layers[i].parts == 0;
    return empty;
}

static gn_result restore(gn_shadow_map *map, const gn_scene *scene, const gn_light *light,
                         const gn_map_state *state)
{
    const bool directional = light->desc.type == GN_LIGHT_DIRECTIONAL;
    if (is_empty(state))
        return GN_OK;
    if (state->type != (uint32_t)light->desc.type)
        return refuse(map, "it belongs to another light");
    if (state->has_camera > 1 ||
        (state->has_camera && (!gn_all_finite(state->camera, 16) || !is_unit(state->sun))))
        return refuse(map, "the camera's place");
    gn_map_origin *o = &map->origin;
    *o = (gn_map_origin){.scene = scene->number,
                         .structure_version = scene->structure_version,
                         .moving = state->moving,
                         .type = state->type,
                         .range = state->range,
                         .outer = state->outer};
    memcpy(o->light, state->light, sizeof o->light);
    memcpy(o->axis, state->axis, sizeof o->axis);
    map->has_before = state->has_camera == 1;
    memcpy(map->camera, state->camera, sizeof map->camera);
    memcpy(map->sun, state->sun, sizeof map->sun);
    gn_lamp lamp;
    if (!directional)
        lamp = gn_lamp_make(light, scene->bounds_min, scene->bounds_max, state->moving > 0,
                            &map->desc, map->margin);
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++)
        GN_TRY(restore_slot(map, scene, directional ? NULL : &lamp, i, &state->layers[i]));
    return GN_OK;
}

gn_result gn_shadow_map_restore_state(gn_shadow_map *map, const gn_scene *scene, uint32_t light,
                                      const gn_map_state *state)
{
    gn_shadow_map_reset(map);
    GN_TRY(gn_shadow_map_check_scene(map, scene, light));
    const gn_result result = restore(map, scene, &scene->lights[light], state);
    if (result != GN_OK)
        gn_shadow_map_reset(map);
    return result;
}
