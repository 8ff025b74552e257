#version 460
#extension GL_GOOGLE_include_directive : require
// VSM, and EVSM with one and two sides.
#include "gnomon/shadow/variance.h"

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
    float depth = inputs[i].x;
    float receiver = inputs[i].y;
    gn_variance one = gn_evsm_positive_of(depth, 20.0);
    outputs[i] = vec4(gn_vsm_visibility(gn_variance_of(depth), 1e-6, receiver),
                      gn_evsm_visibility(gn_evsm_of(depth, 20.0, 5.0), 20.0, 5.0, 1e-6, receiver),
                      gn_evsm_positive_visibility(one, 20.0, 1e-6, receiver),
                      gn_chebyshev(one.mean, one.square, 0.0, receiver) +
                          gn_evsm_bound(one.mean, one.square, 40.0, 1e-6, receiver));
}
