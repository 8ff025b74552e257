/* What is made of a FLIP map: its mean and quartiles, and its picture. */
#include <string.h>

#include "measure/picture.h"

/* Sorts floats >= 0, whose bits have their order, in two passes of 16 bits. */
static void sort(uint32_t *values, uint32_t *room, size_t count, size_t places[65536])
{
    for (unsigned shift = 0; shift < 32; shift += 16) {
        memset(places, 0, 65536 * sizeof *places);
        for (size_t i = 0; i < count; i++)
            places[values[i] >> shift & 0xffff]++;
        for (size_t digit = 0, next = 0; digit < 65536; digit++) {
            const size_t here = places[digit];
            places[digit] = next;
            next += here;
        }
        for (size_t i = 0; i < count; i++)
            room[places[values[i] >> shift & 0xffff]++] = values[i];
        memcpy(values, room, count * sizeof *values);
    }
}

static double value_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* The least value such that it and those below have `share` of the sum. */
static double quantile(const uint32_t *sorted, size_t count, double sum, double share)
{
    double below = 0;
    for (size_t i = 0; i < count; i++) {
        below += value_of(sorted[i]);
        if (below >= share * sum)
            return value_of(sorted[i]);
    }
    return value_of(sorted[count - 1]);
}

gn_result gn_flip_pool(gn_context *context, const float *map, size_t count, gn_flip *flip)
{
    uint32_t *sorted = gn_alloc_copy(context, map, count, sizeof *map);
    uint32_t *room = gn_alloc(context, count, sizeof *room);
    size_t *places = gn_alloc(context, 65536, sizeof *places);
    const bool good = sorted && room && places;
    if (good) {
        sort(sorted, room, count, places);
        double sum = 0;
        for (size_t i = 0; i < count; i++)
            sum += value_of(sorted[i]);
        *flip = (gn_flip){.mean = sum / (double)count,
                          .quartile1 = quantile(sorted, count, sum, 0.25),
                          .median = quantile(sorted, count, sum, 0.5),
                          .quartile3 = quantile(sorted, count, sum, 0.75),
                          .max = value_of(sorted[count - 1])};
    }
    gn_free(context, sorted);
    gn_free(context, room);
    gn_free(context, places);
    return good ? GN_OK : gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "no memory to pool FLIP");
}

/* Every fifth of the 256 colours of magma (Nathaniel Smith, Stefan van der Walt; CC0). Those
 * between are interpolated, to 1/255. */
static const uint8_t magma[52][3] = {
    {0, 0, 4},       {2, 2, 11},      {5, 4, 22},      {9, 7, 32},      {14, 11, 43},
    {20, 14, 54},    {26, 16, 66},    {33, 17, 78},    {41, 17, 90},    {49, 17, 101},
    {57, 15, 110},   {66, 15, 117},   {74, 16, 121},   {82, 19, 124},   {90, 22, 126},
    {98, 25, 128},   {106, 28, 129},  {114, 31, 129},  {121, 34, 130},  {129, 37, 129},
    {137, 40, 129},  {145, 43, 129},  {153, 45, 128},  {161, 48, 126},  {170, 51, 125},
    {178, 53, 123},  {186, 56, 120},  {194, 59, 117},  {202, 62, 114},  {210, 66, 111},
    {217, 70, 107},  {224, 76, 103},  {231, 82, 99},   {236, 88, 96},   {241, 96, 93},
    {244, 105, 92},  {247, 114, 92},  {249, 123, 93},  {251, 133, 96},  {252, 142, 100},
    {253, 152, 105}, {254, 161, 110}, {254, 170, 116}, {254, 180, 123}, {254, 189, 130},
    {254, 198, 138}, {254, 207, 146}, {254, 216, 154}, {253, 226, 163}, {253, 235, 172},
    {252, 244, 182}, {252, 253, 191}};

void gn_flip_colors(const float *values, uint8_t *rgb, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const int color = (int)(gn_clamp(values[i], 0.0f, 1.0f) * 255.0f + 0.5f);
        const uint8_t *low = magma[color / 5], *high = magma[(color + 4) / 5];
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = (uint8_t)((low[k] * (5 - color % 5) + high[k] * (color % 5) + 2) / 5);
    }
}
