/* From depths to visibility by moments, in the dialect: the same text in C and GLSL. */
#ifndef GN_TESTS_VULKAN_CHAIN_H
#define GN_TESTS_VULKAN_CHAIN_H

#include "gnomon/shadow/moments_nonlinear.h"

#include "gnomon/shadow/dialect.h"

GN_FN gn_moments gn_chain_add(gn_moments sum, gn_moments m)
{
    return GN_MAKE4(gn_moments, sum.b1 + m.b1, sum.b2 + m.b2, sum.b3 + m.b3, sum.b4 + m.b4);
}

GN_FN gn_moments gn_chain_mean(gn_moments sum, real count)
{
    return GN_MAKE4(gn_moments, sum.b1 / count, sum.b2 / count, sum.b3 / count, sum.b4 / count);
}

/* MSM 128, Algorithm 1, with both bounds. */
GN_FN real gn_chain_hamburger(gn_moments mean, real receiver)
{
    return gn_hamburger_visibility(gn_moments_bias_float(mean, K(3e-7f)), receiver);
}

GN_FN real gn_chain_hausdorff(gn_moments mean, real receiver)
{
    return gn_hausdorff_visibility(gn_moments_bias_float(mean, K(3e-7f)), receiver);
}

/* MSM 64. */
GN_FN real gn_chain_fixed(gn_moments mean, real receiver)
{
    gn_moments_fixed q = gn_moments_quantize(gn_moments_bias_fixed(mean, K(6e-5f)));
    luint low = gn_unorm16_pack(q.q1, q.q2);
    luint high = gn_unorm16_pack(q.q3, q.q4);
    gn_moments_fixed read = GN_MAKE4(gn_moments_fixed, gn_unorm16_low(low), gn_unorm16_high(low),
                                     gn_unorm16_low(high), gn_unorm16_high(high));
    return gn_hamburger_visibility(gn_moments_dequantize(read), receiver);
}

/* Algorithm 2. */
GN_FN gn_nonlinear gn_chain_encode(gn_moments mean)
{
    return gn_nonlinear_of(gn_moments_bias_float(mean, K(3e-7f)));
}

/* Algorithm 3 of what was stored in 64 and in 32 bits. */
GN_FN real gn_chain_visibility64(gn_nonlinear_words words, real receiver)
{
    return gn_nonlinear_visibility(gn_nonlinear_unpack64(words.low, words.high), receiver);
}

GN_FN real gn_chain_visibility32(luint word, real receiver)
{
    return gn_nonlinear_visibility(gn_nonlinear_unpack32(word), receiver);
}

#include "gnomon/shadow/dialect_end.h"

#endif
