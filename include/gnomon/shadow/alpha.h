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
 * alpha passes the test, taking alpha as linear there: a ramp one footprint wide around the cutoff.
 * slope: length of alpha's gradient, per texel of mip 0; footprint: in such texels, > 0. */
GN_FN real gn_alpha_ramp(real alpha, real cutoff, real slope, real footprint)
{
    real width = gn_max(slope * footprint, K(1e-6f));
    return gn_clamp((alpha - cutoff) / width + 0.5f, K(0.0f), K(1.0f));
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
 * Optical depth of an opacity in [0,1], in 1/65536 of a halving of the light: -log2(1 - opacity),
 * at most 16 halvings, so that 4096 occluders fit 32 bits. */
GN_FN lint gn_optical_depth(real opacity)
{
    real through = gn_max(1.0f - opacity, K(1.52587890625e-5f));
    return gn_to_int(gn_max(-gn_log2(through), K(0.0f)) * 65536.0f + 0.5f);
}

/* Visibility behind occluders whose optical depths add up to depth >= 0. */
GN_FN real gn_optical_visibility(lint depth)
{
    return gn_exp2(gn_to_real(depth) * -1.52587890625e-5f);
}

#include "dialect_end.h"

#endif
