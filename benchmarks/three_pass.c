#include "three_pass.h"

#include <stdlib.h>
#include <string.h>

#define BAND  16u  /* rows that a thread takes at a time */
#define CHUNK 256u /* columns whose vectors stay in the first cache in the last pass */

struct gn_three_pass {
    const gn_filter_rows *rows;
    const gn_filter_job *job;
    gn_gaussian gaussian;
    uint32_t channels;
    size_t stride;  /* floats from channel to channel: the columns, and both margins */
    float *vectors; /* [row][channel][column], the first column behind the margin */
    float *across;  /* the same, but from the first column on */
};

gn_three_pass *gn_three_pass_create(uint32_t resolution, uint32_t channels)
{
    gn_three_pass *pass = calloc(1, sizeof *pass);
    if (!pass)
        return NULL;
    pass->stride = ((size_t)resolution + 2 * GN_ACROSS_MARGIN + 15) / 16 * 16;
    const size_t size = pass->stride * resolution * channels * sizeof(float);
    pass->vectors = aligned_alloc(64, size);
    pass->across = aligned_alloc(64, size);
    if (!pass->vectors || !pass->across) {
        gn_three_pass_destroy(pass);
        return NULL;
    }
    memset(pass->vectors, 0, size); /* what lies between the channels, too, is read */
    memset(pass->across, 0, size);
    return pass;
}

void gn_three_pass_destroy(gn_three_pass *pass)
{
    if (!pass)
        return;
    free(pass->vectors);
    free(pass->across);
    free(pass);
}

static size_t row_size(const gn_three_pass *pass)
{
    return pass->stride * pass->channels;
}

static uint32_t band_end(const gn_three_pass *pass, uint32_t band)
{
    const uint32_t end = (band + 1) * BAND;
    return end < pass->job->resolution ? end : pass->job->resolution;
}

static void resolve_band(uint32_t band, uint32_t thread, void *user)
{
    const gn_three_pass *pass = user;
    const uint32_t n = pass->job->resolution, radius = pass->gaussian.radius;
    (void)thread;
    for (uint32_t y = band * BAND; y < band_end(pass, band); y++) {
        float *row = pass->vectors + y * row_size(pass) + GN_ACROSS_MARGIN;
        pass->rows->read(pass->job, 0, y, n, row, pass->stride);
        for (uint32_t c = 0; c < pass->channels; c++) {
            float *channel = row + c * pass->stride;
            for (uint32_t i = 0; i < radius; i++) {
                *(channel - i - 1) = channel[0];
                channel[n + i] = channel[n - 1];
            }
        }
    }
}

static void across_band(uint32_t band, uint32_t thread, void *user)
{
    const gn_three_pass *pass = user;
    (void)thread;
    for (uint32_t y = band * BAND; y < band_end(pass, band); y++)
        pass->rows->across(&pass->gaussian, pass->vectors + y * row_size(pass) + GN_ACROSS_MARGIN,
                           (uint32_t)((pass->channels - 1) * pass->stride) + pass->job->resolution,
                           pass->across + y * row_size(pass));
}

static void down_band(uint32_t band, uint32_t thread, void *user)
{
    const gn_three_pass *pass = user;
    const gn_filter_job *job = pass->job;
    const uint32_t n = job->resolution, radius = pass->gaussian.radius;
    const size_t words = gn_map_words(&job->format);
    float vectors[GN_MAX_CHANNELS][CHUNK] __attribute__((aligned(64)));
    (void)thread;
    for (uint32_t y = band * BAND; y < band_end(pass, band); y++)
        for (uint32_t x = 0; x < n; x += CHUNK) {
            const uint32_t count = n - x < CHUNK ? n - x : CHUNK;
            for (uint32_t c = 0; c < pass->channels; c++) {
                const float *rows[2 * GN_MAX_RADIUS + 1];
                for (uint32_t k = 0; k <= 2 * radius; k++) {
                    const int64_t row = (int64_t)y + k - radius;
                    const size_t clamped = row < 0 ? 0 : row < n ? (size_t)row : n - 1;
                    rows[k] = pass->across + clamped * row_size(pass) + c * pass->stride + x;
                }
                pass->rows->down(&pass->gaussian, rows, count, vectors[c]);
            }
            pass->rows->encode(&job->format, job->moment_bias, vectors[0], CHUNK, count,
                               job->texels + ((size_t)y * n + x) * words);
        }
}

void gn_three_pass_run(gn_three_pass *pass, const gn_cpu *cpu, const gn_filter_job *job)
{
    pass->rows = &cpu->kernels->filter;
    pass->job = job;
    pass->gaussian = gn_gaussian_make(job->width, job->sigma);
    pass->channels = gn_map_channels(&job->format);
    const uint32_t bands = (job->resolution + BAND - 1) / BAND;
    gn_parallel_for(cpu->context, bands, resolve_band, pass);
    gn_parallel_for(cpu->context, bands, across_band, pass);
    gn_parallel_for(cpu->context, bands, down_band, pass);
}
