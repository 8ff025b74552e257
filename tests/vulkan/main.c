/* vulkan FUNCTIONS.spv CHAIN.spv: compares both shaders with scalar C, first with their arithmetic
 * made precise, then as they are; see check.sh. */
#include <stdio.h>
#include <stdlib.h>

#include "checks.h"
#include "precise.h"

static uint32_t *read_shader(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END) != 0) {
        perror(path);
        exit(1);
    }
    const long size = ftell(file);
    uint32_t *words = size > 0 ? malloc((size_t)size) : NULL;
    rewind(file);
    if (!words || fread(words, 1, (size_t)size, file) != (size_t)size) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    fclose(file);
    *bytes = (size_t)size;
    return words;
}

typedef bool check(const gn_compute *compute, const uint32_t *spirv, size_t bytes, bool precise);

static bool check_shader(const gn_compute *compute, const char *path, check *run)
{
    size_t bytes, precise_bytes;
    uint32_t *spirv = read_shader(path, &bytes);
    uint32_t *precise = gn_spirv_precise(spirv, bytes, &precise_bytes);
    printf("\nprecise:\n");
    const bool same = run(compute, precise, precise_bytes, true);
    printf("\nas it is:\n");
    const bool near = run(compute, spirv, bytes, false);
    free(spirv);
    free(precise);
    return same && near;
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "usage: vulkan FUNCTIONS.spv CHAIN.spv\n");
        return 2;
    }
    gn_compute compute;
    const char *reason;
    if (!gn_compute_open(&compute, &reason)) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    printf("on %s\n", compute.properties.deviceName);
    const bool functions = check_shader(&compute, argv[1], gn_check_functions);
    const bool chain = check_shader(&compute, argv[2], gn_check_chain);
    gn_compute_close(&compute);
    return functions && chain ? 0 : 1;
}
