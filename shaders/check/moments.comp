#version 460
#extension GL_GOOGLE_include_directive : require
// Biases, quantization and both reconstructions.
#include "gnomon/shadow/moments.h"

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
    float receiver = inputs[i].y;
    gn_moments m = gn_moments_of(inputs[i].x);
    gn_moments coarse = gn_moments_bias_fixed(m, 6e-5);
    gn_moments fine = gn_moments_bias_float(gn_moments_bias(m, 1e-7, 0.5, 0.5), 3e-7);
    gn_moments_fixed q = gn_moments_quantize(coarse);
    gn_moments_support support = gn_moments_support_of(fine, receiver);
    outputs[i] = vec4(gn_hamburger_visibility(gn_moments_dequantize(q), receiver),
                      gn_hamburger_visibility(fine, receiver),
                      gn_hausdorff_visibility(fine, receiver),
                      gn_moments_support_visibility(support));
}
