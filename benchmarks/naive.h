/* The baseline of every speed-up: shadow rays as a good tutorial would write them. One ray at a
 * time, one instance a node, and an alpha test in mip 0 with a plain bilinear lookup. */
#ifndef GN_BENCHMARKS_NAIVE_H
#define GN_BENCHMARKS_NAIVE_H

#include <gnomon/view.h>

typedef struct gn_naive gn_naive;

/* Builds its own Embree scene of a committed scene, as it stands. NULL without memory. */
gn_naive *gn_naive_create(const gn_scene *scene, uint32_t threads);
void gn_naive_destroy(gn_naive *naive);

/* Brings moved nodes up to date after a commit. */
void gn_naive_update(gn_naive *naive);

/* As gn_scene_visibility() with the method ray-mip0. */
void gn_naive_visibility(const gn_naive *naive, const gn_gbuffer *gbuffer, uint32_t light,
                         float *visibility);

#endif
