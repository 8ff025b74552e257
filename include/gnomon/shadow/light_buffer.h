/* The light buffer: shadow rays without a tree.
 *
 * All rays to one light are points in its view: a sun's are parallel, a lamp's meet in it. A grid
 * over that view keeps for each cell the triangles that overlap it, and a ray asks only those of
 * the cell that its receiver lies in.
 *
 * This work is based on:
 *   Eric Haines, Donald Greenberg. The Light Buffer: A Shadow-Testing Accelerator. IEEE CG&A 6(9),
 *   1986
 *
 * One ray, one triangle:
 *   1 place     of the receiver in the light's view, relative to the centre of its cell, and its
 *               depth, which grows away from the light
 *   2 corners   of the triangle, relative to the ray: gn_light_corner_parallel() or
 *               gn_light_corner_central()
 *   3 weights   gn_light_weigh(): the three edge functions, which are the barycentric coordinates
 *               times gn_light_area()
 *   4 covers    is the ray inside?  gn_light_covers()
 *   5 depth     gn_light_ahead(): the triangle's plane lies nearer to the light than the receiver
 *               where it is negative
 *
 * The edge functions of an edge's two triangles are each other's negative to the bit, and a ray
 * that meets an edge exactly belongs to one of its sides by the edge's direction. So a ray that
 * crosses a closed surface crosses a triangle of it: no light comes through between two, and no
 * occluder counts twice. (A weight is of the right sign or 0. Where it is rounded to 0 for two
 * edges of one triangle, a sliver in line with the ray but for 2^-23 of its distance, the answer
 * may be that of a ray as far beside.) Triangles block from both sides.
 *
 * Frames. Parallel light: x and y in metres across its direction, relative to the cell's centre;
 * depth in metres along it. Central light (point and spot): a corner is (X - cx W, Y - cy W, W),
 * where (X, Y, W) is relative to the light, W along the axis of a face, and (cx, cy) the cell's
 * centre in the plane W = 1; depth is -1 / W, so that a triangle's is linear over the cell, as with
 * a parallel light. Corners behind the light (W < 0) need no clipping. */
#ifndef GNOMON_SHADOW_LIGHT_BUFFER_H
#define GNOMON_SHADOW_LIGHT_BUFFER_H

#include "dialect.h"

/* A corner relative to a ray, which is x = y = 0. */
GN_STRUCT(gn_light_corner)
{
    real x;
    real y;
};

/* Parallel light. x, y: in the cell's frame; ray_x, ray_y: of the receiver. */
GN_FN gn_light_corner gn_light_corner_parallel(real x, real y, real ray_x, real ray_y)
{
    return GN_MAKE2(gn_light_corner, x - ray_x, y - ray_y);
}

/* Central light. ray_x, ray_y: of the receiver in the plane W = 1, relative to the cell's centre.
 */
GN_FN gn_light_corner gn_light_corner_central(real x, real y, real w, real ray_x, real ray_y)
{
    return GN_MAKE2(gn_light_corner, x - ray_x * w, y - ray_y * w);
}

/* The edge functions opposite to corners a, b, c: of the same sign where the ray is inside. */
GN_STRUCT(gn_light_weights)
{
    real a;
    real b;
    real c;
};

GN_FN gn_light_weights gn_light_weigh(gn_light_corner a, gn_light_corner b, gn_light_corner c)
{
    return GN_MAKE3(gn_light_weights, b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x,
                    a.x * b.y - a.y * b.x);
}

/* Parallel light: twice the triangle's area in the light's view, N.d for the cross product N of two
 * of its edges and the light's direction d. Central light: N.D for D = (X, Y, 1), so that
 * N.d = area / |D|. Either sign. */
GN_FN real gn_light_area(gn_light_weights w)
{
    return w.a + w.b + w.c;
}

/* The side of the edge from a to b that the ray lies on; weight: the edge function. Exactly one of
 * an edge's two directions says true, unless its ends fall together. */
GN_FN mask gn_light_side(real weight, gn_light_corner a, gn_light_corner b)
{
    return gn_or(weight > 0.0f,
                 gn_and(weight == 0.0f, gn_or(a.y < b.y, gn_and(a.y == b.y, a.x < b.x))));
}

/* Does the ray's line meet the triangle, before or behind a central light? Whatever way the
 * triangle faces. Never for triangles without area. */
GN_FN mask gn_light_covers(gn_light_corner a, gn_light_corner b, gn_light_corner c,
                           gn_light_weights w)
{
    mask side_a = gn_light_side(w.a, b, c);
    mask side_b = gn_light_side(w.b, c, a);
    mask side_c = gn_light_side(w.c, a, b);
    mask same = gn_not(gn_or(side_a != side_b, side_b != side_c));
    return gn_and(same, gn_light_area(w) != 0.0f);
}

/* gn_light_covers() in two steps, for loops over many: a ray with gn_light_inside() meets the
 * triangle; one with gn_light_on_edge(), which is rare, may meet it; others do not. */
GN_FN mask gn_light_inside(gn_light_weights w)
{
    return gn_or(gn_min(gn_min(w.a, w.b), w.c) > 0.0f, gn_max(gn_max(w.a, w.b), w.c) < 0.0f);
}

GN_FN mask gn_light_on_edge(gn_light_weights w)
{
    return gn_or(gn_min(gn_min(w.a, w.b), w.c) == 0.0f, gn_max(gn_max(w.a, w.b), w.c) == 0.0f);
}

/* Depth of the triangle's plane on the ray less the receiver's. Both depths are sums of a float and
 * a much smaller one (the same offset may be taken off both before they are split), so that a
 * receiver in the plane of a triangle is told from one behind it: nearly equal floats differ
 * exactly. high, low: the plane's depth at the cell's centre, to which whoever makes lists adds a
 * bound of rounding, some 2^-22 (|slope_x| + |slope_y|) times half the cell's side: no receiver
 * then lies behind its own triangle. slope_x, slope_y: how the depth grows along x and y. */
GN_FN real gn_light_ahead(real high, real low, real slope_x, real slope_y, real ray_x, real ray_y,
                          real ray_high, real ray_low)
{
    return (high - ray_high) + ((low - ray_low) + (slope_x * ray_x + slope_y * ray_y));
}

/* Central light: the face of a cube around it in whose pyramid a point lies, relative to the light:
 * 0 to 5 for +x, -x, +y, -y, +z, -z. Of equal coordinates the first counts. */
GN_FN lint gn_light_face(real x, real y, real z)
{
    real ax = gn_abs(x), ay = gn_abs(y), az = gn_abs(z);
    mask is_x = gn_and(ax >= ay, ax >= az);
    mask is_y = ay >= az;
    real along = gn_select(is_x, x, gn_select(is_y, y, z));
    lint axis =
        gn_select_int(is_x, gn_splat_int(0), gn_select_int(is_y, gn_splat_int(2), gn_splat_int(4)));
    return axis + gn_select_int(along < 0.0f, gn_splat_int(1), gn_splat_int(0));
}

/* The whole number log2 of the side of a receiver's tile: 2^GN_LIGHT_TILE_BITS of its pixel's
 * footprints, down to a sixteenth of that. Sides are 16 times each other, since receivers of many
 * distances lie one behind the other in the light's view: with a side for each power of two a
 * triangle would be in the tiles of most. width: of the footprint, > 0. Central light: over its
 * distance along the face's axis. */
#define GN_LIGHT_TILE_BITS 9
GN_FN lint gn_light_level(real width)
{
    return (((gn_bits(width) >> 23) - 127) & ~3) + GN_LIGHT_TILE_BITS;
}

#include "dialect_end.h"

#endif
