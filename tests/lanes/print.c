/* Prints one line for each lane count and function: a hash of what it makes of many inputs. The
 * lines of all compilers and flags must be the same (check.sh). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "lanes.h"

#define COUNT 65536

static float in_planes[GN_LANE_INPUTS][COUNT], out_planes[GN_LANE_OUTPUTS][COUNT];

static uint64_t hash(uint64_t h, const float *values)
{
    for (size_t i = 0; i < COUNT; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        if (isnan(values[i]))
            bits = 0x7fc00000u; /* any payload */
        h = (h ^ bits) * 1099511628211u;
    }
    return h;
}

int main(void)
{
    const gn_lane_function *tables[] = {gn_lane_functions_1, gn_lane_functions_8,
                                        gn_lane_functions_16};
    float *in[GN_LANE_INPUTS] = {in_planes[0], in_planes[1], in_planes[2]};
    float *out[GN_LANE_OUTPUTS] = {out_planes[0], out_planes[1], out_planes[2], out_planes[3]};
    for (int t = 0; t < 3; t++)
        for (uint32_t f = 0; tables[t][f].name; f++) {
            gn_lane_inputs(tables[t][f].domain, f, in, COUNT);
            memset(out_planes, 0, sizeof out_planes);
            tables[t][f].run((const float *const *)in, out, COUNT);
            uint64_t h = 14695981039346656037u;
            for (int plane = 0; plane < GN_LANE_OUTPUTS; plane++)
                h = hash(h, out[plane]);
            printf("%-28s %016llx\n", tables[t][f].name, (unsigned long long)h);
        }
    return 0;
}
