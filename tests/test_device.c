/* Devices: descriptors and messages, memory hooks, running out of memory, several at once. */
#include "render_testing.h"

#include <pthread.h>
#include <stdatomic.h>

/* Memory hooks ------------------------------------------------------------------------------- */

/* Counts, and fails at the call number `fail_at` (counted from 0; negative: never). */
typedef struct heap {
    _Atomic long calls, blocks;
    _Atomic size_t bytes;
    long fail_at;
    _Atomic bool failed, misaligned;
} heap;

static void *heap_alloc(size_t size, void *user)
{
    heap *h = user;
    if (atomic_fetch_add(&h->calls, 1) == h->fail_at) {
        h->failed = true;
        return NULL;
    }
    void *block = NULL;
    if (posix_memalign(&block, 64, size) != 0)
        return NULL;
    memset(block, 0xa5, size); /* nothing may rely on zeros */
    atomic_fetch_add(&h->blocks, 1);
    atomic_fetch_add(&h->bytes, size);
    return block;
}

static void heap_free(void *block, size_t size, void *user)
{
    heap *h = user;
    atomic_fetch_sub(&h->blocks, 1);
    atomic_fetch_sub(&h->bytes, size);
    free(block);
}

static gn_device_desc heap_desc(heap *h)
{
    gn_device_desc desc = gn_device_desc_default();
    desc.allocator = (gn_allocator){heap_alloc, heap_free, h};
    desc.threads = 1; /* what is lost or wrong does not depend on it, the time does */
    return desc;
}

/* The first failure of a long row of calls ends it. */
#define step(call)                                                                                 \
    do {                                                                                           \
        const gn_result step_result = (call);                                                      \
        if (step_result != GN_OK) {                                                                \
            result = step_result;                                                                  \
            goto done;                                                                             \
        }                                                                                          \
    } while (0)

/* Everything that a user does: a scene of all kinds of things, edits, frames. */
static gn_result use_everything(gn_device *on, float *sum)
{
    gn_result result = GN_OK;
    gn_scene *scene = NULL;
    gn_view *view = NULL;
    static const float corners[] = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1};
    static const float ups[] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    static const float uvs[] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    uint8_t rgba[16 * 16 * 4];
    for (int i = 0; i < 16 * 16 * 4; i++)
        rgba[i] = (uint8_t)(i * 37);

    step(gn_scene_create(on, &scene));
    gn_texture_desc texture = gn_texture_desc_default();
    texture.name = "holes";
    texture.width = texture.height = 16;
    texture.rgba = rgba;
    gn_material_desc material = gn_material_desc_default();
    step(gn_scene_add_texture(scene, &texture, &material.texture));
    material.alpha_mode = GN_ALPHA_MASK;
    material.double_sided = true;
    uint32_t masked;
    step(gn_scene_add_material(scene, &material, &masked));
    gn_mesh_part part = {.vertex_count = 4,
                         .positions = corners,
                         .normals = ups,
                         .uvs = uvs,
                         .index_count = 6,
                         .indices = indices,
                         .material = masked};
    uint32_t card, ground, sun, camera;
    step(gn_scene_add_mesh(scene, "card", &part, 1, &card));
    part.material = GN_NONE;
    step(gn_scene_add_mesh(scene, "ground", &part, 1, &ground));
    gn_node_desc node = gn_node_desc_default();
    node.mesh = ground;
    node.scale[0] = node.scale[2] = 4;
    step(gn_scene_add_node(scene, &node, NULL));
    node = gn_node_desc_default();
    node.mesh = card;
    uint32_t moving = 0;
    for (int i = 0; i < 40; i++) { /* so that tables grow */
        node.translation[1] = 1 + 0.01f * (float)i;
        step(gn_scene_add_node(scene, &node, &moving));
    }
    gn_channel_desc channel = gn_channel_desc_default();
    channel.node = moving;
    channel.key_count = 2;
    channel.times = (const float[]){0, 1};
    channel.values = (const float[]){0, 1, 0, 0, 2, 0};
    step(gn_scene_add_channel(scene, &channel));
    step(gn_scene_add_sun(scene, 30, 50, &sun));
    step(gn_scene_commit(scene));
    step(gn_scene_add_overview(scene, &camera));
    step(gn_scene_commit(scene));

    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = 40;
    view_desc.height = 30;
    view_desc.samples = 2;
    step(gn_view_create(on, &view_desc, &view));
    step(gn_view_render(view, scene, camera, NULL, &sun, 1));
    step(gn_scene_set_time(scene, 0.5));
    step(gn_scene_commit(scene));
    step(gn_view_render(view, scene, camera, NULL, (const uint32_t[]){sun, sun}, 2));
    node.translation[0] = 0.5f;
    step(gn_scene_add_node(scene, &node, &moving));
    float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1};
    step(gn_scene_set_node_matrix(scene, 3, matrix));
    step(gn_scene_commit(scene));
    step(gn_view_render(view, scene, camera, NULL, &sun, 1));
    *sum = 0;
    for (int i = 0; i < 40 * 30; i++)
        *sum += gn_view_visibility(view, 0)[i];
done:
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
    return result;
}

static void test_allocator(void **state)
{
    (void)state;
    heap h = {.fail_at = -1};
    const gn_device_desc desc = heap_desc(&h);
    gn_device *made = NULL;
    assert_int_equal(gn_device_create(&desc, &made), GN_OK);
    const size_t own = gn_device_bytes(made);
    assert_int_equal(own, h.bytes);
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create(made, &scene), GN_OK);
    assert_int_equal(gn_device_bytes(made), h.bytes);
    assert_true(gn_device_bytes(made) > own);
    gn_scene_destroy(&scene);
    assert_null(scene);
    float sum, again;
    assert_int_equal(use_everything(made, &sum), GN_OK);
    assert_int_equal(gn_device_bytes(made), own);
    assert_int_equal(use_everything(made, &again), GN_OK);
    assert_true(sum == again && sum > 0);
    assert_int_equal(h.bytes, own);
    gn_device_destroy(&made);
    assert_null(made);
    assert_int_equal(h.blocks, 0);
    assert_int_equal(h.bytes, 0);
}

/* Every allocation fails once: a result that says so, nothing lost, and the device still works. */
static void test_out_of_memory(void **state)
{
    (void)state;
    long n = 0;
    for (;; n++) {
        heap h = {.fail_at = n};
        const gn_device_desc desc = heap_desc(&h);
        gn_device *made = NULL;
        gn_result result = gn_device_create(&desc, &made);
        if (result == GN_OK) {
            const size_t own = h.bytes;
            float sum;
            result = use_everything(made, &sum);
            if (h.failed && result == GN_OK)
                fail_msg("allocation %ld failed, and nobody said so", n);
            if (h.bytes != own)
                fail_msg("allocation %ld failed: %zu bytes are lost", n, h.bytes - own);
            if (result != GN_OK) {
                if (!strstr(gn_device_message(made), "memory"))
                    fail_msg("allocation %ld: the message is \"%s\"", n, gn_device_message(made));
                if (n % 16 == 0 && use_everything(made, &sum) != GN_OK)
                    fail_msg("after allocation %ld: %s", n, gn_device_message(made));
            }
            gn_device_destroy(&made);
        } else {
            assert_null(made);
        }
        if (h.failed && result != GN_ERROR_OUT_OF_MEMORY)
            fail_msg("allocation %ld: %s", n, gn_result_string(result));
        if (h.blocks != 0 || h.bytes != 0)
            fail_msg("allocation %ld: %ld blocks of %zu bytes are lost", n, h.blocks, h.bytes);
        if (!h.failed)
            break;
    }
    print_message("%ld allocations failed, one at a time\n", n);
    assert_true(n > 50);
}

/* Descriptors and messages ------------------------------------------------------------------- */

typedef struct journal {
    gn_log_level level;
    char text[1024];
    int count;
} journal;

static void write_journal(gn_log_level level, const char *message, void *user)
{
    journal *j = user;
    j->level = level;
    j->count++;
    snprintf(j->text, sizeof j->text, "%s", message);
}

static void assert_device_refused(gn_device_desc desc, gn_result expected, const char *words)
{
    journal j = {0};
    desc.logger = (gn_logger){write_journal, &j};
    gn_device *made = (gn_device *)&j;
    assert_int_equal(gn_device_create(&desc, &made), expected);
    assert_null(made);
    if (j.count != 1 || j.level != GN_LOG_ERROR || !strstr(j.text, words))
        fail_msg("%d messages, the last is \"%s\", expected \"%s\" in it", j.count, j.text, words);
}

static void test_device_desc(void **state)
{
    (void)state;
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = 1025;
    assert_device_refused(desc, GN_ERROR_INVALID_ARGUMENT, "1025");
    desc = gn_device_desc_default();
    desc.isa = (gn_isa)4;
    assert_device_refused(desc, GN_ERROR_INVALID_ARGUMENT, "4");
    desc = gn_device_desc_default();
    desc.allocator.alloc = heap_alloc;
    assert_device_refused(desc, GN_ERROR_INVALID_ARGUMENT, "alloc");

    /* Without a cookie nothing in a descriptor is trusted, its logger neither. */
    gn_device_desc bad;
    memset(&bad, 0xa5, sizeof bad);
    gn_device *made = NULL;
    assert_int_equal(gn_device_create(&bad, &made), GN_ERROR_INVALID_DESC);
    memset(&bad, 0, sizeof bad);
    assert_int_equal(gn_device_create(&bad, &made), GN_ERROR_INVALID_DESC);
    assert_null(made);
    assert_int_equal(gn_device_create(NULL, NULL), GN_ERROR_INVALID_ARGUMENT);
    gn_device_destroy(NULL);
    gn_device_destroy(&made);
    assert_string_equal(gn_device_message(NULL), "");

    desc = gn_device_desc_default();
    desc.threads = 3;
    desc.isa = GN_ISA_SCALAR;
    assert_int_equal(gn_device_create(&desc, &made), GN_OK);
    const gn_device_info info = gn_device_get_info(made);
    assert_int_equal(info.threads, 3);
    assert_int_equal(info.isa, GN_ISA_SCALAR);
    assert_string_equal(info.isa_name, "scalar");
    assert_true(info.tracer_version[0] >= '3' && strchr(info.tracer_version, '.'));
    assert_string_equal(gn_device_message(made), "");
    gn_device_destroy(&made);
}

#define refused(call, expected, words)                                                             \
    do {                                                                                           \
        assert_int_equal((call), (expected));                                                      \
        if (!strstr(gn_device_message(device), (words)))                                           \
            fail_msg("the message is \"%s\", expected \"%s\" in it", gn_device_message(device),    \
                     (words));                                                                     \
    } while (0)

static void test_view_desc(void **state)
{
    (void)state;
    const gn_result invalid = GN_ERROR_INVALID_ARGUMENT;
    gn_view *view = (gn_view *)&view;
    gn_view_desc zero = {0};
    refused(gn_view_create(device, &zero, &view), GN_ERROR_INVALID_DESC, "gn_view_desc_default");
    assert_null(view);
    const uint32_t wrong[][3] = {{0, 10, 1},     {10, 0, 1},  {16385, 10, 1},
                                 {10, 16385, 1}, {10, 10, 0}, {10, 10, 4097}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        gn_view_desc desc = gn_view_desc_default();
        desc.width = wrong[i][0];
        desc.height = wrong[i][1];
        desc.samples = wrong[i][2];
        refused(gn_view_create(device, &desc, &view), invalid, "range");
    }
    gn_view_destroy(NULL);
    gn_view_destroy(&view);

    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 1, 0, GN_NONE), false);
    const uint32_t sun = add_sun(scene, v3(0, 1, 0));
    const uint32_t camera = add_camera(scene, v3(0, 2, 2), v3(0, 0, 0), 0.8, 0.1);
    gn_view_desc desc = gn_view_desc_default();
    desc.width = desc.height = 8;
    ok(gn_view_create(device, &desc, &view));
    refused(gn_view_render(view, scene, camera, NULL, &sun, 1), GN_ERROR_STATE, "commit");
    ok(gn_scene_commit(scene));
    refused(gn_view_render(view, scene, 1, NULL, &sun, 1), invalid, "camera 1");
    refused(gn_view_render(view, scene, camera, NULL, (const uint32_t[]){1}, 1), invalid,
            "light 1");
    ok(gn_view_render(view, scene, camera, NULL, NULL, 0)); /* no light */
    assert_null(gn_view_visibility(view, 0));
    ok(gn_view_render(view, scene, camera, NULL, &sun, 1));
    assert_non_null(gn_view_visibility(view, 0));
    assert_null(gn_view_visibility(view, 1));

    gn_visibility_desc bad = {0};
    refused(gn_view_render(view, scene, camera, &bad, &sun, 1), GN_ERROR_INVALID_DESC,
            "gn_visibility_desc_default");
    float visibility[64];
    const gn_gbuffer *g = gn_view_gbuffer(view);
    refused(gn_scene_visibility(scene, g, &bad, visibility, NULL), GN_ERROR_INVALID_DESC,
            "gn_visibility_desc_default");
    refused(gn_scene_visibility(scene, g, NULL, visibility, NULL), GN_ERROR_INVALID_DESC,
            "gn_visibility_desc_default");
    const float cutoffs[] = {-0.01f, 0.51f, NAN};
    for (int i = 0; i < 3; i++) {
        gn_visibility_desc v = gn_visibility_desc_default();
        v.cutoff = cutoffs[i];
        refused(gn_scene_visibility(scene, g, &v, visibility, NULL), invalid, "cutoff");
        v = gn_visibility_desc_default();
        v.point_light_clip = i ? NAN : -1;
        refused(gn_scene_visibility(scene, g, &v, visibility, NULL), invalid, "clip");
    }
    gn_visibility_desc v = gn_visibility_desc_default();
    v.method = NULL;
    refused(gn_scene_visibility(scene, g, &v, visibility, NULL), invalid, "method");
    v = gn_visibility_desc_default();
    v.light = 1;
    refused(gn_scene_visibility(scene, g, &v, visibility, NULL), invalid, "light 1");
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
    assert_int_equal(gn_device_bytes(device) > 0, 1);
}

static void test_empty_scene(void **state)
{
    (void)state;
    gn_scene *scene = new_scene();
    ok(gn_scene_commit(scene));
    const uint32_t camera = add_camera(scene, v3(0, 2, 2), v3(0, 0, 0), 0.8, 0);
    const uint32_t sun = add_sun(scene, v3(0, 1, 0));
    ok(gn_scene_commit(scene));
    frame f = render(scene, camera, sun, 20, 10);
    for (size_t i = 0; i < f.pixels; i++)
        assert_true(f.g->surface[i] == GN_NONE && f.visibility[i] == 0);
    end(&f);
    gn_scene_destroy(&scene);
}

/* Methods ------------------------------------------------------------------------------------ */

static void test_methods(void **state)
{
    (void)state;
    size_t count = 0;
    for (const gn_method *const *m = gn_methods; *m; m++, count++) {
        assert_ptr_equal(gn_method_find((*m)->name), *m);
        assert_true(strlen((*m)->description) > 10);
        for (const gn_method *const *other = gn_methods; *other != *m; other++)
            assert_string_not_equal((*other)->name, (*m)->name);
    }
    assert_true(count >= 5);
    assert_non_null(gn_method_find("ray"));
    assert_null(gn_method_find("no such method"));
    assert_null(gn_method_find(NULL));
}

/* Several at once ---------------------------------------------------------------------------- */

static int cancel_at_half(double fraction, const char *what, void *user)
{
    *(int *)user += what != NULL;
    return fraction >= 0.5;
}

static void test_cancel(void **state)
{
    (void)state;
    int reports = 0;
    gn_device_desc desc = gn_device_desc_default();
    desc.progress = (gn_progress){cancel_at_half, &reports};
    gn_device *made;
    assert_int_equal(gn_device_create(&desc, &made), GN_OK);
    float sum;
    assert_int_equal(use_everything(made, &sum), GN_ERROR_CANCELLED);
    assert_true(reports > 0);
    gn_device_destroy(&made);
}

typedef struct job {
    const gn_scene *scene;
    gn_view *view;
    uint32_t camera, light;
    gn_result result;
} job;

static void *run_job(void *user)
{
    job *j = user;
    j->result = GN_OK;
    for (int i = 0; i < 5 && j->result == GN_OK; i++)
        j->result = gn_view_render(j->view, j->scene, j->camera, NULL, &j->light, 1);
    return NULL;
}

static void test_views_at_once(void **state)
{
    (void)state;
    gn_scene *scene = NULL;
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = 0.05;
    ok(gn_scene_create_procedural(device, "grove", &desc, &scene));
    frame alone = render(scene, 0, 0, 160, 100);
    job jobs[4];
    pthread_t threads[4];
    for (int i = 0; i < 4; i++) {
        gn_view_desc view_desc = gn_view_desc_default();
        view_desc.width = 160;
        view_desc.height = 100;
        jobs[i] = (job){.scene = scene};
        ok(gn_view_create(device, &view_desc, &jobs[i].view));
        assert_int_equal(pthread_create(&threads[i], NULL, run_job, &jobs[i]), 0);
    }
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    for (int i = 0; i < 4; i++) {
        ok(jobs[i].result);
        assert_memory_equal(gn_view_visibility(jobs[i].view, 0), alone.visibility,
                            alone.pixels * sizeof(float));
        assert_memory_equal(gn_view_image(jobs[i].view), gn_view_image(alone.view),
                            alone.pixels * 3 * sizeof(float));
        gn_view_destroy(&jobs[i].view);
    }
    end(&alone);
    gn_scene_destroy(&scene);
}

/* Two devices do not know of each other: their messages and bytes are their own. */
static void *use_device(void *user)
{
    float *sum = user;
    gn_device *made = NULL;
    if (gn_device_create(NULL, &made) != GN_OK || use_everything(made, sum) != GN_OK)
        *sum = -1;
    gn_device_destroy(&made);
    return NULL;
}

static void test_two_devices(void **state)
{
    (void)state;
    gn_device *other = NULL;
    ok(gn_device_create(NULL, &other));
    const size_t bytes = gn_device_bytes(device);
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create(other, &scene), GN_OK);
    assert_int_equal(gn_device_bytes(device), bytes);
    assert_int_not_equal(gn_scene_add_sun(scene, NAN, 0, NULL), GN_OK);
    assert_true(strstr(gn_device_message(other), "sun") != NULL);
    assert_null(strstr(gn_device_message(device), "azimuth"));
    gn_scene_destroy(&scene);
    gn_device_destroy(&other);

    float sums[2], alone;
    pthread_t threads[2];
    use_device(&alone);
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, use_device, &sums[i]), 0);
    for (int i = 0; i < 2; i++)
        pthread_join(threads[i], NULL);
    assert_true(alone > 0 && sums[0] == alone && sums[1] == alone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_allocator),   cmocka_unit_test(test_out_of_memory),
        cmocka_unit_test(test_device_desc), cmocka_unit_test(test_view_desc),
        cmocka_unit_test(test_empty_scene), cmocka_unit_test(test_methods),
        cmocka_unit_test(test_cancel),      cmocka_unit_test(test_views_at_once),
        cmocka_unit_test(test_two_devices),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
