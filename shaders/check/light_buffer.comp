#version 460
#extension GL_GOOGLE_include_directive : require
// A ray to a sun, or to a lamp, and one triangle of its cell's list.
#include "gnomon/shadow/light_buffer.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Rays
{
    vec4 rays[]; // the receiver in the cell's frame, its depth in two parts
};
layout(std430, binding = 1) readonly buffer Triangles
{
    vec4 triangles[]; // four a triangle: corners in the cell's frame, its plane
};
layout(std430, binding = 2) readonly buffer Receivers
{
    vec4 receivers[]; // relative to the light, and the width of the cone
};
layout(std430, binding = 3) writeonly buffer Answers
{
    ivec4 answers[];
};
layout(push_constant) uniform Constants
{
    uint central;
};

gn_light_corner corner_of(vec4 p, vec4 ray)
{
    if (central != 0)
        return gn_light_corner_central(p.x, p.y, p.z, ray.x, ray.y);
    return gn_light_corner_parallel(p.x, p.y, ray.x, ray.y);
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    vec4 ray = rays[i];
    gn_light_corner a = corner_of(triangles[4 * i], ray);
    gn_light_corner b = corner_of(triangles[4 * i + 1], ray);
    gn_light_corner c = corner_of(triangles[4 * i + 2], ray);
    vec4 plane = triangles[4 * i + 3];
    gn_light_weights w = gn_light_weigh(a, b, c);
    bool hit = (gn_light_inside(w) || (gn_light_on_edge(w) && gn_light_covers(a, b, c, w))) &&
               gn_light_ahead(plane.x, plane.y, plane.z, plane.w, ray.x, ray.y, ray.z, ray.w) < 0.0;
    vec4 receiver = receivers[i];
    answers[i] =
        ivec4(int(hit), int(gn_light_side(w.a, b, c)) + floatBitsToInt(gn_light_area(w)),
              gn_light_face(receiver.x, receiver.y, receiver.z), gn_light_level(receiver.w));
}
