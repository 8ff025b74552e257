/* The CPU device: the passes of a frame, on a scene's tree. */
#ifndef GN_CPU_CPU_H
#define GN_CPU_CPU_H

#include "cpu/kernels.h"

typedef struct gn_cpu {
    gn_context *context;
    RTCDevice rtc;
    const gn_kernels *kernels;
    gn_isa isa;
    char version[32]; /* of Embree */
    gn_tables tables;
} gn_cpu;

/* isa: GN_ISA_AUTO, or one that must be there. */
gn_result gn_cpu_create(gn_context *context, gn_isa isa, gn_cpu *cpu);
void gn_cpu_destroy(gn_cpu *cpu);

/* Camera rays: fills the job's G-buffer. */
void gn_cpu_gbuffer(const gn_cpu *cpu, const gn_gbuffer_job *job);

/* Chooses the job's tracer, and fills in what desc says of rays. */
void gn_cpu_prepare_rays(gn_visibility_job *job, const gn_visibility_desc *desc);

/* Shadow rays of all pixels: fills the job's visibility. A light buffer grows on the way. */
gn_result gn_cpu_visibility(const gn_cpu *cpu, gn_visibility_job *job,
                            const gn_visibility_desc *desc, uint64_t *rays);

/* A light for shading, with its visibility. */
typedef struct gn_shade_light {
    const gn_light *light;
    const float *visibility;
} gn_shade_light;

/* Lambert, sky ambient; linear RGB, 3 floats a pixel. Adds weight times the colour to image. */
void gn_cpu_shade(const gn_cpu *cpu, const gn_gbuffer *gbuffer, const gn_rays *rays,
                  const gn_shade_light *lights, uint32_t light_count, float weight, float *image);

#endif
