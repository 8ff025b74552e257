/* The layers of a shadow map: drawn at once, or in slices over several updates. */
#ifndef GN_RENDER_MAP_REFRESH_H
#define GN_RENDER_MAP_REFRESH_H

#include "render/cascade.h"
#include "render/shadow_map.h"

/* What static depth was drawn of: as long as it is the same, a layer that stays in its place stays
 * as it is. Static nodes cannot move: a node that moves counts as moving for good. */
typedef struct gn_map_origin {
    uint64_t scene, structure_version;
    uint32_t moving;         /* nodes with a mesh that may move */
    uint32_t type;           /* of the light, and what matters of it; zero elsewhere */
    float light[3], axis[3]; /* position; direction, but for suns whose layers have their own */
    float range, outer;
} gn_map_origin;

/* A layer: the one that is read, and behind it the one in the making. */
typedef struct gn_map_slot {
    bool used;               /* layer holds a drawn map of what lies in `place` */
    gn_cascade place;        /* of lamps the projection alone */
    gn_map_layer layer;      /* with buffers that may be left from earlier */
    float *dynamic;          /* shown in the layer where moving casters touch it */
    gn_rect shown;           /* texels of it that are not 1 */
    gn_rect moving;          /* texels that moving casters cover as of moving_version */
    uint64_t moving_version; /* scene->transform_version of what is drawn */
    bool still;              /* nothing of that is drawn yet */

    bool begun;     /* back is being drawn */
    uint32_t parts; /* of it that are drawn, < desc.refresh */
    gn_cascade back;
    float *back_depth; /* NULL: none yet */
    uint32_t *back_texels;
} gn_map_slot;

struct gn_shadow_map {
    gn_device *device;
    gn_map_format format;
    gn_map_desc desc; /* resolved */
    uint32_t margin;  /* texels that fitting keeps free at a layer's border */
    gn_map_origin origin;
    bool has_before;                    /* the two below are known */
    float camera[16], sun[3];           /* world matrix and direction, of the last update */
    gn_map_slot slots[GN_MAX_CASCADES]; /* six at most for a lamp */
    uint32_t layer_count;
    gn_map_layer layers[GN_MAX_CASCADES]; /* those that are read, in order of their index */
};

/* Starts a layer anew at a place; what was in the making is lost. The old one stays in use, but
 * where layers are drawn at once. */
void gn_map_slot_begin(const gn_shadow_map *map, gn_map_slot *slot, const gn_cascade *place);

/* An update's work on a layer. advance: draws the next part of what is in the making, or filters
 * the next of its rows; after desc.refresh parts it takes the place of the old one. Then what is in
 * use gets its moving casters. The layer that results does not depend on the number of parts. */
gn_result gn_map_slot_update(const gn_shadow_map *map, const gn_scene *scene, gn_map_slot *slot,
                             bool advance, gn_map_update *update);

/* What gn_map_slot_begin() and so many parts leave: all of them, a layer in use whose moving
 * casters are still to be drawn. */
gn_result gn_map_slot_restore(const gn_shadow_map *map, const gn_scene *scene, gn_map_slot *slot,
                              const gn_cascade *place, uint32_t parts);

/* Refuses a scene that is not committed, or of another device, and lights that do not exist. */
gn_result gn_shadow_map_check_scene(const gn_shadow_map *map, const gn_scene *scene,
                                    uint32_t light);

size_t gn_map_slot_bytes(const gn_shadow_map *map, const gn_map_slot *slot);
void gn_map_slot_free(const gn_shadow_map *map, gn_map_slot *slot);

#endif
