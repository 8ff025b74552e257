/* How much two pictures differ, in numbers and as a map. docs/metrics.md has the definitions. */
#ifndef GNOMON_MEASURE_H
#define GNOMON_MEASURE_H

#include <gnomon/device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a person looks at. Values count as clamped to [0, 1], NaN as 0. */
typedef struct gn_picture {
    uint32_t width, height;
    const float *rgb; /* 3 floats a pixel, rows from top to bottom */
    int linear;       /* non-zero: linear light, as gn_view_image(); 0: sRGB encoded */
} gn_picture;

/* FLIP, the difference that a person sees who flips between two pictures, 0 to 1 (Andersson et al.,
 * "FLIP: A Difference Evaluator for Alternating Images", HPG 2020). Quartiles are weighted: of the
 * sum of the map, a quarter, half and three quarters are due to errors up to them. */
typedef struct gn_flip {
    double mean, quartile1, median, quartile3, max;
} gn_flip;

typedef struct gn_picture_difference {
    gn_flip flip;
    double mean_abs; /* of the channels, sRGB encoded, as the next */
    double psnr;     /* decibels, peak 1; INFINITY for equal pictures */
    double ssim;     /* mean, of luma, at most 1; NaN where a side is shorter than 11 pixels */
} gn_picture_difference;

/* From a monitor 0.7 m wide with 3840 pixels, seen from 0.7 m. */
#define GN_PIXELS_PER_DEGREE 67.0

/* Both pictures have the same size. pixels_per_degree of the viewer's sight, 1 to 1000, for FLIP.
 * flip_map: NULL, or a float for each pixel, FLIP's error. */
GN_API gn_result gn_measure_pictures(gn_device *device, const gn_picture *reference,
                                     const gn_picture *test, double pixels_per_degree,
                                     gn_picture_difference *difference, float *flip_map);

/* Values in [0, 1] (clamped; NaN as 0) to the colours of FLIP's error map, 8-bit sRGB: magma, from
 * black to light yellow. rgb has 3 bytes a value. */
GN_API void gn_flip_colors(const float *values, uint8_t *rgb, size_t count);

#ifdef __cplusplus
}
#endif

#endif
