/* R. Ulichney, "The void-and-cluster method for dither array generation", Proc. SPIE 1913, 1993. */
#include "void_cluster.h"

#include <string.h>

enum { SIZE = GN_TILE_SIZE, PIXELS = GN_TILE_PIXELS };

/* The energy of a pixel is the sum of Gaussians around the pixels that are on. Integers, so that
 * order and compiler do not matter; all pixels together stay below 2^31: 2 pi sigma^2 = 22.7. The
 * Gaussian rounds to zero farther away than REACH. */
#define SCALE 67108864.0 /* 2^26 */
enum { REACH = 12 };

typedef struct pattern {
    int32_t energy[SIZE][SIZE];
    int32_t on[SIZE][SIZE]; /* 0 or -1 */
    /* Row REACH + dy: the Gaussian at height dy, its peak at column SIZE, twice around the torus.
     */
    int32_t gaussian[2 * REACH + 1][2 * SIZE];
} pattern;

static void pattern_clear(pattern *p)
{
    memset(p, 0, sizeof *p);
    /* exp(-d^2 / (2 sigma^2)) for sigma = 1.9, as powers of exp(-1 / (2 sigma^2)): products round
     * the same everywhere, which exp() of <math.h> does not promise. */
    double powers[2 * REACH * REACH + 1] = {1.0};
    for (int i = 1; i <= 2 * REACH * REACH; i++)
        powers[i] = powers[i - 1] * 0.8706596335622918;
    for (int dy = -REACH; dy <= REACH; dy++)
        for (int dx = -REACH; dx <= REACH; dx++) {
            const int32_t value = (int32_t)(powers[dx * dx + dy * dy] * SCALE + 0.5);
            p->gaussian[REACH + dy][(2 * SIZE + dx) % (2 * SIZE)] = value;
            p->gaussian[REACH + dy][SIZE + dx] = value;
        }
}

static void pattern_toggle(pattern *p, int pixel)
{
    const int py = pixel / SIZE, px = pixel % SIZE;
    const int32_t sign = p->on[py][px] ? -1 : 1;
    p->on[py][px] = ~p->on[py][px];
    for (int dy = -REACH; dy <= REACH; dy++) {
        int32_t *energy = p->energy[(py + dy + SIZE) % SIZE];
        const int32_t *gaussian = p->gaussian[REACH + dy] + SIZE - px;
        for (int x = 0; x < SIZE; x++)
            energy[x] += sign * gaussian[x];
    }
}

/* Of the pixels that are off, the one of least energy; of equal ones the first. */
static int largest_void(const pattern *p)
{
    int32_t least = INT32_MAX;
    int y = 0, x = 0;
    for (int row = 0; row < SIZE; row++) {
        int32_t row_least = INT32_MAX;
        for (int i = 0; i < SIZE; i++) {
            const int32_t energy = p->energy[row][i] | (p->on[row][i] & INT32_MAX);
            row_least = energy < row_least ? energy : row_least;
        }
        if (row_least < least) {
            least = row_least;
            y = row;
        }
    }
    while (p->on[y][x] || p->energy[y][x] != least)
        x++;
    return y * SIZE + x;
}

/* Of the pixels that are on, the one of most energy; of equal ones the first. */
static int tightest_cluster(const pattern *p)
{
    int32_t most = 0;
    int y = 0, x = 0;
    for (int row = 0; row < SIZE; row++) {
        int32_t row_most = 0;
        for (int i = 0; i < SIZE; i++) {
            const int32_t energy = p->energy[row][i] & p->on[row][i];
            row_most = energy > row_most ? energy : row_most;
        }
        if (row_most > most) {
            most = row_most;
            y = row;
        }
    }
    while (!p->on[y][x] || p->energy[y][x] != most)
        x++;
    return y * SIZE + x;
}

/* Steele, Lea and Flood's SplitMix64. */
static uint64_t next_random(uint64_t *state)
{
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

void gn_void_cluster(uint32_t seed, uint16_t ranks[GN_TILE_PIXELS])
{
    /* The prototype: a tenth of the pixels, at random, then clusters moved into voids until the
     * largest void is the one that the tightest cluster has just left. Each move lowers the energy
     * of the whole, so this ends. */
    enum { PROTOTYPE = PIXELS / 10 };
    pattern prototype;
    pattern_clear(&prototype);
    uint64_t state = seed;
    for (int on = 0; on < PROTOTYPE;) {
        const int pixel = (int)(next_random(&state) % PIXELS);
        if (!prototype.on[pixel / SIZE][pixel % SIZE]) {
            pattern_toggle(&prototype, pixel);
            on++;
        }
    }
    for (;;) {
        const int from = tightest_cluster(&prototype);
        pattern_toggle(&prototype, from);
        const int to = largest_void(&prototype);
        if (prototype.energy[to / SIZE][to % SIZE] == prototype.energy[from / SIZE][from % SIZE]) {
            pattern_toggle(&prototype, from);
            break;
        }
        pattern_toggle(&prototype, to);
    }

    /* Phase I: ranks of the prototype's pixels, from its tightest cluster down. */
    pattern p = prototype;
    for (int rank = PROTOTYPE - 1; rank >= 0; rank--) {
        const int pixel = tightest_cluster(&p);
        pattern_toggle(&p, pixel);
        ranks[pixel] = (uint16_t)rank;
    }

    /* Phase II: up to half of the pixels, the largest void first. Phase III: the tightest cluster
     * of pixels that are off, which is the largest void as well: on a torus the energies of on and
     * off add up to the same number everywhere. */
    p = prototype;
    for (int rank = PROTOTYPE; rank < PIXELS; rank++) {
        const int pixel = largest_void(&p);
        pattern_toggle(&p, pixel);
        ranks[pixel] = (uint16_t)rank;
    }
}

void gn_noise_tile(uint32_t tile, uint8_t bytes[GN_TILE_CHANNELS * GN_TILE_PIXELS])
{
    for (uint32_t channel = 0; channel < GN_TILE_CHANNELS; channel++) {
        uint16_t ranks[PIXELS];
        gn_void_cluster(GN_TILE_CHANNELS * tile + channel, ranks);
        for (uint32_t i = 0; i < PIXELS; i++)
            bytes[GN_TILE_CHANNELS * i + channel] = (uint8_t)(ranks[i] * 256u / PIXELS);
    }
}
