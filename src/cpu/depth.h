/* Drawing depth: what the driver (depth.c) and the inner loops (depth.inc) share. */
#ifndef GN_CPU_DEPTH_H
#define GN_CPU_DEPTH_H

#include "cpu/map.h"
#include "cpu/runs.h"

/* Texels a side of one thread's piece of work, and of a block: one vector of 16 lanes. */
enum { GN_DEPTH_TILE = 128, GN_DEPTH_BLOCK = 4, GN_DEPTH_BLOCKS = GN_DEPTH_TILE / GN_DEPTH_BLOCK };

/* A tree as a layer sees it. */
typedef struct gn_depth_draw {
    const gn_runs *runs;
    const gn_triangle_tree *tree;
    /* From the tree's space to column, row (texels) and depth where orthographic; else to (column,
     * row) * w relative to the centre of projection, and w. */
    float rows[3][4];
    float unit; /* length in the tree's space of one metre */
} gn_depth_draw;

/* A run that can be seen, and the tiles that it touches: columns and rows [first, last]. */
typedef struct gn_depth_run {
    uint32_t draw, run;
    uint16_t first[2], last[2];
} gn_depth_run;

typedef struct gn_depth_frame {
    const gn_depth_job *job;
    const gn_accel *accel;
    const float (*samples)[2];    /* job->samples places in a texel */
    float sample_min, sample_max; /* of both coordinates */
    float centre;                 /* of projection, in texels */
    float depth_scale;            /* 1 / (far - near) */
    gn_depth_draw *draws;
    const gn_depth_run *runs;
    uint32_t tiles;                           /* a side */
    const uint32_t *first_in_tile, *in_tiles; /* runs of each tile, front to back */
    float **buffers;                          /* a thread's tile: samples * GN_DEPTH_TILE^2 */
    gn_rect *covered;                         /* a tile's */
} gn_depth_frame;

/* Draws a tile and writes it out. */
typedef void (*gn_depth_tile)(const gn_depth_frame *frame, uint32_t tile, float *buffer);

/* One packet of the ray oracle: 16 samples of sample plane `sample` at a 4x4 block of texels. */
typedef struct gn_depth_rays {
    const gn_depth_job *job;
    const gn_accel *accel;
    const float (*samples)[2];
    float start; /* metres along forward where orthographic rays begin */
    uint32_t mask;
} gn_depth_rays;

typedef void (*gn_depth_packet)(const gn_depth_rays *rays, uint32_t sample, uint32_t bx,
                                uint32_t by);

#endif
