/* Numbers on their way into a file or out of memory, little-endian; the same calls for both, so
 * that a format is written down once. After an error calls do nothing, and values stay. */
#ifndef GN_RENDER_STREAM_H
#define GN_RENDER_STREAM_H

#include "output/output.h"

typedef struct gn_stream {
    gn_context *context;
    const char *name; /* of the file, for messages */
    const char *what; /* is at hand, for messages */
    gn_result result; /* of all calls so far */
    gn_file *file;    /* writing; NULL: reading */
    uint64_t sum;     /* writing: checksum so far, from GN_CHECKSUM_START */
    const uint8_t *data;
    size_t size, at; /* reading: data, and where in it */
} gn_stream;

/* "FILE: WHAT REASON" (GN_ERROR_FORMAT). */
void gn_stream_refuse(gn_stream *s, const char *reason);
/* A function failed whose message knows nothing of the file: "FILE: WHAT: MESSAGE". */
void gn_stream_blame(gn_stream *s, gn_result result);

void gn_stream_bytes(gn_stream *s, uint8_t *data, size_t size);
/* Unsigned, of size bytes, at most 8. */
void gn_stream_number(gn_stream *s, uint64_t *value, size_t size);
void gn_stream_word(gn_stream *s, uint32_t *value);
/* Refuses other values than 0 and 1. */
void gn_stream_flag(gn_stream *s, bool *value);
/* A value in [0, count), which is returned; refuses others, and returns 0 after an error. */
uint32_t gn_stream_choice(gn_stream *s, uint32_t value, uint32_t count);
void gn_stream_reals(gn_stream *s, float *values, size_t count);
void gn_stream_doubles(gn_stream *s, double *values, size_t count);

/* Is there as much in what is left to read? Asked before memory is; refuses where there is not. */
bool gn_stream_has(gn_stream *s, uint64_t count, uint64_t size);

/* FNV-1a, 64 bits: a change of one byte always changes it. */
#define GN_CHECKSUM_START 14695981039346656037u
uint64_t gn_checksum(uint64_t sum, const void *data, size_t size);

#endif
