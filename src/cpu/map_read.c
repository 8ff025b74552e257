/* Visibility of a light by its shadow map. */
#include "cpu/map_read.h"

#include <math.h>

#include "cpu/cpu.h"

typedef struct run {
    const gn_map_reader *reader;
    const gn_kernels *kernels;
} run;

static void run_strip(uint32_t strip, uint32_t thread, void *user)
{
    const run *r = user;
    (void)thread;
    r->kernels->map_strip(r->reader, strip);
}

static gn_map_levels find_levels(uint32_t resolution, bool mip_maps)
{
    gn_map_levels levels = {.count = mip_maps ? gn_level_count(resolution, resolution) : 1};
    uint32_t offset = 0;
    for (uint32_t i = 0; i < levels.count; i++) {
        levels.size[i] = gn_level_size(resolution, i);
        levels.offset[i] = offset;
        offset += levels.size[i] * levels.size[i];
    }
    return levels;
}

static gn_result check_layers(const gn_map_job *job, gn_context *context)
{
    if (job->layer_count > GN_MAX_CASCADES)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a shadow map of %u layers: the range is 0 to %u", job->layer_count,
                       GN_MAX_CASCADES);
    for (uint32_t i = 0; i < job->layer_count; i++) {
        const gn_map_layer *layer = &job->layers[i];
        if (gn_map_has_texels(&job->format) ? !layer->texels : !layer->depth[GN_CASTERS_STATIC])
            return gn_fail(context, GN_ERROR_STATE, "layer %u of a shadow map is empty", i);
    }
    return GN_OK;
}

gn_result gn_map_reader_make(gn_context *context, const gn_map_job *job, gn_map_reader *reader)
{
    GN_TRY(check_layers(job, context));
    const gn_map_desc *desc = &job->desc;
    const bool four = job->format.kind == GN_MAP_PCF && job->format.pcf_width == 2;
    *reader = (gn_map_reader){.job = job,
                              .reading = four ? GN_READING_BILINEAR : desc->reading,
                              .cos_outer = (float)cos((double)job->light.desc.outer_cone_angle),
                              .margin = (float)gn_map_margin(&job->format, desc),
                              .place = gn_noise_of_frame(desc->seed, job->frame)};
    reader->noise = gn_blue_noise_tile(reader->place.tile);
    for (uint32_t i = 0; i < job->layer_count; i++)
        reader->levels[i] = find_levels(job->layers[i].projection.resolution, desc->mip_maps);
    if (job->format.kind == GN_MAP_PCF && !four) {
        /* The map filter's weights, so that both see the same share of a step. */
        const int32_t radius = (int32_t)job->format.pcf_width / 2;
        const gn_gaussian g = gn_gaussian_make(job->format.pcf_width, desc->filter_sigma);
        for (int32_t i = -radius; i <= radius; i++)
            reader->weights[1 + radius + i] = g.weights[i < 0 ? -i : i];
    }
    return GN_OK;
}

gn_result gn_cpu_map_visibility(const struct gn_cpu *cpu, const gn_map_job *job)
{
    gn_map_reader reader;
    GN_TRY(gn_map_reader_make(cpu->context, job, &reader));
    run r = {&reader, cpu->kernels};
    gn_parallel_for(cpu->context, gn_strips(job->gbuffer->height), run_strip, &r);
    return GN_OK;
}
