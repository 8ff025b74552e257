/* Alpha of MASK and BLEND materials, in three mip chains (see gn_alpha_map).
 *
 * The rescaled chain follows section 2.3 of Bruell, Kern and Grosch, "Alias-Free Shadows with Ray
 * Cones for Alpha Tested Geometry": each level is scaled so that as many texels pass the alpha test
 * as in level 0. Where the paper searches the factor by bisection, it is read off the sorted values
 * here, and texels of equal value are told apart by a dither. The coverage chain is our own. */
#include "scene/scene.h"
#include "scene/mips.h"

#include <math.h>
#include <string.h>

uint32_t gn_alpha_threshold(float cutoff)
{
    uint32_t value = 0;
    while (value < 255 && (float)value / 255.0f < cutoff)
        value++;
    return value;
}

/* Wrapping ----------------------------------------------------------------------------------- */

static uint32_t wrap_texel(gn_wrap wrap, int64_t index, uint32_t size)
{
    const int64_t n = size;
    switch (wrap) {
    case GN_WRAP_CLAMP:
        return (uint32_t)(index < 0 ? 0 : index >= n ? n - 1 : index);
    case GN_WRAP_MIRROR: {
        const int64_t turn = (index % (2 * n) + 2 * n) % (2 * n);
        return (uint32_t)(turn < n ? turn : 2 * n - 1 - turn);
    }
    case GN_WRAP_REPEAT:
        break;
    }
    return (uint32_t)((index % n + n) % n);
}

gn_texel_range gn_alpha_range(const uint8_t *level, uint32_t width, uint32_t height, gn_wrap wrap_u,
                              gn_wrap wrap_v, int64_t x0, int64_t y0, int64_t x1, int64_t y1)
{
    /* Two periods hold every texel, mirrored or not. */
    const int64_t last_x = x1 - x0 < 2 * (int64_t)width ? x1 : x0 + 2 * (int64_t)width - 1;
    const int64_t last_y = y1 - y0 < 2 * (int64_t)height ? y1 : y0 + 2 * (int64_t)height - 1;
    gn_texel_range range = {255, 0};
    for (int64_t y = y0; y <= last_y; y++) {
        const uint8_t *row = level + (size_t)wrap_texel(wrap_v, y, height) * width;
        for (int64_t x = x0; x <= last_x; x++) {
            const uint8_t value = row[wrap_texel(wrap_u, x, width)];
            range.min = value < range.min ? value : range.min;
            range.max = value > range.max ? value : range.max;
        }
    }
    return range;
}

/* Averages ----------------------------------------------------------------------------------- */

/* The next level, in place: no texel is read after it is overwritten. */
static void shrink(float *texels, uint32_t width, uint32_t height)
{
    const uint32_t smaller_width = gn_level_size(width, 1),
                   smaller_height = gn_level_size(height, 1);
    float *made = texels;
    for (uint32_t y = 0; y < smaller_height; y++) {
        const gn_taps taps_y = gn_box_taps(height, y);
        if (width % 2 == 0 && height % 2 == 0) {
            const float *upper = texels + (size_t)2 * y * width, *lower = upper + width;
            for (uint32_t x = 0; x < smaller_width; x++, upper += 2, lower += 2)
                *made++ = 0.25f * ((upper[0] + upper[1]) + (lower[0] + lower[1]));
            continue;
        }
        for (uint32_t x = 0; x < smaller_width; x++) {
            const gn_taps taps_x = gn_box_taps(width, x);
            float sum = 0;
            for (uint32_t j = 0; j < taps_y.count; j++) {
                const float *row = texels + (size_t)(taps_y.first + j) * width + taps_x.first;
                for (uint32_t i = 0; i < taps_x.count; i++)
                    sum += row[i] * (taps_x.weight[i] * taps_y.weight[j]);
            }
            *made++ = sum;
        }
    }
}

static uint8_t to_byte(float value)
{
    return (uint8_t)(value >= 255 ? 255 : value + 0.5f);
}

/* Rescaling ---------------------------------------------------------------------------------- */

typedef struct rank {
    uint32_t key;   /* the k-th largest */
    size_t of_ties; /* how many keys equal to it belong to the k largest */
} rank;

/* Radix selection; k in [1, count]. */
static rank find_rank(const uint32_t *keys, size_t count, size_t k)
{
    rank found = {0, k};
    uint32_t known = 0;
    for (int shift = 24; shift >= 0; shift -= 8) {
        size_t histogram[256] = {0};
        for (size_t i = 0; i < count; i++) {
            if ((keys[i] & known) == found.key)
                histogram[keys[i] >> shift & 255]++;
        }
        uint32_t digit = 255;
        while (found.of_ties > histogram[digit])
            found.of_ties -= histogram[digit--];
        found.key |= digit << shift;
        known |= 255u << shift;
    }
    return found;
}

/* Order among equal texels: a lattice in which any share of the largest is spread evenly (additive
 * recurrence of the plastic number, 2^32 / p and 2^32 / p^2). */
static uint32_t dither(size_t index, uint32_t width)
{
    return (uint32_t)(index % width) * 3242174889u + (uint32_t)(index / width) * 2447445414u;
}

/* Averages as sorting keys, in steps finer than any difference that matters, so that what the
 * filter's rounding tells apart still counts as equal. */
#define KEYS_PER_STEP 256

static uint32_t sorting_key(float average)
{
    return (uint32_t)(average * KEYS_PER_STEP + 0.5f);
}

/* Stores the averages of a level (in [0,255]) scaled by the factor nearest to 1 that lets `passing`
 * texels reach the threshold (>= 1) once rounded. keys: room for count. */
static void rescale(const float *averages, uint32_t width, size_t count, size_t passing,
                    uint32_t threshold, uint32_t *keys, uint8_t *out)
{
    /* The weakest texel that passes, and the strongest that does not. */
    for (size_t i = 0; i < count; i++)
        keys[i] = sorting_key(averages[i]);
    const rank weakest = passing > 0 ? find_rank(keys, count, passing) : (rank){UINT32_MAX, 0};
    size_t ties = 0;
    uint32_t strongest = 0;
    for (size_t i = 0; i < count; i++) {
        ties += keys[i] == weakest.key;
        if (keys[i] < weakest.key && keys[i] > strongest)
            strongest = keys[i];
    }

    /* Of equal texels, some pass and some do not: those above `border` do, and as many on it as
     * are left over. */
    uint32_t border = 0;
    size_t on_border = SIZE_MAX;
    if (weakest.of_ties < ties) {
        strongest = weakest.key;
        size_t listed = 0;
        for (size_t i = 0; i < count; i++) {
            if (sorting_key(averages[i]) == weakest.key)
                keys[listed++] = dither(i, width);
        }
        const rank last = find_rank(keys, ties, weakest.of_ties);
        border = last.key;
        on_border = last.of_ties;
    }

    /* factor * weakest >= threshold - 1/2 > factor * strongest */
    const double half = (threshold - 0.5) * KEYS_PER_STEP;
    double factor = 1;
    if (strongest > 0)
        factor = fmin(factor, half / strongest);
    if (passing > 0 && weakest.key > 0)
        factor = fmax(factor, half / weakest.key);

    for (size_t i = 0; i < count; i++) {
        const uint32_t key = sorting_key(averages[i]);
        bool passes = key > weakest.key;
        if (key == weakest.key) {
            const uint32_t order = dither(i, width);
            passes = order > border || (order == border && on_border > 0);
            on_border -= order == border && passes;
        }
        const uint8_t value = to_byte((float)factor * averages[i]);
        if (passes)
            out[i] = (uint8_t)(value < threshold ? threshold : value);
        else
            out[i] = (uint8_t)(value < threshold ? value : threshold - 1);
    }
}

/* Coverage ----------------------------------------------------------------------------------- */

#define QUADRANT_ROWS 8

/* The share of a quarter of a texel where the bilinear interpolant is >= threshold: exact along the
 * axis on which it changes more, in rows of samples across. own, beside, below, across: this texel
 * and its three neighbours. */
static float quadrant_coverage(float own, float beside, float below, float across, float threshold)
{
    const int passing =
        (own >= threshold) + (beside >= threshold) + (below >= threshold) + (across >= threshold);
    if (passing == 0 || passing == 4)
        return passing == 0 ? 0.0f : 1.0f;
    if (fabsf(below - own) + fabsf(across - beside) > fabsf(beside - own) + fabsf(across - below)) {
        const float swapped = below;
        below = beside;
        beside = swapped;
    }
    float sum = 0;
    for (int row = 0; row < QUADRANT_ROWS; row++) {
        const float v = ((float)row + 0.5f) / (2 * QUADRANT_ROWS);
        const float start = own + v * (below - own);
        const float far = beside + v * (across - beside);
        const float end = 0.5f * (start + far);
        if ((start >= threshold) == (end >= threshold)) {
            sum += start >= threshold ? 1.0f : 0.0f;
        } else {
            const float crossing = (threshold - start) / (end - start);
            sum += start >= threshold ? crossing : 1 - crossing;
        }
    }
    return sum / QUADRANT_ROWS;
}

/* Into coverage, [0,255]. passing: room for width + 2. */
static void cover(const uint8_t *alpha, uint32_t width, uint32_t height,
                  const gn_material_desc *desc, uint8_t *passing, float *coverage)
{
    /* The texel of the threshold itself passes, whatever rounding makes of 255 * cutoff. */
    const uint32_t first = gn_alpha_threshold(desc->alpha_cutoff);
    const float threshold = fminf(desc->alpha_cutoff * 255, (float)first);
    for (uint32_t y = 0; y < height; y++) {
        const uint8_t *rows[3];
        for (int j = 0; j < 3; j++)
            rows[j] = alpha + (size_t)wrap_texel(desc->wrap_v, (int64_t)y + j - 1, height) * width;
        /* How many of three texels, one above the other, pass; most texels are like all eight
         * around them, and need no more. */
        for (uint32_t x = 0; x < width; x++)
            passing[x + 1] =
                (uint8_t)((rows[0][x] >= first) + (rows[1][x] >= first) + (rows[2][x] >= first));
        const uint32_t left = wrap_texel(desc->wrap_u, -1, width);
        const uint32_t right = wrap_texel(desc->wrap_u, width, width);
        passing[0] = passing[left + 1];
        passing[width + 1] = passing[right + 1];
        for (uint32_t x = 0; x < width; x++) {
            const int around = passing[x] + passing[x + 1] + passing[x + 2];
            if (around == 0 || around == 9) {
                *coverage++ = around == 0 ? 0.0f : 255.0f;
                continue;
            }
            const uint32_t columns[] = {x > 0 ? x - 1 : left, x, x + 1 < width ? x + 1 : right};
            float sum = 0;
            for (int j = 0; j < 3; j += 2) {
                for (int i = 0; i < 3; i += 2)
                    sum += quadrant_coverage(rows[1][x], rows[1][columns[i]], rows[j][x],
                                             rows[j][columns[i]], threshold);
            }
            *coverage++ = sum * (255.0f / 4);
        }
    }
}

/* Chains ------------------------------------------------------------------------------------- */

static size_t level_texels(const gn_alpha_map *map, uint32_t level)
{
    return (size_t)gn_level_size(map->width, level) * gn_level_size(map->height, level);
}

/* Averages, and the rescaled chain from the same floats, since scaling bytes would round twice.
 * threshold 0: averages alone. */
static void store_averages(gn_alpha_map *map, uint32_t threshold, float *work, uint32_t *keys)
{
    const size_t total = level_texels(map, 0);
    size_t passing = 0;
    for (size_t i = 0; i < total; i++) {
        work[i] = map->averaged[0][i];
        passing += map->averaged[0][i] >= threshold;
    }
    for (uint32_t level = 1; level < map->levels; level++) {
        shrink(work, gn_level_size(map->width, level - 1), gn_level_size(map->height, level - 1));
        const size_t count = level_texels(map, level);
        for (size_t i = 0; i < count; i++)
            map->averaged[level][i] = to_byte(work[i]);
        if (threshold > 0)
            rescale(work, gn_level_size(map->width, level), count,
                    (2 * passing * count + total) / (2 * total), threshold, keys,
                    map->rescaled[level]);
    }
}

/* passing: room for width + 2. */
static void store_coverage(gn_alpha_map *map, const gn_material_desc *desc, uint8_t *passing,
                           float *work)
{
    cover(map->averaged[0], map->width, map->height, desc, passing, work);
    for (uint32_t level = 0; level < map->levels; level++) {
        if (level > 0)
            shrink(work, gn_level_size(map->width, level - 1),
                   gn_level_size(map->height, level - 1));
        for (size_t i = 0; i < level_texels(map, level); i++)
            map->coverage[level][i] = to_byte(work[i]);
    }
}

static uint8_t *lay_out(const gn_alpha_map *map, uint8_t *memory, uint8_t *levels[])
{
    for (uint32_t level = 0; level < map->levels; level++) {
        levels[level] = memory;
        memory += level_texels(map, level);
    }
    return memory;
}

#define PADDING 64 /* bytes that wide loads may read past the last texel */

gn_result gn_alpha_map_build(gn_context *context, const gn_texture *texture,
                             const gn_material_desc *desc, gn_alpha_map *map)
{
    memset(map, 0, sizeof *map);
    const uint32_t width = texture ? texture->width : 1, height = texture ? texture->height : 1;
    const size_t total = (size_t)width * height, chain = gn_chain_texels(width, height);
    const bool tested = desc->alpha_mode == GN_ALPHA_MASK;
    const uint32_t threshold = tested ? gn_alpha_threshold(desc->alpha_cutoff) : 255;

    /* A material that is opaque everywhere needs no map. */
    uint8_t alphas[256];
    for (int alpha = 0; alpha < 256; alpha++)
        alphas[alpha] = to_byte(desc->base_color[3] * (float)alpha);
    bool opaque = true;
    for (size_t i = 0; opaque && i < total; i++)
        opaque = alphas[texture ? texture->rgba[0][4 * i + 3] : 255] >= threshold;
    if (opaque)
        return GN_OK;

    gn_alpha_map made = {.width = width, .height = height, .levels = gn_level_count(width, height)};
    uint8_t *memory = gn_alloc_zero(context, (tested ? 3 : 1) * chain + PADDING, 1);
    float *work = gn_alloc(context, total, sizeof *work);
    uint32_t *keys = tested ? gn_alloc(context, (total + 1) / 2 + 1, sizeof *keys) : NULL;
    if (!memory || !work || (tested && !keys)) {
        gn_free(context, memory);
        gn_free(context, work);
        gn_free(context, keys);
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY,
                       "no memory for the alpha maps of %u x %u texels", width, height);
    }
    uint8_t *rest = lay_out(&made, memory, made.averaged);
    for (size_t i = 0; i < total; i++)
        made.averaged[0][i] = alphas[texture ? texture->rgba[0][4 * i + 3] : 255];
    if (tested) {
        rest = lay_out(&made, rest, made.rescaled);
        lay_out(&made, rest, made.coverage);
        memcpy(made.rescaled[0], made.averaged[0], total);
        store_averages(&made, threshold, work, keys);
        /* The keys have done their work; their room is 2 * total + 4 bytes or more. */
        store_coverage(&made, desc, (uint8_t *)keys, work);
    } else {
        store_averages(&made, 0, work, keys);
        memcpy(made.rescaled, made.averaged, sizeof made.rescaled);
        memcpy(made.coverage, made.averaged, sizeof made.coverage);
    }
    gn_free(context, work);
    gn_free(context, keys);
    *map = made;
    return GN_OK;
}

void gn_alpha_map_free(gn_context *context, gn_alpha_map *map)
{
    gn_free(context, map->averaged[0]);
    memset(map, 0, sizeof *map);
}
