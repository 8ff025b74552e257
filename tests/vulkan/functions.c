/* Every function of tests/lanes/functions.h, on the same inputs in scalar C and in GLSL. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "checks.h"
#include "lanes/lanes.h"

enum { COUNT = 1 << 16, GROUP = 64 };

static float in_planes[GN_LANE_INPUTS][COUNT], expected[GN_LANE_OUTPUTS][COUNT];

static uint32_t bits(float x)
{
    uint32_t i;
    memcpy(&i, &x, sizeof i);
    return isnan(x) ? 0x7fc00000u : i;
}

/* By how much a value may differ where arithmetic is not precise: by absolute, or by relative times
 * itself. lavapipe multiplies constants with each other first, as in (2^(a b)) with a constant b.
 */
typedef struct bound {
    const char *name;
    double absolute, relative;
} bound;

static const bound bounds[] = {
    {"bilinear_blend", 1.2e-7, 0},
    /* Exponents of up to 84, an exponential's relative error is their absolute one. */
    {"exponential_warp", 0, 2e-5},
    {"esm_visibility", 2e-5, 0},
    {"evsm_positive_of", 0, 4e-5},
    {"evsm_bound", 2.4e-7, 0},
    {"evsm_positive_visibility", 1e-4, 0},
    {"evsm_of", 0, 4e-5},
    {"evsm_visibility", 1e-4, 0},
    {"light_ahead", 4.8e-7, 0},
    {"moments_quantize", 2.4e-7, 0},
    {"moments_dequantize", 2.4e-7, 0},
    {"nonlinear_unpack64", 0, 2e-5},
};

static bound bound_of(const char *name, bool precise)
{
    for (size_t i = 0; !precise && i < sizeof bounds / sizeof *bounds; i++)
        if (strcmp(bounds[i].name, name) == 0)
            return bounds[i];
    return (bound){name, 0, 0}; /* the same bits */
}

/* Compares a function's values, prints the worst errors, and the first value beyond the bound. */
static bool compare(bound b, const float *out)
{
    double absolute = 0, relative = 0;
    size_t different = 0, bad = 0, first = 0;
    for (size_t i = 0; i < (size_t)GN_LANE_OUTPUTS * COUNT; i++) {
        const float e = expected[i / COUNT][i % COUNT];
        if (bits(e) == bits(out[i]))
            continue;
        different++;
        const double error = fabs((double)out[i] - (double)e);
        absolute = fmax(absolute, error);
        relative = fmax(relative, error / fabs((double)e));
        const double allowed = fmax(b.absolute, b.relative * fabs((double)e));
        if (!(error > 0 && error <= allowed) && bad++ == 0) /* nor zeros of another sign */
            first = i;
    }
    printf("%-28s %6zu differ, at most by %.3g, relative %.3g\n", b.name, different, absolute,
           relative);
    if (bad > 0) {
        const size_t i = first % COUNT;
        printf("FAILED: %s(%a, %a, %a) value %zu is %a, in C %a; %zu values beyond %g or %g\n",
               b.name, (double)in_planes[0][i], (double)in_planes[1][i], (double)in_planes[2][i],
               first / COUNT, (double)out[first], (double)expected[first / COUNT][i], bad,
               b.absolute, b.relative);
    }
    return bad == 0;
}

bool gn_check_functions(const gn_compute *compute, const uint32_t *spirv, size_t bytes,
                        bool precise)
{
    float *in[GN_LANE_INPUTS], *out[GN_LANE_OUTPUTS];
    for (int plane = 0; plane < GN_LANE_INPUTS; plane++)
        in[plane] = in_planes[plane];
    for (int plane = 0; plane < GN_LANE_OUTPUTS; plane++)
        out[plane] = expected[plane];

    gn_compute_program program;
    gn_compute_program_make(compute, spirv, bytes, sizeof in_planes, sizeof expected, &program);
    bool good = true;
    uint32_t f = 0;
    for (; gn_lane_functions_1[f].name; f++) {
        const gn_lane_function *function = &gn_lane_functions_1[f];
        gn_lane_inputs(function->domain, f, in, COUNT);
        memset(expected, 0, sizeof expected);
        function->run((const float *const *)in, out, COUNT);

        memcpy(program.in, in_planes, sizeof in_planes);
        memset(program.out, 0, sizeof expected);
        gn_compute_program_run(compute, &program, (const uint32_t[4]){f, COUNT}, COUNT / GROUP);
        good = compare(bound_of(function->name, precise), program.out) && good;
    }
    printf("%u functions, %d inputs each\n", f, COUNT);
    gn_compute_program_free(compute, &program);
    return good;
}
