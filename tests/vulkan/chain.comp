#version 460
#extension GL_GOOGLE_include_directive : require
// chain.h for many texels: push constant x says how many depths each has, y how many texels there
// are. The input is a plane for each depth and one of receivers, the output the planes of chain.c.
#include "chain.h"

layout(local_size_x = 64) in;
layout(push_constant) uniform Constants
{
    uvec4 constants;
};
layout(std430, binding = 0) readonly buffer In
{
    float in_planes[];
};
layout(std430, binding = 1) writeonly buffer Out
{
    uint out_planes[];
};

void store(uint plane, uint word)
{
    out_planes[plane * constants.y + gl_GlobalInvocationID.x] = word;
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    gn_moments sum = gn_moments(0.0, 0.0, 0.0, 0.0);
    for (uint sample_index = 0; sample_index < constants.x; sample_index++)
        sum = gn_chain_add(sum, gn_moments_of(in_planes[sample_index * constants.y + i]));
    float receiver = in_planes[constants.x * constants.y + i];

    gn_moments mean = gn_chain_mean(sum, float(constants.x));
    gn_nonlinear n = gn_chain_encode(mean);
    gn_nonlinear_words words64 = gn_nonlinear_pack64(n);
    uint word32 = gn_nonlinear_pack32(n);
    store(0, gn_real_word(gn_chain_hamburger(mean, receiver)));
    store(1, gn_real_word(gn_chain_hausdorff(mean, receiver)));
    store(2, gn_real_word(gn_chain_fixed(mean, receiver)));
    store(3, gn_real_word(gn_nonlinear_visibility(n, receiver)));
    store(4, gn_real_word(gn_chain_visibility64(words64, receiver)));
    store(5, gn_real_word(gn_chain_visibility32(word32, receiver)));
    store(6, words64.low);
    store(7, words64.high);
    store(8, word32);
}
