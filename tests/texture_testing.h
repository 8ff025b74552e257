/* What tests of textures share: random numbers, and a box filter by brute force. */
#ifndef TEXTURE_TESTING_H
#define TEXTURE_TESTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "scene/scene.h"

static gn_context context = {.mutex = PTHREAD_MUTEX_INITIALIZER, .threads = 1};

static uint32_t random_state = 1;

static inline uint32_t next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

static const uint32_t sizes[][2] = {{128, 128}, {64, 256}, {61, 47}, {33, 100},
                                    {127, 1},   {1, 96},   {5, 3},   {1, 1}};
#define SIZE_COUNT (sizeof sizes / sizeof *sizes)

static inline gn_texture make_texture(uint32_t width, uint32_t height)
{
    gn_texture texture = {.width = width, .height = height};
    texture.rgba[0] = gn_alloc_zero(&context, gn_chain_texels(width, height), 4);
    assert_non_null(texture.rgba[0]);
    return texture;
}

/* The average over [x, x + 1) x [y, y + 1) of the smaller level, by the overlap with each texel
 * of the larger one. Only channel `channel` of `channels`. */
static inline double overlap(uint32_t texel, uint32_t smaller, uint32_t source, uint32_t larger)
{
    const double scale = (double)larger / smaller;
    const double from = fmax(texel * scale, source), to = fmin((texel + 1) * scale, source + 1.0);
    return fmax(to - from, 0) / scale;
}

static inline double box(const double *above, uint32_t width, uint32_t height, uint32_t x,
                         uint32_t y)
{
    const uint32_t smaller_width = width > 1 ? width / 2 : 1;
    const uint32_t smaller_height = height > 1 ? height / 2 : 1;
    double sum = 0;
    for (uint32_t j = 0; j < height; j++) {
        const double weight = overlap(y, smaller_height, j, height);
        for (uint32_t i = 0; weight > 0 && i < width; i++)
            sum += weight * overlap(x, smaller_width, i, width) * above[(size_t)j * width + i];
    }
    return sum;
}

static inline void shrink_plane(double **plane, uint32_t width, uint32_t height)
{
    const uint32_t smaller_width = gn_level_size(width, 1),
                   smaller_height = gn_level_size(height, 1);
    double *made = malloc(sizeof *made * smaller_width * smaller_height);
    assert_non_null(made);
    for (uint32_t y = 0; y < smaller_height; y++) {
        for (uint32_t x = 0; x < smaller_width; x++)
            made[(size_t)y * smaller_width + x] = box(*plane, width, height, x, y);
    }
    free(*plane);
    *plane = made;
}

#endif
