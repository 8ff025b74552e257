/* Blue noise for reading shadow maps (moment paper, section 4.2). */
#include "cpu/map.h"

/* Made by tools/blue_noise.c when the library is built. */
extern const unsigned char gn_blue_noise[GN_NOISE_TILES][2 * GN_NOISE_SIZE * GN_NOISE_SIZE];

const uint8_t *gn_blue_noise_tile(uint32_t tile)
{
    return gn_blue_noise[tile % GN_NOISE_TILES];
}

gn_noise_place gn_noise_of_frame(uint32_t seed, uint32_t frame)
{
    /* The finalizer of MurmurHash3 mixes all 64 bits into each of those that are used. */
    uint64_t bits = ((uint64_t)seed << 32 | frame) + 0x9e3779b97f4a7c15u;
    bits = (bits ^ (bits >> 33)) * 0xff51afd7ed558ccdu;
    bits = (bits ^ (bits >> 33)) * 0xc4ceb9fe1a85ec53u;
    bits ^= bits >> 33;
    return (gn_noise_place){.tile = (uint32_t)(bits >> 32) % GN_NOISE_TILES,
                            .x = (uint32_t)(bits >> 40) % GN_NOISE_SIZE,
                            .y = (uint32_t)(bits >> 48) % GN_NOISE_SIZE};
}
