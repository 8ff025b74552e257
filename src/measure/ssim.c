/* Structural similarity (Wang et al. 2004), of luma: 11 x 11 Gaussian, sigma 1.5, K1 = 0.01,
 * K2 = 0.03. Means and moments of the windows are sums along rows, then along columns. */
#include <math.h>

#include "measure/picture.h"

#define WINDOW 11u
#define BAND   16u /* rows of windows that a thread does at once */

enum { MEAN_A, MEAN_B, SQUARE_A, SQUARE_B, PRODUCT, MOMENTS };

typedef struct ssim_job {
    const gn_picture *pictures[2];
    uint32_t columns, rows; /* windows that fit */
    double weights[WINDOW];
    double *scratch; /* for each thread */
    size_t scratch_size;
    double *sums; /* one a row of windows */
} ssim_job;

/* The moments of row y along x. */
static void add_row(const ssim_job *job, uint32_t y, double *luma, float *rgb, double *moments)
{
    const uint32_t width = job->pictures[0]->width;
    for (uint32_t k = 0; k < 2; k++) {
        gn_picture_encoded(job->pictures[k], y, rgb);
        for (uint32_t x = 0; x < width; x++)
            luma[k * width + x] = 0.299 * (double)rgb[3 * x] + 0.587 * (double)rgb[3 * x + 1] +
                                  0.114 * (double)rgb[3 * x + 2];
    }
    const size_t columns = job->columns;
    for (size_t i = 0; i < MOMENTS * columns; i++)
        moments[i] = 0;
    for (uint32_t k = 0; k < WINDOW; k++) {
        const double weight = job->weights[k];
        const double *a = luma + k, *b = luma + width + k;
#pragma omp simd
        for (size_t x = 0; x < columns; x++) {
            moments[MEAN_A * columns + x] += weight * a[x];
            moments[MEAN_B * columns + x] += weight * b[x];
            moments[SQUARE_A * columns + x] += weight * (a[x] * a[x]);
            moments[SQUARE_B * columns + x] += weight * (b[x] * b[x]);
            moments[PRODUCT * columns + x] += weight * (a[x] * b[x]);
        }
    }
}

static double similarity(const double *moments, size_t columns)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const double a = moments[MEAN_A * columns], b = moments[MEAN_B * columns];
    const double variances =
        moments[SQUARE_A * columns] - a * a + (moments[SQUARE_B * columns] - b * b);
    const double covariance = moments[PRODUCT * columns] - a * b;
    return (2 * a * b + c1) * (2 * covariance + c2) / ((a * a + b * b + c1) * (variances + c2));
}

static void add_band(uint32_t band, uint32_t thread, void *user)
{
    const ssim_job *job = user;
    const uint32_t first = band * BAND;
    const uint32_t rows = job->rows - first < BAND ? job->rows - first : BAND;
    const size_t columns = job->columns, size = MOMENTS * columns;
    double *lines = job->scratch + thread * job->scratch_size;
    double *moments = lines + (BAND + WINDOW - 1) * size, *luma = moments + size;
    float *rgb = (float *)(luma + 2 * (size_t)job->pictures[0]->width);
    for (uint32_t i = 0; i < rows + WINDOW - 1; i++)
        add_row(job, first + i, luma, rgb, lines + i * size);
    for (uint32_t i = 0; i < rows; i++) {
        for (size_t x = 0; x < size; x++)
            moments[x] = 0;
        for (uint32_t k = 0; k < WINDOW; k++) {
            const double weight = job->weights[k];
            const double *line = lines + (i + k) * size;
#pragma omp simd
            for (size_t x = 0; x < size; x++)
                moments[x] += weight * line[x];
        }
        double sum = 0;
        for (size_t x = 0; x < columns; x++)
            sum += similarity(moments + x, columns);
        job->sums[first + i] = sum;
    }
}

/* Without exp(), whose last bit depends on the processor: exp(-x^2 / (2 sigma^2)) is q^(x^2). */
static void set_weights(double weights[WINDOW])
{
    const double q = 0.80073740291680808; /* exp(-1 / 4.5) */
    const uint32_t middle = WINDOW / 2;
    double total = weights[middle] = 1, step = q;
    for (uint32_t x = 1; x <= middle; x++, step *= q * q) {
        weights[middle + x] = weights[middle - x] = weights[middle + x - 1] * step;
        total += 2 * weights[middle + x];
    }
    for (uint32_t k = 0; k < WINDOW; k++)
        weights[k] /= total;
}

gn_result gn_ssim(gn_context *context, const gn_picture *reference, const gn_picture *test,
                  double *ssim)
{
    *ssim = (double)NAN;
    if (reference->width < WINDOW || reference->height < WINDOW)
        return GN_OK;
    ssim_job job = {.pictures = {reference, test},
                    .columns = reference->width - (WINDOW - 1),
                    .rows = reference->height - (WINDOW - 1)};
    set_weights(job.weights);

    /* The lines of a band, the moments of a row of windows, two rows of luma, one of RGB. */
    job.scratch_size =
        (size_t)(BAND + WINDOW) * MOMENTS * job.columns + 4 * (size_t)reference->width;
    job.scratch = gn_alloc(context, context->threads * job.scratch_size, sizeof *job.scratch);
    job.sums = gn_alloc(context, job.rows, sizeof *job.sums);
    const bool good = job.scratch && job.sums;
    if (good) {
        gn_parallel_for(context, (job.rows + BAND - 1) / BAND, add_band, &job);
        double sum = 0;
        for (uint32_t y = 0; y < job.rows; y++)
            sum += job.sums[y];
        *ssim = sum / ((double)job.rows * job.columns);
    }
    gn_free(context, job.scratch);
    gn_free(context, job.sums);
    return good ? GN_OK : gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "no memory for SSIM");
}
