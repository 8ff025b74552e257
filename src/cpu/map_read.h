/* Reading shadow maps: what is prepared once a call, and the same for all its tiles. */
#ifndef GN_CPU_MAP_READ_H
#define GN_CPU_MAP_READ_H

#include "cpu/map.h"

#define GN_PCF_TAPS 34u /* columns of the widest window: 33, and one more between texels */

/* The chain of mips of a layer: sides, and where each level starts, in texels. */
typedef struct gn_map_levels {
    uint32_t count; /* >= 1 */
    uint32_t size[GN_MAX_LEVELS], offset[GN_MAX_LEVELS];
} gn_map_levels;

typedef struct gn_map_reader {
    const gn_map_job *job;
    gn_map_reading reading; /* PCF of four texels is always BILINEAR */
    float cos_outer;        /* of a spot light's outer cone */
    float margin;           /* gn_map_margin() */
    bool even;              /* the four depths of PCF and DEPTH weigh the same (leak tracing) */
    gn_map_levels levels[GN_MAX_CASCADES];
    const uint8_t *noise; /* the frame's tile */
    gn_noise_place place;
    float weights[GN_PCF_TAPS + 1]; /* of PCF: 0, then pcf_width of them, then 0 */
} gn_map_reader;

/* Prepares a reader for a job, which must outlive it. */
gn_result gn_map_reader_make(gn_context *context, const gn_map_job *job, gn_map_reader *reader);

#endif
