/* The baseline of the map filter: three passes through memory, as renderers do it that keep their
 * filter in three shaders. Resolve and vectors into a texture, filter across into a second one,
 * filter down and quantization into the map.
 *
 * The textures hold floats for every format. (Textures of 16 bits, where the format has them, would
 * move fewer bytes, and cost packing and unpacking without texture units.) The loops over rows are
 * those of the fused filter, so that both do the same arithmetic with the same instructions, and
 * the texels come out the same. */
#ifndef GN_BENCHMARKS_THREE_PASS_H
#define GN_BENCHMARKS_THREE_PASS_H

#include "cpu/cpu.h"
#include "cpu/map_filter.h"

typedef struct gn_three_pass gn_three_pass;

/* The textures for maps up to this size. NULL without memory. */
gn_three_pass *gn_three_pass_create(uint32_t resolution, uint32_t channels);
void gn_three_pass_destroy(gn_three_pass *pass);

/* As gn_cpu_filter() with the whole map as its rectangle. job: of that resolution, and with at most
 * so many channels. */
void gn_three_pass_run(gn_three_pass *pass, const gn_cpu *cpu, const gn_filter_job *job);

#endif
