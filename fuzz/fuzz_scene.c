/* Feeds arbitrary bytes to the glTF reader, then resolves and moves what it read.
 *
 * cmake -B build/fuzz -DCMAKE_C_COMPILER=clang -DGNOMON_BUILD_FUZZERS=ON
 * cmake --build build/fuzz --target fuzz_scene
 * mkdir -p corpus && build/fuzz/fuzz_scene -dict=fuzz/gltf.dict corpus fuzz/corpus/scene
 *
 * By hand: clang -g -O1 -fopenmp -fsanitize=fuzzer,address,undefined
 *          -fno-sanitize-recover -Iinclude -Isrc fuzz/fuzz_scene.c <sources> <libraries> */
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static gn_device *device;
    if (!device) {
        gn_device_desc desc = gn_device_desc_default();
        desc.threads = 1;
        if (gn_device_create(&desc, &device) != GN_OK)
            __builtin_trap();
    }
    gn_scene *scene = NULL;
    if (gn_scene_create(device, &scene) != GN_OK)
        return 0;
    if (gn_import_gltf_memory(scene, data, size) == GN_OK && gn_scene_resolve(scene) == GN_OK &&
        gn_scene_set_time(scene, 0.5) == GN_OK)
        (void)gn_scene_resolve(scene);
    gn_scene_destroy(&scene);
    return 0;
}
