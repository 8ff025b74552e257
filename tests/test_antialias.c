/* Antialiasing: pictures that are known at every place, sampled as a renderer would. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/gnomon.h>

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT };

static gn_device *device;

static void ok(gn_result result)
{
    if (result != GN_OK)
        fail_msg("%s", gn_device_message(device));
}

/* A flat surface that fills the picture, and all of it moves alike. */
typedef struct stage {
    gn_gbuffer g;
    float motion[2][PIXELS], depth[PIXELS];
    uint32_t surface[PIXELS];
    float image[PIXELS * 3], out[PIXELS * 3], expected[PIXELS * 3];
} stage;

static stage s;

static void set_stage(float dx, float dy)
{
    s.g = (gn_gbuffer){.width = WIDTH, .height = HEIGHT};
    for (size_t i = 0; i < PIXELS; i++) {
        s.motion[0][i] = dx;
        s.motion[1][i] = dy;
        s.depth[i] = 1;
        s.surface[i] = 0;
    }
    s.g.motion[0] = s.motion[0];
    s.g.motion[1] = s.motion[1];
    s.g.depth = s.depth;
    s.g.surface = s.surface;
}

static gn_antialias *new_antialias(gn_antialias_kind kind)
{
    gn_antialias_desc desc = gn_antialias_desc_default();
    desc.kind = kind;
    desc.width = WIDTH;
    desc.height = HEIGHT;
    gn_antialias *a;
    ok(gn_antialias_create(device, &desc, &a));
    return a;
}

static void apply(gn_antialias *a)
{
    ok(gn_antialias_apply(a, &s.g, s.image, s.out));
}

/* Light at a place of the picture. */
typedef float (*scene_function)(float x, float y);

static float stripes(float x, float y)
{
    return fmodf(x + 0.37f * y + 100, 9.5f) < 4 ? 0.9f : 0.1f;
}

/* Half-planes, by the slope of their edge and the way it runs. */
static float slope;
static bool steep, turned;

static float half_plane(float x, float y)
{
    const float along = steep ? y - HEIGHT / 2 : x - WIDTH / 2;
    const float across = steep ? x - WIDTH / 2 : y - HEIGHT / 2;
    return (across < slope * along + 0.3f) != turned ? 1.0f : 0.0f;
}

static void paint(scene_function scene, const float place[2], float *image)
{
    for (size_t i = 0; i < PIXELS; i++)
        for (size_t c = 0; c < 3; c++)
            image[3 * i + c] = scene((float)(i % WIDTH) + place[0], (float)(i / WIDTH) + place[1]);
}

static void paint_reference(scene_function scene)
{
    enum { SIDE = 8 };
    static float sample[PIXELS * 3];
    memset(s.expected, 0, sizeof s.expected);
    for (int k = 0; k < SIDE * SIDE; k++) {
        const float place[2] = {((float)(k % SIDE) + 0.5f) / SIDE,
                                ((float)(k / SIDE) + 0.5f) / SIDE};
        paint(scene, place, sample);
        for (size_t i = 0; i < PIXELS * 3; i++)
            s.expected[i] += sample[i] / (SIDE * SIDE);
    }
}

static void render_frame(gn_antialias *a, scene_function scene)
{
    float place[2];
    gn_antialias_jitter(a, place);
    assert_true(place[0] > 0 && place[0] < 1 && place[1] > 0 && place[1] < 1);
    paint(scene, place, s.image);
    apply(a);
}

static double error_of(const float *image)
{
    double sum = 0;
    for (size_t i = 0; i < PIXELS * 3; i++) {
        const double d = (double)image[i] - (double)s.expected[i];
        sum += d * d;
    }
    return sqrt(sum / (PIXELS * 3));
}

/* The longer it stands, the nearer it comes to the picture of many samples. */
static void test_taa_settles(void **state)
{
    (void)state;
    set_stage(0, 0);
    gn_antialias *a = new_antialias(GN_ANTIALIAS_TAA);
    paint_reference(stripes);
    double before = INFINITY, first = 0;
    for (uint32_t frame = 1; frame <= 32; frame++) {
        render_frame(a, stripes);
        if (frame & (frame - 1))
            continue;
        const double error = error_of(s.out);
        print_message("%u frames: %.4f from the reference\n", frame, error);
        if (frame <= 8 && !(error < before))
            fail_msg("after %u frames %g, and before %g", frame, error, before);
        first = frame == 1 ? error : first;
        before = error;
    }
    assert_true(before < 0.35 * first);
    gn_antialias_destroy(&a);
}

/* A pattern of texels that knows no places between them, moved by whole pixels. */
static void paint_noise(int32_t dx, int32_t dy, uint32_t frame)
{
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++)
            for (int32_t c = 0; c < 3; c++) {
                uint32_t h = (uint32_t)(x - dx) * 73856093u ^ (uint32_t)(y - dy) * 19349663u ^
                             (uint32_t)c * 83492791u ^ frame % 8 * 2654435761u;
                h = (h ^ h >> 15) * 2246822519u;
                s.image[3 * (y * WIDTH + x) + c] = (float)(h >> 16 & 255) / 255;
            }
}

/* What moves as it is said to is as what stands still. */
static void test_motion(void **state)
{
    (void)state;
    enum { FRAMES = 6, BORDER = 2 * FRAMES + 4 };
    static float still[PIXELS * 3];
    gn_antialias *a = new_antialias(GN_ANTIALIAS_TAA);
    set_stage(0, 0);
    for (uint32_t f = 0; f < FRAMES; f++) {
        paint_noise(0, 0, f);
        apply(a);
    }
    memcpy(still, s.out, sizeof still);
    gn_antialias_reset(a);
    set_stage(-2, 1); /* it was to the left, and below */
    for (uint32_t f = 0; f < FRAMES; f++) {
        paint_noise(2 * (int32_t)f, -(int32_t)f, f);
        apply(a);
    }
    for (int32_t y = BORDER; y < HEIGHT - BORDER; y++)
        for (int32_t x = BORDER; x < WIDTH - BORDER; x++) {
            const float *moved = s.out + 3 * (y * WIDTH + x);
            const float *there = still + 3 * ((y + FRAMES - 1) * WIDTH + x - 2 * (FRAMES - 1));
            if (memcmp(moved, there, 3 * sizeof(float)) != 0)
                fail_msg("pixel %d, %d: %g moved and %g still", x, y, (double)moved[0],
                         (double)there[0]);
        }
    gn_antialias_destroy(&a);
}

/* Nothing is left of what is gone: after a cut, where motion leads out of the picture, and where
 * the new frame has nothing like it. */
static void test_no_ghosts(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        static float fresh[PIXELS * 3];
        gn_antialias *a = new_antialias((gn_antialias_kind)kind),
                     *b = new_antialias((gn_antialias_kind)kind);
        set_stage(0, 0);
        for (int f = 0; f < 5; f++)
            render_frame(a, stripes);
        gn_antialias_reset(a);
        slope = 0.3f;
        for (int f = 0; f < 3; f++) {
            render_frame(a, half_plane);
            memcpy(fresh, s.out, sizeof fresh);
            render_frame(b, half_plane);
            assert_memory_equal(fresh, s.out, sizeof fresh);
        }
        /* Not seen before: as a first frame. */
        set_stage(1e9f, 1e9f);
        render_frame(a, stripes);
        memcpy(fresh, s.out, sizeof fresh);
        if (kind == GN_ANTIALIAS_TAA)
            assert_memory_equal(fresh, s.image, sizeof fresh);
        gn_antialias_destroy(&a);
        gn_antialias_destroy(&b);
    }
    gn_antialias *a = new_antialias(GN_ANTIALIAS_TAA);
    set_stage(0, 0);
    for (size_t i = 0; i < PIXELS * 3; i++)
        s.image[i] = 0.2f;
    for (size_t c = 0; c < 3; c++)
        s.image[3 * (20 * WIDTH + 30) + c] = 1;
    for (int f = 0; f < 10; f++)
        apply(a);
    for (size_t c = 0; c < 3; c++)
        s.image[3 * (20 * WIDTH + 30) + c] = 0.2f;
    apply(a);
    for (size_t i = 0; i < PIXELS * 3; i++)
        if (fabsf(s.out[i] - 0.2f) > 1e-6f)
            fail_msg("value %zu is %g, and should be 0.2", i, (double)s.out[i]);
    gn_antialias_destroy(&a);
}

/* Without edges there is nothing to do. */
static void test_smooth_pictures(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        gn_antialias *a = new_antialias((gn_antialias_kind)kind);
        set_stage(0, 0);
        for (size_t i = 0; i < PIXELS * 3; i++)
            s.image[i] = 0.7f;
        for (int f = 0; f < 4; f++)
            apply(a);
        for (size_t i = 0; i < PIXELS * 3; i++)
            if (fabsf(s.out[i] - 0.7f) > (kind == GN_ANTIALIAS_TAA ? 1e-6f : 0.0f))
                fail_msg("kind %d: %.9g in place of 0.7", kind, (double)s.out[i]);
        gn_antialias_destroy(&a);
    }
    gn_antialias *a = new_antialias(GN_ANTIALIAS_SMAA_T2X);
    for (size_t i = 0; i < PIXELS * 3; i++)
        s.image[i] = 0.1f + 0.01f * (float)(i / 3 % WIDTH) + 0.003f * (float)(i / 3 / WIDTH);
    for (int f = 0; f < 3; f++)
        apply(a);
    assert_memory_equal(s.out, s.image, sizeof s.out);
    gn_antialias_destroy(&a);
}

/* Half-planes of many slopes: a frame alone, the mean of the two places, and SMAA T2X. */
static void test_smaa_edges(void **state)
{
    (void)state;
    static float mean[PIXELS * 3];
    double sums[3] = {0};
    int count = 0;
    set_stage(0, 0);
    for (int k = 0; k < 32; k++, count++) {
        slope = (0.04f + 0.11f * (float)(k >> 3 & 3)) * (k & 1 ? 1.0f : -1.0f);
        steep = k & 2;
        turned = k & 4;
        paint_reference(half_plane);
        static const float centre[2] = {0.5f, 0.5f};
        paint(half_plane, centre, s.image);
        const double alone = error_of(s.image);
        gn_antialias *a = new_antialias(GN_ANTIALIAS_SMAA_T2X);
        memset(mean, 0, sizeof mean);
        for (int f = 0; f < 2; f++) {
            render_frame(a, half_plane);
            for (size_t i = 0; i < PIXELS * 3; i++)
                mean[i] += 0.5f * s.image[i];
        }
        const double both = error_of(mean), smaa = error_of(s.out);
        if (!(smaa < 0.55 * alone && smaa < 0.8 * both))
            fail_msg("slope %g, %s: %.4f alone, %.4f as a mean, %.4f by SMAA T2X", (double)slope,
                     steep ? "steep" : "flat", alone, both, smaa);
        sums[0] += alone;
        sums[1] += both;
        sums[2] += smaa;
        gn_antialias_destroy(&a);
    }
    print_message("from the reference: %.4f alone, %.4f as a mean of two, %.4f by SMAA T2X\n",
                  sums[0] / count, sums[1] / count, sums[2] / count);
}

/* Another number of threads, the same bits. */
static void test_threads(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        static float results[2][PIXELS * 3];
        for (uint32_t t = 0; t < 2; t++) {
            gn_device_desc desc = gn_device_desc_default();
            desc.threads = 1 + 4 * t;
            gn_device *const usual = device;
            ok(gn_device_create(&desc, &device));
            const size_t held = gn_device_bytes(device);
            gn_antialias *a = new_antialias((gn_antialias_kind)kind);
            set_stage(0.37f, -1.21f);
            for (uint32_t f = 0; f < 4; f++) {
                paint_noise(0, 0, f);
                apply(a);
            }
            memcpy(results[t], s.out, sizeof s.out);
            gn_antialias_destroy(&a);
            assert_int_equal(gn_device_bytes(device), held);
            gn_device_destroy(&device);
            device = usual;
        }
        assert_memory_equal(results[0], results[1], sizeof results[0]);
    }
}

static void refused(const gn_antialias_desc *desc, const char *reason)
{
    gn_antialias *a;
    if (gn_antialias_create(device, desc, &a) == GN_OK || a)
        fail_msg("not refused: %s", reason);
    if (!strstr(gn_device_message(device), reason))
        fail_msg("'%s' is not in: %s", reason, gn_device_message(device));
}

static void test_refusals(void **state)
{
    (void)state;
    const gn_antialias_desc good = gn_antialias_desc_default();
    gn_antialias_desc desc = good;
    desc.cookie = 0;
    refused(&desc, "gn_antialias_desc_default");
    desc = good, desc.kind = (gn_antialias_kind)2;
    refused(&desc, "does not exist");
    desc = good, desc.width = 0;
    refused(&desc, "0 x 1080");
    desc = good, desc.blend = 0;
    refused(&desc, "a blend of 0");
    desc = good, desc.deviations = NAN;
    refused(&desc, "deviations");
    desc = good, desc.threshold = 1.5f;
    refused(&desc, "a threshold of 1.5");
    gn_antialias *a = new_antialias(GN_ANTIALIAS_TAA);
    set_stage(0, 0);
    s.g.width = WIDTH - 1;
    assert_int_equal(gn_antialias_apply(a, &s.g, s.image, s.out), GN_ERROR_INVALID_ARGUMENT);
    gn_antialias_destroy(&a);
    gn_antialias_destroy(&a);
}

/* A real view: jitter leaves motion at rest, and the pictures come nearer to that of many samples.
 */
static void test_view(void **state)
{
    (void)state;
    gn_scene *scene;
    ok(gn_scene_create_procedural(device, "railing", NULL, &scene));
    ok(gn_scene_commit(scene));
    const uint32_t light = 0;
    gn_visibility_desc visibility = gn_visibility_desc_default();
    visibility.method = gn_method_find("ray-mip0");
    gn_view_desc desc = gn_view_desc_default();
    desc.width = WIDTH;
    desc.height = HEIGHT;
    gn_view *view, *reference;
    ok(gn_view_create(device, &desc, &view));
    desc.samples = 64;
    ok(gn_view_create(device, &desc, &reference));
    ok(gn_view_render(reference, scene, 0, &visibility, &light, 1));
    memcpy(s.expected, gn_view_image(reference), sizeof s.expected);
    ok(gn_view_render(view, scene, 0, &visibility, &light, 1));
    const double alone = error_of(gn_view_image(view));
    assert_int_equal(gn_view_set_jitter(view, 1, 0), GN_ERROR_INVALID_ARGUMENT);
    assert_int_equal(gn_view_set_jitter(view, 0, NAN), GN_ERROR_INVALID_ARGUMENT);
    for (int kind = 0; kind < 2; kind++) {
        gn_antialias *a = new_antialias((gn_antialias_kind)kind);
        for (int f = 0; f < 16; f++) {
            float place[2];
            gn_antialias_jitter(a, place);
            ok(gn_view_set_jitter(view, place[0], place[1]));
            ok(gn_view_render(view, scene, 0, &visibility, &light, 1));
            ok(gn_antialias_apply(a, gn_view_gbuffer(view), gn_view_image(view), s.out));
        }
        for (size_t i = 0; i < PIXELS; i++)
            assert_true(gn_view_gbuffer(view)->motion[0][i] == 0.0f);
        const double error = error_of(s.out);
        print_message("railing: %.4f from the reference alone, %.4f by %s\n", alone, error,
                      kind ? "SMAA T2X" : "TAA");
        assert_true(error < (kind ? 0.75 : 0.65) * alone);
        gn_antialias_destroy(&a);
    }
    gn_view_destroy(&view);
    gn_view_destroy(&reference);
    gn_scene_destroy(&scene);
}

static int open_all(void **state)
{
    (void)state;
    return gn_device_create(NULL, &device) == GN_OK ? 0 : -1;
}

static int close_all(void **state)
{
    (void)state;
    gn_device_destroy(&device);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_taa_settles), cmocka_unit_test(test_motion),
        cmocka_unit_test(test_no_ghosts),   cmocka_unit_test(test_smooth_pictures),
        cmocka_unit_test(test_smaa_edges),  cmocka_unit_test(test_threads),
        cmocka_unit_test(test_refusals),    cmocka_unit_test(test_view)};
    return cmocka_run_group_tests_name("antialias", tests, open_all, close_all);
}
