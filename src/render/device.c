#include "render/device.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

gn_device_desc gn_device_desc_default(void)
{
    return (gn_device_desc){.cookie = GN_COOKIE, .isa = GN_ISA_AUTO};
}

/* Before there is a device, a context of our own takes the messages to the user's logger. */
static gn_result create(gn_context *context, const gn_device_desc *desc, gn_device **device)
{
    GN_CHECK_DESC(context, desc, gn_device_desc);
    if (desc->threads > 1024)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%u threads: the range is 0 to 1024",
                       desc->threads);
    if (!desc->allocator.alloc != !desc->allocator.free)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "an allocator needs both alloc and free");
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    context->threads = desc->threads > 0 ? desc->threads : cores > 0 ? (uint32_t)cores : 1;
    context->allocator = desc->allocator;
    context->progress = desc->progress;

    gn_device *made = gn_alloc_zero(context, 1, sizeof *made);
    if (!made)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a device");
    made->context.allocator = context->allocator;
    made->context.logger = context->logger;
    made->context.progress = context->progress;
    made->context.threads = context->threads;
    made->context.bytes = context->bytes;
    pthread_mutex_init(&made->context.mutex, NULL);
    gn_result result = gn_cpu_create(&made->context, desc->isa, &made->cpu);
    if (result != GN_OK) {
        gn_device_destroy(&made);
        return result;
    }
    *device = made;
    return GN_OK;
}

gn_result gn_device_create(const gn_device_desc *desc, gn_device **device)
{
    if (!device)
        return GN_ERROR_INVALID_ARGUMENT;
    *device = NULL;
    const gn_device_desc defaults = gn_device_desc_default();
    if (!desc)
        desc = &defaults;
    gn_context context = {.threads = 1, .logger = desc->logger};
    if (desc->cookie != GN_COOKIE)
        context.logger = (gn_logger){0};
    pthread_mutex_init(&context.mutex, NULL);
    const gn_result result = create(&context, desc, device);
    pthread_mutex_destroy(&context.mutex);
    return result;
}

void gn_device_destroy(gn_device **device)
{
    if (!device || !*device)
        return;
    gn_device *d = *device;
    *device = NULL;
    gn_cpu_destroy(&d->cpu);
    pthread_mutex_destroy(&d->context.mutex);
    gn_context last = {.allocator = d->context.allocator};
    gn_free(&last, d);
}

const char *gn_device_message(const gn_device *device)
{
    return device ? device->context.message : "";
}

size_t gn_device_bytes(const gn_device *device)
{
    return device->context.bytes;
}

gn_device_info gn_device_get_info(const gn_device *device)
{
    return (gn_device_info){.threads = device->context.threads,
                            .isa = device->cpu.isa,
                            .isa_name = device->cpu.kernels->name,
                            .tracer_version = device->cpu.version};
}
