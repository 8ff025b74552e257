/* Tells triangles of MASK materials apart by the texels that they can touch. */
#include "cpu/accel.h"

#include <math.h>

/* Beyond this many texels a triangle is taken as masked without looking. */
#define MAX_TEXELS 65536.0f

/* With at least this alpha everywhere a triangle is opaque under every alpha rule (to 2 %). */
#define OPAQUE_TEXEL 250

static uint32_t wrap_texel(int64_t x, uint32_t size, gn_wrap wrap)
{
    int64_t n = (int64_t)size;
    if (wrap == GN_WRAP_CLAMP)
        return (uint32_t)(x < 0 ? 0 : x >= n ? n - 1 : x);
    if (wrap == GN_WRAP_REPEAT)
        return (uint32_t)(((x % n) + n) % n);
    int64_t folded = ((x % (2 * n)) + 2 * n) % (2 * n);
    return (uint32_t)(folded < n ? folded : 2 * n - 1 - folded);
}

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
        const uint8_t *row = map->averaged[0] +
                             (size_t)wrap_texel(y, map->height, material->desc.wrap_v) * map->width;
        for (int64_t x = x0; x <= x1; x++) {
            uint8_t alpha = row[wrap_texel(x, map->width, material->desc.wrap_u)];
            least = alpha < least ? alpha : least;
            most = alpha > most ? alpha : most;
        }
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
