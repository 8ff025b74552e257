/* Devices, results, allocation and messages.
 *
 * Everything in gnomon belongs to a device. There is no process-wide state: two devices in one
 * process do not see each other. */
#ifndef GNOMON_DEVICE_H
#define GNOMON_DEVICE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(GNOMON_SHARED) && defined(__GNUC__)
#define GN_API __attribute__((visibility("default")))
#else
#define GN_API
#endif

#define GN_VERSION_MAJOR 0
#define GN_VERSION_MINOR 1
#define GN_VERSION_PATCH 0

/* "No such object": the null value of every index in this API. */
#define GN_NONE UINT32_MAX

/* What every function that can fail returns. 0 is success. */
typedef enum gn_result {
    GN_OK = 0,
    GN_ERROR_INVALID_DESC = 1,     /* a descriptor that was not made by its _desc_default() */
    GN_ERROR_INVALID_ARGUMENT = 2, /* a value out of its documented range */
    GN_ERROR_OUT_OF_MEMORY = 3,
    GN_ERROR_IO = 4,          /* a file cannot be opened, read or written */
    GN_ERROR_FORMAT = 5,      /* a file or its data breaks the rules of its format */
    GN_ERROR_UNSUPPORTED = 6, /* valid, but not something gnomon can do */
    GN_ERROR_STATE = 7,       /* calls in the wrong order, such as rendering before a commit */
    GN_ERROR_CANCELLED = 8    /* the progress callback asked to stop */
} gn_result;

/* A short English name, never NULL: "ok", "invalid argument"... */
GN_API const char *gn_result_string(gn_result result);

typedef enum gn_log_level { GN_LOG_ERROR = 0, GN_LOG_WARNING = 1, GN_LOG_INFO = 2 } gn_log_level;

/* Memory hooks. alloc: at least size bytes, aligned to 64, or NULL. free: gets the same size.
 * Both may be called from several threads at once. Libraries below (Embree, Assimp, the image
 * codecs) use their own allocation. */
typedef struct gn_allocator {
    void *(*alloc)(size_t size, void *user);
    void (*free)(void *pointer, size_t size, void *user);
    void *user;
} gn_allocator;

typedef struct gn_logger {
    void (*log)(gn_log_level level, const char *message, void *user);
    void *user;
} gn_logger;

/* Progress of long work: fraction in [0,1], what names the step. Return non-zero to cancel.
 * Called from the thread that made the call, never from workers. */
typedef struct gn_progress {
    int (*report)(double fraction, const char *what, void *user);
    void *user;
} gn_progress;

/* Highest instruction set the CPU device may use. Results agree between them (docs/decisions.md).*/
typedef enum gn_isa {
    GN_ISA_AUTO = 0, /* the best this machine has */
    GN_ISA_SCALAR = 1,
    GN_ISA_AVX2 = 2,
    GN_ISA_AVX512 = 3
} gn_isa;

/* Made by gn_device_desc_default(). */
typedef struct gn_device_desc {
    uint32_t cookie;        /* set by gn_device_desc_default(); do not touch */
    uint32_t threads;       /* worker threads, [0, 1024], default 0: one for each core */
    gn_isa isa;             /* default GN_ISA_AUTO */
    gn_allocator allocator; /* default {NULL}: malloc and free */
    gn_logger logger;       /* default {NULL}: silent */
    gn_progress progress;   /* default {NULL}: none */
} gn_device_desc;

/* Thread-safety: a device may be used from several threads at once; objects made from it may be
 * edited by one thread at a time (see scene.h and view.h). */
typedef struct gn_device gn_device;

GN_API gn_device_desc gn_device_desc_default(void);

/* Creates a device into *device, which is NULL after an error. desc may be NULL: defaults.
 * Errors are also told to desc->logger, since there is no device to ask. */
GN_API gn_result gn_device_create(const gn_device_desc *desc, gn_device **device);

/* Destroys a device and sets *device to NULL. Scenes and views made from it must be gone. NULL and
 * &NULL are fine. */
GN_API void gn_device_destroy(gn_device **device);

/* The message of the last call that failed on this device in any thread, "" if none. It names the
 * file, the thing and the reason. Valid until the next failing call. */
GN_API const char *gn_device_message(const gn_device *device);

/* Bytes that gnomon itself holds at the moment for this device. */
GN_API size_t gn_device_bytes(const gn_device *device);

/* Facts for reports: threads in use, instruction set in use, Embree version "3.13.5". */
typedef struct gn_device_info {
    uint32_t threads;
    gn_isa isa;
    const char *isa_name;
    const char *tracer_version;
} gn_device_info;

GN_API gn_device_info gn_device_get_info(const gn_device *device);

#ifdef __cplusplus
}
#endif

#endif
