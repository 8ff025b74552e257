#include "cpu/cpu.h"

#include <math.h>
#include <stdatomic.h>

#include <gnomon/shadow/alpha.h>

#include "cpu/light_buffer.h"

typedef struct run {
    const gn_visibility_job *job;
    bool missed; /* the tiles that the first pass missed, no others */
    _Atomic uint64_t rays;
} run;

static void run_tile(uint32_t tile, uint32_t thread, void *user)
{
    run *r = user;
    (void)thread;
    if (!r->missed || r->job->missed[tile])
        atomic_fetch_add(&r->rays, r->job->tracer.accel->kernels->visibility_tile(r->job, tile));
}

void gn_cpu_prepare_rays(gn_visibility_job *job, const gn_visibility_desc *desc)
{
    job->tracer.rule = desc->method->alpha;
    job->tracer.rescaled = desc->rescale_alpha;
    job->tracer.statistics = job->lod || job->lookups || job->entries;
    /* A wholly opaque occluder, 2^-16 in optical depth, ends a ray whatever the cutoff. */
    const double least = fmax((double)desc->cutoff, 1.0 / 65536.0);
    job->tracer.depth_limit = (int32_t)(-log2(least) * (double)GN_OPTICAL_HALVING);
    const gn_kernels *kernels = job->tracer.accel->kernels;
    job->tracer.trace = job->tracer.buffer ? kernels->trace_light : kernels->trace;
    job->cutoff = desc->cutoff;
    job->point_light_clip = desc->point_light_clip;
    job->cos_outer = (float)cos((double)job->light.desc.outer_cone_angle);
}

gn_result gn_cpu_visibility(const gn_cpu *cpu, gn_visibility_job *job,
                            const gn_visibility_desc *desc, uint64_t *rays)
{
    gn_cpu_prepare_rays(job, desc);
    run r = {.job = job, .rays = 0};
    const uint32_t tiles = gn_ray_tiles_of(job).count;
    if (job->tracer.buffer) {
        job->missed = gn_alloc_zero(cpu->context, tiles, 1);
        if (!job->missed)
            return gn_fail(cpu->context, GN_ERROR_OUT_OF_MEMORY, "out of memory for %u tiles",
                           tiles);
    }
    /* Pixels that meet a part of the light buffer which is not there yet wait until it is. */
    job->tracer.patient = job->tracer.buffer != NULL;
    gn_parallel_for(cpu->context, tiles, run_tile, &r);
    gn_result result = GN_OK;
    if (job->tracer.buffer) {
        result = gn_light_buffer_grow(job->tracer.buffer);
        job->tracer.patient = false;
        r.missed = true;
        if (result == GN_OK)
            gn_parallel_for(cpu->context, tiles, run_tile, &r);
        gn_free(cpu->context, job->missed);
        job->missed = NULL;
    }
    *rays = r.rays;
    return result;
}
