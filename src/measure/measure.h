/* Numbers about pictures: how wrong, how unsteady, how far apart. */
#ifndef GN_MEASURE_MEASURE_H
#define GN_MEASURE_MEASURE_H

#include <stdint.h>

#include <gnomon/view.h>

/* Two visibility images of equal size. Fractions are of count. */
typedef struct gn_difference {
    double wrong;    /* share of pixels that differ by more than 0.5 */
    double mean_abs; /* mean absolute difference */
    double mse;      /* mean squared difference */
    double max_abs;
    double mean_a, mean_b;
    uint64_t count;
} gn_difference;

/* mask: NULL, or count bytes, 0 leaves a pixel out. */
gn_difference gn_measure_difference(const float *a, const float *b, const uint8_t *mask,
                                    uint64_t count);

/* 10 log10(peak^2 / mse); INFINITY for equal images. */
double gn_measure_psnr(double mse, double peak);

/* Change of visibility from one frame to the next where both see the same surface
 * (docs/metrics.md). */
typedef struct gn_flicker {
    double flicker;  /* mean squared motion-compensated change */
    double toggles;  /* share of pixels that change by more than 0.5 */
    uint64_t pixels; /* compared */
} gn_flicker;

/* Keeps what the next frame is compared with. Zero-initialise; free with gn_flicker_state_free().*/
typedef struct gn_flicker_state {
    uint32_t width, height;
    float *depth, *visibility; /* visibility less the reference, where there is one */
    uint32_t *surface;
} gn_flicker_state;

/* Compares this frame with the one before (all zero at the first) and remembers this one. For
 * each pixel: the nearest pixel to where motion says the surface point was; the same surface if
 * the surface numbers agree and the depth there is what motion foretells, within two ray cone
 * widths. Without memory the state is emptied and zero returned. */
gn_flicker gn_measure_flicker(gn_flicker_state *state, const gn_gbuffer *gbuffer,
                              const float *visibility);
/* The same after the change of a reference of this frame (width * height values, say of many
 * samples a pixel) is taken off, so that real motion does not count: the change of visibility -
 * reference, over the same pixels. state: one of its own for each visibility. */
gn_flicker gn_measure_residual_flicker(gn_flicker_state *state, const gn_gbuffer *gbuffer,
                                       const float *visibility, const float *reference);
void gn_flicker_state_free(gn_flicker_state *state);

/* Median, minimum, maximum of count values (>= 1), which are sorted in place. */
typedef struct gn_spread {
    double median, min, max;
} gn_spread;

gn_spread gn_measure_spread(double *values, uint32_t count);

#endif
