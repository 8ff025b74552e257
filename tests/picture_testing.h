/* What tests of pictures share: a context in place of a device, pictures made in code, checks. */
#ifndef PICTURE_TESTING_H
#define PICTURE_TESTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/measure.h>

#include "base/base.h"

static gn_context context = {.mutex = PTHREAD_MUTEX_INITIALIZER, .threads = 2};

/* The context is the first member of every device. */
static inline gn_device *device(void)
{
    return (gn_device *)&context;
}

static inline void assert_near(double value, double expected, double tolerance, const char *what)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s is %.9g, expected %.9g within %g", what, value, expected, tolerance);
}

static inline void assert_refused(gn_result result, gn_result expected, const char *words)
{
    if (result != expected || !strstr(context.message, words))
        fail_msg("result %d with \"%s\", expected %d with \"%s\"", result, context.message,
                 expected, words);
}

static inline float random_unit(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216.0f;
}

static inline void fill_noise(float *rgb, size_t count, uint32_t seed)
{
    for (size_t i = 0; i < count; i++)
        rgb[i] = random_unit(&seed);
}

static inline void fill_color(float *rgb, size_t pixels, float r, float g, float b)
{
    for (size_t i = 0; i < pixels; i++) {
        rgb[3 * i] = r;
        rgb[3 * i + 1] = g;
        rgb[3 * i + 2] = b;
    }
}

/* A ramp with a disc and a thin bright line, moved by so many pixels. */
static inline void fill_shapes(float *rgb, uint32_t width, uint32_t height, float moved)
{
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            float *pixel = rgb + 3 * ((size_t)y * width + x);
            const float u = (float)x - moved - 0.4f * (float)width;
            const float v = (float)y - 0.5f * (float)height;
            pixel[0] = (float)x / (float)width;
            pixel[1] = (float)y / (float)height;
            pixel[2] = 0.5f + 0.45f * sinf(0.7f * (float)(x + y));
            if (u * u + v * v < 40.0f)
                fill_color(pixel, 1, 0.1f, 0.15f, 0.05f);
            if (fabsf(u - v - 9.0f) < 1.0f)
                fill_color(pixel, 1, 1.0f, 0.9f, 0.3f);
        }
    }
}

static inline gn_picture_difference measure(const float *reference, const float *test,
                                            uint32_t width, uint32_t height, double ppd, float *map)
{
    const gn_picture pictures[] = {{width, height, reference, 0}, {width, height, test, 0}};
    gn_picture_difference difference;
    const gn_result result =
        gn_measure_pictures(device(), &pictures[0], &pictures[1], ppd, &difference, map);
    if (result != GN_OK)
        fail_msg("gn_measure_pictures: %s", context.message);
    return difference;
}

#endif
