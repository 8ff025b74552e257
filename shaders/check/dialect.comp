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
    values[i] = gn_log2(gn_exp2(gn_clamp(x, 0.0, 1.0))) + gn_atan(gn_tan(gn_floor(gn_sqrt(gn_abs(x)))));
}
