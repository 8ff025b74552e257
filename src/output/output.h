/* Files that are whole or not there. */
#ifndef GN_OUTPUT_OUTPUT_H
#define GN_OUTPUT_OUTPUT_H

#include <stdio.h>

#include "base/base.h"

/* A file being written. Between begin and commit the data lies in a temporary file beside the
 * target. A target that is no regular file (a pipe, a terminal, /dev/full) is written directly. */
typedef struct gn_file {
    FILE *stream;
    gn_context *context;
    char *path;      /* as the caller named it, for messages */
    char *target;    /* with symbolic links resolved */
    char *temporary; /* NULL where the target is written directly */
} gn_file;

/* Opens; after an error there is nothing to abort. */
gn_result gn_file_begin(gn_context *context, const char *path, gn_file *file);

/* Writes size bytes at the current position; an error leaves the file to be aborted. */
gn_result gn_file_write(gn_file *file, const void *data, size_t size);

/* Makes the file appear under its name. After an error the temporary file is gone too. */
gn_result gn_file_commit(gn_file *file);

/* Removes the temporary file. */
void gn_file_abort(gn_file *file);

/* Fails with the file's path, the reason in errno where it is not 0, and otherwise with detail. */
gn_result gn_file_fail(const gn_file *file, int error, const char *detail);

/* Whether a file begins as OpenEXR files do. */
bool gn_exr_is(const void *data, size_t size);

/* An OpenEXR file in memory to linear RGB, 3 floats a pixel, rows from top to bottom: channels R, G
 * and B of its first part, or Y for all three. name is for messages. rgb is gn_free()d by the
 * caller; after an error nothing is set. */
gn_result gn_exr_decode(gn_context *context, const char *name, const void *data, size_t size,
                        uint32_t *width, uint32_t *height, float **rgb);

#endif
