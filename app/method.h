/* Methods at work: names, settings of maps, visibility and what it costs. */
#ifndef GN_APP_METHOD_H
#define GN_APP_METHOD_H

#include "app.h"

/* One of gn_methods, one made of options, or a pseudo-method that only some commands know. Zero
 * and gn_app_release_methods() it. Does not move once it is used. */
typedef struct gn_app_method {
    const char *name;
    bool pseudo; /* there is no method; the command knows what the name means */
    gn_method method;
    gn_history *history; /* its maps, kept from frame to frame; NULL unless it has maps */
} gn_app_method;

#define GN_APP_MAX_METHODS 64

/* Adds what list names to methods: "a,b,c"; "all", "rays", "maps"; names with * and ?. pseudo:
 * other names, ending with NULL, or NULL. Returns the count, or 0 after saying what is wrong: exit
 * with GN_EXIT_USAGE. */
uint32_t gn_app_parse_methods(const char *command, const char *list, const char *const *pseudo,
                              gn_app_method methods[GN_APP_MAX_METHODS]);

/* One name. False after saying what is wrong. */
bool gn_app_parse_method(const char *command, const char *name, const char *const *pseudo,
                         gn_app_method *method);

/* A method by its parts, in place of a name (render). Counts are GN_NONE where not given. */
typedef struct gn_app_parts {
    uint32_t map, trace, alpha; /* gn_map_kind, gn_trace_rule, gn_alpha_rule */
    uint32_t bits, pcf_width;
    uint32_t bound; /* gn_moment_bound */
    bool single_depth, one_sided;
    char name[64]; /* of the method that was made */
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
                  "pixels that get a ray: all (the default without a map), none"),                 \
        GN_CHOICE("alpha", 0, "RULE", &(p).alpha, gn_app_alpha_names,                              \
                  "what a masked occluder does to a ray: mip0, raw, test, saturate, coverage")

/* In the order of gn_map_kind, gn_trace_rule, gn_alpha_rule and gn_moment_bound. */
extern const char *const gn_app_map_names[];
extern const char *const gn_app_trace_names[];
extern const char *const gn_app_alpha_names[];
extern const char *const gn_app_bound_names[];

gn_app_parts gn_app_parts_default(void);
bool gn_app_parts_given(const gn_app_parts *parts);
/* Returns GN_GO_ON, or GN_EXIT_USAGE after saying why they make no method. Its name lies in parts.
 */
int gn_app_combine_parts(const char *command, gn_app_parts *parts, gn_app_method *method);

/* The settings of maps by the options. */
gn_map_desc gn_app_map_desc(const gn_app_map_options *options);

/* Would the library make such a map? If not, it has said why. */
bool gn_app_accepts_map(gn_app *app, const gn_map_format *format, const gn_map_desc *desc);

/* Makes methods ready: app->map by the options, exponents, histories. After gn_app_open(). What the
 * library refuses is wrong usage. */
bool gn_app_use_methods(gn_app *app, gn_app_method *methods, uint32_t count);
/* Before gn_app_close(). */
void gn_app_release_methods(gn_app_method *methods, uint32_t count);

static inline bool gn_app_has_map(const gn_app_method *method)
{
    return !method->pseudo && method->method.map.kind != GN_MAP_NONE;
}

gn_visibility_desc gn_app_visibility_desc(const gn_app *app, const gn_app_method *method);

/* What it took: milliseconds, sums over the lights. */
typedef struct gn_app_cost {
    double total, shadow_map, filter, test, trace;
    uint64_t rays;
    uint32_t fitted; /* layers of maps that were placed anew */
} gn_app_cost;

/* Runs the visibility of all chosen lights on the G-buffer of frame app->frame, seen by
 * app->camera, into planes of width * height floats, one a light. cost may be NULL. */
bool gn_app_visibility(gn_app *app, const gn_gbuffer *gbuffer, gn_app_method *method, float *planes,
                       gn_app_cost *cost);

/* "ray-mip0": what wrong pixels are counted against. Needs no gn_app_use_methods(). */
gn_app_method gn_app_yardstick(void);

/* {"kind": "evsm", ...}, or null without a map. */
cJSON *gn_app_map_json(const gn_map_format *format);

#endif
