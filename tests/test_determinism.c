/* The same input gives the same bytes; instruction sets agree. */
#include "render_testing.h"

/* Their first camera and light. */
static const char *const kinds[] = {"grove", "leafbox", "court"};
#define KINDS (sizeof kinds / sizeof *kinds)

static const char *const methods[] = {"ray-mip0",     "ray-raw",      "ray-test",
                                      "ray-saturate", "ray-coverage", "sm",
                                      "pcf9",         "evsm64",       "nlmsm64"};
#define METHODS (sizeof methods / sizeof *methods)

/* A frame, and visibility by every method. */
typedef struct result {
    gn_scene *scene;
    frame frame;
    float *visibility[METHODS];
} result;

static bool make_device(uint32_t threads, gn_isa isa, gn_device **made)
{
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = threads;
    desc.isa = isa;
    const gn_result created = gn_device_create(&desc, made);
    if (created != GN_ERROR_UNSUPPORTED)
        assert_int_equal(created, GN_OK);
    return created == GN_OK;
}

/* As an animation would: not at its first time. */
static result render_all(gn_device *on, const char *kind, uint32_t width, uint32_t samples)
{
    result r;
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = 0.1;
    ok(gn_scene_create_procedural(on, kind, &desc, &r.scene));
    ok(gn_scene_set_time(r.scene, 0.7));
    ok(gn_scene_commit(r.scene));
    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = width;
    view_desc.height = width * 9 / 16;
    view_desc.samples = samples;
    r.frame = (frame){.pixels = (size_t)width * view_desc.height};
    ok(gn_view_create(on, &view_desc, &r.frame.view));
    ok(gn_view_render(r.frame.view, r.scene, 0, NULL, (const uint32_t[]){0}, 1));
    r.frame.g = gn_view_gbuffer(r.frame.view);
    r.frame.visibility = gn_view_visibility(r.frame.view, 0);
    for (size_t m = 0; m < METHODS; m++) {
        gn_visibility_desc visibility = gn_visibility_desc_default();
        visibility.method = gn_method_find(methods[m]);
        visibility.map.resolution = 256;
        visibility.frame = 3;
        r.visibility[m] = malloc(r.frame.pixels * sizeof(float));
        assert_non_null(r.visibility[m]);
        ok(gn_scene_visibility(r.scene, r.frame.g, &visibility, r.visibility[m], NULL));
    }
    return r;
}

static void forget(result *r)
{
    for (size_t m = 0; m < METHODS; m++)
        free(r->visibility[m]);
    end(&r->frame);
    gn_scene_destroy(&r->scene);
}

static void same_bytes(const void *a, const void *b, size_t bytes, const char *kind,
                       const char *when, const char *what)
{
    if (memcmp(a, b, bytes) == 0)
        return;
    size_t i = 0;
    while (memcmp((const char *)a + i, (const char *)b + i, 4) == 0)
        i += 4;
    fail_msg("%s, %s: %s differs first at value %zu", kind, when, what, i / 4);
}

static void assert_same(const result *a, const result *b, const char *kind, const char *when)
{
    const size_t bytes = a->frame.pixels * sizeof(float);
    const gn_gbuffer *g = a->frame.g, *h = b->frame.g;
    for (size_t m = 0; m < METHODS; m++)
        same_bytes(a->visibility[m], b->visibility[m], bytes, kind, when, methods[m]);
    same_bytes(a->frame.visibility, b->frame.visibility, bytes, kind, when, "visibility");
    same_bytes(gn_view_image(a->frame.view), gn_view_image(b->frame.view), 3 * bytes, kind, when,
               "image");
    same_bytes(g->depth, h->depth, bytes, kind, when, "depth");
    same_bytes(g->origin_error, h->origin_error, bytes, kind, when, "origin_error");
    same_bytes(g->cone_width, h->cone_width, bytes, kind, when, "cone_width");
    same_bytes(g->albedo, h->albedo, bytes, kind, when, "albedo");
    same_bytes(g->surface, h->surface, bytes, kind, when, "surface");
    for (int axis = 0; axis < 3; axis++) {
        same_bytes(g->position[axis], h->position[axis], bytes, kind, when, "position");
        same_bytes(g->normal[axis], h->normal[axis], bytes, kind, when, "normal");
        same_bytes(g->shading_normal[axis], h->shading_normal[axis], bytes, kind, when,
                   "shading_normal");
        same_bytes(g->motion[axis], h->motion[axis], bytes, kind, when, "motion");
    }
}

/* Devices of their own: the tree, too, is built by their threads. */
static void test_threads(void **state)
{
    (void)state;
    static const uint32_t threads[] = {1, 2, 4, 4};
    gn_device *devices[4];
    for (int i = 0; i < 4; i++)
        assert_true(make_device(threads[i], GN_ISA_AUTO, &devices[i]));
    for (size_t k = 0; k < KINDS; k++) {
        result one = render_all(devices[0], kinds[k], 256, 1);
        picture(&one.frame, kinds[k]);
        for (int i = 1; i < 4; i++) {
            char when[32];
            snprintf(when, sizeof when, "%u threads", threads[i]);
            result other = render_all(devices[i], kinds[k], 256, 1);
            assert_same(&one, &other, kinds[k], when);
            forget(&other);
        }
        forget(&one);
    }
    /* Several samples a pixel. */
    result a = render_all(devices[0], "leafbox", 256, 3),
           b = render_all(devices[2], "leafbox", 256, 3);
    assert_same(&a, &b, "leafbox", "3 samples");
    forget(&a);
    forget(&b);
    for (int i = 0; i < 4; i++)
        gn_device_destroy(&devices[i]);
}

static void test_instruction_sets(void **state)
{
    (void)state;
    static const gn_isa sets[] = {GN_ISA_SCALAR, GN_ISA_AVX2, GN_ISA_AVX512};
    gn_device *devices[3];
    bool have[3];
    for (int i = 0; i < 3; i++)
        have[i] = make_device(0, sets[i], &devices[i]);
    assert_true(have[0]);
    size_t wrong[3] = {0}, shades[3] = {0}, pixels = 0;
    for (size_t k = 0; k < KINDS; k++) {
        result scalar = render_all(devices[0], kinds[k], 480, 1);
        pixels += METHODS * scalar.frame.pixels;
        for (int i = 1; i < 3; i++) {
            if (!have[i])
                continue;
            result wide = render_all(devices[i], kinds[k], 480, 1);
            for (size_t m = 0; m < METHODS; m++) {
                const float *a = scalar.visibility[m], *b = wide.visibility[m];
                wrong[i] += count_different(a, b, scalar.frame.pixels, 0.5f);
                shades[i] += count_different(a, b, scalar.frame.pixels, 1 / 255.0f);
            }
            forget(&wide);
        }
        forget(&scalar);
    }
    for (int i = 1; i < 3; i++) {
        if (!have[i])
            continue;
        const char *name = gn_device_get_info(devices[i]).isa_name;
        print_message("scalar and %s: %zu of %zu pixels differ by more than 0.5, %zu by more than "
                      "1/255\n",
                      name, wrong[i], pixels, shades[i]);
        few(wrong[i], pixels, 1e-5, "scalar and %s", name);
    }
    for (int i = 0; i < 3; i++)
        gn_device_destroy(&devices[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_instruction_sets),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
