/* The plain shadow test, of one depth.
 *
 * This work is based on:
 *   Lance Williams. Casting Curved Shadows on Curved Surfaces. SIGGRAPH 1978
 *
 * Depths: 0 at the light's near end, 1 at its far end or where there is nothing. */
#ifndef GNOMON_SHADOW_DEPTH_H
#define GNOMON_SHADOW_DEPTH_H

#include "dialect.h"

/* 1 (lit) where receiver <= stored, else 0. */
GN_FN real gn_depth_test(real stored, real receiver)
{
    return gn_select(receiver <= stored, K(1.0f), K(0.0f));
}

#include "dialect_end.h"

#endif
