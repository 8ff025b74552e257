/* Leak tracing on the CPU device: map test, mask, compaction and rays, strip by strip. */
#ifndef GN_CPU_LEAK_H
#define GN_CPU_LEAK_H

#include "cpu/kernels.h"
#include "cpu/map_read.h"

/* The temporal mask of one light: 3 bits a pixel (gn_leak_class) in texels that hold those of all
 * lights, low bits first. `now` may hold other lights' bits, which stay. */
typedef struct gn_leak_mask {
    const uint8_t *before;     /* of the frame before; NULL: there is none */
    uint8_t *now;              /* NULL: no mask is written */
    uint32_t texel_bytes;      /* 1, 2, 4, 8 or 16 */
    uint32_t first_bit;        /* 3 * the light's slot; the 3 bits may lie in two bytes */
    const float *depth_before; /* along the camera's axis, of the frame before; NULL: not kept */
} gn_leak_mask;

/* One light of one frame. */
typedef struct gn_leak_job {
    gn_map_job map;         /* map and picture; visibility and layer are filled as by
                               gn_cpu_map_visibility(), with the rays' answers in place */
    gn_visibility_job rays; /* tracer, light and results; the same G-buffer and visibility */
    gn_leak_desc desc;      /* depth_test ON or OFF */
    gn_leak_mask mask;
    float *test, *traced, *leak_class; /* may be NULL */
    gn_leak_counts counts;             /* out */
    uint64_t traced_count;             /* out: rays */
    double test_ms, trace_ms;          /* out: the call's time, split as the threads spent theirs */
} gn_leak_job;

gn_result gn_cpu_leak(const struct gn_cpu *cpu, gn_leak_job *job, const gn_visibility_desc *desc);

/* What the driver (leak.c) and the inner loops (leak.inc) share ------------------------------- */

/* In the order of gn_leak_counts. */
enum {
    GN_COUNT_TESTED,
    GN_COUNT_UNSURE,
    GN_COUNT_EXPANDED,
    GN_COUNT_REMOVED,
    GN_COUNT_LOST,
    GN_COUNT_UNHELD,
    GN_LEAK_COUNTS
};

/* Columns of the blocks in which a strip's rays are traced. */
enum { GN_LEAK_BLOCK = 8 };

/* Columns that are tested row by row before the next ones: the rows read much the same texels. */
enum { GN_LEAK_COLUMNS = 640 };

/* A thread's room for one strip of the picture. */
typedef struct gn_leak_thread {
    uint32_t count;            /* pixels that get a ray */
    uint32_t *pixels, *sorted; /* row by row as they are found; block by block as they are traced */
    uint8_t *states;           /* of the mask, a pixel of the strip; what the ray finds is added */
    uint32_t *starts;          /* of blocks */
    uint8_t *flags;            /* of three rows, 2 more each */
    uint32_t counts[GN_LEAK_COUNTS][GN_PACKET]; /* of this strip, lane by lane */
    uint64_t sums[GN_LEAK_COUNTS], traced;
    double test_ms, trace_ms;
} gn_leak_thread;

typedef struct gn_leak_run {
    const gn_leak_job *job;
    const gn_map_reader *reader;
    bool masked; /* the method has a mask: what it has not seen gets a ray */
    float jitter_x, jitter_y;
    uint16_t *asks; /* what the mask of the frame before asks for, a pixel (leak.inc) */
    gn_leak_thread *threads;
} gn_leak_run;

#endif
