/* Feeds arbitrary bytes to the image decoders. Built like fuzz_scene.c; its seeds are in
 * fuzz/corpus/image. */
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static gn_context context = {.threads = 1, .mutex = PTHREAD_MUTEX_INITIALIZER};
    uint32_t width = 0, height = 0;
    uint8_t *pixels = NULL;
    if (gn_image_decode(&context, "input", data, size, &width, &height, &pixels) != GN_OK)
        return 0;
    /* Every texel must be readable. */
    volatile uint8_t sum = 0;
    for (size_t i = 0; i < (size_t)width * height * 4; i++)
        sum = (uint8_t)(sum + pixels[i]);
    gn_free(&context, pixels);
    if (context.bytes != 0)
        __builtin_trap(); /* a leak */
    return 0;
}
