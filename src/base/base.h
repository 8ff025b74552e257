/* The ground floor: results and messages, memory, growing arrays, parallel loops, progress. */
#ifndef GN_BASE_BASE_H
#define GN_BASE_BASE_H

#include <pthread.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <gnomon/device.h>

/* What every part of a device shares. The first member of gn_device. */
typedef struct gn_context {
    gn_allocator allocator;
    gn_logger logger;
    gn_progress progress;
    uint32_t threads;        /* resolved: >= 1 */
    _Atomic size_t bytes;    /* held through gn_alloc */
    _Atomic uint64_t scenes; /* made so far: numbers them */
    pthread_mutex_t mutex;   /* guards message */
    char message[1024];
} gn_context;

/* A device begins with its context. */
static inline gn_context *gn_device_context(gn_device *device)
{
    return (gn_context *)device;
}

/* Messages ---------------------------------------------------------------------------------- */

/* Records and logs an error; returns result, so that callers write `return gn_fail(...)`. */
gn_result gn_fail(gn_context *context, gn_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void gn_log(gn_context *context, gn_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Reports progress; true where the user asked to stop. */
bool gn_report(gn_context *context, double fraction, const char *what);

/* Returns from the calling function where a call fails. */
#define GN_TRY(call)                                                                               \
    do {                                                                                           \
        const gn_result try_result = (call);                                                       \
        if (try_result != GN_OK)                                                                   \
            return try_result;                                                                     \
    } while (0)

/* Memory ------------------------------------------------------------------------------------ */

/* Aligned to 64 bytes; NULL where there is none (or the size overflows). Not cleared. */
void *gn_alloc(gn_context *context, size_t count, size_t element_size);
void *gn_alloc_zero(gn_context *context, size_t count, size_t element_size);
void *gn_alloc_copy(gn_context *context, const void *source, size_t count, size_t element_size);
/* A copy of at most 255 characters of text; "" for NULL. NULL only without memory. */
char *gn_alloc_string(gn_context *context, const char *text);
void gn_free(gn_context *context, void *pointer); /* NULL is fine */

/* Makes room for one more element; *data, *count and *capacity belong together. false: no memory.
 * Use: if (!gn_grow(c, (void **)&a, &n, &cap, sizeof *a)) ...; a[n++] = x; (count is not changed)*/
bool gn_grow(gn_context *context, void **data, uint32_t count, uint32_t *capacity,
             size_t element_size);
/* The same for `more` elements at once. */
bool gn_reserve(gn_context *context, void **data, uint32_t count, uint32_t more, uint32_t *capacity,
                size_t element_size);

/* Parallel loops ---------------------------------------------------------------------------- */

/* Calls body(index, thread, user) for each index in [0, count), in any order, on the context's
 * threads; thread in [0, context->threads). Returns when all are done. */
typedef void (*gn_parallel_body)(uint32_t index, uint32_t thread, void *user);
void gn_parallel_for(gn_context *context, uint32_t count, gn_parallel_body body, void *user);

/* Time -------------------------------------------------------------------------------------- */

double gn_milliseconds(void); /* monotonic */

/* Descriptors ------------------------------------------------------------------------------- */

#define GN_COOKIE 0x676e6f6du /* "gnom": proves that a descriptor was made by its default */

#define GN_CHECK_DESC(context, desc, type)                                                         \
    do {                                                                                           \
        if ((desc) == NULL || (desc)->cookie != GN_COOKIE)                                         \
            return gn_fail((context), GN_ERROR_INVALID_DESC,                                       \
                           #type " was not made by " #type "_default()");                          \
    } while (0)

#endif
