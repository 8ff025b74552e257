/* What methods keep from frame to frame. */
#ifndef GN_RENDER_HISTORY_H
#define GN_RENDER_HISTORY_H

#include "cpu/leak.h"

/* The map of a light for a format and settings, made or kept; the history owns it. */
gn_result gn_history_reserve_map(gn_history *history, const gn_scene *scene, uint32_t light,
                                 const gn_map_format *format, const gn_map_desc *desc,
                                 gn_shadow_map **map);

/* Most lights with a mask: 3 bits each in 128. */
#define GN_MAX_MASKS 42u

/* The mask of a light for the frame at hand, after gn_history_reserve_map() for it. A frame begins
 * when a light comes round again. `before` is NULL in the first frame, after a cut, a change of
 * camera or of the picture's size, and where the light was not asked for in the frame before.
 * keep_depth: the G-buffer's depth is needed in the next frame. */
gn_result gn_history_begin_mask(gn_history *history, uint32_t light, uint32_t camera,
                                const gn_gbuffer *gbuffer, bool keep_depth, gn_leak_mask *mask);

#endif
