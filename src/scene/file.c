#include "scene/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *read_descriptor(gn_context *context, int descriptor, uint8_t **data,
                                   uint64_t *size)
{
    struct stat status;
    if (fstat(descriptor, &status) != 0)
        return strerror(errno);
    if (!S_ISREG(status.st_mode))
        return "not a regular file";
    const size_t length = (size_t)status.st_size;
    uint8_t *bytes = gn_alloc(context, length, 1);
    if (!bytes)
        return "out of memory";
    size_t done = 0;
    while (done < length) {
        const ssize_t step = read(descriptor, bytes + done, length - done);
        if (step < 0 && errno == EINTR)
            continue;
        if (step <= 0) {
            const char *reason = step < 0 ? strerror(errno) : "it became shorter meanwhile";
            gn_free(context, bytes);
            return reason;
        }
        done += (size_t)step;
    }
    *data = bytes;
    *size = length;
    return NULL;
}

const char *gn_file_read(gn_context *context, const char *path, uint8_t **data, uint64_t *size)
{
    /* O_NONBLOCK: a named pipe must not hold us up before it is refused. */
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0)
        return strerror(errno);
    const char *reason = read_descriptor(context, descriptor, data, size);
    close(descriptor);
    return reason;
}

bool gn_file_beside(const char *file, const char *relative, char *path, size_t capacity)
{
    const char *slash = strrchr(file, '/');
    const int folder = slash && relative[0] != '/' ? (int)(slash - file) + 1 : 0;
    const int length = snprintf(path, capacity, "%.*s%s", folder, file, relative);
    return length >= 0 && (size_t)length < capacity;
}
