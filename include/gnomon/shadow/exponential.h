/* Exponential shadow maps.
 *
 * This work is based on:
 *   Thomas Annen, Tom Mertens, Hans-Peter Seidel et al. Exponential Shadow Maps. GI 2008
 *   Felix Brull, Rene Kern, Thorsten Grosch. Real-Time Pixel-Perfect Hard Shadows with Leak
 *   Tracing. SR 2024, section 2.1 (its printed max is a min)
 *
 * Depths d are in [0,1], 0 at the light's near end; the exponential is taken of z = 2d - 1. */
#ifndef GNOMON_SHADOW_EXPONENTIAL_H
#define GNOMON_SHADOW_EXPONENTIAL_H

#include "dialect.h"

/* e^(c z), relative error < 1.7e-7 |c| + 3e-7: nearly all of it a shift of the depth by less than
 * 9e-8, the same wherever a depth is used. depth: [0,1]; |c| <= 84. */
GN_FN real gn_exponential_warp(real depth, real c)
{
    return gn_exp2_inside((2.0f * depth - 1.0f) * (c * 1.44269504f));
}

/* What a texel holds; averages of it are filtered texels. c: (0, 84]. */
GN_FN real gn_esm_of(real depth, real c)
{
    return gn_exponential_warp(depth, c);
}

/* Markov's inequality: an upper bound of P(stored >= receiver), [0,1]; sharp over all distributions
 * on the real line with this moment. moment: >= 0, as gn_esm_of() and averages of it are. Receivers
 * beyond [0,1] are taken to its ends. */
GN_FN real gn_esm_visibility(real moment, real c, real receiver)
{
    real d = gn_clamp(receiver, K(0.0f), K(1.0f));
    return gn_min(moment * gn_exponential_warp(d, -c), K(1.0f));
}

#include "dialect_end.h"

#endif
