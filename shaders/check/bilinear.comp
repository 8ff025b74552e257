#version 460
#extension GL_GOOGLE_include_directive : require
// A bilinear lookup among four values.
#include "gnomon/shadow/bilinear.h"

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
    vec2 place = inputs[i].xy * 64.0;
    gn_bilinear w =
        gn_bilinear_weights(gn_bilinear_fraction(place.x), gn_bilinear_fraction(place.y));
    outputs[i] = vec4(gn_bilinear_blend(w, inputs[i].x, inputs[i].y, inputs[i].z, inputs[i].w),
                      gn_bilinear_base(place.x), gn_bilinear_base(place.y), 0.0);
}
