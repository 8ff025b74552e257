#version 460
#extension GL_GOOGLE_include_directive : require
// Every function of tests/lanes/functions.h, as the array functions of tests/lanes/lanes.inc: push
// constant x says which, y how many values a plane has.
#include "gnomon/shadow/alpha.h"
#include "gnomon/shadow/bilinear.h"
#include "gnomon/shadow/depth.h"
#include "gnomon/shadow/exponential.h"
#include "gnomon/shadow/leak.h"
#include "gnomon/shadow/light_buffer.h"
#include "gnomon/shadow/moments.h"
#include "gnomon/shadow/moments_nonlinear.h"
#include "gnomon/shadow/ray_cone.h"
#include "gnomon/shadow/texel.h"
#include "gnomon/shadow/variance.h"

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
    float out_planes[];
};

void store(uint plane, float value)
{
    out_planes[plane * constants.y + gl_GlobalInvocationID.x] = value;
}

#define GN_MAKE_CONE(width, angle)    gn_ray_cone(width, angle)
#define GN_MAKE_FIXED(q1, q2, q3, q4) gn_moments_fixed(q1, q2, q3, q4)
#define GN_MAKE_NONLINEAR(a, b, c)                                                                 \
    gn_nonlinear(2.0 * gn_min(a, b) - 1.0, 2.0 * gn_max(a, b) - 1.0, c, gn_abs((a) * (b)) * 1e-4)
#define GN_MAKE_MOMENTS(a, b, c) gn_nonlinear_moments(GN_MAKE_NONLINEAR(a, b, c))
#define GN_MAKE_CORNER(x, y) gn_light_corner(x, y)
#define GN_MAKE_CORNERS(a, b, c)                                                                   \
    GN_MAKE_CORNER(a - b, b - c), GN_MAKE_CORNER(b - c, c - a), GN_MAKE_CORNER(c - a, a - b)
#define GN_MAKE_WEIGHTS(a, b, c) gn_light_weights(a, b, c)

#define REAL(name, domain, value)                                                                  \
    if (constants.x == function++)                                                                 \
        store(0, value);
#define WORD(name, domain, word)                                                                   \
    if (constants.x == function++) {                                                               \
        uint result = word;                                                                        \
        store(0, float(result & 0xffffu));                                                         \
        store(1, float(result >> 16));                                                             \
    }
#define PAIR(name, domain, type, m1, m2, pair)                                                     \
    if (constants.x == function++) {                                                               \
        type result = pair;                                                                        \
        store(0, result.m1);                                                                       \
        store(1, result.m2);                                                                       \
    }
#define FOUR(name, domain, type, m1, m2, m3, m4, four)                                             \
    if (constants.x == function++) {                                                               \
        type result = four;                                                                        \
        store(0, result.m1);                                                                       \
        store(1, result.m2);                                                                       \
        store(2, result.m3);                                                                       \
        store(3, result.m4);                                                                       \
    }

void main()
{
    uint i = gl_GlobalInvocationID.x;
    float a = in_planes[i];
    float b = in_planes[constants.y + i];
    float c = in_planes[2 * constants.y + i];
    uint function = 0;
#include "../lanes/functions.h"
}
