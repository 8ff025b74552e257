/* Writes the library's tiles of blue noise as C: gnomon-blue-noise TILES FILE. */
#include <stdio.h>
#include <stdlib.h>

#include "void_cluster.h"

int main(int argc, char **argv)
{
    const unsigned long tiles = argc == 3 ? strtoul(argv[1], NULL, 10) : 0;
    FILE *file = tiles > 0 ? fopen(argv[2], "w") : NULL;
    if (!file) {
        fprintf(stderr, "usage: gnomon-blue-noise TILES FILE\n");
        return 1;
    }
    fprintf(file,
            "extern const unsigned char gn_blue_noise[%lu][%d];\n"
            "const unsigned char gn_blue_noise[%lu][%d] = {\n",
            tiles, GN_TILE_CHANNELS * GN_TILE_PIXELS, tiles, GN_TILE_CHANNELS * GN_TILE_PIXELS);
    for (uint32_t tile = 0; tile < tiles; tile++) {
        uint8_t bytes[GN_TILE_CHANNELS * GN_TILE_PIXELS];
        gn_noise_tile(tile, bytes);
        for (size_t i = 0; i < sizeof bytes; i++)
            fprintf(file, "%s%u,%s", i == 0 ? "{" : "", bytes[i], i % 32 == 31 ? "\n" : "");
        fprintf(file, "},\n");
    }
    fprintf(file, "};\n");
    const int failed = ferror(file);
    if (fclose(file) != 0 || failed) {
        fprintf(stderr, "gnomon-blue-noise: cannot write %s\n", argv[2]);
        return 1;
    }
    return 0;
}
