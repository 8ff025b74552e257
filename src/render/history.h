/* What methods keep from frame to frame. */
#ifndef GN_RENDER_HISTORY_H
#define GN_RENDER_HISTORY_H

#include <gnomon/view.h>

/* The map of a light for a format and settings, made or kept; the history owns it. */
gn_result gn_history_reserve_map(gn_history *history, const gn_scene *scene, uint32_t light,
                                 const gn_map_format *format, const gn_map_desc *desc,
                                 gn_shadow_map **map);

#endif
