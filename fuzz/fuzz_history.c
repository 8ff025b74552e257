/* Feeds arbitrary bytes to the reader of histories, renders with what it makes of them, and writes
 * that again. Built like fuzz_scene.c; its seeds are in fuzz/corpus/history.
 *
 * Fingerprint and checksum are put right first, so that the fuzzer gets past them. */
#include <stdlib.h>
#include <string.h>

#include "render/history_file.h"
#include "render/stream.h"
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { WIDTH = 5, HEIGHT = 4 };

static gn_device *device;
static gn_scene *scene;
static gn_view *view;

static void check(gn_result result)
{
    if (result != GN_OK)
        __builtin_trap();
}

/* Files may ask for large maps. */
static void *modest_alloc(size_t size, void *user)
{
    (void)user;
    return size > (size_t)1 << 21 ? NULL : aligned_alloc(64, (size + 63) / 64 * 64);
}

static void modest_free(void *pointer, size_t size, void *user)
{
    (void)size;
    (void)user;
    free(pointer);
}

/* A triangle over another, a sun and a lamp. */
static void set_up(void)
{
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = 1;
    desc.allocator = (gn_allocator){modest_alloc, modest_free, NULL};
    check(gn_device_create(&desc, &device));
    check(gn_scene_create(device, &scene));
    static const float corners[] = {-3, 0, 3, 3, 0, 3, 0, 0, -3, -1, 1, 1, 1, 1, 1, 0, 1, -1};
    static const uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    const gn_mesh_part part = {.vertex_count = 6,
                               .positions = corners,
                               .index_count = 6,
                               .indices = indices,
                               .material = GN_NONE};
    gn_node_desc node = gn_node_desc_default();
    check(gn_scene_add_mesh(scene, "triangles", &part, 1, &node.mesh));
    check(gn_scene_add_node(scene, &node, NULL));
    check(gn_scene_add_sun(scene, 30, 60, NULL));
    gn_light_desc lamp = gn_light_desc_default();
    lamp.type = GN_LIGHT_POINT;
    node = gn_node_desc_default();
    node.translation[1] = 2;
    check(gn_scene_add_light(scene, &lamp, &node.light));
    check(gn_scene_add_node(scene, &node, NULL));
    check(gn_scene_commit(scene));
    uint32_t camera;
    check(gn_scene_add_overview(scene, &camera));
    check(gn_scene_commit(scene));
    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = WIDTH;
    view_desc.height = HEIGHT;
    check(gn_view_create(device, &view_desc, &view));
    check(gn_view_trace_gbuffer(view, scene, camera));
}

static void put(uint8_t *at, uint64_t value)
{
    for (int i = 0; i < 8; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* A frame by the method that the masks are of, and by one that has other maps. */
static void use(gn_history *history)
{
    static const char *const methods[] = {"lt-vsm", "lt-esm"};
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.history = history;
    float visibility[WIDTH * HEIGHT];
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
        desc.method = gn_method_find(methods[i]);
        desc.map.resolution = 32;
        desc.map.cascades = 2;
        for (desc.light = 0; desc.light < 2; desc.light++)
            if (gn_scene_visibility(scene, gn_view_gbuffer(view), &desc, visibility, NULL) == GN_OK)
                for (int p = 0; p < WIDTH * HEIGHT; p++)
                    if (!(visibility[p] >= 0 && visibility[p] <= 1))
                        __builtin_trap();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!device)
        set_up();
    const size_t head = 8 + 4 + 8 * 8;
    if (size < head + 8)
        return 0;
    uint8_t *file = malloc(size);
    if (!file)
        return 0;
    memcpy(file, data, size);
    const gn_fingerprint f = gn_fingerprint_make(scene);
    const uint64_t fields[] = {f.nodes,   f.meshes,   f.materials, f.lights,
                               f.cameras, f.vertices, f.triangles, f.digest};
    for (size_t i = 0; i < 8; i++)
        put(file + 12 + 8 * i, fields[i]);
    put(file + size - 8, gn_checksum(GN_CHECKSUM_START, file, size - 8));

    const size_t held = gn_device_bytes(device);
    gn_history *history;
    gn_last_frame last = {.width = WIDTH, .height = HEIGHT};
    if (gn_history_read_memory(scene, "input", file, size, &history, &last) == GN_OK) {
        check(gn_history_write(history, &last, "/dev/null"));
        use(history);
        check(gn_history_write(history, NULL, "/dev/null"));
    }
    gn_history_destroy(&history);
    gn_free(scene->context, last.world);
    free(file);
    /* What the scene makes at its first use stays. */
    static bool used;
    if (used && gn_device_bytes(device) != held)
        __builtin_trap();
    used |= gn_device_bytes(device) != held;
    return 0;
}
