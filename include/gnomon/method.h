/* Methods: the ways of finding visibility, as data.
 *
 * A method is a point in a small space: what map the light stores, which pixels get a ray, and
 * what an alpha-tested occluder does to a ray. The command line, tests, benchmarks and documents
 * all iterate gn_methods. */
#ifndef GNOMON_METHOD_H
#define GNOMON_METHOD_H

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
typedef enum gn_trace_rule { GN_TRACE_ALL = 0 } gn_trace_rule;

/* What the light's view stores. */
typedef enum gn_map_kind { GN_MAP_NONE = 0 } gn_map_kind;

typedef struct gn_method {
    const char *name;        /* "ray-saturate" */
    const char *description; /* one line */
    const char *paper;       /* where it comes from, "" if our own */
    gn_map_kind map;
    gn_trace_rule trace;
    gn_alpha_rule alpha;
} gn_method;

/* All presets, ending with NULL. */
GN_API extern const gn_method *const gn_methods[];

/* NULL where no preset has that name. "ray" is the default of the ray methods. */
GN_API const gn_method *gn_method_find(const char *name);

#ifdef __cplusplus
}
#endif

#endif
