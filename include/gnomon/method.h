/* Methods: the ways of finding visibility, as data.
 *
 * A method is a point in a small space: what map the light stores, which pixels get a ray, and
 * what an alpha-tested occluder does to a ray. The command line, tests, benchmarks and documents
 * all iterate gn_methods. */
#ifndef GNOMON_METHOD_H
#define GNOMON_METHOD_H

#include <stdbool.h>
#include <gnomon/device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a MASK occluder of opacity alpha, read at the ray cone's level of detail, does to the light
 * that passes (ray cone paper, section 3.3). c is the material's alpha cutoff. */
typedef enum gn_alpha_rule {
    GN_ALPHA_RULE_MIP0 = 0,     /* binary: alpha of mip 0 >= c blocks; what engines do today */
    GN_ALPHA_RULE_RAW = 1,      /* alpha itself is blocked */
    GN_ALPHA_RULE_TEST = 2,     /* binary: alpha >= c blocks */
    GN_ALPHA_RULE_SATURATE = 3, /* min(alpha / c, 1) is blocked */
    GN_ALPHA_RULE_COVERAGE = 4  /* the share of the footprint that passes the test is blocked */
} gn_alpha_rule;

/* Which pixels get a shadow ray. */
typedef enum gn_trace_rule {
    GN_TRACE_ALL = 0,
    GN_TRACE_NONE = 1,
    GN_TRACE_LEAK = 2 /* those of which the map is unsure, and those that the mask of the frame
                         before asks for (leak tracing paper, section 3) */
} gn_trace_rule;

/* What the light's view stores. */
typedef enum gn_map_kind {
    GN_MAP_NONE = 0,
    GN_MAP_DEPTH = 1, /* plain depth, one comparison (Williams 1978) */
    GN_MAP_PCF = 2,   /* plain depth, percentage-closer filtering (Reeves et al. 1987) */
    GN_MAP_VSM = 3,   /* two moments (Donnelly and Lauritzen 2006) */
    GN_MAP_ESM = 4,   /* one exponential (Annen et al., Salvi 2008) */
    GN_MAP_EVSM = 5,  /* moments of exponentials (Lauritzen and McCool 2008) */
    GN_MAP_MSM = 6,   /* four moments (Peters and Klein 2015) */
    GN_MAP_NLMSM = 7  /* four moments, quantized non-linearly (Peters 2017) */
} gn_map_kind;

/* What is made of four moments. */
typedef enum gn_moment_bound { GN_BOUND_HAMBURGER = 0, GN_BOUND_HAUSDORFF = 1 } gn_moment_bound;

/* A texel of a map and how it is read. Checked by gn_shadow_map_create(). */
typedef struct gn_map_format {
    gn_map_kind kind;
    uint32_t bits;           /* a texel. DEPTH, PCF, ESM: 32; VSM: 32 (two 16-bit fixed-point
                                numbers) or 64 (two floats); EVSM: 64 (four 16-bit floats, or two
                                floats where one_sided) or 128; MSM: 64 (affine quantization) or
                                128; NLMSM: 32 or 64 */
    bool single_depth;       /* VSM, ESM, EVSM, MSM: keep plain depth (32 bits a texel, whatever
                                bits says) and build the vector from the 2x2 texels that are read
                                (leak tracing paper, section 3.2); no filter */
    bool one_sided;          /* EVSM: the positive exponential alone */
    float positive_exponent; /* EVSM: c+, ESM: c. (0, 42] for EVSM in floats, (0, 5.54] in 16-bit
                                floats, (0, 84] for ESM */
    float negative_exponent; /* EVSM: c-, ranges as c+ */
    uint32_t pcf_width;      /* PCF: 2 (the four texels around, bilinear weights), or an odd width
                                [3, 33] of a Gaussian with the map's filter_sigma */
    gn_moment_bound bound;   /* MSM */
} gn_map_format;

typedef struct gn_method {
    const char *name;        /* "ray-saturate" */
    const char *description; /* one line */
    const char *paper;       /* where it comes from, "" if our own */
    gn_map_format map;
    gn_trace_rule trace;
    bool mask;           /* LEAK: with the temporal mask (lt-*); else the test alone (ltt-*) */
    gn_alpha_rule alpha; /* of rays; maps have their own (gn_map_desc.alpha) */
} gn_method;

/* All presets, ending with NULL. */
GN_API extern const gn_method *const gn_methods[];

/* NULL where no preset has that name. "ray" is the default of the ray methods. */
GN_API const gn_method *gn_method_find(const char *name);

#ifdef __cplusplus
}
#endif

#endif
