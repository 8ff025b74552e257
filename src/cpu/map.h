/* Shadow maps on the CPU device: depth, filter, reading. */
#ifndef GN_CPU_MAP_H
#define GN_CPU_MAP_H

#include <gnomon/view.h>

#include "scene/scene.h"

struct gn_cpu;

/* Where a layer looks; the formulas are at gn_map_layer_info. */
typedef struct gn_map_projection {
    float origin[3], right[3], up[3], forward[3];
    bool perspective;
    float extent, near, far;
    uint32_t resolution;
} gn_map_projection;

/* Sides of a texel at distance w along forward, metres. */
static inline float gn_map_texel_size(const gn_map_projection *p, float w)
{
    return 2.0f * p->extent * (p->perspective ? w : 1.0f) / (float)p->resolution;
}

/* Moving casters are those of nodes with gn_node.animated. */
typedef enum gn_casters {
    GN_CASTERS_STATIC = 0,
    GN_CASTERS_DYNAMIC = 1,
    GN_CASTERS_ALL = 2
} gn_casters;

/* A rectangle of texels: columns [x0, x1), rows [y0, y1). Empty where x0 >= x1. */
typedef struct gn_rect {
    uint32_t x0, y0, x1, y1;
} gn_rect;

/* Depth ---------------------------------------------------------------------------------------*/

/* Draws casters into depth: `samples` planes of resolution^2 floats, cleared to 1 first. Sample 0
 * of 1 is the texel's centre; of 4 they are gn_map_samples. All triangles count, whichever way they
 * face. What lies nearer than `near` gets depth 0 (orthographic) or is left out (perspective). */
typedef struct gn_depth_job {
    const gn_scene *scene;
    gn_map_projection projection;
    gn_casters casters;
    gn_map_alpha alpha;
    uint32_t samples;
    uint32_t part, parts; /* this part of so many alone, [0, parts); parts 0: everything. Parts draw
                             different texels: all of them together are the whole, bit for bit, in
                             any order */
    float *depth;
    const gn_rect *stale; /* NULL: depth holds anything. Else it is 1 outside this rectangle, and
                             tiles outside that nothing is drawn into are not written */
    gn_rect covered;      /* out: holds every texel of the part that is not 1 */
} gn_depth_job;

extern const float gn_map_samples[4][2]; /* in the texel, [0,1]: the standard pattern of four */

/* By tiles and SIMD. */
gn_result gn_cpu_depth(const struct gn_cpu *cpu, gn_depth_job *job);
/* By ray packets: the oracle. */
gn_result gn_cpu_depth_rays(const struct gn_cpu *cpu, gn_depth_job *job);

/* Texels --------------------------------------------------------------------------------------*/

/* A texel is bits / 32 words. Layout of the words, low bits first:
 *   VSM 32   unorm16 mean, square              VSM 64    float mean, square
 *   ESM 32   float                             EVSM 64   half c+: mean, square, c-: mean, square;
 *   EVSM 128 the same as four floats                     one-sided: float mean, square
 *   MSM 64   unorm16 q1..q4 (affine)           MSM 128   float b1..b4
 *   NLMSM 64 unorm16 y1, y2, v2, Psi4(xi4)     NLMSM 32  gn_nonlinear_pack32()
 * MSM and NLMSM are biased before they are stored (Hamburger needs it on what it reads). */
static inline uint32_t gn_map_words(const gn_map_format *format)
{
    return format->bits / 32u;
}

/* Does the format keep texels beside depth? Else depth itself is read. */
static inline bool gn_map_has_texels(const gn_map_format *format)
{
    return format->kind != GN_MAP_DEPTH && format->kind != GN_MAP_PCF && !format->single_depth;
}

/* Resolve, vector, filter, quantization of one layer's rectangle, block by block in cache. Weights
 * at the layer's border stop at the edge texel (clamped). The result of a texel does not depend on
 * rect, threads or instruction set. desc and format were checked and resolved. */
typedef struct gn_filter_job {
    gn_map_format format;
    uint32_t resolution, samples;
    uint32_t width;       /* of the filter, odd */
    float sigma;          /* texels */
    float moment_bias;    /* MSM, NLMSM */
    const float *depth;   /* static casters */
    const float *dynamic; /* moving casters, or NULL; the nearer counts, sample by sample */
    gn_rect rect;
    uint32_t *texels; /* resolution^2 texels */
} gn_filter_job;

gn_result gn_cpu_filter(const struct gn_cpu *cpu, const gn_filter_job *job);

/* Texels of a chain of mips, level 0 with it; resolution need not be a power of two (rounded down,
 * at least 1). */
size_t gn_map_chain_texels(uint32_t resolution, bool mip_maps);
/* Fills levels 1 and up behind level 0, averaging 2x2 in the format's own (linear) values. */
void gn_cpu_map_mips(const struct gn_cpu *cpu, const gn_map_format *format, uint32_t resolution,
                     uint32_t *texels);

/* Reading -------------------------------------------------------------------------------------*/

typedef struct gn_map_layer {
    gn_map_projection projection;
    uint32_t index;   /* which cascade or face it is: some may not be drawn yet, and are left out */
    float *depth[2];  /* by gn_casters: static, dynamic (NULL where nothing moves) */
    gn_rect touched;  /* texels that moving casters may have changed, filtering included */
    uint32_t *texels; /* a chain of mips where the map has them; NULL where depth is read */
} gn_map_layer;

/* Visibility of a light by its map: of each pixel the first layer that holds it: its texel with the
 * margin that filter and reading need, its depth in [0, 1] (a cascade need not reach as deep as the
 * scene). desc is resolved: no field negative, no GN_READING_AUTO. */
typedef struct gn_map_job {
    const gn_map_layer *layers;
    uint32_t layer_count;
    gn_map_format format;
    gn_map_desc desc;
    const gn_gbuffer *gbuffer;
    gn_light light;
    uint32_t frame;
    float *visibility; /* 0 where the surface faces away, or the light does not reach; 1 where no
                          layer holds the pixel */
    float *layer;      /* may be NULL */
} gn_map_job;

gn_result gn_cpu_map_visibility(const struct gn_cpu *cpu, const gn_map_job *job);

/* Refuses what is out of range, with the range in the message (map_desc.c). */
gn_result gn_map_desc_check(gn_context *context, const gn_map_format *format,
                            const gn_map_desc *desc);

/* The biases that a format needs where desc says "the format's own"; AUTO reading resolved. */
gn_map_desc gn_map_desc_resolve(const gn_map_format *format, const gn_map_desc *desc);

/* Texels around the one that a receiver lies in that reading may touch, and that must lie in the
 * layer: receivers nearer to its border belong to the next one. */
uint32_t gn_map_margin(const gn_map_format *format, const gn_map_desc *desc);

/* Blue noise: two channels of 8 bits, GN_NOISE_TILES tiles of GN_NOISE_SIZE^2 (blue_noise.c, made
 * at build time by void and cluster). Byte 2 * (y * size + x) + channel. */
enum { GN_NOISE_TILES = 64, GN_NOISE_SIZE = 64 };
const uint8_t *gn_blue_noise_tile(uint32_t tile);

/* The tile and offset of a frame (moment paper, section 4.2): even, and the same for the same seed
 * and frame. */
typedef struct gn_noise_place {
    uint32_t tile, x, y;
} gn_noise_place;
gn_noise_place gn_noise_of_frame(uint32_t seed, uint32_t frame);

#endif
