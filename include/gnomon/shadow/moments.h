/* Moment shadow maps of four powers of the depth.
 *
 * This work is based on:
 *   Christoph Peters, Reinhard Klein. Moment Shadow Mapping. I3D 2015
 *   Christoph Peters, Cedrick Munstermann, Nico Wetzstein, Reinhard Klein. Improved Moment Shadow
 *   Maps for Translucent Occluders, Soft Shadows and Single Scattering. JCGT 6(1), 2017
 *   Christoph Peters. Non-Linearly Quantized Moment Shadow Maps. HPG 2017 (the paper; equation and
 *   algorithm numbers are its own)
 *
 * The moments are those of z = 2d - 1, [-1,1]; depths and receivers are d in [0,1], 0 at the
 * light's near end. The papers return a lower bound of the shadow P(z < z_f), these functions its
 * complement: visibility, an upper bound of P(stored >= receiver). */
#ifndef GNOMON_SHADOW_MOMENTS_H
#define GNOMON_SHADOW_MOMENTS_H

#include "dialect.h"

GN_STRUCT(gn_moments)
{
    real b1;
    real b2;
    real b3;
    real b4;
};

GN_FN gn_moments gn_moments_of(real depth)
{
    real z = 2.0f * depth - 1.0f;
    real z2 = z * z;
    return GN_MAKE4(gn_moments, z, z2, z2 * z, z2 * z2);
}

/* Section 3.2: a step alpha, [0,1], towards (0, b2, 0, b4), so that rounded moments are moments of
 * a distribution again. */
GN_FN gn_moments gn_moments_bias(gn_moments m, real alpha, real b2, real b4)
{
    real rest = 1.0f - alpha;
    return GN_MAKE4(gn_moments, rest * m.b1, rest * m.b2 + alpha * b2, rest * m.b3,
                    rest * m.b4 + alpha * b4);
}

/* For moments kept as floats; the paper's alpha is 3e-7. */
GN_FN gn_moments gn_moments_bias_float(gn_moments m, real alpha)
{
    return gn_moments_bias(m, alpha, K(0.375f), K(0.375f));
}

/* For moments kept as four unsigned normalized numbers of 16 bits; the paper's alpha is 6e-5. */
GN_FN gn_moments gn_moments_bias_fixed(gn_moments m, real alpha)
{
    return gn_moments_bias(m, alpha, K(0.628f), K(0.628f));
}

/* Moments as four numbers in [0,1] that fill their range (2017, affine quantization). */
GN_STRUCT(gn_moments_fixed)
{
    real q1;
    real q2;
    real q3;
    real q4;
};

GN_FN gn_moments_fixed gn_moments_quantize(gn_moments m)
{
    return GN_MAKE4(gn_moments_fixed, 1.5f * m.b1 - 2.0f * m.b3 + 0.5f, 4.0f * (m.b2 - m.b4),
                    0.866025404f * m.b1 - 0.384900179f * m.b3 + 0.5f, 0.5f * (m.b2 + m.b4));
}

GN_FN gn_moments gn_moments_dequantize(gn_moments_fixed q)
{
    real a = q.q1 - 0.5f;
    real b = 1.73205081f * (q.q3 - 0.5f);
    real c = 0.125f * q.q2;
    return GN_MAKE4(gn_moments, b - 0.333333333f * a, q.q4 + c, 0.75f * (b - a), q.q4 - c);
}

/* What both reconstructions share. With s = z - b1, the polynomials 1, s and s^2 - p s - sigma^2
 * are orthogonal for the moments, with norms 1, sigma^2 and xi4. The points of support besides the
 * receiver, at s = t, are the roots of
 *     u s^2 + b s + c,  b = t xi4 / sigma^2 - p u,  c = xi4 - sigma^2 u
 * where u = t^2 - p t - sigma^2: Algorithm 1, steps 1 to 3, with the Cholesky factorization of
 * B(b). */
GN_STRUCT(gn_moments_support)
{
    real variance;   /* sigma^2 >= 1e-7 */
    real reciprocal; /* 1 / sigma^2 */
    real skew;       /* p = L21 - 2 b1; third central moment over sigma^2 */
    real xi4;        /* >= 1.2e-7 */
    real t;
    real u;
    real b;
    real c;
};

/* z: of the receiver, [-1,1]. The floors are what the paper's smallest bias gives (alpha = 3e-7 at
 * z = 0) and its smallest xi4 (section 3.3): they keep rounded moments from steps that are steeper
 * than their own error. */
GN_FN gn_moments_support gn_moments_support_of(gn_moments m, real z)
{
    gn_moments_support s;
    s.variance = gn_max(m.b2 - m.b1 * m.b1, K(1e-7f));
    s.reciprocal = 1.0f / s.variance;
    real l = m.b3 - m.b1 * m.b2; /* L21 sigma^2 */
    real l21 = l * s.reciprocal;
    s.skew = l21 - 2.0f * m.b1;
    s.xi4 = gn_max(m.b4 - m.b2 * m.b2 - l * l21, K(1.2e-7f));
    s.t = z - m.b1;
    s.u = s.t * (s.t - s.skew) - s.variance;
    s.b = s.t * (s.xi4 * s.reciprocal) - s.skew * s.u;
    s.c = s.xi4 - s.variance * s.u;
    return s;
}

/* The end of Algorithm 1: visibility 1 up to y1, the smaller root of s^2 - p s - sigma^2; 1 - w1 up
 * to y2, the larger; w0 beyond it.
 *     w0 = 1 / (1 + t^2 / sigma^2 + u^2 / xi4)
 *     w1 = (sigma^2 + t s2) / ((t - s1) (s2 - s1)) for the roots s1 < 0 < s2
 * The roots are k and -n, or 1/n and -1/k, of n = -2u / Q and k = 2c / Q with Q = |b| + sqrt(b^2 -
 * 4uc), whichever does not cancel; then s2 - s1 is (1 + nk) / n, or (1 + nk) / k. */
GN_FN real gn_moments_support_visibility(gn_moments_support s)
{
    real root = gn_sqrt(s.b * s.b - 4.0f * s.u * s.c);
    real scale = 2.0f / (gn_abs(s.b) + root + 1e-30f);
    real n = -s.u * scale;
    real k = s.c * scale;
    mask falling = s.b >= 0.0f;
    real top = gn_select(falling, s.variance * n + s.t, n * n * (s.variance + s.t * k));
    real bottom = gn_select(falling, s.t + k, n * s.t + 1.0f) * (1.0f + n * k);

    /* Up to y2 the share of light is (bottom - top) / bottom, beyond it xi4 / (...). */
    mask beyond = s.u >= 0.0f;
    top = gn_select(beyond, s.xi4, bottom - top);
    bottom = gn_select(beyond, s.xi4 * (1.0f + s.t * s.t * s.reciprocal) + s.u * s.u, bottom);
    real share = gn_clamp(top / (bottom + 1e-37f), K(0.0f), K(1.0f));
    return gn_select(gn_and(beyond, s.t < 0.0f), K(1.0f), share);
}

/* Hamburger's moment problem, Algorithm 1: the sharp upper bound over all distributions on the real
 * line with these moments. biased: by one of the functions above.
 * Against P(stored >= receiver): moments summed in single precision and biased by alpha >= 1e-6
 * give no less than that - 2 alpha; at the paper's 3e-7 two in ten thousand random distributions
 * fall short by more than 1e-3, since the rounding of the moments themselves is then as large as
 * the bias. 64-bit moments (alpha = 6e-5): no less than that - 1e-4. */
GN_FN real gn_hamburger_visibility(gn_moments biased, real receiver)
{
    return gn_moments_support_visibility(gn_moments_support_of(biased, 2.0f * receiver - 1.0f));
}

/* Hausdorff's moment problem: the sharp upper bound over the distributions on [-1,1] with these
 * moments; never above Hamburger's. Where a root of Hamburger's lies outside, the support is
 * -1, z, f and 1, with f from E[(1 - x^2) (x - z) (x - f)] = 0. More sensitive to rounding where
 * depths are exactly -1 or 1: biased by alpha >= 1e-5, no less than P(stored >= receiver) - 1e-3.
 */
GN_FN real gn_hausdorff_visibility(gn_moments biased, real receiver)
{
    real z = gn_clamp(2.0f * receiver - 1.0f, K(-1.0f), K(1.0f));
    gn_moments_support s = gn_moments_support_of(biased, z);

    /* Both roots are inside where the quadratic has the sign of u at both ends. */
    real left = -1.0f - biased.b1;
    real right = 1.0f - biased.b1;
    real at_left = (left * s.u + s.b) * left + s.c;
    real at_right = (right * s.u + s.b) * right + s.c;
    mask inside = gn_and(at_left * s.u >= 0.0f, at_right * s.u >= 0.0f);

    /* Moments of (1 - x^2): 0 to 2. */
    real e0 = 1.0f - biased.b2;
    real e1 = biased.b1 - biased.b3;
    real e2 = biased.b2 - biased.b4;
    real below = e1 - z * e0;
    below = gn_select(gn_abs(below) < 1e-12f, K(1e-12f), below);
    real f = gn_clamp((e2 - z * e1) / below, K(-1.0f), K(1.0f));

    /* f < z: E of the cubic that is 0 at -1 and f, 1 at z and 1,
     *     (x + 1) (x - f) (2 (1 - f) - (z + 2 - f) (x - z)) / (2 (1 - f) (1 + z) (z - f));
     * else 1 - E of the one that is 1 at -1, 0 at z, f and 1. Both in powers of x. */
    mask before = f < z;
    real g = z + 2.0f - f;
    real h = 2.0f * (1.0f - f) + g * z;
    real e_before = h * (biased.b2 + (1.0f - f) * biased.b1 - f) -
                    g * (biased.b3 + (1.0f - f) * biased.b2 - f * biased.b1);
    real e_after = (biased.b2 - (z + f) * biased.b1 + z * f) -
                   (biased.b3 - (z + f) * biased.b2 + z * f * biased.b1);
    real bottom = 2.0f * (1.0f + z) * gn_select(before, (1.0f - f) * (z - f), 1.0f + f);
    real top = gn_select(before, e_before, bottom - e_after);
    real share = gn_clamp(top / gn_max(bottom, K(1e-30f)), K(0.0f), K(1.0f));
    share = gn_select(z > -1.0f, share, K(1.0f));

    real hamburger = gn_moments_support_visibility(s);
    return gn_select(inside, hamburger, gn_min(share, hamburger));
}

#include "dialect_end.h"

#endif
