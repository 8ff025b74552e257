#include <gnomon/method.h>

#include <string.h>

/* Papers. */
#define RAY_CONES    "Alias-Free Shadows with Ray Cones for Alpha Tested Geometry (VMV 2025)"
#define LEAK_TRACING "Leak Tracing (SR 2024)"
#define NONLINEAR    "Non-Linearly Quantized Moment Shadow Maps (HPG 2017)"

#define RAY(name, description, paper, alpha)                                                       \
    &(const gn_method)                                                                             \
    {                                                                                              \
        name, description, paper, {.kind = GN_MAP_NONE}, GN_TRACE_ALL, false, alpha                \
    }
/* What is left: the members of gn_map_format. Maps test alpha, so that is what they stand beside.*/
#define MAP(name, description, paper, ...)                                                         \
    &(const gn_method)                                                                             \
    {                                                                                              \
        name, description, paper, {__VA_ARGS__}, GN_TRACE_NONE, false, GN_ALPHA_RULE_TEST          \
    }
/* Leak tracing over the same maps, with its mask or by the test alone. */
#define LEAK(name, description, paper, mask, ...)                                                  \
    &(const gn_method)                                                                             \
    {                                                                                              \
        name, description, paper, {__VA_ARGS__}, GN_TRACE_LEAK, mask, GN_ALPHA_RULE_SATURATE       \
    }
#define EVSM(bits_, positive, negative)                                                            \
    .kind = GN_MAP_EVSM, .bits = (bits_), .positive_exponent = (positive),                         \
    .negative_exponent = (negative)

const gn_method *const gn_methods[] = {
    RAY("ray-mip0", "a ray a pixel, alpha test in mip 0: exact, flickers in foliage", "",
        GN_ALPHA_RULE_MIP0),
    RAY("ray-raw", "a ray cone a pixel, alpha itself is blocked: steady, too soft", RAY_CONES,
        GN_ALPHA_RULE_RAW),
    RAY("ray-test", "a ray cone a pixel, alpha test in the mip: hard, still flickers", RAY_CONES,
        GN_ALPHA_RULE_TEST),
    RAY("ray-saturate", "a ray cone a pixel, saturated alpha: steady, a little thick", RAY_CONES,
        GN_ALPHA_RULE_SATURATE),
    RAY("ray-coverage",
        "a ray cone a pixel, mips of the thresholded alpha: steady, neither thick nor soft", "",
        GN_ALPHA_RULE_COVERAGE),
    MAP("sm", "a shadow map, one depth compared: hard, blocky", "", .kind = GN_MAP_DEPTH,
        .bits = 32),
    MAP("pcf", "a shadow map, four depths compared and blended", "", .kind = GN_MAP_PCF, .bits = 32,
        .pcf_width = 2),
    MAP("pcf9", "a shadow map, 9x9 depths compared with Gaussian weights: soft, dear a pixel", "",
        .kind = GN_MAP_PCF, .bits = 32, .pcf_width = 9),
    MAP("vsm32", "two moments in 32 bits: cheap, leaks light", NONLINEAR, .kind = GN_MAP_VSM,
        .bits = 32),
    MAP("vsm", "two moments in 64 bits: leaks light behind overlapping casters", LEAK_TRACING,
        .kind = GN_MAP_VSM, .bits = 64),
    MAP("esm", "one exponential in 32 bits: leaks light near contacts", LEAK_TRACING,
        .kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 80.0f),
    MAP("evsm", "two exponentials and their squares in 128 bits, exponents 20 and 5", LEAK_TRACING,
        EVSM(128, 20.0f, 5.0f)),
    MAP("evsm2", "one exponential and its square in 64 bits, exponent 40", "",
        EVSM(64, 40.0f, 0.0f), .one_sided = true),
    MAP("evsm64", "two exponentials and their squares in 64 bits, exponents 5.5", NONLINEAR,
        EVSM(64, 5.5f, 5.5f)),
    MAP("evsm128", "two exponentials and their squares in 128 bits, exponents 40 and 5.5",
        NONLINEAR, EVSM(128, 40.0f, 5.5f)),
    MAP("msm64", "four moments in 64 bits: leaks light over short range", NONLINEAR,
        .kind = GN_MAP_MSM, .bits = 64),
    MAP("msm128", "four moments in 128 bits: little light leaks", NONLINEAR, .kind = GN_MAP_MSM,
        .bits = 128),
    MAP("msm-hausdorff",
        "four moments in 128 bits, bounded for depths within the map: msm128, hardly darker", "",
        .kind = GN_MAP_MSM, .bits = 128, .bound = GN_BOUND_HAUSDORFF),
    MAP("nlmsm64", "four moments, quantized non-linearly to 64 bits: as msm128 at half its memory",
        NONLINEAR, .kind = GN_MAP_NLMSM, .bits = 64),
    MAP("nlmsm32", "four moments, quantized non-linearly to 32 bits: little leaks, some banding",
        NONLINEAR, .kind = GN_MAP_NLMSM, .bits = 32),
    MAP("sd-vsm", "plain depth, two moments made of the four depths that are read", LEAK_TRACING,
        .kind = GN_MAP_VSM, .bits = 64, .single_depth = true),
    MAP("sd-esm", "plain depth, exponentials made of the four depths that are read", "",
        .kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 80.0f, .single_depth = true),
    MAP("sd-evsm", "plain depth, exponentials and squares made of the four depths that are read",
        LEAK_TRACING, EVSM(128, 20.0f, 5.0f), .single_depth = true),
    MAP("sd-msm", "plain depth, four moments made of the four depths that are read", LEAK_TRACING,
        .kind = GN_MAP_MSM, .bits = 128, .single_depth = true),
    LEAK("lt-vsm", "leak tracing over two moments: rays at edges and leaks alone", LEAK_TRACING,
         true, .kind = GN_MAP_VSM, .bits = 64, .single_depth = true),
    LEAK("lt-evsm", "leak tracing over exponentials and squares: a little surer than lt-vsm",
         LEAK_TRACING, true, EVSM(128, 20.0f, 5.0f), .single_depth = true),
    LEAK("lt-esm", "leak tracing over exponentials: more rays, and errors that lt-vsm has not",
         LEAK_TRACING, true, .kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 80.0f,
         .single_depth = true),
    LEAK("lt-msm", "leak tracing over four moments", LEAK_TRACING, true, .kind = GN_MAP_MSM,
         .bits = 128, .single_depth = true),
    LEAK("lt-nlmsm64", "leak tracing over filtered moments of 64 bits", "", true,
         .kind = GN_MAP_NLMSM, .bits = 64),
    LEAK("lt-nlmsm32", "leak tracing over filtered moments of 32 bits", "", true,
         .kind = GN_MAP_NLMSM, .bits = 32),
    LEAK("ltt-vsm", "the leak test alone over two moments: no mask, some errors", LEAK_TRACING,
         false, .kind = GN_MAP_VSM, .bits = 64, .single_depth = true),
    LEAK("ltt-evsm", "the leak test alone over exponentials and squares", LEAK_TRACING, false,
         EVSM(128, 20.0f, 5.0f), .single_depth = true),
    LEAK("ltt-esm", "the leak test alone over exponentials", LEAK_TRACING, false,
         .kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 80.0f, .single_depth = true),
    LEAK("ltt-msm", "the leak test alone over four moments", LEAK_TRACING, false,
         .kind = GN_MAP_MSM, .bits = 128, .single_depth = true),
    LEAK("ltt-nlmsm64", "the leak test alone over filtered moments of 64 bits", "", false,
         .kind = GN_MAP_NLMSM, .bits = 64),
    LEAK("ltt-nlmsm32", "the leak test alone over filtered moments of 32 bits", "", false,
         .kind = GN_MAP_NLMSM, .bits = 32),
    LEAK("hybrid-pcf", "rays where four depths disagree (AMD 2021), with leak tracing's mask",
         LEAK_TRACING, true, .kind = GN_MAP_PCF, .bits = 32, .pcf_width = 2),
    NULL,
};

/* The default among the rays; the measurements are in docs/benchmarks.md. */
#define DEFAULT_RAY "ray-coverage"

const gn_method *gn_method_find(const char *name)
{
    if (!name)
        return NULL;
    if (strcmp(name, "ray") == 0)
        name = DEFAULT_RAY;
    for (const gn_method *const *method = gn_methods; *method; method++)
        if (strcmp((*method)->name, name) == 0)
            return *method;
    return NULL;
}
