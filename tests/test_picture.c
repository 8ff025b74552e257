/* Two pictures in numbers: PSNR, mean absolute difference and SSIM against closed forms and a plain
 * computation; what is refused; and what happens without memory. */
#include "picture_testing.h"

#define WIDTH  37
#define HEIGHT 23
#define PIXELS ((size_t)WIDTH * HEIGHT)

static float first[3 * PIXELS], second[3 * PIXELS];

static void test_closed_forms(void **state)
{
    (void)state;
    fill_color(first, PIXELS, 0.25f, 0.5f, 0.75f);
    fill_color(second, PIXELS, 0.375f, 0.5f, 0.5f);
    const gn_picture_difference d = measure(first, second, WIDTH, HEIGHT, 67, NULL);
    assert_near(d.mean_abs, (0.125 + 0 + 0.25) / 3, 1e-12, "mean_abs");
    assert_near(d.psnr, -10 * log10((0.015625 + 0 + 0.0625) / 3), 1e-9, "psnr");
    /* Without variance, SSIM is (2ab + C1) / (a^2 + b^2 + C1) of the lumas. */
    const double a = 0.299 * 0.25 + 0.587 * 0.5 + 0.114 * 0.75;
    const double b = 0.299 * 0.375 + 0.587 * 0.5 + 0.114 * 0.5;
    assert_near(d.ssim, (2 * a * b + 1e-4) / (a * a + b * b + 1e-4), 1e-9, "ssim");

    /* One value of one pixel. */
    memcpy(second, first, sizeof first);
    second[3 * 100 + 2] -= 0.5f;
    const gn_picture_difference one = measure(first, second, WIDTH, HEIGHT, 67, NULL);
    assert_near(one.mean_abs, 0.5 / (3.0 * PIXELS), 1e-12, "mean_abs of one value");
    assert_near(one.psnr, 10 * log10(3.0 * PIXELS / 0.25), 1e-9, "psnr of one value");
}

static void test_identical(void **state)
{
    (void)state;
    fill_noise(first, 3 * PIXELS, 1);
    const gn_picture_difference d = measure(first, first, WIDTH, HEIGHT, 67, NULL);
    assert_near(d.mean_abs, 0, 0, "mean_abs");
    assert_true(isinf(d.psnr) && d.psnr > 0);
    assert_near(d.ssim, 1, 1e-12, "ssim");
}

static void test_symmetry(void **state)
{
    (void)state;
    fill_noise(first, 3 * PIXELS, 2);
    fill_shapes(second, WIDTH, HEIGHT, 0);
    const gn_picture_difference d = measure(first, second, WIDTH, HEIGHT, 67, NULL);
    const gn_picture_difference e = measure(second, first, WIDTH, HEIGHT, 67, NULL);
    assert_memory_equal(&d, &e, sizeof d);
    assert_true(d.ssim > -1 && d.ssim < 1 && d.mean_abs > 0 && d.mean_abs < 1 && d.psnr > 0);
}

/* SSIM, window by window. */
static double plain_ssim(const float *a, const float *b)
{
    double weights[11][11], total = 0, sum = 0;
    for (int y = 0; y < 11; y++)
        for (int x = 0; x < 11; x++)
            total += weights[y][x] =
                exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / (2 * 1.5 * 1.5));
    for (int top = 0; top + 11 <= HEIGHT; top++)
        for (int left = 0; left + 11 <= WIDTH; left++) {
            double lumas[2][11][11], mean[2] = {0}, variance[2] = {0}, covariance = 0;
            for (int y = 0; y < 11; y++)
                for (int x = 0; x < 11; x++)
                    for (int k = 0; k < 2; k++) {
                        const float *p = (k ? b : a) + 3 * ((top + y) * WIDTH + left + x);
                        lumas[k][y][x] =
                            0.299 * (double)p[0] + 0.587 * (double)p[1] + 0.114 * (double)p[2];
                        mean[k] += weights[y][x] / total * lumas[k][y][x];
                    }
            for (int y = 0; y < 11; y++)
                for (int x = 0; x < 11; x++) {
                    const double w = weights[y][x] / total;
                    const double d = lumas[0][y][x] - mean[0], e = lumas[1][y][x] - mean[1];
                    variance[0] += w * d * d;
                    variance[1] += w * e * e;
                    covariance += w * d * e;
                }
            sum += (2 * mean[0] * mean[1] + 1e-4) * (2 * covariance + 9e-4) /
                   ((mean[0] * mean[0] + mean[1] * mean[1] + 1e-4) *
                    (variance[0] + variance[1] + 9e-4));
        }
    return sum / (double)((WIDTH - 10) * (HEIGHT - 10));
}

static void test_ssim(void **state)
{
    (void)state;
    fill_noise(first, 3 * PIXELS, 3);
    fill_noise(second, 3 * PIXELS, 4);
    assert_near(measure(first, second, WIDTH, HEIGHT, 67, NULL).ssim, plain_ssim(first, second),
                1e-9, "ssim of noise");
    fill_shapes(first, WIDTH, HEIGHT, 0);
    fill_shapes(second, WIDTH, HEIGHT, 1);
    const double ssim = measure(first, second, WIDTH, HEIGHT, 67, NULL).ssim;
    assert_near(ssim, plain_ssim(first, second), 1e-9, "ssim of shapes");
    assert_true(ssim > 0.2 && ssim < 0.95);

    /* One window, and none. */
    assert_true(!isnan(measure(first, second, 11, 11, 67, NULL).ssim));
    assert_true(isnan(measure(first, second, 10, 11, 67, NULL).ssim));
    assert_true(isnan(measure(first, second, 11, 10, 67, NULL).ssim));
}

/* Linear light is the same picture as its sRGB code. */
static void test_linear(void **state)
{
    (void)state;
    static float linear[3 * PIXELS];
    fill_shapes(first, WIDTH, HEIGHT, 0);
    for (size_t i = 0; i < 3 * PIXELS; i++) {
        const double s = (double)first[i];
        linear[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
    const gn_picture a = {WIDTH, HEIGHT, first, 0}, b = {WIDTH, HEIGHT, linear, 1};
    gn_picture_difference d;
    assert_int_equal(gn_measure_pictures(device(), &a, &b, 67, &d, NULL), GN_OK);
    assert_true(d.mean_abs < 1e-6 && d.psnr > 120);
    assert_near(d.ssim, 1, 1e-9, "ssim");
    assert_true(d.flip.max < 2e-3);
}

static void test_odd_values(void **state)
{
    (void)state;
    fill_noise(first, 3 * PIXELS, 5);
    memcpy(second, first, sizeof first);
    const float odd[] = {NAN, -1, -INFINITY, 2, INFINITY}, shown[] = {0, 0, 0, 1, 1};
    for (int linear = 0; linear < 2; linear++) {
        for (int i = 0; i < 5; i++) {
            first[40 * i] = odd[i];
            second[40 * i] = shown[i];
        }
        const gn_picture a = {WIDTH, HEIGHT, first, linear}, b = {WIDTH, HEIGHT, second, linear};
        gn_picture_difference d;
        assert_int_equal(gn_measure_pictures(device(), &a, &b, 67, &d, NULL), GN_OK);
        assert_near(d.mean_abs + d.flip.max, 0, 0, "difference of clamped values");
    }
}

static void test_refusals(void **state)
{
    (void)state;
    const gn_picture good = {WIDTH, HEIGHT, first, 0};
    gn_picture_difference d;
    gn_picture other = good;
    other.height--;
    assert_refused(gn_measure_pictures(device(), &good, &other, 67, &d, NULL),
                   GN_ERROR_INVALID_ARGUMENT, "37 x 23 and 37 x 22");
    other = (gn_picture){HEIGHT, WIDTH, first, 0}; /* as many pixels */
    assert_refused(gn_measure_pictures(device(), &good, &other, 67, &d, NULL),
                   GN_ERROR_INVALID_ARGUMENT, "37 x 23 and 23 x 37");
    other = good;
    other.rgb = NULL;
    assert_refused(gn_measure_pictures(device(), &good, &other, 67, &d, NULL),
                   GN_ERROR_INVALID_ARGUMENT, "test picture");
    other = (gn_picture){0, 0, first, 0};
    assert_refused(gn_measure_pictures(device(), &other, &other, 67, &d, NULL),
                   GN_ERROR_INVALID_ARGUMENT, "reference picture");
    const double wrong[] = {NAN, 0, -67, 0.99, 1001, INFINITY};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_refused(gn_measure_pictures(device(), &good, &good, wrong[i], &d, NULL),
                       GN_ERROR_INVALID_ARGUMENT, "pixels per degree");
}

static int allowed;

static void *scarce_alloc(size_t size, void *user)
{
    (void)user;
    return allowed-- > 0 ? aligned_alloc(64, (size + 63) / 64 * 64) : NULL;
}

static void scarce_free(void *pointer, size_t size, void *user)
{
    (void)size;
    (void)user;
    free(pointer);
}

static void test_without_memory(void **state)
{
    (void)state;
    const gn_picture picture = {WIDTH, HEIGHT, first, 0};
    const gn_allocator before = context.allocator;
    context.allocator = (gn_allocator){scarce_alloc, scarce_free, NULL};
    gn_result result = GN_ERROR_OUT_OF_MEMORY;
    int failures = 0;
    for (; result != GN_OK && failures < 100; failures++) {
        gn_picture_difference d;
        allowed = failures;
        result = gn_measure_pictures(device(), &picture, &picture, 67, &d, NULL);
        assert_int_equal(context.bytes, 0);
        if (result != GN_OK)
            assert_refused(result, GN_ERROR_OUT_OF_MEMORY, "no memory");
    }
    context.allocator = before;
    assert_int_equal(result, GN_OK);
    assert_true(failures > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms), cmocka_unit_test(test_identical),
        cmocka_unit_test(test_symmetry),     cmocka_unit_test(test_ssim),
        cmocka_unit_test(test_linear),       cmocka_unit_test(test_odd_values),
        cmocka_unit_test(test_refusals),     cmocka_unit_test(test_without_memory),
    };
    return cmocka_run_group_tests_name("picture", tests, NULL, NULL);
}
