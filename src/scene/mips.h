/* The box filter from one mip level to the next, one axis: a texel of the smaller level covers
 * size / smaller texels of the larger one, which is 2 or, where size is odd, up to 3. */
#ifndef GN_SCENE_MIPS_H
#define GN_SCENE_MIPS_H

#include <stdint.h>

typedef struct gn_taps {
    uint32_t first, count;
    float weight[3]; /* of texels first, first + 1...; they sum to 1 */
} gn_taps;

static inline gn_taps gn_box_taps(uint32_t size, uint32_t index)
{
    const uint32_t smaller = size / 2;
    if (smaller == 0)
        return (gn_taps){0, 1, {1, 0, 0}};
    if (size % 2 == 0)
        return (gn_taps){2 * index, 2, {0.5f, 0.5f, 0}};
    const float whole = (float)size;
    return (gn_taps){
        2 * index,
        3,
        {(float)(smaller - index) / whole, (float)smaller / whole, (float)(index + 1) / whole}};
}

#endif
