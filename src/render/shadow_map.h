/* What the renderer reads of a shadow map, and what is kept of it in a file. */
#ifndef GN_RENDER_SHADOW_MAP_H
#define GN_RENDER_SHADOW_MAP_H

#include "cpu/map.h"

/* Fills layers, layer_count, format and desc (resolved) of a job for reading an updated map. The
 * layers are the map's own, valid until its next update; those that are not drawn yet are not among
 * them (gn_map_layer.index tells which cascade or face one is). */
void gn_shadow_map_fill_job(const gn_shadow_map *map, gn_map_job *job);

/* Where a layer was placed. Fixed size, no padding, any bits are a value: files may hold anything.
 */
typedef struct gn_map_place {
    float direction[3]; /* directional lights: that it is drawn for, unit length */
    float origin[3], extent, near, far;
    uint32_t whole;         /* 1: it holds the scene */
    double low[3], high[3]; /* the box that it holds */
} gn_map_place;

typedef struct gn_map_layer_state {
    uint32_t used;  /* 1: `front` is drawn and read */
    uint32_t parts; /* of `back` that are drawn; 0: there is none */
    gn_map_place front, back;
} gn_map_layer_state;

/* A map without its texels: what it was drawn of and where its layers lie. */
typedef struct gn_map_state {
    uint32_t moving, type; /* nodes that may move; gn_light_type */
    float light[3], axis[3], range, outer;
    float camera[16], sun[3]; /* of the last update: the camera's frame, the sun's direction */
    uint32_t has_camera;      /* 1: they are known */
    gn_map_layer_state layers[GN_MAX_CASCADES];
} gn_map_state;

void gn_shadow_map_save_state(const gn_shadow_map *map, gn_map_state *state);

/* Makes a map of the same format and settings what the saved one was, for a committed scene and one
 * of its lights: draws its layers, and of those in the making what was drawn. Moving casters are
 * drawn in the next update, which gives the same bits as if the map had never been saved. Refuses a
 * state that no update can leave (GN_ERROR_FORMAT); the map is empty then. */
gn_result gn_shadow_map_restore_state(gn_shadow_map *map, const gn_scene *scene, uint32_t light,
                                      const gn_map_state *state);

#endif
