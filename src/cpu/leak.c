#include "cpu/leak.h"

#include <gnomon/shadow/leak.h>

#include "cpu/cpu.h"

typedef struct run {
    const gn_leak_run *leak;
    const gn_kernels *kernels;
} run;

static void ask_strip(uint32_t strip, uint32_t thread, void *user)
{
    const run *r = user;
    r->kernels->leak_ask(r->leak, strip, thread);
}

static void run_strip(uint32_t strip, uint32_t thread, void *user)
{
    const run *r = user;
    r->kernels->leak_strip(r->leak, strip, thread);
}

/* The threads' sums; the call's time is split as theirs was. */
static void add_up(gn_leak_job *job, const gn_leak_thread *threads, uint32_t count, double ms)
{
    uint64_t sums[GN_LEAK_COUNTS] = {0};
    double test = 0, trace = 0;
    job->traced_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < GN_LEAK_COUNTS; k++)
            sums[k] += threads[i].sums[k];
        job->traced_count += threads[i].traced;
        test += threads[i].test_ms;
        trace += threads[i].trace_ms;
    }
    job->counts = (gn_leak_counts){.tested = sums[GN_COUNT_TESTED],
                                   .unsure = sums[GN_COUNT_UNSURE],
                                   .expanded = sums[GN_COUNT_EXPANDED],
                                   .removed = sums[GN_COUNT_REMOVED],
                                   .lost = sums[GN_COUNT_LOST],
                                   .unheld = sums[GN_COUNT_UNHELD]};
    job->test_ms = test > 0 ? ms * test / (test + trace) : 0;
    job->trace_ms = ms - job->test_ms;
}

/* A thread's share of the room that a call needs, in words. */
typedef struct layout {
    size_t pixels, sorted, starts, states, flags, end;
} layout;

static layout lay_out(uint32_t width)
{
    const size_t pixels = (size_t)width * GN_STRIP;
    layout l = {.pixels = 0, .sorted = pixels};
    l.starts = l.sorted + pixels;
    l.states = l.starts + width / GN_LEAK_BLOCK + 2;
    l.flags = l.states + (pixels + 3) / 4;
    l.end = (l.flags + (3 * ((size_t)width + 2) + 3) / 4 + 15) / 16 * 16;
    return l;
}

/* All of it in one piece: the threads' shares, then asks. */
static uint32_t *make_room(gn_context *context, const gn_gbuffer *g, gn_leak_run *leak)
{
    const layout l = lay_out(g->width);
    const size_t words = l.end * context->threads, pixels = (size_t)g->width * g->height;
    uint32_t *room = gn_alloc(context, words + pixels / 2 + 1, sizeof(uint32_t));
    leak->threads = gn_alloc(context, context->threads, sizeof *leak->threads);
    if (!room || !leak->threads)
        return room;
    for (uint32_t i = 0; i < context->threads; i++) {
        uint32_t *share = room + l.end * i;
        leak->threads[i] = (gn_leak_thread){.pixels = share + l.pixels,
                                            .sorted = share + l.sorted,
                                            .starts = share + l.starts,
                                            .states = (uint8_t *)(share + l.states),
                                            .flags = (uint8_t *)(share + l.flags)};
    }
    leak->asks = (uint16_t *)(room + words);
    return room;
}

gn_result gn_cpu_leak(const gn_cpu *cpu, gn_leak_job *job, const gn_visibility_desc *desc)
{
    const gn_gbuffer *g = job->map.gbuffer;
    gn_context *context = cpu->context;
    gn_map_reader reader;
    GN_TRY(gn_map_reader_make(context, &job->map, &reader));
    /* Which of four depths, not how much of each: do they agree? */
    reader.even = job->map.format.kind == GN_MAP_PCF || job->map.format.kind == GN_MAP_DEPTH;
    gn_cpu_prepare_rays(&job->rays, desc);
    gn_leak_run leak = {.job = job,
                        .reader = &reader,
                        .masked = desc->method->mask,
                        .jitter_x = gn_leak_jitter_x(job->map.frame),
                        .jitter_y = gn_leak_jitter_y(job->map.frame)};
    uint32_t *room = make_room(context, g, &leak);
    if (room && leak.threads) {
        run r = {&leak, cpu->kernels};
        const double start = gn_milliseconds();
        if (leak.masked && job->mask.before)
            gn_parallel_for(context, gn_strips(g->height), ask_strip, &r);
        gn_parallel_for(context, gn_strips(g->height), run_strip, &r);
        add_up(job, leak.threads, context->threads, gn_milliseconds() - start);
    }
    const bool done = room && leak.threads;
    gn_free(context, leak.threads);
    gn_free(context, room);
    if (!done)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for leak tracing");
    return GN_OK;
}
