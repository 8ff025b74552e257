/* Whole files into memory, private to the readers. */
#ifndef GN_SCENE_FILE_H
#define GN_SCENE_FILE_H

#include "base/base.h"

/* Reads a regular file; *data is freed with gn_free(). NULL on success, else the reason. */
const char *gn_file_read(gn_context *context, const char *path, uint8_t **data, uint64_t *size);

/* Writes the folder of file and then relative into path; an absolute one stays alone. false: too
 * long. */
bool gn_file_beside(const char *file, const char *relative, char *path, size_t capacity);

#endif
