#include "cpu/tables.h"

#include <math.h>

#include <gnomon/shadow/alpha.h>

void gn_tables_fill(gn_tables *tables)
{
    for (int i = 0; i < 256; i++) {
        const double s = i / 255.0;
        tables->linear[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
    for (int i = 0; i <= GN_LINEAR_STEPS; i++) {
        const double l = (double)i / GN_LINEAR_STEPS;
        const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055;
        tables->srgb[i] = (uint8_t)(s * 255.0 + 0.5);
    }
    for (int i = 0; i <= GN_OPACITY_STEPS; i++)
        tables->depth[i] = gn_optical_depth((float)i / GN_OPACITY_STEPS);
}
