/* A pixel's footprint by geometry, in double: its corners, carried by the camera, a receiver and a
 * light onto an occluder. */
#ifndef RAY_CONE_TESTING_H
#define RAY_CONE_TESTING_H

#include "render_testing.h"

static const double degrees = 0.017453292519943295;

/* A camera at the origin looks along -Z at a receiver, whose normal is tilted up by tilt; the light
 * stands light_tilt on the other side of the normal, in the same plane. light_distance is INFINITY
 * for a sun. The occluder's normal is tilted from the way to the light by occluder_tilt. Lengths in
 * metres, angles in radians. */
typedef struct setup {
    double tan_half_fov, height, distance, tilt;
    double light_tilt, light_distance, occluder_distance, occluder_tilt;
} setup;

/* Up from +Z by an angle. */
static inline vec tilted(double angle)
{
    return v3(0, sin(angle), cos(angle));
}

static inline vec receiver_point(const setup *s)
{
    return v3(0, 0, -s->distance);
}

static inline vec receiver_normal(const setup *s)
{
    return tilted(s->tilt);
}

static inline vec to_light(const setup *s)
{
    return tilted(s->tilt + s->light_tilt);
}

static inline vec occluder_point(const setup *s)
{
    return add(receiver_point(s), mul(to_light(s), s->occluder_distance));
}

static inline vec occluder_normal(const setup *s)
{
    return tilted(s->tilt + s->light_tilt + s->occluder_tilt);
}

/* Cones take a footprint as small, against the distances from which it is seen: is it? */
static inline bool is_small(const setup *s)
{
    const double pixel = 2 * s->tan_half_fov / s->height;
    const double width = pixel * s->distance / cos(s->tilt);
    return pixel * fabs(tan(s->tilt)) < 0.05 &&
           width * sin(fabs(s->light_tilt)) < 0.2 * s->light_distance &&
           width * cos(s->light_tilt) * fabs(tan(s->occluder_tilt)) < 0.3 * s->light_distance;
}

/* Where the line from p along d meets the plane through q with normal n. */
static inline vec meet(vec p, vec d, vec q, vec n)
{
    return add(p, mul(d, dot(sub(q, p), n) / dot(d, n)));
}

/* The centre pixel on the occluder: how long it is in the plane of camera, normal and light, and
 * its area. */
typedef struct carried {
    double extent, area;
} carried;

static inline carried carry_pixel(const setup *s)
{
    const vec receiver = receiver_point(s), light = to_light(s);
    const double half = s->tan_half_fov / s->height;
    vec corner[4];
    for (int i = 0; i < 4; i++) {
        const vec ray = v3(i == 1 || i == 2 ? half : -half, i >= 2 ? half : -half, -1);
        const vec p = meet(v3(0, 0, 0), ray, receiver, receiver_normal(s));
        const vec towards =
            isinf(s->light_distance) ? light : sub(add(receiver, mul(light, s->light_distance)), p);
        corner[i] = meet(p, towards, occluder_point(s), occluder_normal(s));
    }
    const vec bottom = mul(add(corner[0], corner[1]), 0.5);
    const vec top = mul(add(corner[2], corner[3]), 0.5);
    const vec diagonals = cross(sub(corner[2], corner[0]), sub(corner[3], corner[1]));
    return (carried){length(sub(top, bottom)), 0.5 * length(diagonals)};
}

#endif
