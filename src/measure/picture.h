/* Inside the measures of two pictures. */
#ifndef GN_MEASURE_PICTURE_H
#define GN_MEASURE_PICTURE_H

#include <gnomon/measure.h>
#include <gnomon/shadow/dialect.h>
#include <gnomon/shadow/dialect_end.h>

#include "base/base.h"

/* x^exponent for x >= 0, exponent > 0: the same bits on every processor. */
static inline float gn_power(float x, float exponent)
{
    return gn_select(x > 0.0f, gn_exp2(exponent * gn_log2(x)), 0.0f);
}

/* Row y of a picture, 3 floats a pixel, clamped. */
void gn_picture_linear(const gn_picture *picture, uint32_t y, float *row);
void gn_picture_encoded(const gn_picture *picture, uint32_t y, float *row);

/* The error of each pixel. The pictures have the same size. */
gn_result gn_flip_map(gn_context *context, const gn_picture *reference, const gn_picture *test,
                      double pixels_per_degree, float *map);

/* Mean and quartiles of a map. */
gn_result gn_flip_pool(gn_context *context, const float *map, size_t count, gn_flip *flip);

/* Mean structural similarity (Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From
 * Error Visibility to Structural Similarity", 2004). NaN where no window fits. */
gn_result gn_ssim(gn_context *context, const gn_picture *reference, const gn_picture *test,
                  double *ssim);

#endif
