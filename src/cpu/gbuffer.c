#include "cpu/cpu.h"

static void run_tile(uint32_t tile, uint32_t thread, void *user)
{
    const gn_gbuffer_job *job = user;
    (void)thread;
    job->accel->kernels->gbuffer_tile(job, tile);
}

void gn_cpu_gbuffer(const gn_cpu *cpu, const gn_gbuffer_job *job)
{
    gn_gbuffer_job copy = *job;
    gn_parallel_for(cpu->context,
                    gn_tiles_across(job->gbuffer->width) * gn_tiles_across(job->gbuffer->height),
                    run_tile, &copy);
}
