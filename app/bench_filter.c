/* gnomon bench --filter: the map filter against three passes through memory, and against memcpy. */
#include "bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/measure.h"
#include "render/device.h"
#include "three_pass.h"

#define WIDTH 9
#define SIGMA 2.4f

static const struct named_format {
    const char *name;
    gn_map_format format;
    float bias;
} formats[] = {
    {"vsm32", {.kind = GN_MAP_VSM, .bits = 32}, 0},
    {"vsm64", {.kind = GN_MAP_VSM, .bits = 64}, 0},
    {"esm32", {.kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 80}, 0},
    {"evsm64-one-sided",
     {.kind = GN_MAP_EVSM, .bits = 64, .one_sided = true, .positive_exponent = 40},
     0},
    {"evsm64",
     {.kind = GN_MAP_EVSM, .bits = 64, .positive_exponent = 5.5f, .negative_exponent = 5.5f},
     0},
    {"evsm128",
     {.kind = GN_MAP_EVSM, .bits = 128, .positive_exponent = 40, .negative_exponent = 5.5f},
     0},
    {"msm64", {.kind = GN_MAP_MSM, .bits = 64}, 6e-5f},
    {"msm128", {.kind = GN_MAP_MSM, .bits = 128}, 3e-7f},
    {"nlmsm64", {.kind = GN_MAP_NLMSM, .bits = 64}, 3e-7f},
    {"nlmsm32", {.kind = GN_MAP_NLMSM, .bits = 32}, 3e-7f},
};
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

/* What is filtered -----------------------------------------------------------------------------*/

static float noise_at(int32_t x, int32_t y)
{
    uint32_t h = (uint32_t)x * 0x9e3779b1u ^ (uint32_t)y * 0x85ebca77u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    return (float)(h >> 8) * 0x1p-24f;
}

/* Hills below the light, fences across them, crowns of leaves above, and nothing at the border. */
static float depth_at(float u, float v)
{
    if (hypotf(u - 0.5f, v - 0.5f) > 0.6f)
        return 1.0f;
    float depth = 0.7f + 0.12f * sinf(11.0f * u) * cosf(9.0f * v) + 0.02f * sinf(70.0f * u + v);
    const float fence = fmodf(u * 24.0f + 0.1f * sinf(20.0f * v), 1.0f);
    if (fence < 0.02f || (fence < 0.2f && fmodf(v * 300.0f, 1.0f) < 0.3f))
        depth -= 0.04f;
    const float tree = fmodf(v * 7.0f, 1.0f) - 0.5f, row = fmodf(u * 7.0f, 1.0f) - 0.5f;
    const float leaf = noise_at((int32_t)(u * 700.0f), (int32_t)(v * 700.0f));
    if (tree * tree + row * row < 0.12f && leaf > 0.5f)
        depth -= 0.2f + 0.15f * leaf;
    return depth;
}

typedef struct depth_run {
    uint32_t resolution;
    float *depth;
} depth_run;

static void fill_row(uint32_t index, uint32_t thread, void *user)
{
    const depth_run *run = user;
    const uint32_t n = run->resolution, sample = index / n, y = index % n;
    (void)thread;
    for (uint32_t x = 0; x < n; x++)
        run->depth[(size_t)index * n + x] =
            depth_at(((float)x + gn_map_samples[sample][0]) / (float)n,
                     ((float)y + gn_map_samples[sample][1]) / (float)n);
}

/* memcpy that reads what the filter reads and writes what it writes ----------------------------*/

#define PIECES 256u

typedef struct copy_run {
    const char *from;
    char *to;
    size_t read, written;  /* bytes in all */
    uint32_t sums[PIECES]; /* of what is read but not copied */
} copy_run;

static void copy_piece(uint32_t piece, uint32_t thread, void *user)
{
    copy_run *run = user;
    (void)thread;
    const size_t read = run->read / PIECES, written = run->written / PIECES;
    const char *from = run->from + piece * read;
    char *to = run->to + piece * written;
    for (size_t done = 0; done < written; done += read)
        memcpy(to + done, from, written - done < read ? written - done : read);
    uint32_t sum = 0;
    for (size_t i = written; i < read; i += sizeof sum) {
        uint32_t word;
        memcpy(&word, from + i, sizeof word);
        sum += word;
    }
    run->sums[piece] = sum;
}

/* Measurement ----------------------------------------------------------------------------------*/

typedef struct filter_row {
    const char *name;
    uint32_t samples;
    gn_spread fused, three_pass, memcpy; /* milliseconds */
} filter_row;

typedef struct filter_options {
    uint32_t resolution, repeats;
} filter_options;

static bool measure_format(gn_app *app, const filter_options *o, const gn_filter_job *job,
                           gn_three_pass *pass, copy_run *copy, filter_row *row)
{
    double *times = calloc((size_t)3 * o->repeats, sizeof *times);
    if (!times)
        return gn_app_error(app, "out of memory");
    bool good = true;
    /* They take turns, so that all see the same machine; the first turn warms up. */
    for (uint32_t i = 0; good && i <= o->repeats; i++) {
        const uint32_t slot = i > 0 ? i - 1 : 0;
        const double start = gn_milliseconds();
        good = gn_cpu_filter(&app->device->cpu, job) == GN_OK;
        const double fused = gn_milliseconds();
        gn_three_pass_run(pass, &app->device->cpu, job);
        const double passes = gn_milliseconds();
        gn_parallel_for(&app->device->context, PIECES, copy_piece, copy);
        const double copied = gn_milliseconds();
        times[slot] = fused - start;
        times[o->repeats + slot] = passes - fused;
        times[2 * o->repeats + slot] = copied - passes;
    }
    row->fused = gn_measure_spread(times, o->repeats);
    row->three_pass = gn_measure_spread(times + o->repeats, o->repeats);
    row->memcpy = gn_measure_spread(times + 2 * o->repeats, o->repeats);
    free(times);
    return good;
}

/* Every format with 1 and 4 samples a texel. */
static bool measure_all(gn_app *app, const filter_options *o, filter_row rows[2 * FORMAT_COUNT])
{
    const size_t texels = (size_t)o->resolution * o->resolution;
    float *depth = calloc(texels, 4 * sizeof *depth);
    uint32_t *map = calloc(texels, 4 * sizeof *map);
    gn_three_pass *pass = gn_three_pass_create(o->resolution, GN_MAX_CHANNELS);
    bool good = depth && map && pass;
    if (!good)
        gn_app_error(app, "no memory for maps of %u texels a side", o->resolution);
    if (good) {
        depth_run run = {o->resolution, depth};
        gn_parallel_for(&app->device->context, 4 * o->resolution, fill_row, &run);
    }
    for (uint32_t i = 0; good && i < 2 * FORMAT_COUNT; i++) {
        const struct named_format *f = &formats[i % FORMAT_COUNT];
        rows[i] = (filter_row){.name = f->name, .samples = i < FORMAT_COUNT ? 1 : 4};
        gn_bar_step(&app->bar, i / (2.0 * FORMAT_COUNT), 0.5 / FORMAT_COUNT, "%s", f->name);
        const gn_filter_job job = {.format = f->format,
                                   .resolution = o->resolution,
                                   .samples = rows[i].samples,
                                   .width = WIDTH,
                                   .sigma = SIGMA,
                                   .moment_bias = f->bias,
                                   .depth = depth,
                                   .rect = {0, 0, o->resolution, o->resolution},
                                   .texels = map};
        copy_run copy = {.from = (const char *)depth,
                         .to = (char *)map,
                         .read = texels * rows[i].samples * sizeof *depth,
                         .written = texels * f->format.bits / 8};
        good = measure_format(app, o, &job, pass, &copy, &rows[i]);
        if (good && gn_app_interrupted())
            good = gn_app_error(app, "interrupted");
    }
    gn_bar_clear(&app->bar);
    gn_three_pass_destroy(pass);
    free(map);
    free(depth);
    return good;
}

/* Output ---------------------------------------------------------------------------------------*/

static void print_rows(const gn_app *app, const filter_options *o, const filter_row *rows)
{
    const gn_device_info info = gn_device_get_info(app->device);
    printf("%u x %u texels, Gaussian of %u x %u texels (sigma %.1f), %u threads, %s; medians of "
           "%u\n\n",
           o->resolution, o->resolution, WIDTH, WIDTH, (double)SIGMA, info.threads, info.isa_name,
           o->repeats);
    printf("%-18s%8s%10s%12s%11s%8s%11s\n", "", "samples", "fused ms", "3 passes ms", "memcpy ms",
           "ratio", "/ memcpy");
    for (uint32_t i = 0; i < 2 * FORMAT_COUNT; i++) {
        const filter_row *row = &rows[i];
        printf("%-18s%8u%10.2f%12.2f%11.2f%8.2f%11.2f\n", row->name, row->samples,
               row->fused.median, row->three_pass.median, row->memcpy.median,
               row->three_pass.median / row->fused.median, row->fused.median / row->memcpy.median);
    }
    printf("\nratio: three passes over fused; memcpy reads the depth and writes as many bytes as "
           "the map has.\n");
}

static cJSON *rows_json(const gn_app *app, const filter_options *o, const filter_row *rows)
{
    cJSON *json = gn_app_json(app);
    cJSON_AddNumberToObject(json, "map_size", o->resolution);
    cJSON_AddNumberToObject(json, "filter_width", WIDTH);
    cJSON_AddNumberToObject(json, "filter_sigma", 0.1 * round(10.0 * (double)SIGMA));
    cJSON_AddNumberToObject(json, "repeats", o->repeats);
    cJSON *list = cJSON_AddArrayToObject(json, "filter");
    for (uint32_t i = 0; i < 2 * FORMAT_COUNT; i++) {
        const filter_row *row = &rows[i];
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(list, item);
        cJSON_AddStringToObject(item, "format", row->name);
        cJSON_AddNumberToObject(item, "samples", row->samples);
        cJSON_AddNumberToObject(item, "fused_ms", row->fused.median);
        cJSON_AddNumberToObject(item, "fused_ms_min", row->fused.min);
        cJSON_AddNumberToObject(item, "three_pass_ms", row->three_pass.median);
        cJSON_AddNumberToObject(item, "three_pass_ms_min", row->three_pass.min);
        cJSON_AddNumberToObject(item, "memcpy_ms", row->memcpy.median);
        cJSON_AddNumberToObject(item, "memcpy_ms_min", row->memcpy.min);
        cJSON_AddNumberToObject(item, "ratio", row->three_pass.median / row->fused.median);
        cJSON_AddNumberToObject(item, "fused_over_memcpy", row->fused.median / row->memcpy.median);
    }
    return json;
}

int gn_app_bench_filter(int argc, char **argv)
{
    static const char *const words[] = {NULL};
    static const char *const notes[] = {
        "Needs no scene: the depths are hills, fences and crowns made on the spot. Each format is",
        "filtered with 1 and 4 depths a texel; the fused filter, three passes through memory and a",
        "memcpy of the same bytes take turns.", NULL};
    const gn_usage usage = {
        "bench",
        "time of the shadow map filter, against three passes and memcpy",
        "--filter [options]",
        words,
        notes,
        {"gnomon bench --filter", "gnomon bench --filter --map-size 1024 --json > filter.json"}};
    gn_app_options common = gn_app_options_default();
    filter_options filter = {.resolution = 2048, .repeats = 9};
    bool chosen = false;
    const gn_option options[] = {
        GN_FLAG("filter", 0, &chosen, "measure the filter of shadow maps"),
        GN_COUNT("map-size", 0, "N", &filter.resolution, 16, 16384, "texels a side, default 2048"),
        GN_COUNT("repeats", 'r', "N", &filter.repeats, 1, 1000, "turns of each, default 9"),
        GN_APP_DEVICE_OPTIONS(common), GN_OPTIONS_END};
    int code = gn_options_parse(&usage, options, argc, argv, NULL);
    if (code != GN_GO_ON)
        return code;
    gn_app app = {0};
    filter_row rows[2 * FORMAT_COUNT];
    bool good = gn_app_open(&app, "bench", &common) && measure_all(&app, &filter, rows);
    if (good && common.json)
        good = gn_app_print_json(&app, rows_json(&app, &filter, rows));
    else if (good) {
        print_rows(&app, &filter, rows);
        good = gn_app_flush(&app);
    }
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_close(&app);
    return code;
}
