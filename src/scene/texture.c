/* Mip chains of colour. */
#include "scene/scene.h"
#include "scene/mips.h"

#include <math.h>
#include <string.h>

/* sRGB to linear and back. The way back looks up a code that is not too large and climbs: exact
 * rounding in sRGB, without a power function a texel. */
#define ENCODE_BINS 4096

typedef struct srgb_tables {
    float linear[256];
    float border[256];          /* from which linear value on code + 1 is nearer than code */
    uint8_t start[ENCODE_BINS]; /* code of the bin's lower end */
} srgb_tables;

static double decode(double srgb)
{
    return srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4);
}

static void fill_tables(srgb_tables *tables)
{
    for (int code = 0; code < 256; code++) {
        tables->linear[code] = (float)decode(code / 255.0);
        tables->border[code] = code < 255 ? (float)decode((code + 0.5) / 255.0) : INFINITY;
    }
    uint32_t code = 0;
    for (uint32_t bin = 0; bin < ENCODE_BINS; bin++) {
        while ((float)bin / ENCODE_BINS >= tables->border[code])
            code++;
        tables->start[bin] = (uint8_t)code;
    }
}

static uint8_t encode(const srgb_tables *tables, float linear)
{
    const float clamped = linear < 1 ? linear : 1;
    const uint32_t bin = (uint32_t)(clamped * ENCODE_BINS);
    uint32_t code = tables->start[bin < ENCODE_BINS ? bin : ENCODE_BINS - 1];
    while (clamped >= tables->border[code])
        code++;
    return (uint8_t)code;
}

/* Linear red, green, blue, not premultiplied, and alpha in [0,1]. */
typedef float texel __attribute__((vector_size(16)));

static texel splat(float value)
{
    return (texel){value, value, value, value};
}

/* The average of taps. Colour counts by its alpha; where all is transparent, evenly. */
static texel average(const texel *source, uint32_t width, const gn_taps *x, const gn_taps *y)
{
    texel weighted = splat(0), plain = splat(0);
    for (uint32_t j = 0; j < y->count; j++) {
        const texel *row = source + (size_t)j * width + x->first;
        for (uint32_t i = 0; i < x->count; i++) {
            const texel part = row[i] * splat(x->weight[i] * y->weight[j]);
            plain += part;
            weighted += part * splat(row[i][3]);
        }
    }
    if (plain[3] > 0) {
        const float alpha = plain[3];
        plain = weighted / splat(alpha);
        plain[3] = alpha;
    }
    return plain;
}

gn_result gn_texture_build_mips(gn_context *context, gn_texture *texture)
{
    const uint32_t width = texture->width, height = texture->height;
    texture->levels = gn_level_count(width, height);
    for (uint32_t level = 1; level < texture->levels; level++)
        texture->rgba[level] = texture->rgba[level - 1] + (size_t)gn_level_size(width, level - 1) *
                                                              gn_level_size(height, level - 1) * 4;
    if (texture->levels == 1)
        return GN_OK;

    /* Three decoded rows of level 0, and the level at work in floats: each level is made in place
     * of the one before, since no texel is read after it is overwritten. */
    srgb_tables tables;
    fill_tables(&tables);
    const uint32_t first_width = gn_level_size(width, 1), first_height = gn_level_size(height, 1);
    texel *rows = gn_alloc(context, 3 * (size_t)width, sizeof *rows);
    texel *level_texels = gn_alloc(context, (size_t)first_width * first_height, sizeof *rows);
    if (!rows || !level_texels) {
        gn_free(context, rows);
        gn_free(context, level_texels);
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "no memory for the mips of %u x %u texels",
                       width, height);
    }

    for (uint32_t level = 1; level < texture->levels; level++) {
        const uint32_t above_width = gn_level_size(width, level - 1);
        const uint32_t above_height = gn_level_size(height, level - 1);
        const uint32_t level_width = gn_level_size(width, level);
        const uint32_t level_height = gn_level_size(height, level);
        uint8_t *out = texture->rgba[level];
        texel *made = level_texels;
        for (uint32_t y = 0; y < level_height; y++) {
            const gn_taps taps_y = gn_box_taps(above_height, y);
            const texel *source = level_texels + (size_t)taps_y.first * above_width;
            if (level == 1) {
                const uint8_t *in = texture->rgba[0] + (size_t)taps_y.first * width * 4;
                for (size_t i = 0; i < (size_t)taps_y.count * width; i++, in += 4)
                    rows[i] = (texel){tables.linear[in[0]], tables.linear[in[1]],
                                      tables.linear[in[2]], (float)in[3] / 255};
                source = rows;
            }
            for (uint32_t x = 0; x < level_width; x++, out += 4) {
                const gn_taps taps_x = gn_box_taps(above_width, x);
                const texel value = average(source, above_width, &taps_x, &taps_y);
                for (int channel = 0; channel < 3; channel++)
                    out[channel] = encode(&tables, value[channel]);
                out[3] = (uint8_t)(value[3] * 255 + 0.5f);
                *made++ = value;
            }
        }
    }
    gn_free(context, rows);
    gn_free(context, level_texels);
    return GN_OK;
}
