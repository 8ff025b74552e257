/* Leak tracing: which pixels of a shadow map need a ray, by the map's own doubt and by what rays
 * found in the frame before.
 *
 * This work is based on:
 *   Rene Kern, Felix Brull, Thorsten Grosch. Real-Time Pixel-Perfect Hard Shadows with Leak
 *   Tracing. SR 2024, section 3 (equation numbers below are its own)
 *   AMD FidelityFX Hybrid Shadows, 2021 (the same test on 2x2 percentage-closer filtering)
 *
 * One frame of a light, a pixel (section 3.1.3):
 *
 *   1. read the map: its test is a visibility, [0,1], an upper bound;
 *   2. trace where gn_leak_unsure();
 *   3. reproject the pixel into the mask of the frame before; trace where that fails;
 *   4. expand: trace what is sure where any neighbour gn_leak_expands();
 *   5. remove: do not trace what is unsure where all neighbours gn_leak_confirms(), and
 *      gn_leak_removable();
 *   6. without a ray visibility is 0 where gn_leak_shadowed(), else 1;
 *   7. write gn_leak_state() into the mask, for every pixel, RS being gn_leak_blocked().
 *
 * Neighbours are pixels of the mask around the reprojected place, itself included. */
#ifndef GNOMON_SHADOW_LEAK_H
#define GNOMON_SHADOW_LEAK_H

#include "dialect.h"

/* A pixel's state in the mask: three bits, those of Table 1. GN_LEAK_HIT without GN_LEAK_RAY is no
 * row of that table; alone (4) it is our own state of a pixel without a surface that faces the
 * light, which says nothing about its neighbours: it does not expand, and it confirms. The paper
 * has black (0) there, which would put rays along the whole outline of whatever is in shadow. */
#define GN_LEAK_RAY    1 /* M_LTT: a ray was traced */
#define GN_LEAK_SHADOW 2 /* M_ST: the map's test said shadow */
#define GN_LEAK_HIT    4 /* M_RS: the ray found shadow */

/* Equation 3, LTT: between the sure ends, both excluded. visibility: the map's test; epsilon: [0,
 * 0.5). NaN is unsure. */
GN_FN mask gn_leak_unsure(real visibility, real epsilon)
{
    return gn_not(gn_or(visibility <= epsilon, visibility >= 1.0f - epsilon));
}

/* Equation 4: ST of a map's test, and RS of what a ray found, which for alpha-tested occluders may
 * lie between 0 and 1 (the paper's rays give 0 or 1). NaN is lit. */
GN_FN mask gn_leak_shadowed(real visibility)
{
    return visibility < 0.5f;
}

/* RS as the mask keeps it of an answer that may lie between 0 and 1: light that is partial by more
 * than this agrees neither with a map that says shadow nor with one that says lit. Were it rounded
 * (0.5, the paper's; the same where rays answer 0 or 1), rays that found a soft edge would be taken
 * away for agreeing. shadow: ST of the pixel. */
#define GN_LEAK_PARTIAL 0.1f
GN_FN mask gn_leak_blocked(real visibility, mask shadow)
{
    return visibility < gn_select(shadow, K(GN_LEAK_PARTIAL), K(1.0f - GN_LEAK_PARTIAL));
}

/* The bits to keep for the next frame. hit counts only with ray. */
GN_FN lint gn_leak_state(mask ray, mask shadow, mask hit)
{
    return gn_select_int(ray, gn_splat_int(GN_LEAK_RAY), gn_splat_int(0)) |
           gn_select_int(shadow, gn_splat_int(GN_LEAK_SHADOW), gn_splat_int(0)) |
           gn_select_int(gn_and(ray, hit), gn_splat_int(GN_LEAK_HIT), gn_splat_int(0));
}

/* Equation 6, for one neighbour: a ray there corrected the answer that the map gives here (purple,
 * yellow), or the map itself said the opposite there. shadow: ST here. */
GN_FN mask gn_leak_expands(lint neighbour, mask shadow)
{
    mask ray = (neighbour & GN_LEAK_RAY) != 0;
    mask opposite = ((neighbour & GN_LEAK_SHADOW) != 0) != shadow;
    mask corrected = ((neighbour & GN_LEAK_HIT) != 0) != shadow;
    return gn_and(neighbour != GN_LEAK_HIT, gn_or(gn_and(ray, corrected), opposite));
}

/* Equation 8, for one neighbour: the map said the same there, and if there was a ray it agreed.
 * The opposite of Equation 6 but for GN_LEAK_HIT alone. */
GN_FN mask gn_leak_confirms(lint neighbour, mask shadow)
{
    return gn_not(gn_leak_expands(neighbour, shadow));
}

/* May a ray be taken away where the test says this? Halfway between lit and shadow the answer that
 * would take its place is no better than a guess (the paper has no such limit; docs/benchmarks.md).
 */
GN_FN mask gn_leak_removable(real visibility)
{
    mask dark = visibility <= 0.25f;
    mask bright = visibility >= 0.75f;
    return gn_or(dark, bright);
}

/* The 2x2 gather of section 3.1.1: columns gn_bilinear_base(x + gn_leak_jitter_x(frame)) and the
 * next, rows likewise, around a reprojected place x, y in pixels. A column whose centre is less
 * than 0.75 pixels from the place is asked in every frame, less than 1.25 in half of them (x: every
 * other; y: two of four), farther ones never. So the four are among the 3x3 around the pixel that
 * the place lies in, which is one of them, and for a place less than 0.25 pixels from a pixel's
 * centre, as for all places at rest, any four consecutive frames ask all of 3x3. frame: wraps. */
GN_FN real gn_leak_jitter_x(luint frame)
{
    return gn_select((frame & 1u) != 0u, K(0.25f), K(-0.25f));
}

GN_FN real gn_leak_jitter_y(luint frame)
{
    return gn_select((frame & 2u) != 0u, K(0.25f), K(-0.25f));
}

#include "dialect_end.h"

#endif
