/* Building one triangle tree from parts. */
#ifndef GN_CPU_TREE_H
#define GN_CPU_TREE_H

#include "cpu/kernels.h"

/* One part to put into a tree. */
typedef struct gn_tree_part {
    const gn_part *part;
    const float *world; /* column major; NULL: as it is */
    uint32_t surface;
} gn_tree_part;

/* Fills *tree, which must be zero. Every triangle of every part goes in, but for those whose alpha
 * lets everything through. */
gn_result gn_tree_build(gn_accel *accel, const gn_scene *scene, const gn_tree_part *parts,
                        uint32_t part_count, gn_triangle_tree *tree);
void gn_tree_free(gn_context *context, gn_triangle_tree *tree);

#endif
