#include "base/base.h"

#include <omp.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

const char *gn_result_string(gn_result result)
{
    switch (result) {
    case GN_OK:
        return "ok";
    case GN_ERROR_INVALID_DESC:
        return "invalid descriptor";
    case GN_ERROR_INVALID_ARGUMENT:
        return "invalid argument";
    case GN_ERROR_OUT_OF_MEMORY:
        return "out of memory";
    case GN_ERROR_IO:
        return "input or output failed";
    case GN_ERROR_FORMAT:
        return "malformed file";
    case GN_ERROR_UNSUPPORTED:
        return "unsupported";
    case GN_ERROR_STATE:
        return "call out of order";
    case GN_ERROR_CANCELLED:
        return "cancelled";
    }
    return "unknown result";
}

gn_result gn_fail(gn_context *context, gn_result result, const char *format, ...)
{
    char text[sizeof context->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);

    pthread_mutex_lock(&context->mutex);
    memcpy(context->message, text, sizeof text);
    pthread_mutex_unlock(&context->mutex);
    if (context->logger.log)
        context->logger.log(GN_LOG_ERROR, text, context->logger.user);
    return result;
}

void gn_log(gn_context *context, gn_log_level level, const char *format, ...)
{
    if (!context->logger.log)
        return;
    char text[sizeof context->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    context->logger.log(level, text, context->logger.user);
}

bool gn_report(gn_context *context, double fraction, const char *what)
{
    return context->progress.report &&
           context->progress.report(fraction, what, context->progress.user) != 0;
}

/* Each block is preceded by its size, for the user's sized free. */
#define GN_HEADER 64u

/* Pictures and maps are walked through in many planes at once: pages of 4 KiB would be looked up
 * all the time. */
#define GN_LARGE ((size_t)4 << 20)
#define GN_PAGE  ((size_t)2 << 20)

static void *alloc_large(size_t size)
{
    void *block = NULL;
    if (posix_memalign(&block, GN_PAGE, size) != 0)
        return NULL;
    madvise(block, size, MADV_HUGEPAGE); /* a wish */
    return block;
}

void *gn_alloc(gn_context *context, size_t count, size_t element_size)
{
    size_t size;
    if (__builtin_mul_overflow(count, element_size, &size) ||
        __builtin_add_overflow(size, 2 * GN_HEADER, &size))
        return NULL;
    size &= ~(size_t)(GN_HEADER - 1);
    unsigned char *block = context->allocator.alloc
                               ? context->allocator.alloc(size, context->allocator.user)
                           : size >= GN_LARGE ? alloc_large(size)
                                              : aligned_alloc(GN_HEADER, size);
    if (!block)
        return NULL;
    memcpy(block, &size, sizeof size);
    atomic_fetch_add(&context->bytes, size);
    return block + GN_HEADER;
}

void *gn_alloc_zero(gn_context *context, size_t count, size_t element_size)
{
    void *pointer = gn_alloc(context, count, element_size);
    if (pointer)
        memset(pointer, 0, count * element_size);
    return pointer;
}

void *gn_alloc_copy(gn_context *context, const void *source, size_t count, size_t element_size)
{
    void *pointer = gn_alloc(context, count, element_size);
    if (pointer && count > 0)
        memcpy(pointer, source, count * element_size);
    return pointer;
}

char *gn_alloc_string(gn_context *context, const char *text)
{
    size_t length = text ? strnlen(text, 255) : 0;
    char *copy = gn_alloc(context, length + 1, 1);
    if (copy) {
        if (length > 0)
            memcpy(copy, text, length);
        copy[length] = '\0';
    }
    return copy;
}

void gn_free(gn_context *context, void *pointer)
{
    if (!pointer)
        return;
    unsigned char *block = (unsigned char *)pointer - GN_HEADER;
    size_t size;
    memcpy(&size, block, sizeof size);
    atomic_fetch_sub(&context->bytes, size);
    if (context->allocator.alloc)
        context->allocator.free(block, size, context->allocator.user);
    else
        free(block);
}

bool gn_reserve(gn_context *context, void **data, uint32_t count, uint32_t more, uint32_t *capacity,
                size_t element_size)
{
    const uint64_t needed = (uint64_t)count + more;
    if (needed <= *capacity)
        return true;
    if (needed > UINT32_MAX / 2)
        return false;
    const uint32_t twice = *capacity ? *capacity * 2 : 16;
    const uint32_t larger = needed > twice ? (uint32_t)needed : twice;
    void *grown = gn_alloc(context, larger, element_size);
    if (!grown)
        return false;
    if (count > 0)
        memcpy(grown, *data, count * element_size);
    gn_free(context, *data);
    *data = grown;
    *capacity = larger;
    return true;
}

bool gn_grow(gn_context *context, void **data, uint32_t count, uint32_t *capacity,
             size_t element_size)
{
    return gn_reserve(context, data, count, 1, capacity, element_size);
}

void gn_parallel_for(gn_context *context, uint32_t count, gn_parallel_body body, void *user)
{
    const int threads = (int)context->threads;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (uint32_t index = 0; index < count; index++) {
        body(index, (uint32_t)omp_get_thread_num(), user);
    }
}

double gn_milliseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}
