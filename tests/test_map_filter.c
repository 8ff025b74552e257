/* The map filter against sums in double written here, and against itself: parts and wholes, threads
 * and instruction sets, three passes through memory. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/gnomon.h>
#include <gnomon/shadow/moments_nonlinear.h>

#include "render/device.h"
#include "three_pass.h"

#define MSM64_BIAS 6e-5f
#define FLOAT_BIAS 3e-7f

typedef struct named_format {
    const char *name;
    gn_map_format format;
    float bias;
} named_format;

static const named_format formats[] = {
    {"vsm32", {.kind = GN_MAP_VSM, .bits = 32}, 0},
    {"vsm64", {.kind = GN_MAP_VSM, .bits = 64}, 0},
    {"esm", {.kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 80}, 0},
    {"evsm64",
     {.kind = GN_MAP_EVSM, .bits = 64, .positive_exponent = 5.5f, .negative_exponent = 5.5f},
     0},
    {"evsm64 one-sided",
     {.kind = GN_MAP_EVSM, .bits = 64, .one_sided = true, .positive_exponent = 40},
     0},
    {"evsm128",
     {.kind = GN_MAP_EVSM, .bits = 128, .positive_exponent = 40, .negative_exponent = 5.5f},
     0},
    {"msm64", {.kind = GN_MAP_MSM, .bits = 64}, MSM64_BIAS},
    {"msm128", {.kind = GN_MAP_MSM, .bits = 128}, FLOAT_BIAS},
    {"nlmsm64", {.kind = GN_MAP_NLMSM, .bits = 64}, FLOAT_BIAS},
    {"nlmsm32", {.kind = GN_MAP_NLMSM, .bits = 32}, FLOAT_BIAS},
};
#define FORMAT_COUNT (sizeof formats / sizeof *formats)

static gn_device *make_device(uint32_t threads, gn_isa isa)
{
    gn_device *device = NULL;
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = threads;
    desc.isa = isa;
    return gn_device_create(&desc, &device) == GN_OK ? device : NULL;
}

/* Ground with hills, posts before it, and places where nothing is; samples differ at edges. */
static float depth_at(uint32_t x, uint32_t y, uint32_t sample, bool moving)
{
    const double u = x + 0.25 * (sample % 2) + 0.1, v = y + 0.25 * (double)(sample / 2);
    if (moving)
        return hypot(u - 20, v - 14) < 7 || fmod(u + v, 83) < 3 ? (float)(0.2 + 0.0006 * u) : 1.0f;
    if (fmod(u, 17) < 2.4)
        return (float)(0.3 + 0.0005 * v);
    if (fmod(v, 41) > 33)
        return 1.0f;
    return (float)(0.7 + 0.2 * sin(0.05 * u) * cos(0.07 * v));
}

static float *make_depth(uint32_t resolution, uint32_t samples, bool moving)
{
    const size_t plane = (size_t)resolution * resolution;
    float *depth = malloc(plane * samples * sizeof *depth);
    assert_non_null(depth);
    for (uint32_t s = 0; s < samples; s++)
        for (size_t i = 0; i < plane; i++)
            depth[s * plane + i] =
                depth_at((uint32_t)(i % resolution), (uint32_t)(i / resolution), s, moving);
    return depth;
}

static gn_filter_job make_job(const named_format *f, uint32_t resolution, uint32_t samples,
                              bool moving, uint32_t width)
{
    return (gn_filter_job){.format = f->format,
                           .resolution = resolution,
                           .samples = samples,
                           .width = width,
                           .sigma = 0.05f + 0.26f * (float)width,
                           .moment_bias = f->bias,
                           .depth = make_depth(resolution, samples, false),
                           .dynamic = moving ? make_depth(resolution, samples, true) : NULL,
                           .rect = {0, 0, resolution, resolution},
                           .texels = malloc((size_t)resolution * resolution * f->format.bits / 8)};
}

static void free_job(gn_filter_job *job)
{
    free((void *)job->depth);
    free((void *)job->dynamic);
    free(job->texels);
}

static void run(gn_device *device, const gn_filter_job *job)
{
    if (gn_cpu_filter(&device->cpu, job) != GN_OK)
        fail_msg("%s", gn_device_message(device));
}

static size_t texel_bytes(const gn_filter_job *job)
{
    return (size_t)job->resolution * job->resolution * job->format.bits / 8;
}

/* In double ---------------------------------------------------------------------------------- */

static int clamp_index(int i, int count)
{
    return i < 0 ? 0 : i >= count ? count - 1 : i;
}

/* The vector of a depth, as the papers define it. */
static void vector_in_double(const gn_map_format *f, double d, double v[4])
{
    const double z = 2 * d - 1, p = exp((double)f->positive_exponent * z),
                 n = -exp(-(double)f->negative_exponent * z);
    const double vectors[][4] = {
        {d, d * d, 0, 0}, {p, 0, 0, 0}, {p, p * p, n, n * n}, {z, z * z, z * z * z, z * z * z * z}};
    const int which = f->kind == GN_MAP_VSM    ? 0
                      : f->kind == GN_MAP_ESM  ? 1
                      : f->kind == GN_MAP_EVSM ? 2
                                               : 3;
    memcpy(v, vectors[which], sizeof vectors[which]);
}

/* The filtered vector of a texel: one sum over the whole square and all samples. */
static void filter_in_double(const gn_filter_job *job, int x, int y, double sum[4])
{
    const int n = (int)job->resolution, radius = (int)job->width / 2;
    const double s = (double)job->sigma;
    double total = 0;
    memset(sum, 0, 4 * sizeof *sum);
    for (int j = -radius; j <= radius; j++)
        for (int i = -radius; i <= radius; i++) {
            const double weight = exp(-(i * i + j * j) / (2 * s * s));
            const size_t texel =
                (size_t)clamp_index(y + j, n) * job->resolution + (size_t)clamp_index(x + i, n);
            for (uint32_t sample = 0; sample < job->samples; sample++) {
                const size_t at = sample * (size_t)n * (size_t)n + texel;
                double d = (double)job->depth[at], v[4];
                if (job->dynamic)
                    d = fmin(d, (double)job->dynamic[at]);
                vector_in_double(&job->format, d, v);
                for (int c = 0; c < 4; c++)
                    sum[c] += weight * v[c];
                total += weight;
            }
        }
    for (int c = 0; c < 4; c++)
        sum[c] /= total;
}

static void bias_in_double(double m[4], double alpha, double target)
{
    for (int c = 0; c < 4; c++)
        m[c] = (1 - alpha) * m[c] + (c % 2 == 1 ? alpha * target : 0);
}

/* Algorithm 1 in double: visibility. */
static double hamburger_in_double(const double m[4], double z)
{
    const double variance = m[1] - m[0] * m[0], l = m[2] - m[0] * m[1];
    const double xi = m[3] - m[1] * m[1] - l * l / variance;
    /* Solve B q = (1, z, z^2) by the Cholesky factors of B. */
    const double l21 = l / variance;
    double q1 = (z - m[0]) / variance, q2 = (z * z - m[1] - l21 * (z - m[0])) / xi;
    q1 -= l21 * q2;
    const double q0 = 1 - m[0] * q1 - m[1] * q2;
    const double half = -q1 / (2 * q2), root = sqrt(fmax(half * half - q0 / q2, 0));
    const double a = half - root, b = half + root;
    double shadow = 0;
    const double at[3] = {z, a, b};
    for (int i = 1; i < 3; i++)
        if (at[i] < z) {
            const double j = at[3 - i];
            shadow += (m[1] - m[0] * (z + j) + z * j) / ((at[i] - z) * (at[i] - j));
        }
    return 1 - shadow;
}

/* Texels as numbers ---------------------------------------------------------------------------*/

static double half_in_double(uint32_t h)
{
    const int exponent = (int)(h >> 10 & 31), mantissa = (int)(h & 1023);
    const double value =
        exponent == 0 ? ldexp(mantissa, -24) : ldexp(1024 + mantissa, exponent - 25);
    return h >> 15 ? -value : value;
}

static double word_in_double(uint32_t word)
{
    float f;
    memcpy(&f, &word, sizeof f);
    return (double)f;
}

/* The numbers that a texel of a linear format stores. */
static void stored_numbers(const gn_map_format *f, const uint32_t *words, double v[4])
{
    const bool fixed =
        (f->kind == GN_MAP_VSM && f->bits == 32) || (f->kind == GN_MAP_MSM && f->bits == 64);
    const bool halves = f->kind == GN_MAP_EVSM && f->bits == 64 && !f->one_sided;
    memset(v, 0, 4 * sizeof *v);
    for (uint32_t i = 0; i < f->bits / 16 && i < 4; i++)
        if (fixed)
            v[i] = (words[i / 2] >> (16 * (i % 2)) & 0xffff) / 65535.0;
        else if (halves)
            v[i] = half_in_double(words[i / 2] >> (16 * (i % 2)) & 0xffff);
        else if (i < f->bits / 32)
            v[i] = word_in_double(words[i]);
}

/* What they should be, and how far off they may be. */
static void expected_numbers(const gn_filter_job *job, const double m[4], double v[4],
                             double error[4])
{
    const gn_map_format *f = &job->format;
    for (int c = 0; c < 4; c++) {
        v[c] = m[c];
        if (f->kind == GN_MAP_VSM)
            error[c] = f->bits == 32 ? 0.5 / 65535 + 1e-6 : 1e-6;
        else if (f->kind == GN_MAP_MSM)
            error[c] = f->bits == 64 ? 0.5 / 65535 + 1e-6 : 1e-6;
        else {
            /* The stated error of the warp, of its square, and of halves. */
            const double exponent =
                c < 2 ? (double)f->positive_exponent : (double)f->negative_exponent;
            error[c] = fabs(m[c]) * (2 * (7e-8 * exponent + 3e-7) + 1e-6);
            if (f->bits == 64 && !f->one_sided)
                error[c] += fabs(m[c]) / 2048 + ldexp(1, -25);
        }
    }
    if (f->kind == GN_MAP_MSM) {
        double b[4];
        memcpy(b, m, sizeof b);
        bias_in_double(b, (double)job->moment_bias, f->bits == 64 ? 0.628 : 0.375);
        memcpy(v, b, sizeof b);
        if (f->bits == 64) {
            v[0] = 1.5 * b[0] - 2 * b[2] + 0.5;
            v[1] = 4 * (b[1] - b[3]);
            v[2] = sqrt(3) / 2 * b[0] - 2 * sqrt(3) / 9 * b[2] + 0.5;
            v[3] = 0.5 * (b[1] + b[3]);
            for (int c = 0; c < 4; c++)
                v[c] = fmin(fmax(v[c], 0), 1);
        }
    }
    const uint32_t numbers = f->kind == GN_MAP_ESM                   ? 1
                             : f->kind == GN_MAP_VSM || f->one_sided ? 2
                                                                     : 4;
    for (uint32_t c = numbers; c < 4; c++)
        v[c] = error[c] = 0;
}

/* Against the reference ---------------------------------------------------------------------- */

static void check_linear(const named_format *f, const gn_filter_job *job, int x, int y)
{
    double m[4], expected[4], error[4], got[4];
    filter_in_double(job, x, y, m);
    expected_numbers(job, m, expected, error);
    const size_t texel = (size_t)y * job->resolution + (size_t)x;
    stored_numbers(&f->format, job->texels + texel * f->format.bits / 32, got);
    for (int c = 0; c < 4; c++)
        if (!(fabs(got[c] - expected[c]) <= error[c]))
            fail_msg("%s, width %u, samples %u, texel %d %d, channel %d: %.9g, not %.9g +- %.2g",
                     f->name, job->width, job->samples, x, y, c, got[c], expected[c], error[c]);
}

/* Visibilities of what is stored against those of the moments in double. */
typedef struct disagreement {
    double sum, worst;
    unsigned count, large; /* large: by more than 0.05 */
} disagreement;

static void compare_visibility(const gn_filter_job *job, int x, int y, disagreement *d)
{
    double m[4];
    filter_in_double(job, x, y, m);
    bias_in_double(m, (double)job->moment_bias, 0.375);
    const size_t texel = (size_t)y * job->resolution + (size_t)x;
    const uint32_t *words = job->texels + texel * job->format.bits / 32;
    const gn_nonlinear n = job->format.bits == 64 ? gn_nonlinear_unpack64(words[0], words[1])
                                                  : gn_nonlinear_unpack32(words[0]);
    for (double receiver = 0.0625; receiver < 1; receiver += 0.125) {
        const double expected = hamburger_in_double(m, 2 * receiver - 1);
        const double got = (double)gn_nonlinear_visibility(n, (float)receiver);
        const double off = fabs(got - expected);
        d->sum += off;
        d->worst = fmax(d->worst, off);
        d->large += off > 0.05;
        d->count++;
    }
}

static void check_format(gn_device *device, const named_format *f, uint32_t samples, bool moving,
                         uint32_t width)
{
    gn_filter_job job = make_job(f, 61, samples, moving, width);
    run(device, &job);
    disagreement d = {0};
    for (int y = 0; y < 61; y += y < 6 || y > 53 ? 1 : 5)
        for (int x = 0; x < 61; x += x < 6 || x > 53 ? 1 : 5)
            if (f->format.kind == GN_MAP_NLMSM)
                compare_visibility(&job, x, y, &d);
            else
                check_linear(f, &job, x, y);
    if (d.count > 0) {
        /* 16 bits of everything, or 6 to 10. */
        const bool wide = f->format.bits == 64;
        const double mean = d.sum / d.count, large = (double)d.large / d.count;
        if (!(mean <= (wide ? 1e-4 : 0.02)) || !(large <= (wide ? 0 : 0.12)))
            fail_msg("%s, width %u, samples %u: visibility is off by %.5f on average, by more than "
                     "0.05 in %.4f, by %.3f at worst",
                     f->name, width, samples, mean, large, d.worst);
    }
    free_job(&job);
}

static void test_formats(void **state)
{
    (void)state;
    gn_device *device = make_device(2, GN_ISA_AUTO);
    assert_non_null(device);
    static const uint32_t widths[] = {1, 3, 9, 33};
    for (size_t f = 0; f < FORMAT_COUNT; f++)
        for (size_t w = 0; w < 4; w++)
            for (uint32_t samples = 1; samples <= 4; samples += 3) {
                check_format(device, &formats[f], samples, false, widths[w]);
                check_format(device, &formats[f], samples, true, widths[w]);
            }
    gn_device_destroy(&device);
}

/* Depth that is 1 everywhere stays 1: nothing is there, and everything is lit. */
static void test_nothing_there(void **state)
{
    (void)state;
    gn_device *device = make_device(1, GN_ISA_AUTO);
    assert_non_null(device);
    for (uint32_t width = 1; width <= 33; width += 2)
        for (size_t f = 0; f < FORMAT_COUNT; f++) {
            if (formats[f].bias > 0)
                continue;
            gn_filter_job job = make_job(&formats[f], 40, 1, false, width);
            float *depth = (float *)job.depth;
            for (int i = 0; i < 1600; i++)
                depth[i] = 1.0f;
            run(device, &job);
            double vector[4], expected[4], error[4], got[4];
            vector_in_double(&job.format, 1, vector);
            expected_numbers(&job, vector, expected, error);
            for (int i = 0; i < 1600; i++) {
                stored_numbers(&job.format, job.texels + i * (int)job.format.bits / 32, got);
                for (int c = 0; c < 4; c++) {
                    const double off = job.format.kind == GN_MAP_VSM ? 0 : error[c];
                    if (!(fabs(got[c] - expected[c]) <= off))
                        fail_msg("%s, width %u: %.9g, not %.9g", formats[f].name, width, got[c],
                                 expected[c]);
                }
            }
            free_job(&job);
        }
    gn_device_destroy(&device);
}

/* Parts and wholes --------------------------------------------------------------------------- */

static uint32_t *filtered_copy(gn_device *device, const gn_filter_job *job)
{
    gn_filter_job whole = *job;
    whole.rect = (gn_rect){0, 0, job->resolution, job->resolution};
    whole.texels = malloc(texel_bytes(job));
    assert_non_null(whole.texels);
    run(device, &whole);
    return whole.texels;
}

/* The texels of a rectangle are the whole's, and others are not touched. */
static void check_rect(gn_device *device, gn_filter_job *job, const uint32_t *whole, gn_rect rect,
                       const char *name)
{
    const uint32_t words = job->format.bits / 32, n = job->resolution;
    memset(job->texels, 0xa5, texel_bytes(job));
    job->rect = rect;
    run(device, job);
    for (uint32_t y = 0; y < n; y++)
        for (uint32_t x = 0; x < n; x++) {
            const bool inside = x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
            for (uint32_t w = 0; w < words; w++) {
                const size_t at = ((size_t)y * n + x) * words + w;
                const uint32_t expected = inside ? whole[at] : 0xa5a5a5a5u;
                if (job->texels[at] != expected)
                    fail_msg("%s, width %u, rectangle %u %u %u %u: texel %u %u is %08x, not %08x",
                             name, job->width, rect.x0, rect.y0, rect.x1, rect.y1, x, y,
                             job->texels[at], expected);
            }
        }
}

static void test_rectangles(void **state)
{
    (void)state;
    gn_device *device = make_device(2, GN_ISA_AUTO);
    assert_non_null(device);
    static const gn_rect rects[] = {
        {0, 0, 300, 300}, {0, 0, 1, 1},       {299, 299, 300, 300}, {255, 100, 257, 160},
        {3, 5, 250, 9},   {131, 0, 140, 300}, {17, 120, 299, 141},  {256, 128, 300, 256},
        {5, 5, 5, 10},    {7, 9, 6, 12},
    };
    static const uint32_t widths[] = {1, 9, 33};
    for (size_t f = 0; f < FORMAT_COUNT; f++) {
        /* Blocks are wider where there are fewer channels. */
        const uint32_t scale = 4 / gn_map_channels(&formats[f].format);
        gn_filter_job job = make_job(&formats[f], 300 * scale, f % 2 ? 4 : 1, f % 3 == 0, 9);
        job.width = widths[f % 3];
        uint32_t *whole = filtered_copy(device, &job);
        for (size_t r = 0; r < sizeof rects / sizeof *rects; r++)
            check_rect(device, &job, whole,
                       (gn_rect){rects[r].x0 * scale, rects[r].y0 * scale, rects[r].x1 * scale,
                                 rects[r].y1 * scale},
                       formats[f].name);
        free(whole);
        free_job(&job);
    }
    gn_device_destroy(&device);
}

static void test_threads_and_instruction_sets(void **state)
{
    (void)state;
    static const gn_isa isas[] = {GN_ISA_SCALAR, GN_ISA_AVX2, GN_ISA_AVX512};
    static const uint32_t threads[] = {1, 4, 2}, sizes[] = {16, 100, 1000};
    gn_device *devices[3];
    for (int i = 0; i < 3; i++)
        devices[i] = make_device(threads[i], isas[i]); /* NULL: not on this processor */
    assert_non_null(devices[0]);
    for (size_t f = 0; f < FORMAT_COUNT; f++)
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t samples = k == 2 && f % 2 ? 4 : 1, width = k == 0 ? 3 : k == 1 ? 33 : 9;
            gn_filter_job job = make_job(&formats[f], sizes[k], samples, k == 1, width);
            uint32_t *expected = filtered_copy(devices[0], &job);
            for (int i = 1; i < 3; i++) {
                if (!devices[i])
                    continue;
                run(devices[i], &job);
                const size_t words = texel_bytes(&job) / 4;
                for (size_t w = 0; w < words; w++)
                    if (job.texels[w] != expected[w])
                        fail_msg("%s at %u: word %zu is %08x with %s, %08x with scalar code",
                                 formats[f].name, job.resolution, w, job.texels[w],
                                 devices[i]->cpu.kernels->name, expected[w]);
            }
            free(expected);
            free_job(&job);
        }
    for (int i = 0; i < 3; i++)
        gn_device_destroy(&devices[i]);
}

/* Three passes through memory, the benchmark's baseline, make the same texels. */
static void test_three_passes(void **state)
{
    (void)state;
    gn_device *device = make_device(2, GN_ISA_AUTO);
    gn_three_pass *pass = gn_three_pass_create(300, 4);
    assert_non_null(device);
    assert_non_null(pass);
    static const uint32_t widths[] = {9, 1, 33};
    for (size_t f = 0; f < FORMAT_COUNT; f++) {
        gn_filter_job job = make_job(&formats[f], 300, f % 2 ? 4 : 1, f % 4 == 0, widths[f % 3]);
        uint32_t *fused = filtered_copy(device, &job);
        gn_three_pass_run(pass, &device->cpu, &job);
        for (size_t w = 0; w < texel_bytes(&job) / 4; w++)
            if (job.texels[w] != fused[w])
                fail_msg("%s, width %u: word %zu is %08x in three passes, %08x fused",
                         formats[f].name, job.width, w, job.texels[w], fused[w]);
        free(fused);
        free_job(&job);
    }
    gn_three_pass_destroy(pass);
    gn_device_destroy(&device);
}

/* Mips --------------------------------------------------------------------------------------- */

static void test_chain_texels(void **state)
{
    (void)state;
    assert_int_equal(gn_map_chain_texels(16, false), 256);
    assert_int_equal(gn_map_chain_texels(16, true), 256 + 64 + 16 + 4 + 1);
    assert_int_equal(gn_map_chain_texels(21, true), 441 + 100 + 25 + 4 + 1);
    assert_int_equal(gn_map_chain_texels(16384, true), 357913941);
}

/* Every level is the average of the one below, in the numbers that are stored. */
static void check_mips(gn_device *device, const named_format *f, uint32_t resolution)
{
    gn_filter_job job = make_job(f, resolution, 1, false, 9);
    const uint32_t words = f->format.bits / 32;
    job.texels = realloc(job.texels, gn_map_chain_texels(resolution, true) * words * 4);
    assert_non_null(job.texels);
    run(device, &job);
    gn_cpu_map_mips(&device->cpu, &f->format, resolution, job.texels);
    const bool fixed = f->format.kind == GN_MAP_MSM || f->format.bits == 32;
    const bool halves = strcmp(f->name, "evsm64") == 0;
    const uint32_t *from = job.texels;
    for (uint32_t n = resolution; n > 1; n /= 2) {
        const uint32_t *to = from + (size_t)n * n * words;
        for (uint32_t y = 0; y < n / 2; y++)
            for (uint32_t x = 0; x < n / 2; x++) {
                double sum[4] = {0}, v[4], got[4];
                for (uint32_t i = 0; i < 4; i++) {
                    const size_t texel = (size_t)(2 * y + i / 2) * n + 2 * x + i % 2;
                    stored_numbers(&f->format, from + texel * words, v);
                    for (int c = 0; c < 4; c++)
                        sum[c] += v[c] / 4;
                }
                stored_numbers(&f->format, to + ((size_t)y * (n / 2) + x) * words, got);
                for (int c = 0; c < 4; c++) {
                    const double rounding = halves ? 1.0 / 2048 : 2e-7;
                    const double off = (fixed ? 0.51 / 65535 : 1e-7) + fabs(sum[c]) * rounding;
                    if (!(fabs(got[c] - sum[c]) <= off))
                        fail_msg("%s, level of %u, texel %u %u, channel %d: %.9g, not %.9g",
                                 f->name, n / 2, x, y, c, got[c], sum[c]);
                }
            }
        from = to;
    }
    free_job(&job);
}

static void test_mips(void **state)
{
    (void)state;
    gn_device *device = make_device(2, GN_ISA_AUTO);
    assert_non_null(device);
    for (size_t f = 0; f < FORMAT_COUNT; f++)
        if (formats[f].format.kind != GN_MAP_NLMSM) {
            check_mips(device, &formats[f], 160);
            check_mips(device, &formats[f], 53);
        }
    gn_device_destroy(&device);
}

/* Memory ------------------------------------------------------------------------------------- */

static bool refuse_memory;

static void *refusing_alloc(size_t size, void *user)
{
    (void)user;
    return refuse_memory ? NULL : aligned_alloc(64, size);
}

static void refusing_free(void *block, size_t size, void *user)
{
    (void)size;
    (void)user;
    free(block);
}

static void test_no_memory(void **state)
{
    (void)state;
    gn_device *device = NULL;
    gn_device_desc desc = gn_device_desc_default();
    desc.allocator = (gn_allocator){refusing_alloc, refusing_free, NULL};
    assert_int_equal(gn_device_create(&desc, &device), GN_OK);
    gn_filter_job job = make_job(&formats[0], 32, 1, false, 9);
    refuse_memory = true;
    assert_int_equal(gn_cpu_filter(&device->cpu, &job), GN_ERROR_OUT_OF_MEMORY);
    refuse_memory = false;
    if (!strstr(gn_device_message(device), "shadow map"))
        fail_msg("the message is: %s", gn_device_message(device));
    free_job(&job);
    gn_device_destroy(&device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formats),      cmocka_unit_test(test_nothing_there),
        cmocka_unit_test(test_rectangles),   cmocka_unit_test(test_threads_and_instruction_sets),
        cmocka_unit_test(test_three_passes), cmocka_unit_test(test_chain_texels),
        cmocka_unit_test(test_mips),         cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
