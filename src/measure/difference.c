#include "measure/measure.h"

#include <math.h>
#include <stddef.h>

gn_difference gn_measure_difference(const float *a, const float *b, const uint8_t *mask,
                                    uint64_t count)
{
    gn_difference result = {0};
    uint64_t wrong = 0;
    double sum_abs = 0, sum_squares = 0, sum_a = 0, sum_b = 0;
    for (uint64_t i = 0; i < count; i++) {
        if (mask != NULL && mask[i] == 0)
            continue;
        const double difference = fabs((double)a[i] - (double)b[i]);
        if (!(difference <= 0.5)) /* NaN is wrong, too */
            wrong++;
        sum_abs += difference;
        sum_squares += difference * difference;
        sum_a += (double)a[i];
        sum_b += (double)b[i];
        if (difference > result.max_abs)
            result.max_abs = difference;
        result.count++;
    }
    if (result.count == 0)
        return result;
    const double scale = 1.0 / (double)result.count;
    result.wrong = (double)wrong * scale;
    result.mean_abs = sum_abs * scale;
    result.mse = sum_squares * scale;
    result.mean_a = sum_a * scale;
    result.mean_b = sum_b * scale;
    return result;
}

double gn_measure_psnr(double mse, double peak)
{
    return mse > 0 ? 10.0 * log10(peak * peak / mse) : INFINITY;
}
