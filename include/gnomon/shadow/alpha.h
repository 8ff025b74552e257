/* What an alpha-tested occluder does to a shadow ray.
 *
 * This work is based on:
 *   Felix Brull, Rene Kern, Thorsten Grosch. Alias-Free Shadows with Ray Cones for Alpha Tested
 *   Geometry. VMV 2025, section 3.3, and the authors' reference snippet
 *
 * alpha: [0,1], read at the ray cone's level of detail. cutoff: the material's, (0,1].
 * Every rule returns an opacity: the share of light, [0,1], that the occluder takes. */
#ifndef GNOMON_SHADOW_ALPHA_H
#define GNOMON_SHADOW_ALPHA_H

#include "dialect.h"

/* Raw: alpha itself. Soft, since the camera sees texels over the cutoff as wholly opaque. */
GN_FN real gn_alpha_raw(real alpha)
{
    return alpha;
}

/* Alpha test: binary. alpha >= cutoff is opaque, glTF's rule and the snippet's (the paper's text
 * has >). At mip 0 this is what engines do without ray cones. */
GN_FN real gn_alpha_test(real alpha, real cutoff)
{
    return gn_select(alpha >= cutoff, K(1.0f), K(0.0f));
}

/* Saturate: min(alpha / cutoff, 1); the paper's min(2 alpha, 1) is the case of cutoff 0.5. */
GN_FN real gn_alpha_saturate(real alpha, real cutoff)
{
    return gn_min(alpha / cutoff, K(1.0f));
}

/* Magnified coverage, our own: the share of a footprint smaller than a texel where the interpolated
 * alpha passes the test, taking alpha as linear there and the footprint as a square along its
 * gradient: a ramp one footprint wide around the cutoff. Where alpha is constant, the test itself.
 * slope: length of alpha's gradient, per texel of mip 0; footprint: in such texels, > 0. */
GN_FN real gn_alpha_ramp(real alpha, real cutoff, real slope, real footprint)
{
    real width = slope * footprint;
    real share = gn_clamp((alpha - cutoff) / gn_max(width, K(1e-6f)) + 0.5f, K(0.0f), K(1.0f));
    return gn_select(width > 1e-6f, share, gn_alpha_test(alpha, cutoff));
}

/* Accumulation: visibility behind one more occluder; start with 1. */
GN_FN real gn_visibility_accumulate(real visibility, real opacity)
{
    return visibility * (1.0f - opacity);
}

/* The end of a ray: a visibility below the cutoff counts as none, and the rest is stretched to
 * [0,1], as the snippet does, so that nothing jumps at the cutoff. cutoff: [0,1). */
GN_FN real gn_visibility_rescale(real visibility, real cutoff)
{
    return gn_clamp((visibility - cutoff) / (1.0f - cutoff), K(0.0f), K(1.0f));
}

/* Accumulation that does not depend on the order of the occluders: a sum of integers. A tree gives
 * a ray's occluders in an order that may change with the number of threads that built it, and a
 * product of floats would then change in its last bits.
 *
 * Optical depth is -log2(1 - opacity), an opacity in [0,1], at most 16 halvings of the light, in
 * 1/GN_OPTICAL_HALVING of a halving: 4096 occluders sum up to 2^30 at most. */
#define GN_OPTICAL_HALVING 16384.0f

GN_FN lint gn_optical_depth(real opacity)
{
    real through = gn_max(1.0f - opacity, K(1.52587890625e-5f));
    return gn_to_int(gn_max(-gn_log2(through), K(0.0f)) * GN_OPTICAL_HALVING + 0.5f);
}

/* Visibility behind n occluders whose optical depths add up to depth >= 0. Against the product of
 * their 1 - opacity: a relative error < 2.4e-5 n, and 2^-16 at most for what a wholly opaque one
 * still lets through. */
GN_FN real gn_optical_visibility(lint depth)
{
    return gn_exp2(gn_to_real(depth) * (-1.0f / GN_OPTICAL_HALVING));
}

#include "dialect_end.h"

#endif
