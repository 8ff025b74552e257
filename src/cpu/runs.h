/* Triangles of a tree for drawing: in runs that lie close together, with boxes to cull by.
 *
 * A tree's own order is that of its meshes; runs follow a Morton curve through the triangles'
 * centres, opaque ones first, corners copied in the order in which a rasterizer loads them. */
#ifndef GN_CPU_RUNS_H
#define GN_CPU_RUNS_H

#include "cpu/accel.h"

enum { GN_BATCH = 16, GN_RUN_BATCHES = 4, GN_RUN = GN_BATCH * GN_RUN_BATCHES };

/* 16 triangles; those behind the last have three equal corners. */
typedef struct gn_batch {
    float corners[3][3][GN_BATCH]; /* [corner][axis], in the tree's space */
    uint32_t ids[GN_BATCH];        /* in the tree's arrays of their kind */
} gn_batch;

typedef struct gn_box {
    float min[3], max[3];
} gn_box;

typedef struct gn_runs {
    gn_batch *batches; /* GN_RUN_BATCHES a run */
    gn_box *boxes;     /* one a run */
    gn_box bounds;     /* of all; only where count > 0 */
    uint32_t count;
    uint32_t first_masked; /* runs before it are opaque, the others masked */
} gn_runs;

/* The runs of a tree, made at the first call and freed with it. NULL: out of memory.
 * Thread-safety: any number of threads. */
const gn_runs *gn_tree_runs(gn_accel *accel, gn_triangle_tree *tree);
void gn_runs_free(gn_context *context, gn_runs *runs); /* NULL is fine */

/* An order by key, ascending and stable. spare: room for count more. Returns the sorted one of
 * the two. */
typedef struct gn_sort_item {
    uint64_t key;
    uint32_t index;
} gn_sort_item;
gn_sort_item *gn_sort(gn_sort_item *items, gn_sort_item *spare, uint32_t count);

#endif
