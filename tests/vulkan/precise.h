/* SPIR-V whose arithmetic is precise. */
#ifndef GN_TESTS_VULKAN_PRECISE_H
#define GN_TESTS_VULKAN_PRECISE_H

#include <stddef.h>
#include <stdint.h>

/* A copy of a module, made with malloc, in which every arithmetic instruction on floats has the
 * decoration NoContraction: GLSL's `precise`, for every expression of every function. */
uint32_t *gn_spirv_precise(const uint32_t *spirv, size_t bytes, size_t *precise_bytes);

#endif
