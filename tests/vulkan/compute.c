#include <stdio.h>
#include <stdlib.h>

#include "compute.h"

#define CHECK(call)                                                                                \
    do {                                                                                           \
        const VkResult check_result = (call);                                                      \
        if (check_result != VK_SUCCESS) {                                                          \
            fprintf(stderr, "%s:%d: %s gives VkResult %d\n", __FILE__, __LINE__, #call,            \
                    check_result);                                                                 \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

/* The first family of queues that computes, or -1. */
static int compute_family(VkPhysicalDevice device)
{
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families);
    for (uint32_t i = 0; i < count; i++)
        if (families[i].queueFlags & VK_QUEUE_COMPUTE_BIT)
            return (int)i;
    return -1;
}

bool gn_compute_open(gn_compute *compute, const char **reason)
{
    *compute = (gn_compute){0};
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_1};
    const VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                           .pApplicationInfo = &application};
    *reason = "there is no Vulkan driver (Debian's mesa-vulkan-drivers has lavapipe)";
    if (vkCreateInstance(&instance, NULL, &compute->instance) != VK_SUCCESS)
        return false;

    VkPhysicalDevice devices[16];
    uint32_t count = 16;
    const VkResult found = vkEnumeratePhysicalDevices(compute->instance, &count, devices);
    if (found != VK_SUCCESS && found != VK_INCOMPLETE)
        count = 0;
    for (uint32_t i = 0; i < count; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(devices[i], &properties);
        const int family = compute_family(devices[i]);
        if (!compute->physical && family >= 0 && properties.apiVersion >= VK_API_VERSION_1_1 &&
            properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) {
            compute->physical = devices[i];
            compute->properties = properties;
            compute->family = (uint32_t)family;
        }
    }
    if (!compute->physical) {
        vkDestroyInstance(compute->instance, NULL);
        *reason =
            "no Vulkan device here is a processor (Debian's mesa-vulkan-drivers has lavapipe)";
        return false;
    }

    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = compute->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue};
    CHECK(vkCreateDevice(compute->physical, &device, NULL, &compute->device));
    vkGetDeviceQueue(compute->device, compute->family, 0, &compute->queue);
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = compute->family};
    CHECK(vkCreateCommandPool(compute->device, &pool, NULL, &compute->pool));
    return true;
}

void gn_compute_close(gn_compute *compute)
{
    vkDestroyCommandPool(compute->device, compute->pool, NULL);
    vkDestroyDevice(compute->device, NULL);
    vkDestroyInstance(compute->instance, NULL);
}

static void *make_buffer(const gn_compute *compute, size_t bytes, VkBuffer *buffer,
                         VkDeviceMemory *memory)
{
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = bytes,
                                     .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    CHECK(vkCreateBuffer(compute->device, &info, NULL, buffer));

    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(compute->device, *buffer, &needs);
    VkPhysicalDeviceMemoryProperties memories;
    vkGetPhysicalDeviceMemoryProperties(compute->physical, &memories);
    /* Vulkan promises a type with both. */
    const VkMemoryPropertyFlags mapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    uint32_t type = 0;
    while (!(needs.memoryTypeBits & 1u << type) ||
           (memories.memoryTypes[type].propertyFlags & mapped) != mapped)
        type++;

    const VkMemoryAllocateInfo allocation = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                             .allocationSize = needs.size,
                                             .memoryTypeIndex = type};
    void *pointer = NULL;
    CHECK(vkAllocateMemory(compute->device, &allocation, NULL, memory));
    CHECK(vkBindBufferMemory(compute->device, *buffer, *memory, 0));
    CHECK(vkMapMemory(compute->device, *memory, 0, VK_WHOLE_SIZE, 0, &pointer));
    return pointer;
}

static void make_pipeline(const gn_compute *compute, const uint32_t *spirv, size_t spirv_bytes,
                          gn_compute_program *program)
{
    const VkShaderModuleCreateInfo module = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = spirv_bytes,
                                             .pCode = spirv};
    CHECK(vkCreateShaderModule(compute->device, &module, NULL, &program->module));

    VkDescriptorSetLayoutBinding bindings[2];
    for (uint32_t i = 0; i < 2; i++)
        bindings[i] =
            (VkDescriptorSetLayoutBinding){.binding = i,
                                           .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                           .descriptorCount = 1,
                                           .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo set_layout = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = 2,
        .pBindings = bindings};
    CHECK(vkCreateDescriptorSetLayout(compute->device, &set_layout, NULL, &program->set_layout));

    const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                                       .size = 4 * sizeof(uint32_t)};
    const VkPipelineLayoutCreateInfo layout = {.sType =
                                                   VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &program->set_layout,
                                               .pushConstantRangeCount = 1,
                                               .pPushConstantRanges = &range};
    CHECK(vkCreatePipelineLayout(compute->device, &layout, NULL, &program->layout));

    const VkComputePipelineCreateInfo pipeline = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = program->module,
                  .pName = "main"},
        .layout = program->layout};
    CHECK(vkCreateComputePipelines(compute->device, VK_NULL_HANDLE, 1, &pipeline, NULL,
                                   &program->pipeline));
}

void gn_compute_program_make(const gn_compute *compute, const uint32_t *spirv, size_t spirv_bytes,
                             size_t in_bytes, size_t out_bytes, gn_compute_program *program)
{
    *program = (gn_compute_program){0};
    make_pipeline(compute, spirv, spirv_bytes, program);
    program->in = make_buffer(compute, in_bytes, &program->buffers[0], &program->memory[0]);
    program->out = make_buffer(compute, out_bytes, &program->buffers[1], &program->memory[1]);

    const VkDescriptorPoolSize size = {.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                       .descriptorCount = 2};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 1,
                                             .pPoolSizes = &size};
    CHECK(vkCreateDescriptorPool(compute->device, &pool, NULL, &program->descriptors));
    const VkDescriptorSetAllocateInfo allocation = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
        .descriptorPool = program->descriptors,
        .descriptorSetCount = 1,
        .pSetLayouts = &program->set_layout};
    CHECK(vkAllocateDescriptorSets(compute->device, &allocation, &program->set));
    for (uint32_t i = 0; i < 2; i++) {
        const VkDescriptorBufferInfo buffer = {.buffer = program->buffers[i],
                                               .range = VK_WHOLE_SIZE};
        const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                            .dstSet = program->set,
                                            .dstBinding = i,
                                            .descriptorCount = 1,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                            .pBufferInfo = &buffer};
        vkUpdateDescriptorSets(compute->device, 1, &write, 0, NULL);
    }
}

void gn_compute_program_run(const gn_compute *compute, const gn_compute_program *program,
                            const uint32_t constants[4], uint32_t groups)
{
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo allocation = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = compute->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1};
    CHECK(vkAllocateCommandBuffers(compute->device, &allocation, &commands));
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    CHECK(vkBeginCommandBuffer(commands, &begin));
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, program->pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, program->layout, 0, 1,
                            &program->set, 0, NULL);
    vkCmdPushConstants(commands, program->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       4 * sizeof *constants, constants);
    vkCmdDispatch(commands, groups, 1, 1);
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                         0, 1, &barrier, 0, NULL, 0, NULL);
    CHECK(vkEndCommandBuffer(commands));

    const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                 .commandBufferCount = 1,
                                 .pCommandBuffers = &commands};
    CHECK(vkQueueSubmit(compute->queue, 1, &submit, VK_NULL_HANDLE));
    CHECK(vkQueueWaitIdle(compute->queue));
    vkFreeCommandBuffers(compute->device, compute->pool, 1, &commands);
}

void gn_compute_program_free(const gn_compute *compute, gn_compute_program *program)
{
    vkDestroyDescriptorPool(compute->device, program->descriptors, NULL);
    for (int i = 0; i < 2; i++) {
        vkDestroyBuffer(compute->device, program->buffers[i], NULL);
        vkFreeMemory(compute->device, program->memory[i], NULL);
    }
    vkDestroyPipeline(compute->device, program->pipeline, NULL);
    vkDestroyPipelineLayout(compute->device, program->layout, NULL);
    vkDestroyDescriptorSetLayout(compute->device, program->set_layout, NULL);
    vkDestroyShaderModule(compute->device, program->module, NULL);
}
