/* Leak tracing on the CPU device: map test, mask, compaction and rays, tile by tile. */
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

/* Pixels a side of one thread's piece of work. Rays are squeezed together in it: larger pieces have
 * fuller packets. */
enum { GN_LEAK_TILE = 64, GN_LEAK_PIXELS = GN_LEAK_TILE * GN_LEAK_TILE };

/* The rays that a tile asks for, and where their answers go. */
typedef struct gn_leak_rays {
    uint32_t count;
    float origin[3][GN_LEAK_PIXELS], direction[3][GN_LEAK_PIXELS];
    float distance[GN_LEAK_PIXELS], cone_width[GN_LEAK_PIXELS], cone_angle[GN_LEAK_PIXELS];
    uint32_t pixels[GN_LEAK_PIXELS];
    uint8_t states[GN_LEAK_PIXELS]; /* of the mask, but for the ray's answer */
} gn_leak_rays;

typedef struct gn_leak_thread {
    gn_leak_rays rays;
    gn_leak_counts counts;
    uint64_t traced;
    double test_ms, trace_ms;
} gn_leak_thread;

typedef struct gn_leak_run {
    const gn_leak_job *job;
    const gn_map_reader *reader;
    bool masked; /* the method has a mask: what it has not seen gets a ray */
    float jitter_x, jitter_y;
    gn_leak_thread *threads;
} gn_leak_run;

#endif
