/* Blue noise by void and cluster, for the generator (blue_noise.c) and for the test of its tables.
 */
#ifndef GN_TOOLS_VOID_CLUSTER_H
#define GN_TOOLS_VOID_CLUSTER_H

#include <stdint.h>

/* Sides of a tile, its pixels, and the channels of a pixel. */
enum { GN_TILE_SIZE = 64, GN_TILE_PIXELS = GN_TILE_SIZE * GN_TILE_SIZE, GN_TILE_CHANNELS = 2 };

/* The ranks 0 to 4095, each once, row by row: the pixels of the lowest n are spread evenly over the
 * torus, for every n. The same for the same seed on every machine. */
void gn_void_cluster(uint32_t seed, uint16_t ranks[GN_TILE_PIXELS]);

/* A tile of the table: byte 2 * (y * size + x) + channel, each of 256 values 16 times a channel. */
void gn_noise_tile(uint32_t tile, uint8_t bytes[GN_TILE_CHANNELS * GN_TILE_PIXELS]);

#endif
