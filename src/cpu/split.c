/* Tells triangles of MASK materials apart by the texels that they can touch. */
#include "cpu/accel.h"

#include <math.h>

/* Beyond this many texels a triangle is taken as masked without looking. */
#define MAX_TEXELS 65536.0f

/* With at least this alpha everywhere a triangle is opaque under every alpha rule (to 2 %). */
#define OPAQUE_TEXEL 250

gn_triangle_class gn_classify_triangle(const gn_material *material, const float uv[3][2])
{
    if (!material->masked)
        return GN_CLASS_OPAQUE;
    const gn_alpha_map *map = &material->alpha;
    const float size[2] = {(float)map->width, (float)map->height};
    float low[2], high[2];
    for (int axis = 0; axis < 2; axis++) {
        float a = uv[0][axis], b = uv[1][axis], c = uv[2][axis];
        /* One texel more on each side: rounding of interpolated coordinates. */
        low[axis] = fminf(a, fminf(b, c)) * size[axis] - 1.5f;
        high[axis] = fmaxf(a, fmaxf(b, c)) * size[axis] + 0.5f;
        if (!(fabsf(low[axis]) < 1e6f) || !(fabsf(high[axis]) < 1e6f))
            return GN_CLASS_MASKED;
    }
    if ((high[0] - low[0] + 2) * (high[1] - low[1] + 2) > MAX_TEXELS)
        return GN_CLASS_MASKED;

    /* The range of every texel that bilinear interpolation in mip 0 can read. */
    uint8_t least = 255, most = 0;
    const int64_t x0 = (int64_t)floorf(low[0]), x1 = (int64_t)floorf(high[0]) + 1;
    const int64_t y0 = (int64_t)floorf(low[1]), y1 = (int64_t)floorf(high[1]) + 1;
    for (int64_t y = y0; y <= y1; y++) {
        const gn_texel_range row =
            gn_alpha_range(map->averaged[0], map->width, map->height, material->desc.wrap_u,
                           material->desc.wrap_v, x0, y, x1, y);
        least = row.min < least ? row.min : least;
        most = row.max > most ? row.max : most;
        if (least < OPAQUE_TEXEL && most > 0)
            return GN_CLASS_MASKED;
    }
    const float cutoff = material->desc.alpha_cutoff * 255.0f;
    if (least >= OPAQUE_TEXEL &&
        (material->desc.alpha_mode == GN_ALPHA_BLEND ? least == 255 : (float)least >= cutoff))
        return GN_CLASS_OPAQUE;
    return most == 0 && (material->desc.alpha_mode == GN_ALPHA_BLEND || cutoff > 0.0f)
               ? GN_CLASS_EMPTY
               : GN_CLASS_MASKED;
}
