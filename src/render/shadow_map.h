/* What the renderer reads of a shadow map. */
#ifndef GN_RENDER_SHADOW_MAP_H
#define GN_RENDER_SHADOW_MAP_H

#include "cpu/map.h"

/* Fills layers, layer_count, format and desc (resolved) of a job for reading an updated map. The
 * layers are the map's own, valid until its next update. */
void gn_shadow_map_fill_job(const gn_shadow_map *map, gn_map_job *job);

#endif
