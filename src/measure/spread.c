#include "measure/measure.h"

#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

gn_spread gn_measure_spread(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, compare);
    const uint32_t half = count / 2;
    return (gn_spread){
        .median = count % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]),
        .min = values[0],
        .max = values[count - 1],
    };
}
