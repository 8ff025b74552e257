#version 460
#extension GL_GOOGLE_include_directive : require
// The warp and Markov's bound.
#include "gnomon/shadow/exponential.h"

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
    float moment = gn_esm_of(inputs[i].x, 80.0);
    outputs[i] = vec4(gn_esm_visibility(moment, 80.0, inputs[i].y),
                      gn_exponential_warp(inputs[i].x, 5.0), 0.0, 0.0);
}
