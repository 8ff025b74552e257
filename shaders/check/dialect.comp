#version 460
#extension GL_GOOGLE_include_directive : require
// The dialect's own functions as GLSL.
#include "gnomon/shadow/dialect.h"
#include "gnomon/shadow/dialect_end.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Values
{
    float values[];
};

void main()
{
    uint i = gl_GlobalInvocationID.x;
    float x = values[i];
    bool inside = gn_or(gn_and(x > 0.0, gn_not(x > 1.0)), x < -1.0);
    float y = gn_log2(gn_exp2(gn_clamp(gn_select(inside, x, gn_splat(0.5)), 0.0, 1.0)));
    y += gn_exp2_inside(gn_clamp_positive(y, 0.0, 1.0));
    y += gn_atan(gn_tan(gn_floor(gn_sqrt(gn_abs(x)))));
    y += gn_from_bits(gn_bits(x) + gn_to_int(y));
    int j = gn_select_int(inside, gn_to_signed(gn_to_unsigned(int(i)) >> 1), gn_splat_int(3));
    values[i] = gn_min(gn_max(y, x), gn_to_real(j));
}
