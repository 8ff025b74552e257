#version 460
#extension GL_GOOGLE_include_directive : require
// Algorithms 2 and 3 between both packings.
#include "gnomon/shadow/moments_nonlinear.h"

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
    gn_moments m = gn_moments_bias_float(gn_moments_of(inputs[i].x), 3e-7);
    gn_nonlinear n = gn_nonlinear_of(m);
    gn_nonlinear_words words = gn_nonlinear_pack64(n);
    gn_nonlinear fine = gn_nonlinear_unpack64(words.low, words.high);
    gn_nonlinear coarse = gn_nonlinear_unpack32(gn_nonlinear_pack32(n));
    outputs[i] = vec4(gn_nonlinear_visibility(fine, inputs[i].y),
                      gn_nonlinear_visibility(coarse, inputs[i].y), gn_nonlinear_moments(n).b4,
                      gn_xi4_unwarp(gn_xi4_warp(n.xi4)) + gn_log2_polynomial(inputs[i].z));
}
