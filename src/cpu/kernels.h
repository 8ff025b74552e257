/* The CPU device's inner loops, compiled once for each instruction set. */
#ifndef GN_CPU_KERNELS_H
#define GN_CPU_KERNELS_H

#include <gnomon/view.h>

#include "cpu/accel.h"
#include "cpu/depth.h"
#include "cpu/map_filter.h"

#define GN_TILE   32u /* pixels a side; a tile is one thread's piece of work */
#define GN_PACKET 16u /* rays a packet */
#define GN_STRIP  8u  /* rows of a strip: a thread's piece of work where maps are read */

/* Shadow rays as a tracer gets them, those of a tile at most, and its answer. Directions have unit
 * length. Rays that lie close together should follow each other. */
enum { GN_RAYS = GN_TILE * GN_TILE };

/* Room for that many, and a line of the cache: were the arrays a multiple of 4 KiB, equal places of
 * all of them would share the few ways of one set of the first cache. */
enum { GN_RAY_ROOM = GN_RAYS + 16 };

typedef struct gn_shadow_rays {
    uint32_t count; /* <= GN_RAYS */
    float origin[3][GN_RAY_ROOM];
    float direction[3][GN_RAY_ROOM]; /* towards the light */
    float distance[GN_RAY_ROOM];     /* where the ray ends; INFINITY for a sun */
    float cone_width[GN_RAY_ROOM];   /* at the origin, before Hit */
    float cone_angle[GN_RAY_ROOM];
    float width[GN_RAY_ROOM];      /* of the pixel's cone at the surface: how far apart rays are */
    float visibility[GN_RAY_ROOM]; /* out: before the cutoff's rescaling; 0: blocked */
    float lod[GN_RAY_ROOM];        /* out, where statistics are asked for */
    float lookups[GN_RAY_ROOM];    /* out, likewise */
    float entries[GN_RAY_ROOM];    /* out, likewise: gn_visibility_stats.entries */
} gn_shadow_rays;

/* The ray query's context as the filters see it: Embree's own, and behind it ours. */
typedef struct gn_query {
    gn_rtc_context embree; /* must be first */
    const gn_accel *accel;
    const gn_depth_rays *map;                           /* rays of a shadow map; else NULL */
    float cone_width[GN_PACKET], cone_angle[GN_PACKET]; /* by ray id */
    /* Shadow rays only. */
    gn_alpha_rule rule;
    bool rescaled, statistics;
    int32_t depth_limit;
    int32_t depth[GN_PACKET]; /* optical depth so far (alpha.h) */
    float lod[GN_PACKET], lookups[GN_PACKET];
} gn_query;

/* A way to answer shadow rays: the seam behind which tree and light buffer stand. */
typedef struct gn_tracer {
    const gn_accel *accel;
    struct gn_light_buffer *buffer; /* NULL: the tree */
    bool patient; /* rays of tiles that are not there are left for later; else the tree traces them
                   */
    gn_alpha_rule rule;
    bool rescaled;   /* read the mips that keep their share of passing texels */
    bool statistics; /* fill lod and lookups; no early end, so that they do not depend on order */
    int32_t depth_limit; /* optical depth (alpha.h) at which a ray ends */
    /* false: a patient tracer left some for later; none is answered. */
    bool (*trace)(const struct gn_tracer *tracer, gn_shadow_rays *rays);
} gn_tracer;

typedef struct gn_visibility_job {
    gn_tracer tracer;
    const gn_gbuffer *gbuffer;
    gn_light light;
    float cos_outer; /* of a spot light's outer cone */
    float cutoff, point_light_clip;
    float *visibility;
    float *lod, *lookups, *entries; /* may be NULL */
    float *traced;                  /* may be NULL; 1 where there was a ray, 0 before */
    uint8_t *missed; /* of a patient tracer: set for each tile (gn_ray_tiles) without an answer */
} gn_visibility_job;

/* A perspective or orthographic camera ready to make rays. */
typedef struct gn_rays {
    float origin[3], right[3], up[3], back[3]; /* right and up scaled to half the view's size at
                                                   distance 1 (perspective) or as is */
    bool orthographic;
    float near;
    float cone_width, cone_angle; /* of one pixel, where the ray starts */
} gn_rays;

typedef struct gn_gbuffer_job {
    const gn_scene *scene;
    const gn_accel *accel;
    gn_rays now, before;
    const float *world_before; /* 16 a node: matrices of the frame before */
    float jitter[2];           /* pixels, where in the pixel the ray goes: 0.5 is the centre */
    gn_gbuffer *gbuffer;
} gn_gbuffer_job;

struct gn_map_reader;
struct gn_leak_run;

struct gn_light_buffer;
struct gn_light_tile;
struct gn_light_scratch;
typedef enum gn_light_outcome {
    GN_LIGHT_DONE,
    GN_LIGHT_TOO_MUCH, /* more triangles or entries than a tile is worth */
    GN_LIGHT_NO_MEMORY
} gn_light_outcome;
typedef gn_light_outcome (*gn_light_tile_builder)(const struct gn_light_buffer *buffer,
                                                  struct gn_light_tile *tile, gn_casters casters,
                                                  struct gn_light_scratch *scratch);

typedef struct gn_kernels {
    const char *name;
    RTCFilterFunctionN intersect_filter, occluded_filter;
    bool (*trace)(const gn_tracer *tracer, gn_shadow_rays *rays);
    bool (*trace_light)(const gn_tracer *tracer, gn_shadow_rays *rays);
    gn_light_tile_builder light_tile; /* light_buffer.h */
    void (*gbuffer_tile)(const gn_gbuffer_job *job, uint32_t tile);
    uint64_t (*visibility_tile)(const gn_visibility_job *job, uint32_t tile); /* rays traced */
    void (*map_strip)(const struct gn_map_reader *reader, uint32_t strip);    /* map_read.h */
    /* leak.h */
    void (*leak_ask)(const struct gn_leak_run *run, uint32_t strip, uint32_t thread);
    void (*leak_strip)(const struct gn_leak_run *run, uint32_t strip, uint32_t thread);
    gn_depth_tile depth_tile;
    gn_depth_packet depth_packet;
    gn_filter_rows filter;
} gn_kernels;

extern const gn_kernels gn_kernels_scalar;
extern const gn_kernels gn_kernels_avx2;
extern const gn_kernels gn_kernels_avx512;

/* The pixels whose shadow rays are made and traced together, GN_RAYS of them. The tree gets
 * squares, whose packets are compact; a light buffer sorts rays by itself, and long rows are read
 * faster. */
typedef struct gn_ray_tiles {
    uint32_t width, height; /* pixels of a tile */
    uint32_t across, count; /* tiles of the picture */
} gn_ray_tiles;

static inline gn_ray_tiles gn_ray_tiles_of(const gn_visibility_job *job)
{
    gn_ray_tiles t = {.width = GN_TILE, .height = GN_TILE};
    if (job->tracer.buffer) {
        t.width = 2 * GN_TILE;
        t.height = GN_TILE / 2;
    }
    t.across = (job->gbuffer->width + t.width - 1) / t.width;
    t.count = t.across * ((job->gbuffer->height + t.height - 1) / t.height);
    return t;
}

static inline uint32_t gn_strips(uint32_t rows)
{
    return (rows + GN_STRIP - 1) / GN_STRIP;
}

static inline uint32_t gn_tiles_across(uint32_t pixels)
{
    return (pixels + GN_TILE - 1) / GN_TILE;
}

#endif
