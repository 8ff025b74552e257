/* gnomon bench: the tables. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"

static void print_cell(double value, const char *format, int width)
{
    if (value < 0)
        printf("%*s", width, "-");
    else
        printf(format, width, value);
}

/* Room for the longest name. */
static int name_width(const gn_bench_result *result)
{
    size_t width = 13;
    for (uint32_t i = 0; i < result->count; i++)
        width = strlen(result->rows[i].name) > width ? strlen(result->rows[i].name) : width;
    return (int)width + 1;
}

static bool any_traces(const gn_bench_result *result, gn_trace_rule trace)
{
    for (uint32_t i = 0; i < result->count; i++)
        if (result->rows[i].timed && result->rows[i].trace == trace)
            return true;
    return false;
}

/* What only methods that read maps alone have. */
static void print_maps(const gn_bench_result *result, double pixels)
{
    if (!any_traces(result, GN_TRACE_NONE))
        return;
    const int width = name_width(result);
    printf("\n%-*s%9s%9s%9s%8s%8s%8s%8s%9s%10s%8s\n", width, "maps, mean ms", "depth", "filter",
           "test", "ns/px", "layers", "fits", "MB", "wrong %", "mean abs", "x mip0");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (!row->timed || row->trace != GN_TRACE_NONE)
            continue;
        printf("%-*s%9.2f%9.2f%9.2f%8.2f%8u%8.2f%8.0f%9.3f%10.5f%8.2f\n", width, row->name,
               row->shadow_map.mean, row->filter.mean, row->test.mean,
               gn_bench_ns_per_pixel(row, pixels), row->map_layers, row->map_fits,
               (double)row->map_bytes * 1e-6, row->wrong * 100, row->mean_abs,
               row->speedup.spread.median);
    }
    printf("ns/px: of the test, median. fits: layers placed anew, a frame. wrong and mean abs: "
           "against "
           "ray-mip0.\n");
}

/* What only leak tracing has. */
static void print_leaks(const gn_bench_result *result, double pixels)
{
    if (!any_traces(result, GN_TRACE_LEAK))
        return;
    const int width = name_width(result);
    printf("\n%-*s%8s%8s%8s%8s%7s%7s%8s%9s%9s%10s%8s%8s%8s%7s\n", width, "leak tracing, ms", "mean",
           "min", "max", "x all", "min", "max", "rays %", "wrong %", "worst", "mean abs", "test",
           "trace", "maps", "fits");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (!row->timed || row->trace != GN_TRACE_LEAK)
            continue;
        printf("%-*s%8.1f%8.1f%8.1f%8.2f%7.2f%7.2f%8.2f%9.4f%9.4f%10.5f%8.2f%8.2f%8.2f%7.2f\n",
               width, row->name, row->visibility.mean, row->visibility.spread.min,
               row->visibility.spread.max, row->speedup.mean, row->speedup.spread.min,
               row->speedup.spread.max, row->rays / pixels * 100, row->wrong * 100,
               row->wrong_max * 100, row->mean_abs, row->test.mean, row->trace_rays.mean,
               row->shadow_map.mean + row->filter.mean, row->map_fits);
    }
    printf(
        "x all, wrong and mean abs: against a ray for every pixel with the same alpha rule, which "
        "is run\ntoo; x all: mean, least and most of the frames' ratios; worst: frame. test, "
        "trace and maps: mean ms.\n");
}

/* Steadiness once more, real motion taken off. */
static void print_residuals(const gn_bench_result *result)
{
    if (!result->residual)
        return;
    const int width = name_width(result);
    const gn_bench_row *rival = gn_bench_rival(result);
    printf("\n%-*s%9s%8s%9s%8s\n", width, "residual", "flicker", "/ mip0", "toggles", "/ mip0");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        if (!row->timed)
            continue;
        printf("%-*s%9.3f", width, row->name, row->residual_flicker * 1e3);
        print_cell(rival ? gn_bench_ratio(row->residual_flicker, rival->residual_flicker) : -1,
                   "%*.3f", 8);
        printf("%9.3f", row->residual_toggles * 1e3);
        print_cell(rival ? gn_bench_ratio(row->residual_toggles, rival->residual_toggles) : -1,
                   "%*.3f", 8);
        printf("\n");
    }
    printf("residual: after the change of the reference from frame to frame is taken off.\n");
}

static void print_counters(const gn_bench_result *result, const gn_machine *machine)
{
    if (!machine->counts) {
        printf("\nNo hardware counters: %s.\n", machine->reason);
        return;
    }
    const int width = name_width(result);
    printf("\n%-*s%10s%10s%9s%14s%15s\n", width, "a frame", "M instr", "M cycles", "a cycle",
           "k cache miss", "k branch miss");
    for (uint32_t i = 0; i < result->count; i++) {
        const double *n = result->rows[i].counts;
        if (!result->rows[i].timed)
            continue;
        printf("%-*s", width, result->rows[i].name);
        print_cell(isnan(n[GN_COUNTER_INSTRUCTIONS]) ? -1 : n[GN_COUNTER_INSTRUCTIONS] * 1e-6,
                   "%*.2f", 10);
        print_cell(isnan(n[GN_COUNTER_CYCLES]) ? -1 : n[GN_COUNTER_CYCLES] * 1e-6, "%*.2f", 10);
        const double rate = n[GN_COUNTER_INSTRUCTIONS] / n[GN_COUNTER_CYCLES];
        print_cell(isfinite(rate) ? rate : -1, "%*.2f", 9);
        print_cell(isnan(n[GN_COUNTER_CACHE_MISSES]) ? -1 : n[GN_COUNTER_CACHE_MISSES] * 1e-3,
                   "%*.1f", 14);
        print_cell(isnan(n[GN_COUNTER_BRANCH_MISSES]) ? -1 : n[GN_COUNTER_BRANCH_MISSES] * 1e-3,
                   "%*.1f", 15);
        printf("\n");
    }
    printf("Hardware counters of all threads, of the fastest repeat of a frame, mean.\n");
}

void gn_bench_print(const gn_app *app, const gn_bench_options *o, const gn_bench_result *result)
{
    const gn_bench_row *rival = gn_bench_rival(result);
    const gn_bench_row *naive = gn_bench_find(result, GN_BENCH_BASELINE);
    char text[32];
    printf("%s, camera %s, %u x %u, %u frames at %g a second, %u threads, %s\n", app->scene_name,
           gn_app_camera_name(app, text), app->options.size[0], app->options.size[1], o->frames,
           o->fps, gn_device_get_info(app->device).threads,
           gn_device_get_info(app->device).isa_name);
    printf("%.2f million shadow rays trace all; G-buffer %.1f ms, scene update %.2f ms\n\n",
           (double)result->rays * 1e-6, result->gbuffer.median, result->update.median);
    const int width = name_width(result);
    const double pixels = (double)app->options.size[0] * app->options.size[1];
    printf("%-*s%9s%9s%9s%8s%8s%8s%8s", width, "", "ms", "min", "max", "ns/ray", "Mray/s",
           "x naive", "/ mip0");
    printf("%9s%8s%9s%8s", "flicker", "/ mip0", "toggles", "/ mip0");
    printf(result->referenced ? "%9s%8s%8s\n" : "\n", "mse", "/ mip0", "mean");
    for (uint32_t i = 0; i < result->count; i++) {
        const gn_bench_row *row = &result->rows[i];
        const bool plain = row->timed && row->trace == GN_TRACE_ALL; /* rays are all it does */
        printf("%-*s", width, row->name);
        print_cell(row->timed ? row->visibility.spread.median : -1, "%*.1f", 9);
        print_cell(row->timed ? row->visibility.spread.min : -1, "%*.1f", 9);
        print_cell(row->timed ? row->visibility.spread.max : -1, "%*.1f", 9);
        print_cell(plain ? gn_bench_ratio(row->visibility.spread.median * 1e6, row->rays) : -1,
                   "%*.1f", 8);
        print_cell(plain ? row->rays / (row->visibility.spread.median * 1e3) : -1, "%*.2f", 8);
        print_cell(naive && row->timed ? row->speedup_naive.median : -1, "%*.2f", 8);
        print_cell(rival && row->timed ? gn_bench_ratio(row->visibility.spread.median,
                                                        rival->visibility.spread.median)
                                       : -1,
                   "%*.2f", 8);
        print_cell(row->steady ? row->flicker * 1e3 : -1, "%*.3f", 9);
        print_cell(rival && row->steady ? gn_bench_ratio(row->flicker, rival->flicker) : -1,
                   "%*.3f", 8);
        print_cell(row->steady ? row->toggles * 1e3 : -1, "%*.3f", 9);
        print_cell(rival && row->steady ? gn_bench_ratio(row->toggles, rival->toggles) : -1,
                   "%*.3f", 8);
        if (result->referenced) {
            print_cell(row->timed ? row->mse * 1e3 : -1, "%*.3f", 9);
            print_cell(rival && row->timed ? gn_bench_ratio(row->mse, rival->mse) : -1, "%*.3f", 8);
            print_cell(row->mean, "%*.4f", 8);
        }
        printf("\n");
    }
    print_residuals(result);
    print_maps(result, pixels);
    print_leaks(result, pixels * app->light_count);
    gn_bench_print_tracing(app, result, width);
    print_counters(result, o->machine);
    printf("\nflicker, toggles and mse are in 1/1000.");
    if (result->referenced)
        printf(" The reference has %u samples a pixel on %u frames, and a mean of %.4f.",
               o->reference, result->referenced, result->reference_mean);
    printf("\n");
    char busy[256];
    if (gn_bench_busy(result, busy))
        printf("The machine was busy: %s.\n", busy);
}
