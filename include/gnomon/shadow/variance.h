/* Variance and exponential variance shadow maps.
 *
 * This work is based on:
 *   William Donnelly, Andrew Lauritzen. Variance Shadow Maps. I3D 2006
 *   Andrew Lauritzen, Michael McCool. Layered Variance Shadow Maps. GI 2008
 *   Felix Brull, Rene Kern, Thorsten Grosch. Real-Time Pixel-Perfect Hard Shadows with Leak
 *   Tracing. SR 2024, section 2.1
 *
 * Depths d are in [0,1], 0 at the light's near end. VSM keeps moments of d; EVSM keeps moments of
 * e^(c+ z) and -e^(-c- z) with z = 2d - 1. Every test returns visibility, an upper bound of
 * P(stored >= receiver).
 *
 * Minimum variance. Both moments are rounded, so their variance may come out too small, and a flat
 * surface would shadow itself. If the moments have the relative error e of their format and their
 * sums, the variance is wrong by 3 e square at most (for fixed point: by 3 e with e absolute); a
 * minimum variance of that size keeps the test a bound. It is *added* to the variance: a floor
 * under it (the papers' max) loses the bound wherever the true variance is of the floor's size.
 *
 * In the warped space of EVSM a depth that is off by s is off by |dw/dd| s = 2 c |w| s, so
 * minimum_variance, in squared depths, is multiplied by (2 c w)^2 at the receiver. Unscaled, it
 * would be lost beside w = e^40, where surfaces then shadow themselves. With e as above it should
 * be at least 3 e / (2 c)^2 for the smaller c:
 *     VSM 64: 1e-6; VSM 32: 3e-5; EVSM 128 (c- = 5 or 5.5): 1e-8; one-sided (c = 40): 1e-10;
 *     EVSM 64 in halves (5.5, 5.5; the squares get subnormal): 3e-5.
 * Then no test gives less than P(stored >= receiver) - 1e-6; 32-bit VSM 1e-5, halves 3e-3. */
#ifndef GNOMON_SHADOW_VARIANCE_H
#define GNOMON_SHADOW_VARIANCE_H

#include "exponential.h"

#include "dialect.h"

GN_STRUCT(gn_variance)
{
    real mean;
    real square; /* mean of the squares */
};

/* One-tailed Chebyshev inequality (Cantelli): the sharp upper bound of P(stored >= receiver) over
 * the distributions on the real line with this mean and this square + minimum_variance.
 * minimum_variance: >= 0; in the units of square, which may be those of a warped space. */
GN_FN real gn_chebyshev(real mean, real square, real minimum_variance, real receiver)
{
    /* 1.2e-38, the smallest normal float: the quotient is a number. */
    real variance = gn_max(square - mean * mean, K(0.0f)) + (minimum_variance + 1.17549435e-38f);
    real distance = receiver - mean;
    real bound = variance / (variance + distance * distance);
    return gn_select(distance > 0.0f, bound, K(1.0f));
}

GN_FN gn_variance gn_variance_of(real depth)
{
    return GN_MAKE2(gn_variance, depth, depth * depth);
}

/* minimum_variance: of depth, [0, 0.25]. */
GN_FN real gn_vsm_visibility(gn_variance v, real minimum_variance, real receiver)
{
    return gn_chebyshev(v.mean, v.square, minimum_variance, receiver);
}

/* One-sided EVSM. c: (0, 42], 5.5 at most where texels are halves. */
GN_FN gn_variance gn_evsm_positive_of(real depth, real c)
{
    real warped = gn_exponential_warp(depth, c);
    return GN_MAKE2(gn_variance, warped, warped * warped);
}

/* Chebyshev's bound in a warped space; slope: 2 c, the derivative's factor. */
GN_FN real gn_evsm_bound(real mean, real square, real slope, real minimum_variance, real warped)
{
    real scale = slope * warped;
    return gn_chebyshev(mean, square, (minimum_variance * scale) * scale, warped);
}

/* minimum_variance: of depth, [0, 0.01]. Receivers beyond [0,1] are taken to its ends. */
GN_FN real gn_evsm_positive_visibility(gn_variance v, real c, real minimum_variance, real receiver)
{
    real warped = gn_exponential_warp(gn_clamp(receiver, K(0.0f), K(1.0f)), c);
    return gn_evsm_bound(v.mean, v.square, 2.0f * c, minimum_variance, warped);
}

GN_STRUCT(gn_evsm)
{
    real positive;        /* mean of e^(c+ z) */
    real positive_square; /* mean of its square */
    real negative;        /* mean of -e^(-c- z) */
    real negative_square;
};

/* c_positive, c_negative: (0, 42], 5.5 at most where texels are halves. */
GN_FN gn_evsm gn_evsm_of(real depth, real c_positive, real c_negative)
{
    real positive = gn_exponential_warp(depth, c_positive);
    real negative = -gn_exponential_warp(depth, -c_negative);
    return GN_MAKE4(gn_evsm, positive, positive * positive, negative, negative * negative);
}

/* The smaller of both sides' bounds. minimum_variance: of depth, [0, 0.01]. */
GN_FN real gn_evsm_visibility(gn_evsm v, real c_positive, real c_negative, real minimum_variance,
                              real receiver)
{
    real d = gn_clamp(receiver, K(0.0f), K(1.0f));
    real positive = gn_exponential_warp(d, c_positive);
    real negative = -gn_exponential_warp(d, -c_negative);
    return gn_min(
        gn_evsm_bound(v.positive, v.positive_square, 2.0f * c_positive, minimum_variance, positive),
        gn_evsm_bound(v.negative, v.negative_square, 2.0f * c_negative, minimum_variance,
                      negative));
}

#include "dialect_end.h"

#endif
