/* As little of Vulkan as it takes to run a compute shader over arrays. */
#ifndef GN_TESTS_VULKAN_COMPUTE_H
#define GN_TESTS_VULKAN_COMPUTE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <vulkan/vulkan.h>

typedef struct gn_compute {
    VkInstance instance;
    VkPhysicalDevice physical;
    VkPhysicalDeviceProperties properties;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
} gn_compute;

/* A shader of one input buffer (binding 0), one output buffer (binding 1) and four push constants;
 * both buffers are mapped. */
typedef struct gn_compute_program {
    VkShaderModule module;
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    VkDescriptorPool descriptors;
    VkDescriptorSet set;
    VkBuffer buffers[2];
    VkDeviceMemory memory[2];
    void *in, *out;
} gn_compute_program;

/* The first device that is a processor and computes. false where there is none, with the reason.
 * Whatever fails later prints itself and ends the program. */
bool gn_compute_open(gn_compute *compute, const char **reason);
void gn_compute_close(gn_compute *compute);

void gn_compute_program_make(const gn_compute *compute, const uint32_t *spirv, size_t spirv_bytes,
                             size_t in_bytes, size_t out_bytes, gn_compute_program *program);
/* Runs so many workgroups, and waits for them. */
void gn_compute_program_run(const gn_compute *compute, const gn_compute_program *program,
                            const uint32_t constants[4], uint32_t groups);
void gn_compute_program_free(const gn_compute *compute, gn_compute_program *program);

#endif
