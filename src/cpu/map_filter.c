/* Resolve, filter and quantization of shadow maps in blocks that stay in cache. A block is filtered
 * row by row: the vectors of a row are made and filtered across, and the last `width` such rows are
 * kept, which filtered down make a row of texels. Nothing but depth is read from memory, and
 * nothing but texels is written. */
#include "cpu/map_filter.h"

#include <math.h>
#include <string.h>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "cpu/cpu.h"

/* Rows of a block, and floats of one of its rows in all channels: the nine rows that are kept at
 * the usual width (36 KiB and their margins) stay in the first cache. */
#define BLOCK_ROWS   128u
#define BLOCK_FLOATS 1024u

/* From one row that is kept to the next: no power of two, so that they do not fall on one another
 * in the cache. */
#define ROW_FLOATS (BLOCK_FLOATS + 16u)

gn_texel_layout gn_map_layout(const gn_map_format *format)
{
    switch (format->kind) {
    case GN_MAP_VSM:
        return format->bits == 32 ? GN_TEXEL_VSM32 : GN_TEXEL_VSM64;
    case GN_MAP_EVSM:
        return format->one_sided    ? GN_TEXEL_EVSM64_ONE_SIDED
               : format->bits == 64 ? GN_TEXEL_EVSM64
                                    : GN_TEXEL_EVSM128;
    case GN_MAP_MSM:
        return format->bits == 64 ? GN_TEXEL_MSM64 : GN_TEXEL_MSM128;
    case GN_MAP_NLMSM:
        return format->bits == 64 ? GN_TEXEL_NLMSM64 : GN_TEXEL_NLMSM32;
    default:
        return GN_TEXEL_ESM32;
    }
}

uint32_t gn_map_channels(const gn_map_format *format)
{
    switch (gn_map_layout(format)) {
    case GN_TEXEL_ESM32:
        return 1;
    case GN_TEXEL_VSM32:
    case GN_TEXEL_VSM64:
    case GN_TEXEL_EVSM64_ONE_SIDED:
        return 2;
    default:
        return 4;
    }
}

gn_gaussian gn_gaussian_make(uint32_t width, float sigma)
{
    gn_gaussian g = {.radius = width / 2};
    double weights[GN_MAX_RADIUS + 1], sum = 0;
    for (uint32_t k = 0; k <= g.radius; k++) {
        const double x = (double)k / (double)sigma;
        weights[k] = exp(-0.5 * x * x);
        sum += k == 0 ? weights[k] : 2 * weights[k];
    }
    float pairs = 0;
    for (uint32_t k = g.radius; k > 0; k--) {
        g.weights[k] = (float)(weights[k] / sum);
        pairs += 2.0f * g.weights[k];
    }
    /* The middle takes what the others leave: depth that is 1 everywhere stays 1. */
    g.weights[0] = 1.0f - pairs;
    return g;
}

/* Filter --------------------------------------------------------------------------------------*/

typedef struct filter_run {
    const gn_filter_rows *rows;
    const gn_filter_job *job;
    gn_gaussian gaussian;
    uint32_t channels, columns;    /* columns of a block */
    uint32_t first_column, across; /* where the first block starts; blocks side by side */
    uint32_t stride;     /* floats from channel to channel: the columns, a margin on both sides */
    size_t scratch_size; /* floats a thread */
    float *scratch;
} filter_run;

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* Texels [x0, x1) of row y, filtered across. vectors: scratch, a row. */
static void filter_row(const filter_run *run, uint32_t x0, uint32_t x1, uint32_t y, float *vectors,
                       float *out)
{
    const gn_filter_job *job = run->job;
    const uint32_t radius = run->gaussian.radius, columns = x1 - x0;
    const uint32_t left = least(x0, radius), right = least(job->resolution - x1, radius);
    float *first = vectors + GN_ACROSS_MARGIN;
    run->rows->read(job, x0 - left, y, left + columns + right, first - left, run->stride);
    for (uint32_t c = 0; c < run->channels; c++) {
        float *channel = first + c * run->stride;
        for (uint32_t i = left; i < radius; i++)
            *(channel - i - 1) = *(channel - left);
        for (uint32_t i = right; i < radius; i++)
            channel[columns + i] = channel[columns + right - 1];
    }
    for (uint32_t c = 0; c < run->channels; c++)
        run->rows->across(&run->gaussian, first + c * run->stride, columns, out + c * columns);
}

/* Copies words past the caches: nobody reads a texel before all are there, and a line that is
 * written whole need not be read first. */
static void stream(uint32_t *to, const uint32_t *from, size_t count)
{
#if defined(__SSE2__)
    for (; count > 0 && ((uintptr_t)to & 63) != 0; count--)
        *to++ = *from++;
    for (; count >= 16; count -= 16, to += 16, from += 16)
        for (int i = 0; i < 16; i += 4)
            _mm_stream_si128((__m128i *)(void *)(to + i),
                             _mm_loadu_si128((const __m128i *)(const void *)(from + i)));
#endif
    memcpy(to, from, count * sizeof *to);
}

static void filter_block(uint32_t index, uint32_t thread, void *user)
{
    const filter_run *run = user;
    const gn_filter_job *job = run->job;
    const gn_rect *rect = &job->rect;
    const uint32_t radius = run->gaussian.radius, width = 2 * radius + 1;
    const uint32_t last = job->resolution - 1;
    const uint32_t column = run->first_column + index % run->across * run->columns;
    const uint32_t x0 = column > rect->x0 ? column : rect->x0;
    const uint32_t x1 = least(column + run->columns, rect->x1), columns = x1 - x0;
    const uint32_t y0 = rect->y0 + index / run->across * BLOCK_ROWS;
    const uint32_t y1 = least(y0 + BLOCK_ROWS, rect->y1);
    const size_t words = gn_map_words(&job->format);
    float *vectors = run->scratch + thread * run->scratch_size,
          *filtered = vectors + run->channels * run->stride, *kept = filtered + ROW_FLOATS;

    /* Where the rows y0 - radius, ... of the map lie, those beyond its border clamped. */
    const float *rows[BLOCK_ROWS + 2 * GN_MAX_RADIUS];
    uint32_t line[BLOCK_FLOATS]
        __attribute__((aligned(64))); /* of texels: no more words than floats */
    for (uint32_t i = 0; i < y1 - y0 + 2 * radius; i++) {
        const uint32_t row = least(y0 + i - least(y0 + i, radius), last);
        rows[i] = kept + row % width * ROW_FLOATS;
    }
    const bool streamed = words > 1 && words == run->channels;
    uint32_t next = y0 - least(y0, radius);
    for (uint32_t y = y0; y < y1; y++) {
        for (; next <= least(y + radius, last); next++)
            filter_row(run, x0, x1, next, vectors, kept + next % width * ROW_FLOATS);
        run->rows->down(&run->gaussian, rows + (y - y0), run->channels * columns, filtered);
        uint32_t *texels = job->texels + ((size_t)y * job->resolution + x0) * words;
        run->rows->encode(&job->format, job->moment_bias, filtered, columns, columns,
                          streamed ? line : texels);
        if (streamed)
            stream(texels, line, columns * words);
    }
#if defined(__SSE2__)
    _mm_sfence();
#endif
}

gn_result gn_cpu_filter(const gn_cpu *cpu, const gn_filter_job *job)
{
    const gn_rect *rect = &job->rect;
    if (rect->x0 >= rect->x1 || rect->y0 >= rect->y1)
        return GN_OK;
    filter_run run = {.rows = &cpu->kernels->filter,
                      .job = job,
                      .gaussian = gn_gaussian_make(job->width, job->sigma),
                      .channels = gn_map_channels(&job->format)};
    run.columns = BLOCK_FLOATS / run.channels;
    run.stride = run.columns + 2 * GN_ACROSS_MARGIN;
    run.first_column = rect->x0 / run.columns * run.columns;
    run.across = (rect->x1 - run.first_column + run.columns - 1) / run.columns;
    const uint32_t down = (rect->y1 - rect->y0 + BLOCK_ROWS - 1) / BLOCK_ROWS;
    run.scratch_size = (size_t)run.channels * run.stride + (size_t)(job->width + 1) * ROW_FLOATS;
    run.scratch =
        gn_alloc_zero(cpu->context, cpu->context->threads, run.scratch_size * sizeof(float));
    if (!run.scratch)
        return gn_fail(cpu->context, GN_ERROR_OUT_OF_MEMORY,
                       "no memory to filter a shadow map of %u texels a side", job->resolution);
    gn_parallel_for(cpu->context, run.across * down, filter_block, &run);
    gn_free(cpu->context, run.scratch);
    return GN_OK;
}

/* Mips ----------------------------------------------------------------------------------------*/

size_t gn_map_chain_texels(uint32_t resolution, bool mip_maps)
{
    return mip_maps ? gn_chain_texels(resolution, resolution) : (size_t)resolution * resolution;
}

typedef struct mip_run {
    const gn_filter_rows *rows;
    const gn_map_format *format;
    uint32_t size; /* of the level that is made */
    uint32_t from_size;
    const uint32_t *from;
    uint32_t *to;
} mip_run;

static void mip_row(uint32_t y, uint32_t thread, void *user)
{
    enum { CHUNK = 64 };
    const mip_run *run = user;
    (void)thread;
    const size_t words = gn_map_words(run->format), channels = gn_map_channels(run->format);
    float upper[GN_MAX_CHANNELS][2 * CHUNK], lower[GN_MAX_CHANNELS][2 * CHUNK];
    float averages[GN_MAX_CHANNELS][CHUNK];
    for (uint32_t x = 0; x < run->size; x += CHUNK) {
        const uint32_t count = least(CHUNK, run->size - x);
        const uint32_t *from = run->from + ((size_t)2 * y * run->from_size + 2 * x) * words;
        run->rows->decode(run->format, from, 2 * count, upper[0], 2 * CHUNK);
        run->rows->decode(run->format, from + run->from_size * words, 2 * count, lower[0],
                          2 * CHUNK);
        for (size_t c = 0; c < channels; c++)
            for (uint32_t i = 0; i < count; i++)
                averages[c][i] = ((upper[c][2 * i] + upper[c][2 * i + 1]) +
                                  (lower[c][2 * i] + lower[c][2 * i + 1])) *
                                 0.25f;
        run->rows->encode(run->format, 0.0f, averages[0], CHUNK, count,
                          run->to + ((size_t)y * run->size + x) * words);
    }
}

void gn_cpu_map_mips(const gn_cpu *cpu, const gn_map_format *format, uint32_t resolution,
                     uint32_t *texels)
{
    mip_run run = {.rows = &cpu->kernels->filter, .format = format};
    while (resolution > 1) {
        run.from_size = resolution;
        run.size = resolution / 2;
        run.from = texels;
        run.to = texels + (size_t)resolution * resolution * gn_map_words(format);
        gn_parallel_for(cpu->context, run.size, mip_row, &run);
        texels = run.to;
        resolution = run.size;
    }
}
