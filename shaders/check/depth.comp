#version 460
#extension GL_GOOGLE_include_directive : require
// The plain test.
#include "gnomon/shadow/depth.h"

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
    outputs[i] = vec4(gn_depth_test(inputs[i].x, inputs[i].y), 0.0, 0.0, 0.0);
}
