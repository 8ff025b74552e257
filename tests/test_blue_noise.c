/* The tiles of blue noise: what void and cluster promises, found again from the definitions. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "cpu/map.h"
#include "void_cluster.h"

enum {
    SIZE = GN_NOISE_SIZE,
    PIXELS = SIZE * SIZE,
    CHANNELS = 2,
    FIELDS = CHANNELS * GN_NOISE_TILES /* a field is a channel of a tile */
};

static uint8_t field_value(uint32_t field, uint32_t pixel)
{
    return gn_blue_noise_tile(field / CHANNELS)[CHANNELS * pixel + field % CHANNELS];
}

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* The table --------------------------------------------------------------------------------- */

static void each_value_occurs_equally_often(void **state)
{
    (void)state;
    for (uint32_t field = 0; field < FIELDS; field++) {
        uint32_t counts[256] = {0};
        for (uint32_t i = 0; i < PIXELS; i++)
            counts[field_value(field, i)]++;
        for (uint32_t value = 0; value < 256; value++)
            if (counts[value] != PIXELS / 256)
                fail_msg("field %u has value %u %u times, not %d", field, value, counts[value],
                         PIXELS / 256);
    }
}

static void table_is_what_the_generator_makes(void **state)
{
    (void)state;
    static uint8_t bytes[CHANNELS * PIXELS];
    assert_int_equal(sizeof bytes, GN_TILE_CHANNELS * GN_TILE_PIXELS);
    const uint32_t tiles[] = {0, GN_NOISE_TILES - 1};
    for (size_t i = 0; i < sizeof tiles / sizeof *tiles; i++) {
        gn_noise_tile(tiles[i], bytes);
        assert_memory_equal(bytes, gn_blue_noise_tile(tiles[i]), sizeof bytes);
    }
}

/* Pearson's correlation of two fields of this kind, whose mean and variance are known. */
static double correlation(uint32_t f, uint32_t g)
{
    int64_t sum = 0; /* of (2 f - 255) (2 g - 255); that of f with itself: PIXELS (256^2 - 1) / 3 */
    for (uint32_t i = 0; i < PIXELS; i++)
        sum += (2 * field_value(f, i) - 255) * (2 * field_value(g, i) - 255);
    return (double)sum * 3 / (PIXELS * 65535.0);
}

static void fields_are_uncorrelated(void **state)
{
    (void)state;
    /* Of independent white noise the 8128 pairs would have a standard deviation of 1 / 64. */
    double most = 0, squares = 0;
    for (uint32_t f = 0; f < FIELDS; f++) {
        const double self = correlation(f, f);
        if (fabs(self - 1) > 1e-12)
            fail_msg("field %u has variance %.17g, expected 1", f, self);
        for (uint32_t g = 0; g < f; g++) {
            const double r = fabs(correlation(f, g));
            most = r > most ? r : most;
            squares += r * r;
        }
    }
    const double deviation = sqrt(squares / (FIELDS * (FIELDS - 1) / 2));
    print_message("correlation of fields: standard deviation %.4f, at most %.4f\n", deviation,
                  most);
    if (deviation > 0.02 || most > 0.1)
        fail_msg("correlations have standard deviation %g, expected at most 0.02; the largest is "
                 "%g, expected at most 0.1",
                 deviation, most);
}

/* Void and cluster ------------------------------------------------------------------------------
 */

/* Sum of Gaussians around the pixels whose rank is in [first, end). */
static double energy(const uint16_t *ranks, int pixel, int first, int end)
{
    double sum = 0;
    for (int i = 0; i < PIXELS; i++) {
        int dx = abs(i % SIZE - pixel % SIZE), dy = abs(i / SIZE - pixel / SIZE);
        dx = dx < SIZE - dx ? dx : SIZE - dx;
        dy = dy < SIZE - dy ? dy : SIZE - dy;
        if (ranks[i] >= first && ranks[i] < end)
            sum += exp(-(dx * dx + dy * dy) / (2 * 1.9 * 1.9));
    }
    return sum;
}

static void each_rank_lies_where_its_phase_puts_it(void **state)
{
    (void)state;
    static uint16_t ranks[PIXELS];
    gn_void_cluster(12345, ranks);
    int pixel_of[PIXELS];
    memset(pixel_of, -1, sizeof pixel_of);
    for (int i = 0; i < PIXELS; i++)
        pixel_of[ranks[i]] = i;
    for (int i = 0; i < PIXELS; i++)
        assert_int_not_equal(pixel_of[i], -1);

    /* A rank of phase I, below 409, is the tightest cluster of the ranks up to its own; one of
     * phase II the largest void of the lower ranks; one of phase III the tightest cluster of its
     * own and higher ranks. */
    const int tested[] = {0, 7, 200, 408, 409, 410, 1000, 2047, 2048, 3000, 4000, 4095};
    for (size_t t = 0; t < sizeof tested / sizeof *tested; t++) {
        const int rank = tested[t];
        const bool phase1 = rank < 409, phase2 = !phase1 && rank < PIXELS / 2;
        const int first = phase1 || phase2 ? 0 : rank;
        const int end = phase1 ? rank + 1 : phase2 ? rank : PIXELS;
        const double sign = phase2 ? -1 : 1;
        const double here = energy(ranks, pixel_of[rank], first, end);
        const int from = phase1 ? 0 : rank, to = phase1 ? rank + 1 : PIXELS;
        for (int other = from; other < to; other++) {
            const double there = energy(ranks, pixel_of[other], first, end);
            if (sign * (there - here) > 1e-5)
                fail_msg("rank %d has energy %.9g, but rank %d has %.9g", rank, here, other, there);
        }
    }
}

/* Spectra ---------------------------------------------------------------------------------------
 */

/* Power of the torus's frequencies, 1 on the average over all but the mean. */
static void spectrum(const double *values, double *power)
{
    static double re[PIXELS], im[PIXELS];
    double cosine[SIZE], sine[SIZE], mean = 0, variance = 0;
    for (int i = 0; i < SIZE; i++) {
        cosine[i] = cos(2 * M_PI * i / SIZE);
        sine[i] = sin(2 * M_PI * i / SIZE);
    }
    for (int i = 0; i < PIXELS; i++)
        mean += values[i] / PIXELS;
    for (int i = 0; i < PIXELS; i++)
        variance += (values[i] - mean) * (values[i] - mean) / PIXELS;
    for (int y = 0; y < SIZE; y++)
        for (int u = 0; u < SIZE; u++) {
            double a = 0, b = 0;
            for (int x = 0; x < SIZE; x++) {
                a += (values[y * SIZE + x] - mean) * cosine[u * x % SIZE];
                b -= (values[y * SIZE + x] - mean) * sine[u * x % SIZE];
            }
            re[y * SIZE + u] = a;
            im[y * SIZE + u] = b;
        }
    for (int v = 0; v < SIZE; v++)
        for (int u = 0; u < SIZE; u++) {
            double a = 0, b = 0;
            for (int y = 0; y < SIZE; y++) {
                const double c = cosine[v * y % SIZE], s = sine[v * y % SIZE];
                a += re[y * SIZE + u] * c + im[y * SIZE + u] * s;
                b += im[y * SIZE + u] * c - re[y * SIZE + u] * s;
            }
            power[v * SIZE + u] = (a * a + b * b) / (PIXELS * variance);
        }
}

/* Cycles a tile. */
static double frequency(int index)
{
    const int u = index % SIZE, v = index / SIZE;
    return hypot(u < SIZE / 2 ? u : u - SIZE, v < SIZE / 2 ? v : v - SIZE);
}

/* Mean power of the frequencies in (0, limit]. */
static double low_power(const double *power, double limit)
{
    double sum = 0;
    int count = 0;
    for (int i = 1; i < PIXELS; i++)
        if (frequency(i) <= limit) {
            sum += power[i];
            count++;
        }
    return sum / count;
}

static double white_noise_power(double limit)
{
    static double values[PIXELS], power[PIXELS];
    uint32_t seed = 1;
    for (int i = 0; i < PIXELS; i++)
        values[i] = i / 16;
    for (int i = PIXELS - 1; i > 0; i--) {
        const uint32_t j = next_random(&seed) % (uint32_t)(i + 1);
        const double value = values[i];
        values[i] = values[j];
        values[j] = value;
    }
    spectrum(values, power);
    return low_power(power, limit);
}

static void low_frequencies_are_weak(void **state)
{
    (void)state;
    /* Frequencies go up to 32 cycles a tile along the axes. */
    static double values[PIXELS], power[PIXELS];
    double worst = 0, mean = 0;
    for (uint32_t field = 0; field < FIELDS; field++) {
        for (uint32_t i = 0; i < PIXELS; i++)
            values[i] = field_value(field, i);
        spectrum(values, power);
        const double low = low_power(power, 8);
        worst = low > worst ? low : worst;
        mean += low / FIELDS;
    }
    const double white = white_noise_power(8);
    print_message("power up to 8 cycles a tile: mean %.5f, at most %.5f; white noise %.3f\n", mean,
                  worst, white);
    if (worst > 0.01 * white)
        fail_msg("a field has power %g at low frequencies, expected at most %g", worst,
                 0.01 * white);
}

static void thresholds_are_blue_as_well(void **state)
{
    (void)state;
    /* What reading sees: the pixels whose noise lies below the fraction of the receiver's place.
     * Their power rises towards the frequency of their mean distance. */
    static double values[PIXELS], power[PIXELS];
    const int levels[] = {16, 64, 128, 192, 240};
    for (size_t t = 0; t < sizeof levels / sizeof *levels; t++) {
        double mean = 0;
        enum { STEP = 8 };
        for (uint32_t field = 0; field < FIELDS; field += STEP) {
            for (uint32_t i = 0; i < PIXELS; i++)
                values[i] = field_value(field, i) < levels[t];
            spectrum(values, power);
            mean += low_power(power, 6) * STEP / FIELDS;
        }
        print_message("threshold %3d: power up to 6 cycles a tile %.4f\n", levels[t], mean);
        if (mean > 0.1)
            fail_msg("threshold %d has power %g at low frequencies, expected at most 0.1",
                     levels[t], mean);
    }
}

static void spectrum_is_radially_symmetric(void **state)
{
    (void)state;
    static double values[PIXELS], power[PIXELS], mean[PIXELS];
    memset(mean, 0, sizeof mean);
    for (uint32_t field = 0; field < FIELDS; field++) {
        for (uint32_t i = 0; i < PIXELS; i++)
            values[i] = field_value(field, i);
        spectrum(values, power);
        for (uint32_t i = 0; i < PIXELS; i++)
            mean[i] += power[i] / FIELDS;
    }
    /* Directions of exactly the same frequency: Pythagoras' triples against the axes. */
    static const int triples[][3] = {{3, 4, 5},    {6, 8, 10},  {5, 12, 13},
                                     {9, 12, 15},  {8, 15, 17}, {12, 16, 20},
                                     {15, 20, 25}, {7, 24, 25}, {20, 21, 29}};
    for (size_t t = 0; t < sizeof triples / sizeof *triples; t++) {
        const int u = triples[t][0], v = triples[t][1], r = triples[t][2];
        const double axes = (mean[r] + mean[r * SIZE]) / 2;
        const double oblique = (mean[v * SIZE + u] + mean[u * SIZE + v] +
                                mean[v * SIZE + SIZE - u] + mean[u * SIZE + SIZE - v]) /
                               4;
        print_message("%2d cycles a tile: power %.5f along the axes, %.5f along (%d, %d)\n", r,
                      axes, oblique, u, v);
        /* Powers spread as much as their mean: 256 and 512 of them. */
        if (fabs(axes / oblique - 1) > 0.3)
            fail_msg("at %d cycles a tile power is %g along the axes, %g along (%d, %d)", r, axes,
                     oblique, u, v);
    }
}

static void tiles_wrap_around(void **state)
{
    (void)state;
    /* Neighbours across the seam differ as much as neighbours within. */
    double within = 0, across[2] = {0, 0};
    for (uint32_t field = 0; field < FIELDS; field++)
        for (uint32_t y = 0; y < SIZE; y++)
            for (uint32_t x = 0; x < SIZE; x++) {
                const int here = field_value(field, y * SIZE + x);
                const int right = field_value(field, y * SIZE + (x + 1) % SIZE);
                const int below = field_value(field, (y + 1) % SIZE * SIZE + x);
                *(x + 1 < SIZE ? &within : &across[0]) += abs(here - right);
                *(y + 1 < SIZE ? &within : &across[1]) += abs(here - below);
            }
    within /= (double)FIELDS * 2 * SIZE * (SIZE - 1);
    for (int i = 0; i < 2; i++) {
        across[i] /= (double)FIELDS * SIZE;
        if (fabs(across[i] / within - 1) > 0.03)
            fail_msg("neighbours differ by %g across seam %d, by %g elsewhere", across[i], i,
                     within);
    }
}

/* Places of frames ------------------------------------------------------------------------------
 */

/* Chi square over its degrees of freedom: 1 for even counts at random, with a standard deviation of
 * sqrt(2 / degrees). */
static double unevenness(const uint32_t *counts, uint32_t cells, uint32_t frames)
{
    const double expected = (double)frames / cells;
    double sum = 0;
    for (uint32_t i = 0; i < cells; i++)
        sum += (counts[i] - expected) * (counts[i] - expected) / expected;
    return sum / (cells - 1);
}

static void frames_use_all_places_evenly(void **state)
{
    (void)state;
    enum { FRAMES = 1 << 18, CELLS = 4096 };
    static uint32_t tile_x[CELLS], x_y[CELLS], pairs[CELLS];
    for (uint32_t seed = 0; seed < 4; seed++) {
        memset(tile_x, 0, sizeof tile_x);
        memset(x_y, 0, sizeof x_y);
        memset(pairs, 0, sizeof pairs);
        uint32_t before = 0;
        for (uint32_t frame = 0; frame < FRAMES; frame++) {
            const gn_noise_place place = gn_noise_of_frame(seed, frame);
            if (place.tile >= GN_NOISE_TILES || place.x >= SIZE || place.y >= SIZE)
                fail_msg("frame %u has tile %u, x %u, y %u", frame, place.tile, place.x, place.y);
            tile_x[place.tile * 64 + place.x]++;
            x_y[place.x * 64 + place.y]++;
            pairs[before * 64 + place.tile]++;
            before = place.tile;
        }
        const uint32_t *tables[] = {tile_x, x_y, pairs};
        for (int t = 0; t < 3; t++) {
            const double uneven = unevenness(tables[t], CELLS, FRAMES);
            if (fabs(uneven - 1) > 5 * sqrt(2.0 / (CELLS - 1)))
                fail_msg("seed %u, table %d: chi square is %g a cell, expected 1 within %g", seed,
                         t, uneven, 5 * sqrt(2.0 / (CELLS - 1)));
        }
    }
}

static void places_follow_from_seed_and_frame(void **state)
{
    (void)state;
    uint32_t same = 0;
    enum { FRAMES = 4096 };
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        const gn_noise_place a = gn_noise_of_frame(7, frame), b = gn_noise_of_frame(7, frame);
        assert_int_equal(a.tile, b.tile);
        assert_int_equal(a.x, b.x);
        assert_int_equal(a.y, b.y);
        const gn_noise_place other = gn_noise_of_frame(8, frame);
        same += a.tile == other.tile && a.x == other.x && a.y == other.y;
    }
    if (same > 2) /* one of 2^18 places would be the same by chance */
        fail_msg("%u of %d frames have the same place with another seed", same, FRAMES);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_value_occurs_equally_often),
        cmocka_unit_test(table_is_what_the_generator_makes),
        cmocka_unit_test(fields_are_uncorrelated),
        cmocka_unit_test(each_rank_lies_where_its_phase_puts_it),
        cmocka_unit_test(low_frequencies_are_weak),
        cmocka_unit_test(thresholds_are_blue_as_well),
        cmocka_unit_test(spectrum_is_radially_symmetric),
        cmocka_unit_test(tiles_wrap_around),
        cmocka_unit_test(frames_use_all_places_evenly),
        cmocka_unit_test(places_follow_from_seed_and_frame),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
