#include "cpu/cpu.h"

#include <math.h>
#include <stdatomic.h>

#include <gnomon/shadow/alpha.h>

typedef struct run {
    const gn_visibility_job *job;
    _Atomic uint64_t rays;
} run;

static void run_tile(uint32_t tile, uint32_t thread, void *user)
{
    run *r = user;
    (void)thread;
    atomic_fetch_add(&r->rays, r->job->tracer.accel->kernels->visibility_tile(r->job, tile));
}

void gn_cpu_prepare_rays(gn_visibility_job *job, const gn_visibility_desc *desc)
{
    job->tracer.rule = desc->method->alpha;
    job->tracer.rescaled = desc->rescale_alpha;
    job->tracer.statistics = job->lod || job->lookups;
    /* A wholly opaque occluder, 2^-16 in optical depth, ends a ray whatever the cutoff. */
    const double least = fmax((double)desc->cutoff, 1.0 / 65536.0);
    job->tracer.depth_limit = (int32_t)(-log2(least) * (double)GN_OPTICAL_HALVING);
    job->tracer.trace = job->tracer.accel->kernels->trace;
    job->cutoff = desc->cutoff;
    job->point_light_clip = desc->point_light_clip;
    job->cos_outer = (float)cos((double)job->light.desc.outer_cone_angle);
}

uint64_t gn_cpu_visibility(const gn_cpu *cpu, gn_visibility_job *job,
                           const gn_visibility_desc *desc)
{
    gn_cpu_prepare_rays(job, desc);
    run r = {.job = job, .rays = 0};
    const uint32_t tiles =
        gn_tiles_across(job->gbuffer->width) * gn_tiles_across(job->gbuffer->height);
    gn_parallel_for(cpu->context, tiles, run_tile, &r);
    return r.rays;
}
