/* Random depth distributions, such as a filter finds in a shadow map, for tests of the filterable
 * shadow maps. */
#ifndef GN_TESTS_DISTRIBUTION_TESTING_H
#define GN_TESTS_DISTRIBUTION_TESTING_H

#include <math.h>
#include <stdint.h>

#define MAX_SAMPLES 16

/* Depths in [0,1], floats; weights sum to 1. */
typedef struct distribution {
    int count;
    float depth[MAX_SAMPLES];
    double weight[MAX_SAMPLES];
} distribution;

/* [0,1), Marsaglia's xorshift. */
static inline double random_unit(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return (double)(*state >> 8) * (1.0 / 16777216.0);
}

/* Of count samples over a range of the given width somewhere in [0,1]: even, or in two clusters, or
 * with some depths that are equal, or at the ends. */
static inline distribution random_distribution(uint32_t *state, int count, double width)
{
    distribution d = {.count = count};
    const double low = random_unit(state) * (1.0 - width);
    const int kind = (int)(random_unit(state) * 4.0);
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        double x = random_unit(state);
        if (kind == 1)
            x = i % 2 ? 0.05 * x : 1.0 - 0.05 * x;
        else if (kind == 2 && i > 0 && random_unit(state) < 0.4)
            x = ((double)d.depth[i - 1] - low) / width;
        else if (kind == 3 && random_unit(state) < 0.3)
            x = x < 0.5 ? 0.0 : 1.0;
        d.depth[i] = fminf(fmaxf((float)(low + width * x), 0.0f), 1.0f);
        d.weight[i] = 0.01 + random_unit(state);
        sum += d.weight[i];
    }
    for (int i = 0; i < count; i++)
        d.weight[i] /= sum;
    return d;
}

/* P(stored >= receiver): the light that percentage-closer filtering finds. */
static inline double lit_share(const distribution *d, float receiver)
{
    double share = 0.0;
    for (int i = 0; i < d->count; i++)
        if (d->depth[i] >= receiver)
            share += d->weight[i];
    return share;
}

/* Mean of z^power, z = 2 depth - 1. */
static inline double moment_of(const distribution *d, int power)
{
    double sum = 0.0;
    for (int i = 0; i < d->count; i++)
        sum += d->weight[i] * pow(2.0 * (double)d->depth[i] - 1.0, power);
    return sum;
}

/* A receiver to test with: often one of the depths, or an end, else anywhere near. */
static inline float random_receiver(uint32_t *state, const distribution *d)
{
    const float depth = d->depth[(int)(random_unit(state) * d->count)];
    const float other = d->depth[(int)(random_unit(state) * d->count)];
    switch ((int)(random_unit(state) * 8.0)) {
    case 0:
        return (float)random_unit(state);
    case 1:
        return random_unit(state) < 0.5 ? 0.0f : 1.0f;
    case 2:
    case 3:
        return depth;
    default:
        return depth + (float)(random_unit(state) * 1.5 - 0.25) * (other - depth);
    }
}

#endif
