/* Small tables that every instruction set reads alike; a device owns one. */
#ifndef GN_CPU_TABLES_H
#define GN_CPU_TABLES_H

#include <stdint.h>

#define GN_LINEAR_STEPS  4095
#define GN_OPACITY_STEPS 1020 /* 4 times 255: sums of texels become steps by a shift */

typedef struct gn_tables {
    float linear[256];                 /* of an sRGB byte */
    uint8_t srgb[GN_LINEAR_STEPS + 1]; /* of a linear value of i / GN_LINEAR_STEPS */
    int32_t
        depth[GN_OPACITY_STEPS + 1]; /* optical depth (alpha.h) of opacity i / GN_OPACITY_STEPS */
} gn_tables;

void gn_tables_fill(gn_tables *tables);

#endif
