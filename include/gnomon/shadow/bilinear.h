/* Bilinear reading: which four texels, and how much of each.
 *
 * Places are in texels from the map's corner, x to the right, y down; the centre of texel (i, j) is
 * (i + 0.5, j + 0.5). */
#ifndef GNOMON_SHADOW_BILINEAR_H
#define GNOMON_SHADOW_BILINEAR_H

#include "dialect.h"

/* Weights of the left and right texel of the upper row (w00, w10) and of the lower (w01, w11);
 * each >= 0, their sum is 1 within 2e-7. */
GN_STRUCT(gn_bilinear)
{
    real w00;
    real w10;
    real w01;
    real w11;
};

/* Column (or row) of the left (or upper) one of the two texels around a place; -1 at the border. */
GN_FN real gn_bilinear_base(real x)
{
    return gn_floor(x - 0.5f);
}

/* The other one's weight, [0,1). */
GN_FN real gn_bilinear_fraction(real x)
{
    return (x - 0.5f) - gn_bilinear_base(x);
}

/* fx, fy: gn_bilinear_fraction of both coordinates, [0,1]. */
GN_FN gn_bilinear gn_bilinear_weights(real fx, real fy)
{
    real gx = 1.0f - fx;
    real gy = 1.0f - fy;
    return GN_MAKE4(gn_bilinear, gx * gy, fx * gy, gx * fy, fx * fy);
}

GN_FN real gn_bilinear_blend(gn_bilinear w, real v00, real v10, real v01, real v11)
{
    return (w.w00 * v00 + w.w10 * v10) + (w.w01 * v01 + w.w11 * v11);
}

#include "dialect_end.h"

#endif
