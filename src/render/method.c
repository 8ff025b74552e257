#include <gnomon/method.h>

#include <string.h>

#define RAY_CONES "Alias-Free Shadows with Ray Cones for Alpha Tested Geometry (VMV 2025)"

static const gn_method ray_mip0 = {
    "ray-mip0",   "a ray a pixel, alpha test in mip 0: exact, flickers in foliage",
    "",           {.kind = GN_MAP_NONE},
    GN_TRACE_ALL, GN_ALPHA_RULE_MIP0};
static const gn_method ray_raw = {
    "ray-raw",    "a ray cone a pixel, alpha itself is blocked: steady, too soft",
    RAY_CONES,    {.kind = GN_MAP_NONE},
    GN_TRACE_ALL, GN_ALPHA_RULE_RAW};
static const gn_method ray_test = {
    "ray-test",   "a ray cone a pixel, alpha test in the mip: hard, still flickers",
    RAY_CONES,    {.kind = GN_MAP_NONE},
    GN_TRACE_ALL, GN_ALPHA_RULE_TEST};
static const gn_method ray_saturate = {
    "ray-saturate", "a ray cone a pixel, saturated alpha: steady, a little thick",
    RAY_CONES,      {.kind = GN_MAP_NONE},
    GN_TRACE_ALL,   GN_ALPHA_RULE_SATURATE};
static const gn_method ray_coverage = {
    "ray-coverage",
    "a ray cone a pixel, mips of the thresholded alpha: steady, neither thick nor soft",
    "",
    {.kind = GN_MAP_NONE},
    GN_TRACE_ALL,
    GN_ALPHA_RULE_COVERAGE};

const gn_method *const gn_methods[] = {&ray_mip0,     &ray_raw,      &ray_test,
                                       &ray_saturate, &ray_coverage, NULL};

const gn_method *gn_method_find(const char *name)
{
    if (!name)
        return NULL;
    /* The default among the rays; the measurements are in docs/benchmarks.md. */
    if (strcmp(name, "ray") == 0)
        return &ray_coverage;
    for (const gn_method *const *method = gn_methods; *method; method++)
        if (strcmp((*method)->name, name) == 0)
            return *method;
    return NULL;
}
