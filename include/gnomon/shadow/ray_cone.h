/* Ray cones for shadow rays: how wide a pixel is where its shadow ray passes an occluder.
 *
 * This work is based on:
 *   Felix Brull, Rene Kern, Thorsten Grosch. Alias-Free Shadows with Ray Cones for Alpha Tested
 *   Geometry. VMV 2025 (the paper; equation numbers below are its own)
 *   Tomas Akenine-Moller, Cyril Crassin, Jakub Boksansky et al. Improved Shader and Texture Level
 *   of Detail Using Ray Cones. JCGT 10(1), 2021
 *
 * The chain of sections 3.1 and 3.2, one ray a pixel and light:
 *   1 initialise   (0, gn_ray_cone_spread)
 *   2 propagate    camera to surface
 *   3 hit          the surface
 *   4 reflect      towards the light
 *   5 ortho        (directional light)  or  focus (point or spot light)
 *   6 propagate    surface to occluder
 *   7 hit          the occluder
 *   8 lod          of the occluder's texture
 *
 * Lengths are in metres (any unit, the same everywhere), angles in radians. */
#ifndef GNOMON_SHADOW_RAY_CONE_H
#define GNOMON_SHADOW_RAY_CONE_H

#include "dialect.h"

/* width >= 0: diameter of the cone where the ray is now. angle: full opening angle, negative where
 * the cone closes. */
GN_STRUCT(gn_ray_cone)
{
    real width;
    real angle;
};

/* Equation 1: spread angle of one pixel at the centre of the image, used for all of them.
 * tan_half_fov: tangent of half the vertical field of view, > 0; height: of the image, pixels. */
GN_FN real gn_ray_cone_spread(real tan_half_fov, real height)
{
    return gn_atan(2.0f * tan_half_fov / height);
}

/* Equation 2, approximate form: the cone after distance >= 0. Focused cones end at width 0; the
 * lower bound keeps rounding from passing it. */
GN_FN gn_ray_cone gn_ray_cone_propagate(gn_ray_cone cone, real distance)
{
    return GN_MAKE2(gn_ray_cone, gn_max(cone.width + distance * cone.angle, K(0.0f)), cone.angle);
}

/* Equation 2, exact form, |angle| <= pi/2. Goes with gn_ray_cone_focus_exact(). */
GN_FN gn_ray_cone gn_ray_cone_propagate_exact(gn_ray_cone cone, real distance)
{
    return GN_MAKE2(gn_ray_cone,
                    gn_max(cone.width + 2.0f * distance * gn_tan(0.5f * cone.angle), K(0.0f)),
                    cone.angle);
}

/* Equation 3: the cone's footprint on a surface. cosine: of the angle between ray and normal, its
 * sign is ignored; at 0 (edge-on) the width is bounded by 1e6 times the cone's. */
GN_FN gn_ray_cone gn_ray_cone_hit(gn_ray_cone cone, real cosine)
{
    return GN_MAKE2(gn_ray_cone, cone.width / gn_max(gn_abs(cosine), K(1e-6f)), cone.angle);
}

/* Equation 4: leaving a surface. The inverse of hit; curvature is left out, as in the paper. */
GN_FN gn_ray_cone gn_ray_cone_reflect(gn_ray_cone cone, real cosine)
{
    return GN_MAKE2(gn_ray_cone, cone.width * gn_abs(cosine), cone.angle);
}

/* Equation 8: directional lights; their rays are parallel. */
GN_FN gn_ray_cone gn_ray_cone_ortho(gn_ray_cone cone)
{
    return GN_MAKE2(gn_ray_cone, cone.width, K(0.0f));
}

/* Equation 9, approximate form: point and spot lights; the cone closes at the light.
 * distance > 0: to the light. */
GN_FN gn_ray_cone gn_ray_cone_focus(gn_ray_cone cone, real distance)
{
    return GN_MAKE2(gn_ray_cone, cone.width, -cone.width / distance);
}

/* Equation 9, exact form; needs width <= 2 distance. */
GN_FN gn_ray_cone gn_ray_cone_focus_exact(gn_ray_cone cone, real distance)
{
    return GN_MAKE2(gn_ray_cone, cone.width, 2.0f * gn_atan(-0.5f * cone.width / distance));
}

/* Equations 5 to 7: level of detail, 0 for mip 0, not clamped to the mips that exist.
 * width: after hit. texel_area: t_a, twice the triangle's area in texels of mip 0; world_area: p_a,
 * twice its area in space; all > 0. */
GN_FN real gn_ray_cone_lod(real width, real texel_area, real world_area)
{
    return gn_log2(width * gn_sqrt(texel_area / world_area));
}

/* Footprint in texels of mip 0, 2^LOD, of a cone *before* Hit on the occluder. With N the cross
 * product of two edges of the triangle (so |N| = p_a), Hit divides by |N.d| / p_a and Equation 5
 * multiplies by sqrt(t_a / p_a), which makes
 *     2^LOD = width sqrt(t_a p_a) / |N.d|:
 * one constant a triangle and one division a hit, no square root, no logarithm, no normalisation.
 * texel_scale: sqrt(t_a p_a); normal_dot: N.d for a unit direction d. */
GN_FN real gn_ray_cone_footprint(real width, real texel_scale, real normal_dot)
{
    return width * texel_scale / gn_abs(normal_dot);
}

/* The same of equal area, our own: Hit widens the cone along one axis of the surface only, and
 * Equation 3 takes the longer axis for both, which blurs too much at grazing angles. The footprint
 * that covers as much of the texture has width / sqrt(|cos|) in place of width / |cos|, so
 *     2^LOD = width sqrt(t_a / |N.d|).
 * texel_area: t_a. */
GN_FN real gn_ray_cone_footprint_area(real width, real texel_area, real normal_dot)
{
    return width * gn_sqrt(texel_area / gn_abs(normal_dot));
}

/* The whole number nearest to log2(footprint): the exponent of footprint * sqrt(2). 128 for
 * infinite and NaN footprints (edge-on triangles). */
GN_FN lint gn_ray_cone_nearest_level(real footprint)
{
    return ((gn_bits(footprint * 1.41421356f) & 0x7fffffff) >> 23) - 127;
}

/* The same as a mip that exists, [0, last]. */
GN_FN real gn_ray_cone_nearest_mip(real footprint, real last)
{
    return gn_clamp(gn_to_real(gn_ray_cone_nearest_level(footprint)), K(0.0f), last);
}

#include "dialect_end.h"

#endif
