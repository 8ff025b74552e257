#version 460
#extension GL_GOOGLE_include_directive : require
// The alpha rules and both ways of accumulation.
#include "gnomon/shadow/alpha.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Alphas
{
    float alphas[];
};
layout(std430, binding = 1) writeonly buffer Visibilities
{
    vec4 visibilities[];
};

void main()
{
    uint i = gl_GlobalInvocationID.x;
    float alpha = alphas[i];
    float visibility = gn_visibility_accumulate(1.0, gn_alpha_raw(alpha));
    visibility = gn_visibility_accumulate(visibility, gn_alpha_saturate(alpha, 0.5));
    int depth = gn_optical_depth(gn_alpha_ramp(alpha, 0.5, 0.1, 2.0));
    visibilities[i] = vec4(gn_visibility_rescale(visibility, 0.01), gn_optical_visibility(depth),
                           gn_alpha_test(alpha, 0.5), 0.0);
}
