/* What answers a light's shadow rays. */
#ifndef GN_RENDER_TRACER_H
#define GN_RENDER_TRACER_H

#include "cpu/light_buffer.h"
#include "render/history.h"

/* Chooses between tree and light buffer (desc->tracer) for the rays of a picture of so many pixels,
 * and makes the history's light buffer ready. */
gn_result gn_choose_tracer(const gn_scene *scene, const gn_visibility_desc *desc, size_t pixels,
                           gn_history *history, gn_tracer *tracer);

/* Says what was chosen, after the rays. */
void gn_describe_tracer(const gn_tracer *tracer, gn_visibility_stats *stats);

#endif
