#version 460
#extension GL_GOOGLE_include_directive : require
// Every packing and its inverse.
#include "gnomon/shadow/texel.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Inputs
{
    vec4 inputs[];
};
layout(std430, binding = 1) writeonly buffer Outputs
{
    vec4 outputs[];
};

void main()
{
    uint i = gl_GlobalInvocationID.x;
    vec4 x = inputs[i];
    uint fixed_word = gn_unorm16_pack(x.x, x.y) + gn_unorm16_code(x.z);
    uint half_word = gn_half_pack(x.x, x.y) ^ gn_half_code(x.w);
    uint word = gn_real_word(gn_half_value(half_word & 0x7bffu));
    outputs[i] = vec4(gn_unorm16_low(fixed_word) + gn_unorm16_high(fixed_word),
                      gn_half_low(half_word), gn_half_high(half_word), gn_word_real(word));
}
