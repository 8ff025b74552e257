/* Feeds arbitrary bytes to the OpenEXR reader. Built like fuzz_scene.c; its seeds are in
 * fuzz/corpus/exr. */
#include "output/output.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static gn_context context = {.threads = 1, .mutex = PTHREAD_MUTEX_INITIALIZER};
    uint32_t width = 0, height = 0;
    float *rgb = NULL;
    if (gn_exr_decode(&context, "input", data, size, &width, &height, &rgb) != GN_OK)
        return 0;
    /* Every value must be readable. */
    volatile float sum = 0;
    for (size_t i = 0; i < (size_t)width * height * 3; i++)
        sum = sum + rgb[i];
    gn_free(&context, rgb);
    if (context.bytes != 0)
        __builtin_trap(); /* a leak */
    return 0;
}
