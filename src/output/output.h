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

/* A video being written, as a gn_file: H.264 (libx264) in MP4, 8 bits, yuv420p, BT.709 in its
 * limited range, with the index at the front, so that it plays while it loads. The same frames give
 * the same bytes on any machine with the same libav and x264. path names a regular file or none. */
typedef struct gn_video gn_video;

/* Width and height 1 to 16384 pixels; an odd one is made even by repeating the last column or row.
 * fps in [0.001, 1e6]. GN_ERROR_UNSUPPORTED where the machine's libavcodec has no such encoder.
 * Makes libav silent, in the whole process. After an error *video is NULL. */
gn_result gn_video_begin(gn_context *context, const char *path, uint32_t width, uint32_t height,
                         double fps, gn_video **video);
/* The next frame: 8-bit sRGB, 3 bytes a pixel, rows from top to bottom. After an error the video is
 * to be aborted. */
gn_result gn_video_add(gn_video *video, const uint8_t *rgb);
/* Where it is until then. */
const char *gn_video_partial(const gn_video *video);
/* Makes the file appear under its name. *video is NULL afterwards, also after an error, and then no
 * file is left. At least one frame was added. */
gn_result gn_video_commit(gn_video **video);
/* Removes what there is; *video is NULL afterwards, and may be before. */
void gn_video_abort(gn_video **video);

/* Whether a file begins as OpenEXR files do. */
bool gn_exr_is(const void *data, size_t size);

/* An OpenEXR file in memory to linear RGB, 3 floats a pixel, rows from top to bottom: channels R, G
 * and B of its first part, or Y for all three. name is for messages. rgb is gn_free()d by the
 * caller; after an error nothing is set. */
gn_result gn_exr_decode(gn_context *context, const char *name, const void *data, size_t size,
                        uint32_t *width, uint32_t *height, float **rgb);

#endif
