#version 460
#extension GL_GOOGLE_include_directive : require
// A pixel of leak tracing with one neighbour of the mask.
#include "gnomon/shadow/bilinear.h"
#include "gnomon/shadow/leak.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Inputs
{
    vec4 inputs[]; // the map's test, what a ray would find, the place in the frame before
};
layout(std430, binding = 1) buffer States
{
    int states[];
};
layout(push_constant) uniform Constants
{
    uint frame;
    uint columns;
};

void main()
{
    uint i = gl_GlobalInvocationID.x;
    float test = inputs[i].x;
    float column = gn_bilinear_base(inputs[i].z + gn_leak_jitter_x(frame));
    float row = gn_bilinear_base(inputs[i].w + gn_leak_jitter_y(frame));
    int neighbour = states[int(row) * int(columns) + int(column)];
    bool shadow = gn_leak_shadowed(test);
    bool removed = gn_leak_confirms(neighbour, shadow) && gn_leak_removable(test);
    bool ray = gn_leak_unsure(test, 0.01) ? !removed : gn_leak_expands(neighbour, shadow);
    states[i] = gn_leak_state(ray, shadow, gn_leak_blocked(inputs[i].y, shadow));
}
