/* Methods at work: names, settings of maps, visibility and what it costs. */
#ifndef GN_APP_METHOD_H
#define GN_APP_METHOD_H

#include "app.h"

/* What a method's name says behind colons: settings of its own, in place of the options'. */
typedef struct gn_app_modifiers {
    gn_app_leak_options leak;
    uint32_t resolution, refresh, undrawn; /* GN_NONE: not given */
    uint32_t tracer;                       /* gn_tracer_kind; GN_NONE: not given */
    bool no_reuse;
} gn_app_modifiers;

/* One of gn_methods, perhaps modified, one made of options, or a pseudo-method that only some
 * commands know. Zero and gn_app_release_methods() it. Does not move once it is used. */
typedef struct gn_app_method {
    const char *name;
    bool pseudo; /* there is no method; the command knows what the name means */
    gn_method method;
    gn_app_modifiers own;
    char text[128]; /* the name, where it is no preset's */
    /* By gn_app_use_methods(). */
    gn_map_desc map;
    gn_leak_desc leak;
    bool no_reuse;       /* maps are made anew in every frame */
    gn_history *history; /* what it keeps from frame to frame; NULL for pseudo-methods */
} gn_app_method;

#define GN_APP_MAX_METHODS 64

/* Adds what list names to methods: "a,b,c"; "all", "rays", "maps", "leaks"; names with * and ?;
 * each perhaps with modifiers. pseudo: other names, ending with NULL, or NULL. Returns the count,
 * or 0 after saying what is wrong: exit with GN_EXIT_USAGE. */
uint32_t gn_app_parse_methods(const char *command, const char *list, const char *const *pseudo,
                              gn_app_method methods[GN_APP_MAX_METHODS]);

/* One name, perhaps with modifiers: "lt-vsm:mip0:no-remove". False after saying what is wrong. */
bool gn_app_parse_method(const char *command, const char *name, const char *const *pseudo,
                         gn_app_method *method);

/* Adds what ":mip0:no-remove" says to a method, name and all. False after saying what is wrong. */
bool gn_app_modify_method(const char *command, const char *modifiers, gn_app_method *method);

/* A method by its parts, in place of a name (render). Counts are GN_NONE where not given. */
typedef struct gn_app_parts {
    uint32_t map, trace, alpha; /* gn_map_kind, gn_trace_rule, gn_alpha_rule */
    uint32_t bits, pcf_width;
    uint32_t bound; /* gn_moment_bound */
    bool single_depth, one_sided, no_mask;
} gn_app_parts;

/* Lines for a command's option table. */
#define GN_APP_PARTS_OPTIONS(p)                                                                    \
    GN_CHOICE("map", 0, "KIND", &(p).map, gn_app_map_names,                                        \
              "none, depth, pcf, vsm, esm, evsm, msm, nlmsm; in place of --method"),               \
        GN_APP_COUNT("map-bits", "N", &(p).bits, "bits a texel: 32, 64 or 128"),                   \
        GN_APP_COUNT("pcf-width", "N", &(p).pcf_width,                                             \
                     "of --map pcf: 2, or an odd width of a Gaussian"),                            \
        GN_FLAG("single-depth", 0, &(p).single_depth,                                              \
                "keep plain depth, and make the map's vectors as they are read"),                  \
        GN_FLAG("one-sided", 0, &(p).one_sided, "of --map evsm: the positive exponential alone"),  \
        GN_CHOICE("bound", 0, "NAME", &(p).bound, gn_app_bound_names,                              \
                  "of --map msm: hamburger (the default), hausdorff"),                             \
        GN_CHOICE("trace", 0, "RULE", &(p).trace, gn_app_trace_names,                              \
                  "pixels that get a ray: all (the default without a map), none, leak"),           \
        GN_FLAG("no-mask", 0, &(p).no_mask, "of --trace leak: the test alone"),                    \
        GN_CHOICE("alpha", 0, "RULE", &(p).alpha, gn_app_alpha_names,                              \
                  "what a masked occluder does to a ray: mip0, raw, test, saturate, coverage")

/* In the order of gn_map_kind, gn_trace_rule, gn_alpha_rule and gn_moment_bound. */
extern const char *const gn_app_map_names[];
extern const char *const gn_app_trace_names[];
extern const char *const gn_app_alpha_names[];
extern const char *const gn_app_bound_names[];

gn_app_parts gn_app_parts_default(void);
bool gn_app_parts_given(const gn_app_parts *parts);
/* Returns GN_GO_ON, or GN_EXIT_USAGE after saying why they make no method. */
int gn_app_combine_parts(const char *command, const gn_app_parts *parts, gn_app_method *method);

/* The settings of maps by the options. */
gn_map_desc gn_app_map_desc(const gn_app_map_options *options);

/* Would the library make such a map? If not, it has said why. */
bool gn_app_accepts_map(gn_app *app, const gn_map_format *format, const gn_map_desc *desc);

/* Makes methods ready: settings by the options and by their names, exponents, histories. After
 * gn_app_open(). What the library refuses is wrong usage. */
bool gn_app_use_methods(gn_app *app, gn_app_method *methods, uint32_t count);
/* Before gn_app_close(). */
void gn_app_release_methods(gn_app_method *methods, uint32_t count);

static inline bool gn_app_has_map(const gn_app_method *method)
{
    return !method->pseudo && method->method.map.kind != GN_MAP_NONE;
}

/* Does it remember the rays of the frame before? Then each call is a frame of its own. */
static inline bool gn_app_has_mask(const gn_app_method *method)
{
    return !method->pseudo && method->method.trace == GN_TRACE_LEAK && method->method.mask;
}

static inline bool gn_app_has_rays(const gn_app_method *method)
{
    return !method->pseudo && method->method.trace != GN_TRACE_NONE;
}

/* Frames until a mask has settled. */
#define GN_APP_WARM_UP 8u

gn_visibility_desc gn_app_visibility_desc(const gn_app *app, const gn_app_method *method);

/* What answered rays, sums over lights, or over the frames too. */
typedef struct gn_app_tracing {
    uint32_t lights, buffered; /* how many; those that the light buffer answered */
    uint64_t rays;
    gn_light_buffer_info light_buffer;
} gn_app_tracing;

/* What it took: milliseconds, sums over the lights. */
typedef struct gn_app_cost {
    double total, shadow_map, filter, test, trace;
    gn_app_tracing tracing;
    uint32_t fitted, pending; /* layers of maps that were placed anew, that are being drawn */
    gn_leak_counts leak;
} gn_app_cost;

/* Runs the visibility of all chosen lights on the G-buffer of frame app->frame, seen by
 * app->camera, into planes of width * height floats, one a light. cost may be NULL. */
bool gn_app_visibility(gn_app *app, const gn_gbuffer *gbuffer, gn_app_method *method, float *planes,
                       gn_app_cost *cost);

/* "ray-mip0", the plain ray. Needs no gn_app_use_methods(), as the next. */
gn_app_method gn_app_yardstick(void);
/* What a method's wrong pixels are counted against: a ray for every pixel with the method's alpha
 * rule, of the tree where the method's name says its tracer; for maps and pseudo-methods the plain
 * ray. */
void gn_app_yardstick_of(const gn_app_method *method, gn_app_method *yardstick);

/* Adds up b to a. */
void gn_app_add_counts(gn_leak_counts *a, const gn_leak_counts *b);
/* {"tested": share of pixels, "unheld": likewise, "unsure": share of those tested, ...} */
cJSON *gn_app_leak_json(const gn_leak_counts *counts, double pixels);

/* The tracer that a method asks for: by its name, or else by the options. */
gn_tracer_kind gn_app_tracer(const gn_app *app, const gn_app_method *method);
/* Bytes that the light buffers of a method may take. */
size_t gn_app_light_buffer_limit(const gn_app *app);
double gn_app_megabytes(size_t bytes);

/* One light more. */
void gn_app_add_stats(gn_app_tracing *tracing, const gn_visibility_stats *stats);
/* Adds up b to a. */
void gn_app_add_tracing(gn_app_tracing *a, const gn_app_tracing *b);
/* "bvh", "light-buffer", or "both" where they differ from light to light or frame to frame. */
const char *gn_app_answered(const gn_app_tracing *tracing);
/* Did the tree trace what the light buffer was there for? Then says so. */
bool gn_app_fallback(const gn_app *app, const gn_app_method *method, const gn_app_tracing *tracing,
                     char text[256]);
/* Adds gn_app_fallback()'s text as "fallback", where there is one. */
void gn_app_add_fallback(cJSON *json, const gn_app *app, const gn_app_method *method,
                         const gn_app_tracing *tracing);
/* Adds "tracer", and where there is a light buffer "light_buffer". */
void gn_app_add_tracing_json(cJSON *json, const gn_app_tracing *tracing);

/* {"kind": "evsm", ...}, or null without a map. */
cJSON *gn_app_map_json(const gn_map_format *format);

#endif
