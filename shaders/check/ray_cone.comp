#version 460
#extension GL_GOOGLE_include_directive : require
// The chain of eight steps, for a directional and for a point light.
#include "gnomon/shadow/ray_cone.h"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Rays
{
    // tangent of half the field of view, height, distance from the camera, distance to the light
    vec4 rays[];
};
layout(std430, binding = 1) writeonly buffer Levels
{
    vec4 levels[];
};

void main()
{
    uint i = gl_GlobalInvocationID.x;
    vec4 ray = rays[i];
    gn_ray_cone cone = gn_ray_cone(0.0, gn_ray_cone_spread(ray.x, ray.y));
    cone = gn_ray_cone_propagate(cone, ray.z);
    cone = gn_ray_cone_hit(cone, 0.5);
    cone = gn_ray_cone_reflect(cone, 0.7);

    gn_ray_cone sun = gn_ray_cone_propagate(gn_ray_cone_ortho(cone), 1.0);
    gn_ray_cone lamp = gn_ray_cone_propagate(gn_ray_cone_focus(cone, ray.w), 1.0);
    gn_ray_cone exact = gn_ray_cone_propagate_exact(gn_ray_cone_focus_exact(cone, ray.w), 1.0);
    levels[i] = vec4(gn_ray_cone_lod(gn_ray_cone_hit(sun, 0.9).width, 4096.0, 0.01),
                     gn_ray_cone_lod(gn_ray_cone_hit(lamp, 0.9).width, 4096.0, 0.01),
                     gn_ray_cone_lod(gn_ray_cone_hit(exact, 0.9).width, 4096.0, 0.01),
                     float(gn_ray_cone_nearest_level(sun.width)) +
                     gn_ray_cone_nearest_mip(gn_ray_cone_footprint(sun.width, 64.0, 0.9) +
                                                 gn_ray_cone_footprint_area(lamp.width, 4096.0, 0.1),
                                             10.0));
}
