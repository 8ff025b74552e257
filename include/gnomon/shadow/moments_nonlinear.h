/* Non-linearly quantized moment shadow maps.
 *
 * This work is based on:
 *   Christoph Peters. Non-Linearly Quantized Moment Shadow Maps. HPG 2017 (the paper; equation,
 *   algorithm and section numbers are its own)
 *
 * y1, y2 and the moments are of z = 2d - 1, [-1,1]; receivers are d in [0,1], 0 at the light's near
 * end. Algorithm 3 returns a lower bound of the shadow, gn_nonlinear_visibility its complement. */
#ifndef GNOMON_SHADOW_MOMENTS_NONLINEAR_H
#define GNOMON_SHADOW_MOMENTS_NONLINEAR_H

#include "moments.h"
#include "texel.h"

#include "dialect.h"

/* The two depths and the share of the second that have the moments b1 to b3, and what their fourth
 * moment lacks. -1 <= y1 <= y2 <= 1; v2: [0,1]; xi4: [0, 0.25], and at least
 * 1.2e-7 as made here (section 3.3). */
GN_STRUCT(gn_nonlinear)
{
    real y1;
    real y2;
    real v2;
    real xi4;
};

/* Algorithm 2. biased: by gn_moments_bias_float (section 3.2). The roots are written from the mean:
 * s^2 - p s - sigma^2 = 0 has one root at distance d = |p/2| + r from 0 and one, on the other side,
 * at sigma^2 / d, with r = sqrt((p/2)^2 + sigma^2). All three are scaled by sigma^2, so that one
 * division does for 1 / sigma^2 and for the weight. */
GN_FN gn_nonlinear gn_nonlinear_of(gn_moments biased)
{
    real variance = gn_max(biased.b2 - biased.b1 * biased.b1, K(1e-7f));
    real l = biased.b3 - biased.b1 * biased.b2; /* L21 sigma^2 */
    real cube = variance * (variance * variance);
    real p = 0.5f * l - biased.b1 * variance;
    real r = gn_sqrt(p * p + cube);
    real far = gn_abs(p) + r;
    real product = r * far;
    real inverse = 1.0f / (variance * product);
    real reciprocal = product * inverse;                  /* 1 / sigma^2 */
    real far_weight = 0.5f * cube * (variance * inverse); /* of the farther root */
    far = far * reciprocal;
    real near = 2.0f * far_weight * (r * reciprocal);
    real xi4 = biased.b4 - biased.b2 * biased.b2 - l * (l * reciprocal);
    mask rising = p >= 0.0f;
    real y1 = biased.b1 - gn_select(rising, near, far);
    real y2 = biased.b1 + gn_select(rising, far, near);
    return GN_MAKE4(gn_nonlinear, gn_max(y1, K(-1.0f)), gn_min(y2, K(1.0f)),
                    gn_select(rising, far_weight, 1.0f - far_weight), gn_max(xi4, K(1.2e-7f)));
}

/* Equation 4. */
GN_FN gn_moments gn_nonlinear_moments(gn_nonlinear n)
{
    real s1 = n.y1 * n.y1;
    real s2 = n.y2 * n.y2;
    real v1 = 1.0f - n.v2;
    return GN_MAKE4(gn_moments, v1 * n.y1 + n.v2 * n.y2, v1 * s1 + n.v2 * s2,
                    v1 * (s1 * n.y1) + n.v2 * (s2 * n.y2),
                    v1 * (s1 * s1) + n.v2 * (s2 * s2) + n.xi4);
}

/* Algorithm 3, the same bound with two divisions and a square root. Zero variance (y1 = y2, v2 = 0
 * or 1) is kept away by 1e-6, as in the paper.
 *
 * With m = y2 - z, n = z - y1 and D = y2 - y1, a root y1 + D rho between the other two solves
 *     A rho^2 - B rho - a = 0,  A = v1 v2 D^3 m n,  B = A + xi4 (v1 n - v2 m),  a = xi4 v2 m,
 * which is the paper's equation in q without its divisions. The root below y1 is rho = -e with
 * e = 2a / Q, or Q / 2A where B < 0, Q = |B| + sqrt(B^2 + 4 A a), and its weight
 *     w1 = v1 n / ((1 + e) (n + D e) (1 + 4 A a / Q^2)), times 4 A a / Q^2 where B < 0,
 * a product of positive factors: nothing cancels. Beyond y2 the light is
 *     w0 = 1 / (E[(x - z)^2] / sigma^2 + (m n)^2 / xi4). */
GN_FN real gn_nonlinear_visibility(gn_nonlinear n, real receiver)
{
    real z = 2.0f * receiver - 1.0f;
    real v2 = gn_clamp(n.v2, K(1e-6f), K(0.999999f));
    real v1 = 1.0f - v2;
    real width = gn_max(n.y2 - n.y1, K(1e-6f));
    real after = z - n.y1;
    real ahead = width - after;
    real variance = v1 * v2 * (width * width);
    real product = ahead * after;

    real quadratic = variance * width * product;
    real constant = n.xi4 * v2 * ahead;
    real linear = quadratic + n.xi4 * (v1 * after) - constant;
    real root = gn_sqrt(linear * linear + 4.0f * quadratic * constant);
    real scale = 2.0f / (gn_abs(linear) + root + 1e-30f);
    real big = quadratic * scale;
    real small = constant * scale;
    real both = big * small;
    /* Numerator and denominator of w1, for B < 0 multiplied by (2A / Q)^2. */
    mask positive = linear >= 0.0f;
    real top = v1 * after * gn_select(positive, K(1.0f), big * big * both);
    real bottom = gn_select(positive, (1.0f + small) * (after + width * small),
                            (big + 1.0f) * (big * after + width)) *
                  (1.0f + both);

    mask beyond = ahead < 0.0f;
    top = gn_select(beyond, n.xi4 * variance, bottom - top);
    bottom = gn_select(beyond,
                       n.xi4 * (v2 * (ahead * ahead) + v1 * (after * after)) +
                           variance * (product * product),
                       bottom);
    real share = gn_clamp(top / (bottom + 1e-37f), K(0.0f), K(1.0f));
    return gn_select(after > 0.0f, share, K(1.0f));
}

/* The warp of xi4, section 3.3 ------------------------------------------------------------------*/

/* Binary logarithm for normal x > 0, |error| < 3e-6 + 6e-8 |log2 x|, without a division: a
 * polynomial in the mantissa, best on [sqrt(1/2), sqrt(2)) among those without a jump at its
 * ends. */
GN_FN real gn_log2_polynomial(real x)
{
    lint exponent = (gn_bits(x) - 0x3f3504f3) & -0x800000; /* times 2^23 */
    real f = gn_from_bits(gn_bits(x) - exponent) - 1.0f;
    real f2 = f * f;
    real p = f2 * (f * -0.20403403f + 0.32321727f) + (f * -0.36827446f + 0.47924992f);
    p = p * f2 + (f * -0.72109562f + 1.44271544f);
    return gn_to_real(exponent) * 1.1920929e-7f + p * f;
}

/* Psi4: xi4 of [1.2e-7, 0.25] (clamped) to [0,1], |error| < 2.2e-6, a third of half a 16-bit step
 * (so far it may lie outside); over all floats it never falls. In binary logarithms, whose factors
 * cancel: (log2 log2(1e7 xi4) - log2 log2 1.2) / (log2 log2 2.5e6 - log2 log2 1.2). */
GN_FN real gn_xi4_warp(real xi4)
{
    real l = gn_log2_polynomial(gn_clamp_positive(xi4, K(1.2e-7f), K(0.25f)) * 1e7f);
    return gn_log2_polynomial(l) * 0.157820689f + 0.304069424f;
}

/* The inverse, for [0,1], relative error < 1e-5. */
GN_FN real gn_xi4_unwarp(real warped)
{
    return 1e-7f * gn_exp2_inside(gn_exp2_inside(warped * 6.33630488f - 1.92667657f));
}

/* 64 bits: four unsigned normalized numbers of 16 bits, y1 and y2 in low, v2 and Psi4(xi4) in high.
 */
GN_STRUCT(gn_nonlinear_words)
{
    luint low;
    luint high;
};

GN_FN gn_nonlinear_words gn_nonlinear_pack64(gn_nonlinear n)
{
    return GN_MAKE2(gn_nonlinear_words, gn_unorm16_pack(n.y1 * 0.5f + 0.5f, n.y2 * 0.5f + 0.5f),
                    gn_unorm16_pack(n.v2, gn_xi4_warp(n.xi4)));
}

GN_FN gn_nonlinear gn_nonlinear_unpack64(luint low, luint high)
{
    return GN_MAKE4(gn_nonlinear, 2.0f * gn_unorm16_low(low) - 1.0f,
                    2.0f * gn_unorm16_high(low) - 1.0f, gn_unorm16_low(high),
                    gn_xi4_unwarp(gn_unorm16_high(high)));
}

/* 32 bits, section 3.5 --------------------------------------------------------------------------
 *
 * From the low bits: 10 bits of y2, 9 of y1, 7 of sqrt(v2), 6 of Psi4(xi4). Depths are integers of
 * [0, 1022], floor(511.5 (y + 1)) (1 at y = 1, which would be 1023: the paper's text needs that
 * clamp), read back in the middle of their step. y1 <= y2 lie in a triangle; its half with
 * y1 >= 512 is turned by 180 degrees, to (1023 - y1, 1022 - y2), which leaves 9 bits for the first
 * and is told by the first being larger than the second. Psi4 is cut to 64 steps and read back at
 * the upper end of its step, so that the bound stays a bound. */

GN_FN luint gn_nonlinear_pack32(gn_nonlinear n)
{
    real y1 = gn_floor(gn_clamp_positive(511.5f * n.y1 + 511.5f, K(0.0f), K(1022.0f)));
    real y2 = gn_floor(gn_clamp_positive(511.5f * n.y2 + 511.5f, K(0.0f), K(1022.0f)));
    real v2 = gn_floor(gn_sqrt(gn_clamp_positive(n.v2, K(0.0f), K(1.0f))) * 127.0f + 0.5f);
    real xi4 = gn_floor(gn_clamp_positive(gn_xi4_warp(n.xi4) * 64.0f, K(0.0f), K(63.0f)));
    mask turned = y1 >= 512.0f;
    y1 = gn_select(turned, 1023.0f - y1, y1);
    y2 = gn_select(turned, 1022.0f - y2, y2);
    /* 19 and 13 bits: exact in a real. */
    return gn_to_unsigned(gn_to_int(y1 * 1024.0f + y2)) |
           (gn_to_unsigned(gn_to_int(xi4 * 128.0f + v2)) << 19);
}

GN_FN gn_nonlinear gn_nonlinear_unpack32(luint word)
{
    real y2 = gn_to_real(gn_to_signed(word & 0x3ffu));
    real y1 = gn_to_real(gn_to_signed((word >> 10) & 0x1ffu));
    real root = gn_to_real(gn_to_signed((word >> 19) & 0x7fu)) * (1.0f / 127.0f);
    real xi4 = gn_to_real(gn_to_signed(word >> 26)) * 0.015625f + 0.015625f;
    mask turned = y1 > y2;
    y1 = gn_select(turned, 1023.0f - y1, y1);
    y2 = gn_select(turned, 1022.0f - y2, y2);
    return GN_MAKE4(gn_nonlinear, (y1 + 0.5f) * (1.0f / 511.5f) - 1.0f,
                    (y2 + 0.5f) * (1.0f / 511.5f) - 1.0f, root * root, gn_xi4_unwarp(xi4));
}

#include "dialect_end.h"

#endif
