#include "cpu/leak.h"

#include <gnomon/shadow/leak.h>

#include "cpu/cpu.h"

typedef struct run {
    const gn_leak_run *leak;
    const gn_kernels *kernels;
} run;

static void run_tile(uint32_t tile, uint32_t thread, void *user)
{
    const run *r = user;
    r->kernels->leak_tile(r->leak, tile, thread);
}

/* The threads' sums; the call's time is split as theirs was. */
static void add_up(gn_leak_job *job, const gn_leak_thread *threads, uint32_t count, double ms)
{
    double test = 0, trace = 0;
    for (uint32_t i = 0; i < count; i++) {
        const gn_leak_counts *c = &threads[i].counts;
        job->counts.tested += c->tested;
        job->counts.unsure += c->unsure;
        job->counts.expanded += c->expanded;
        job->counts.removed += c->removed;
        job->counts.lost += c->lost;
        job->counts.unheld += c->unheld;
        job->traced_count += threads[i].traced;
        test += threads[i].test_ms;
        trace += threads[i].trace_ms;
    }
    job->test_ms = test > 0 ? ms * test / (test + trace) : 0;
    job->trace_ms = ms - job->test_ms;
}

gn_result gn_cpu_leak(const gn_cpu *cpu, gn_leak_job *job, const gn_visibility_desc *desc)
{
    const gn_gbuffer *g = job->map.gbuffer;
    const uint32_t threads = cpu->context->threads;
    gn_map_reader reader;
    GN_TRY(gn_map_reader_make(cpu->context, &job->map, &reader));
    /* Which of four depths, not how much of each: do they agree? */
    reader.even = job->map.format.kind == GN_MAP_PCF || job->map.format.kind == GN_MAP_DEPTH;
    if (job->map.format.kind == GN_MAP_DEPTH || job->map.format.single_depth)
        reader.reading = GN_READING_BILINEAR;
    gn_cpu_prepare_rays(&job->rays, desc);
    gn_leak_run leak = {.job = job,
                        .reader = &reader,
                        .masked = desc->method->mask,
                        .jitter_x = gn_leak_jitter_x(job->map.frame),
                        .jitter_y = gn_leak_jitter_y(job->map.frame)};
    leak.threads = gn_alloc_zero(cpu->context, threads, sizeof *leak.threads);
    if (!leak.threads)
        return gn_fail(cpu->context, GN_ERROR_OUT_OF_MEMORY, "out of memory for leak tracing");
    const uint32_t across = (g->width + GN_LEAK_TILE - 1) / GN_LEAK_TILE,
                   down = (g->height + GN_LEAK_TILE - 1) / GN_LEAK_TILE;
    run r = {&leak, cpu->kernels};
    const double start = gn_milliseconds();
    gn_parallel_for(cpu->context, across * down, run_tile, &r);
    job->counts = (gn_leak_counts){0};
    job->traced_count = 0;
    add_up(job, leak.threads, threads, gn_milliseconds() - start);
    gn_free(cpu->context, leak.threads);
    return GN_OK;
}
