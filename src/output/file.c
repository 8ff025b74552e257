#include "output/output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void release(gn_file *file)
{
    gn_free(file->context, file->path);
    gn_free(file->context, file->target);
    gn_free(file->context, file->temporary);
    memset(file, 0, sizeof *file);
}

static char *copy_path(gn_context *context, const char *path)
{
    return gn_alloc_copy(context, path, strlen(path) + 1, 1);
}

gn_result gn_file_fail(const gn_file *file, int error, const char *detail)
{
    return gn_fail(file->context, GN_ERROR_IO, "%s: cannot write: %s", file->path,
                   error ? strerror(error) : detail);
}

/* Finds out where the data will go in the end. */
static gn_result resolve_target(gn_file *file, bool *direct)
{
    gn_context *context = file->context;
    struct stat status;
    *direct = false;
    if (stat(file->path, &status) != 0) {
        if (errno != ENOENT)
            return gn_file_fail(file, errno, NULL);
        file->target = copy_path(context, file->path);
    } else if (S_ISDIR(status.st_mode)) {
        return gn_file_fail(file, EISDIR, NULL);
    } else if (!S_ISREG(status.st_mode)) {
        *direct = true;
        file->target = copy_path(context, file->path);
    } else {
        if (access(file->path, W_OK) != 0)
            return gn_file_fail(file, errno, NULL);
        char *real = realpath(file->path, NULL);
        if (!real)
            return gn_file_fail(file, errno, NULL);
        file->target = copy_path(context, real);
        free(real);
    }
    if (!file->target)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", file->path);
    return GN_OK;
}

/* A new file beside the target; permissions follow the user's umask, unlike mkstemp's. */
static int open_temporary(gn_file *file)
{
    const size_t size = strlen(file->target) + 48;
    file->temporary = gn_alloc(file->context, size, 1);
    if (!file->temporary) {
        errno = ENOMEM;
        return -1;
    }
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        snprintf(file->temporary, size, "%s.%ld-%u.part", file->target, (long)getpid(), attempt);
        int descriptor = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST)
            return descriptor;
    }
    return -1;
}

gn_result gn_file_begin(gn_context *context, const char *path, gn_file *file)
{
    *file = (gn_file){.context = context};
    if (!path || !*path)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "cannot write: the path is empty");
    file->path = copy_path(context, path);
    if (!file->path)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);

    bool direct;
    gn_result result = resolve_target(file, &direct);
    if (result == GN_OK) {
        int descriptor = direct ? open(file->target, O_WRONLY | O_CLOEXEC) : open_temporary(file);
        if (descriptor >= 0) {
            file->stream = fdopen(descriptor, "wb");
            if (!file->stream) {
                int error = errno;
                close(descriptor);
                if (file->temporary)
                    unlink(file->temporary);
                errno = error;
            }
        }
        if (!file->stream)
            result = gn_file_fail(file, errno, NULL);
    }
    if (result != GN_OK)
        release(file);
    return result;
}

gn_result gn_file_write(gn_file *file, const void *data, size_t size)
{
    errno = 0;
    if (size > 0 && fwrite(data, 1, size, file->stream) != size)
        return gn_file_fail(file, errno, "the data were not taken");
    return GN_OK;
}

gn_result gn_file_commit(gn_file *file)
{
    /* What the kernel still held back may fail as late as in close(). */
    errno = 0;
    bool good = fflush(file->stream) == 0 && !ferror(file->stream);
    int error = good ? 0 : errno;
    if (fclose(file->stream) != 0 && good) {
        good = false;
        error = errno;
    }
    file->stream = NULL;
    if (good && file->temporary && rename(file->temporary, file->target) != 0) {
        good = false;
        error = errno;
    }

    gn_result result = GN_OK;
    if (!good) {
        result = gn_file_fail(file, error, "the data were not taken");
        if (file->temporary)
            unlink(file->temporary);
    }
    release(file);
    return result;
}

void gn_file_abort(gn_file *file)
{
    if (!file->stream)
        return;
    fclose(file->stream);
    if (file->temporary)
        unlink(file->temporary);
    release(file);
}
