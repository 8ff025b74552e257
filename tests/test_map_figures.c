/* The moment paper's figures as numbers: what each kind of map leaks.
 *
 * Christoph Peters, "Non-Linearly Quantized Moment Shadow Maps", HPG 2017. The truth is visibility
 * filtered the same way: 9x9 depths of the very texels that a filtered one was made of, each
 * compared with the receiver and weighted with the same Gaussian. Of one map, read with NEAREST,
 * that is what percentage-closer filtering computes. All kinds read the same depths with the same
 * biases, so that what differs from the truth is the kind's own. */
#include "render_testing.h"

#include "cpu/map.h"
#include "render/device.h"
#include "render/shadow_map.h"

enum { TRUTH, VSM32, EVSM64, EVSM128, MSM64, MSM128, NLMSM64, NLMSM32, KINDS };
static const char *const names[KINDS] = {"pcf9",  "vsm32",  "evsm64",  "evsm128",
                                         "msm64", "msm128", "nlmsm64", "nlmsm32"};

/* A picture of a scene read by every kind. Pixels that face away from the light are no part of it.
 */
typedef struct shot {
    gn_scene *scene;
    gn_view *view;
    const gn_gbuffer *g;
    size_t pixels;
    float *visibility[KINDS];
    int *casters; /* where the truth is 0: groups of depths in the window; else 0 */
    float *gap;   /* from the farthest of them to the receiver, parts of the range */
} shot;

static bool faces_light(const shot *s, size_t i)
{
    const float *d = s->scene->lights[0].direction;
    return s->g->surface[i] != GN_NONE &&
           dot(normal_at(s->g, i), v3((double)d[0], (double)d[1], (double)d[2])) < 0;
}

static int ascending(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The 81 depths of a pixel's window, in order: where two neighbours are 0.004 of the range apart,
 * one caster ends and the next begins. */
static void look_at_window(shot *s, size_t i, const gn_map_job *job)
{
    const gn_map_layer *layer = &job->layers[0];
    const gn_map_projection *p = &layer->projection;
    const long size = (long)p->resolution;
    const vec origin = v3((double)p->origin[0], (double)p->origin[1], (double)p->origin[2]);
    const vec from = sub(
        add(position_at(s->g, i), mul(normal_at(s->g, i), (double)s->g->origin_error[i])), origin);
    double place[3];
    const float *const axes[3] = {p->right, p->up, p->forward};
    for (int k = 0; k < 3; k++)
        place[k] = dot(from, v3((double)axes[k][0], (double)axes[k][1], (double)axes[k][2]));
    const long column = (long)floor((1 + place[0] / (double)p->extent) / 2 * (double)size);
    const long row = (long)floor((1 - place[1] / (double)p->extent) / 2 * (double)size);
    float depths[81];
    int count = 0;
    for (long y = row - 4; y <= row + 4; y++)
        for (long x = column - 4; x <= column + 4; x++) {
            assert_true(x >= 0 && y >= 0 && x < size && y < size);
            depths[count++] = layer->depth[0][y * size + x];
        }
    qsort(depths, 81, sizeof *depths, ascending);
    s->casters[i] = 1;
    for (int k = 1; k < count; k++)
        s->casters[i] += depths[k] - depths[k - 1] > 0.004f;
    s->gap[i] = (float)((place[2] - (double)p->near) / (double)(p->far - p->near)) - depths[80];
}

/* A single map over the whole of what is seen, with the paper's depth bias and no other. */
static shot take(const char *name, uint32_t camera, uint32_t resolution)
{
    enum { W = 640, H = 360 };
    shot s = {.pixels = (size_t)W * H};
    ok(gn_scene_create_procedural(device, name, NULL, &s.scene));
    gn_view_desc view = gn_view_desc_default();
    view.width = W;
    view.height = H;
    ok(gn_view_create(device, &view, &s.view));
    ok(gn_view_trace_gbuffer(s.view, s.scene, camera));
    s.g = gn_view_gbuffer(s.view);
    assert_non_null(s.casters = calloc(s.pixels, sizeof *s.casters));
    assert_non_null(s.gap = calloc(s.pixels, sizeof *s.gap));
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = resolution;
    desc.cascades = 1;
    desc.reading = GN_READING_NEAREST;
    desc.depth_bias = 5e-4f;
    desc.normal_bias = 0;
    for (int k = 0; k < KINDS; k++) {
        assert_non_null(s.visibility[k] = malloc(s.pixels * sizeof(float)));
        gn_shadow_map *map;
        ok(gn_shadow_map_create(device, &gn_method_find(names[k])->map, &desc, &map));
        ok(gn_shadow_map_update(map, s.scene, 0, camera, (float)W / H, NULL));
        gn_map_job job = {
            .gbuffer = s.g, .light = s.scene->lights[0], .visibility = s.visibility[k]};
        gn_shadow_map_fill_job(map, &job);
        ok(gn_cpu_map_visibility(&device->cpu, &job));
        for (size_t i = 0; k == TRUTH && i < s.pixels; i++)
            if (s.visibility[TRUTH][i] == 0 && faces_light(&s, i))
                look_at_window(&s, i, &job);
        gn_shadow_map_destroy(&map);
    }
    return s;
}

static void release(shot *s)
{
    for (int k = 0; k < KINDS; k++)
        free(s->visibility[k]);
    free(s->casters);
    free(s->gap);
    gn_view_destroy(&s->view);
    gn_scene_destroy(&s->scene);
}

/* Mean absolute error against the truth where the light is wholly blocked, by a number of casters
 * [from, to] of which the farthest is a distance [near, far) before the receiver: what leaks. */
static double leak(const shot *s, int kind, int from, int to, double near, double far,
                   size_t *pixels)
{
    double sum = 0;
    *pixels = 0;
    for (size_t i = 0; i < s->pixels; i++) {
        const double gap = (double)s->gap[i];
        if (s->casters[i] < from || s->casters[i] > to || gap < near || gap >= far)
            continue;
        sum += (double)s->visibility[kind][i];
        (*pixels)++;
    }
    return *pixels > 0 ? sum / (double)*pixels : 0;
}

/* a < factor * b, or both numbers are printed. */
#define below(a, factor, b, what)                                                                  \
    do {                                                                                           \
        if (!((a) < (factor) * (b)))                                                               \
            fail_msg("%s: %g is not below %g times %g", what, a, (double)(factor), b);             \
    } while (0)

/* Every bound is above the truth, but for what its numbers round: never darker. 10 bits of depth
 * are off by half a step of 1 / 1023, which the paper's bias does not wholly cover. */
static void assert_bounds(const shot *s)
{
    for (int k = VSM32; k < KINDS; k++) {
        size_t darker = 0;
        for (size_t i = 0; i < s->pixels; i++)
            darker += s->visibility[k][i] < s->visibility[TRUTH][i] - 0.01f;
        few(darker, s->pixels, k == NLMSM32 ? 0.002 : 0, "%s is darker than the truth", names[k]);
    }
}

/* Figure 1: a railing shadows a banner, the banner the ground, both over a short range. */
static void test_figure_1(void **state)
{
    (void)state;
    shot s = take("railing", 0, 2048);
    double umbra[KINDS];
    size_t pixels = 0;
    print_message("railing, mean absolute error in full shadow\n");
    for (int k = VSM32; k < KINDS; k++) {
        umbra[k] = leak(&s, k, 1, 81, 8.0 / 1023, 1, &pixels);
        print_message("  %-8s %.5f\n", names[k], umbra[k]);
    }
    assert_true(pixels > 1000);
    assert_bounds(&s);
    /* Those that leak, and those that hardly do. */
    static const int much[] = {VSM32, EVSM64, MSM64},
                     little[] = {EVSM128, MSM128, NLMSM64, NLMSM32};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 4; b++)
            below(umbra[little[b]], 0.25, umbra[much[a]], "full shadow");
    below(umbra[EVSM64], 1, umbra[VSM32], "full shadow");
    below(umbra[MSM64], 1, umbra[VSM32], "full shadow");
    /* 64 bits are as good as 128, and 32 bits leak hardly more. */
    below(fabs(umbra[NLMSM64] - umbra[MSM128]), 0.01, umbra[MSM128], "full shadow");
    below(fabs(umbra[NLMSM32] - umbra[MSM128]), 0.05, umbra[MSM128], "full shadow");
    release(&s);
}

/* Figure 8: shadows over a range of a few steps of 10 bits have bands, of 16 bits none. */
static void test_figure_8(void **state)
{
    (void)state;
    shot s = take("railing", 0, 2048);
    double error[KINDS] = {0}, worst[KINDS] = {0};
    size_t pixels = 0;
    for (size_t i = 0; i < s.pixels; i++) {
        if (s.casters[i] == 0 || s.gap[i] > 8.0f / 1023)
            continue;
        pixels++;
        for (int k = NLMSM64; k <= NLMSM32; k++) {
            const double e = fabs((double)s.visibility[k][i] - (double)s.visibility[MSM128][i]);
            error[k] += e;
            worst[k] = fmax(worst[k], e);
        }
    }
    assert_true(pixels > 300);
    print_message(
        "shadows over a short range, against 128 bits: mean %.6f, worst %.4f with 64 bits; "
        "mean %.6f, worst %.4f with 32\n",
        error[NLMSM64] / (double)pixels, worst[NLMSM64], error[NLMSM32] / (double)pixels,
        worst[NLMSM32]);
    below(error[NLMSM64], 0.05, error[NLMSM32], "mean");
    below(worst[NLMSM64], 0.2, worst[NLMSM32], "worst");
    assert_true(worst[NLMSM32] > 0.01);
    release(&s);
}

/* Figure 9: umbrella, roof and railing one behind the other. Four moments tell two depths apart, so
 * that a third leaks; two exponentials keep the farthest one. The map is coarse, so that its window
 * holds all three. */
static void test_figure_9(void **state)
{
    (void)state;
    shot s = take("railing", 1, 256);
    static const int four[] = {MSM128, NLMSM64, NLMSM32};
    size_t pixels;
    const double exponentials = leak(&s, EVSM128, 3, 81, 8.0 / 1023, 1, &pixels);
    for (int k = 0; k < 3; k++) {
        const double one = leak(&s, four[k], 1, 1, 8.0 / 1023, 1, &pixels);
        assert_true(pixels > 100);
        const double three = leak(&s, four[k], 3, 81, 8.0 / 1023, 1, &pixels);
        assert_true(pixels > 100);
        print_message("%s behind one caster: %.5f, behind three: %.5f (evsm128: %.5f)\n",
                      names[four[k]], one, three, exponentials);
        below(one, 0.05, three, names[four[k]]);
        below(exponentials, 0.5, three, names[four[k]]);
        assert_true(three > 0.01);
    }
    release(&s);
}

/* Section 5.1: 64 bits against 128, both read with NEAREST and the paper's depth bias. */
static void compare_bits(gn_scene *scene, const char *name, uint32_t cascades, uint32_t width,
                         uint32_t height, double share, double largest)
{
    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = width;
    view_desc.height = height;
    gn_view *view;
    ok(gn_view_create(device, &view_desc, &view));
    ok(gn_view_trace_gbuffer(view, scene, 0));
    const size_t pixels = (size_t)width * height;
    float *visibility[2];
    for (int k = 0; k < 2; k++) {
        assert_non_null(visibility[k] = malloc(pixels * sizeof(float)));
        gn_visibility_desc desc = gn_visibility_desc_default();
        desc.method = gn_method_find(k == 0 ? "msm128" : "nlmsm64");
        desc.map.cascades = cascades;
        desc.map.reading = GN_READING_NEAREST;
        desc.map.depth_bias = 5e-4f;
        desc.map.normal_bias = 0;
        ok(gn_scene_visibility(scene, gn_view_gbuffer(view), &desc, visibility[k], NULL));
    }
    double worst = 0;
    for (size_t i = 0; i < pixels; i++)
        worst = fmax(worst, fabs((double)visibility[0][i] - (double)visibility[1][i]));
    const size_t different = count_different(visibility[0], visibility[1], pixels, 0.03f);
    print_message("%s, %u cascades: %zu of %zu pixels differ by more than 0.03, the largest "
                  "difference is %.4f\n",
                  name, cascades, different, pixels, worst);
    few(different, pixels, share, "%s: pixels that differ by more than 0.03", name);
    if (worst > largest)
        fail_msg("%s: the largest difference is %g, allowed are %g", name, worst, largest);
    free(visibility[0]);
    free(visibility[1]);
    gn_view_destroy(&view);
}

/* One map, as in the paper, and four cascades, whose depth ranges are so short that weights below
 * half a step of 16 bits matter: there single pixels differ by more. */
static void compare_scene(gn_scene *scene, const char *name, uint32_t width, uint32_t height)
{
    compare_bits(scene, name, 1, width, height, 1e-5, 0.1);
    compare_bits(scene, name, 4, width, height, 2e-5, 0.5);
}

static void test_quantization(void **state)
{
    (void)state;
    static const char *const scenes[] = {"railing", "court", "grove"};
    const char *folder = getenv("GNOMON_SCENES");
    for (int i = 0; i < 3; i++) {
        gn_scene *scene;
        ok(gn_scene_create_procedural(device, scenes[i], NULL, &scene));
        if (folder)
            compare_scene(scene, scenes[i], 1920, 1080);
        else
            compare_scene(scene, scenes[i], 480, 270);
        gn_scene_destroy(&scene);
    }
    if (!folder)
        print_message("GNOMON_SCENES is not set: the real scenes and 1920 x 1080 are skipped\n");
    for (int i = 1; folder && i < 3; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s.glb", folder, scenes[i]);
        gn_scene *scene;
        ok(gn_scene_load(device, path, &scene));
        compare_scene(scene, path, 1920, 1080);
        gn_scene_destroy(&scene);
    }
}

/* No length is built in: a scene 1024 times as large or as small has the same shadows, to the bit
 * (by 1000, places between texels would be rounded otherwise). */
static void test_scale(void **state)
{
    (void)state;
    enum { W = 160, H = 90 };
    static const char *const methods[] = {"sm", "pcf9", "evsm128", "msm64", "nlmsm64", "sd-vsm"};
    static const double units[] = {1, 1.0 / 1024, 1024};
    static float visibility[3][W * H];
    for (int m = 0; m < 6; m++) {
        for (int u = 0; u < 3; u++) {
            gn_procedural_desc desc = gn_procedural_desc_default();
            desc.unit = units[u];
            gn_scene *scene;
            ok(gn_scene_create_procedural(device, "court", &desc, &scene));
            gn_visibility_desc how = gn_visibility_desc_default();
            how.method = gn_method_find(methods[m]);
            how.map.resolution = 512;
            frame f = render_desc(scene, 0, 0, &how, W, H);
            memcpy(visibility[u], f.visibility, sizeof visibility[u]);
            end(&f);
            gn_scene_destroy(&scene);
        }
        for (int u = 1; u < 3; u++)
            few(count_different(visibility[0], visibility[u], W * H, 0), W * H, 0, "%s, unit %g",
                methods[m], units[u]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_figure_1), cmocka_unit_test(test_figure_8),
        cmocka_unit_test(test_figure_9), cmocka_unit_test(test_quantization),
        cmocka_unit_test(test_scale),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
