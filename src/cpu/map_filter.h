/* The rows that the map filter is made of. What is compiled once for each instruction set is here;
 * map_filter.c puts rows together to blocks, and benchmarks/three_pass.c to passes.
 *
 * A row of vectors is one plane of floats for each channel, `stride` floats apart. */
#ifndef GN_CPU_MAP_FILTER_H
#define GN_CPU_MAP_FILTER_H

#include "cpu/map.h"

#define GN_MAX_CHANNELS 4u
#define GN_MAX_RADIUS   16u

/* Floats that must be there, with any values, on both sides of a row that is filtered across. */
#define GN_ACROSS_MARGIN 32u

/* Texels by the layout of their words (map.h). */
typedef enum gn_texel_layout {
    GN_TEXEL_VSM32,
    GN_TEXEL_VSM64,
    GN_TEXEL_ESM32,
    GN_TEXEL_EVSM64,
    GN_TEXEL_EVSM64_ONE_SIDED,
    GN_TEXEL_EVSM128,
    GN_TEXEL_MSM64,
    GN_TEXEL_MSM128,
    GN_TEXEL_NLMSM64,
    GN_TEXEL_NLMSM32
} gn_texel_layout;

/* format has texels (gn_map_has_texels) and was checked. */
gn_texel_layout gn_map_layout(const gn_map_format *format);

/* Channels of the vectors that a format filters: 1, 2 or 4. */
uint32_t gn_map_channels(const gn_map_format *format);

/* Half of a symmetric filter: weights[0] is the middle's. The sum goes from the outermost pair to
 * the middle, and is 1 to the bit in that order. */
typedef struct gn_gaussian {
    uint32_t radius; /* <= GN_MAX_RADIUS */
    float weights[GN_MAX_RADIUS + 1];
} gn_gaussian;

/* width: odd, at most 2 GN_MAX_RADIUS + 1; sigma in texels. */
gn_gaussian gn_gaussian_make(uint32_t width, float sigma);

typedef struct gn_filter_rows {
    /* Vectors of the texels [x, x + count) of row y, averaged over their samples. */
    void (*read)(const gn_filter_job *job, uint32_t x, uint32_t y, uint32_t count, float *vectors,
                 size_t stride);
    /* out[i] from in[i - radius] .. in[i + radius]; GN_ACROSS_MARGIN. */
    void (*across)(const gn_gaussian *gaussian, const float *in, uint32_t count, float *out);
    /* out[i] from rows[0][i] .. rows[2 radius][i]. */
    void (*down)(const gn_gaussian *gaussian, const float *const *rows, uint32_t count, float *out);
    /* Biases (MSM, NLMSM; bias 0 changes nothing) and packs into texels. Overwrites vectors. */
    void (*encode)(const gn_map_format *format, float bias, float *vectors, size_t stride,
                   uint32_t count, uint32_t *texels);
    /* What encode was given, but for the rounding. Linear formats. */
    void (*decode)(const gn_map_format *format, const uint32_t *texels, uint32_t count,
                   float *vectors, size_t stride);
} gn_filter_rows;

#endif
