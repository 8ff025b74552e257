/* Words of a texel: numbers of 16 bits, two in a word of 32, and floats. */
#ifndef GNOMON_SHADOW_TEXEL_H
#define GNOMON_SHADOW_TEXEL_H

#include "dialect.h"

/* Unsigned normalized numbers of 16 bits. ------------------------------------------------------*/

/* The code nearest to x, [0, 65535]; x is clamped to [0,1], NaN is 0. */
GN_FN luint gn_unorm16_code(real x)
{
    return gn_to_unsigned(gn_to_int(gn_clamp_positive(x, K(0.0f), K(1.0f)) * 65535.0f + 0.5f));
}

/* The low 16 bits hold the first number. */
GN_FN luint gn_unorm16_pack(real low, real high)
{
    return gn_unorm16_code(low) | (gn_unorm16_code(high) << 16);
}

/* code / 65535, relative error < 1.2e-7; 0 and 65535 give 0 and 1 exactly. */
GN_FN real gn_unorm16_low(luint word)
{
    return gn_to_real(gn_to_signed(word & 0xffffu)) * (1.0f / 65535.0f);
}

GN_FN real gn_unorm16_high(luint word)
{
    return gn_to_real(gn_to_signed(word >> 16)) * (1.0f / 65535.0f);
}

/* IEEE half precision. -------------------------------------------------------------------------*/

/* The code of the half nearest to x, ties to even; beyond +-65504 (NaN too) the last finite one.
 * The first select arm rounds in the float's own bits, the second lets an addition of 0.5, whose
 * last place is that of a subnormal half, do it. No subnormal floats appear on the way. */
GN_FN luint gn_half_code(real x)
{
    lint sign = (gn_bits(x) >> 16) & 0x8000;
    real a = gn_min(gn_abs(x), K(65504.0f));
    lint bits = gn_bits(a);
    lint normal = ((bits + 0xfff + ((bits >> 13) & 1)) >> 13) - 0x1c000;
    lint subnormal = gn_bits(a + 0.5f) - 0x3f000000;
    return gn_to_unsigned(sign | gn_select_int(a < 6.103515625e-5f, subnormal, normal));
}

/* The value of a half's code, exactly. Infinities and NaNs are not made by gn_half_code; their
 * codes give numbers of 65536 and more. */
GN_FN real gn_half_value(luint code)
{
    lint bits = gn_to_signed((code & 0x7fffu) << 13);
    lint sign = gn_to_signed((code & 0x8000u) << 16);
    real normal = gn_from_bits(bits + 0x38000000);
    real subnormal = gn_from_bits(bits + 0x38800000) - 6.103515625e-5f;
    return gn_from_bits(gn_bits(gn_select(normal < 6.103515625e-5f, subnormal, normal)) | sign);
}

/* The low 16 bits hold the first number. */
GN_FN luint gn_half_pack(real low, real high)
{
    return gn_half_code(low) | (gn_half_code(high) << 16);
}

GN_FN real gn_half_low(luint word)
{
    return gn_half_value(word & 0xffffu);
}

GN_FN real gn_half_high(luint word)
{
    return gn_half_value(word >> 16);
}

/* Floats: their bits. --------------------------------------------------------------------------*/

GN_FN luint gn_real_word(real x)
{
    return gn_to_unsigned(gn_bits(x));
}

GN_FN real gn_word_real(luint word)
{
    return gn_from_bits(gn_to_signed(word));
}

#include "dialect_end.h"

#endif
