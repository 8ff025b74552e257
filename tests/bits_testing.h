/* Floats and their bits, for tests that do not take the dialect's word for it. */
#ifndef GN_TESTS_BITS_TESTING_H
#define GN_TESTS_BITS_TESTING_H

#include <stdint.h>
#include <string.h>

static inline float from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t to_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

#endif
