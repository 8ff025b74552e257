/* Two pictures: checks, and the differences that need no neighbours. */
#include "measure/picture.h"

#include <math.h>

#include "measure/measure.h"

/* Rows ---------------------------------------------------------------------------------------- */

static float linear_from_srgb(float x)
{
    return x <= 0.04045f ? x * (1.0f / 12.92f) : gn_power((x + 0.055f) * (1.0f / 1.055f), 2.4f);
}

static float srgb_from_linear(float x)
{
    return x <= 0.0031308f ? 12.92f * x : 1.055f * gn_power(x, 1.0f / 2.4f) - 0.055f;
}

void gn_picture_linear(const gn_picture *picture, uint32_t y, float *row)
{
    const size_t count = 3 * (size_t)picture->width;
    const float *from = picture->rgb + y * count;
    for (size_t i = 0; i < count; i++)
        row[i] = gn_clamp(from[i], 0.0f, 1.0f);
    for (size_t i = 0; i < count && !picture->linear; i++)
        row[i] = linear_from_srgb(row[i]);
}

void gn_picture_encoded(const gn_picture *picture, uint32_t y, float *row)
{
    const size_t count = 3 * (size_t)picture->width;
    const float *from = picture->rgb + y * count;
    for (size_t i = 0; i < count; i++)
        row[i] = gn_clamp(from[i], 0.0f, 1.0f);
    for (size_t i = 0; i < count && picture->linear; i++)
        row[i] = srgb_from_linear(row[i]);
}

/* Pixel by pixel ------------------------------------------------------------------------------ */

typedef struct pixel_job {
    const gn_picture *pictures[2];
    float *rows;       /* 2 for each thread */
    double (*sums)[2]; /* for each row: absolute differences, squares */
} pixel_job;

static void add_row(uint32_t y, uint32_t thread, void *user)
{
    const pixel_job *job = user;
    const size_t count = 3 * (size_t)job->pictures[0]->width;
    float *rows[2];
    for (int k = 0; k < 2; k++) {
        rows[k] = job->rows + (2 * (size_t)thread + (size_t)k) * count;
        gn_picture_encoded(job->pictures[k], y, rows[k]);
    }
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count; i++) {
        const double d = (double)rows[0][i] - (double)rows[1][i];
        sum += fabs(d);
        squares += d * d;
    }
    job->sums[y][0] = sum;
    job->sums[y][1] = squares;
}

static gn_result compare_pixels(gn_context *context, const gn_picture *reference,
                                const gn_picture *test, gn_picture_difference *difference)
{
    const uint32_t width = reference->width, height = reference->height;
    pixel_job job = {{reference, test},
                     gn_alloc(context, 6 * (size_t)context->threads * width, sizeof *job.rows),
                     gn_alloc(context, height, sizeof *job.sums)};
    const bool good = job.rows && job.sums;
    if (good) {
        gn_parallel_for(context, height, add_row, &job);
        double sum = 0, squares = 0;
        for (uint32_t y = 0; y < height; y++) {
            sum += job.sums[y][0];
            squares += job.sums[y][1];
        }
        const double values = 3.0 * width * height;
        difference->mean_abs = sum / values;
        difference->psnr = gn_measure_psnr(squares / values, 1);
    }
    gn_free(context, job.rows);
    gn_free(context, job.sums);
    return good ? GN_OK : gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "no memory to compare pictures");
}

/* All ----------------------------------------------------------------------------------------- */

static gn_result check(gn_context *context, const gn_picture *picture, const char *name)
{
    if (!picture || !picture->rgb || picture->width == 0 || picture->height == 0 ||
        picture->width > 65536 || picture->height > 65536)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "the %s picture needs pixels, 1 to 65536 a side", name);
    return GN_OK;
}

gn_result gn_measure_pictures(gn_device *device, const gn_picture *reference,
                              const gn_picture *test, double pixels_per_degree,
                              gn_picture_difference *difference, float *flip_map)
{
    gn_context *context = gn_device_context(device);
    GN_TRY(check(context, reference, "reference"));
    GN_TRY(check(context, test, "test"));
    if (reference->width != test->width || reference->height != test->height)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "pictures of different size: %u x %u and %u x %u pixels", reference->width,
                       reference->height, test->width, test->height);
    if (!(pixels_per_degree >= 1 && pixels_per_degree <= 1000))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%g pixels per degree are not 1 to 1000",
                       pixels_per_degree);

    const size_t pixels = (size_t)reference->width * reference->height;
    float *map = flip_map ? flip_map : gn_alloc(context, pixels, sizeof *map);
    gn_result result = map ? compare_pixels(context, reference, test, difference)
                           : gn_fail(context, GN_ERROR_OUT_OF_MEMORY,
                                     "no memory for a FLIP map of %zu pixels", pixels);
    if (result == GN_OK)
        result = gn_ssim(context, reference, test, &difference->ssim);
    if (result == GN_OK)
        result = gn_flip_map(context, reference, test, pixels_per_degree, map);
    if (result == GN_OK)
        result = gn_flip_pool(context, map, pixels, &difference->flip);
    if (map != flip_map)
        gn_free(context, map);
    return result;
}
