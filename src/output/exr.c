#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <gnomon/image.h>
#include <openexr.h>

#include "output/output.h"

#define MAX_NAME 255u

typedef struct channel {
    char name[MAX_NAME + 1];
    const float *plane;
    uint32_t stride;
    bool full_precision;
} channel;

/* The stream of one file, as OpenEXR sees it. */
typedef struct sink {
    int descriptor;
    int error; /* errno of the first write that failed */
} sink;

static int64_t write_at(exr_const_context_t exr, void *user, const void *buffer, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void)exr;
    (void)error; /* its caller holds a lock that it takes again */
    sink *out = user;
    uint64_t done = 0;
    while (done < size) {
        ssize_t written = pwrite(out->descriptor, (const char *)buffer + done, size - done,
                                 (off_t)(offset + done));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) {
            if (!out->error)
                out->error = written < 0 ? errno : ENOSPC;
            return -1;
        }
        done += (uint64_t)written;
    }
    return (int64_t)done;
}

/* OpenEXR would print. It holds its own lock here, so the context must not be asked anything. */
static void keep_silent(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    (void)message;
}

static int compare_channels(const void *a, const void *b)
{
    return strcmp(((const channel *)a)->name, ((const channel *)b)->name);
}

/* All channels of all layers, in the order that the format demands. */
static gn_result collect(gn_context *context, const char *path, const gn_layer *layers,
                         uint32_t layer_count, channel **channels, uint32_t *count)
{
    size_t total = 0;
    for (uint32_t i = 0; i < layer_count; i++) {
        size_t letters = layers[i].channels ? strlen(layers[i].channels) : 0;
        size_t name = layers[i].name ? strlen(layers[i].name) : 0;
        if (letters < 1 || letters > 4 || name + 2 > MAX_NAME)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "%s: layer %u needs 1 to 4 channels and a name under %u bytes", path, i,
                           MAX_NAME - 2);
        for (size_t c = 0; c < letters; c++) {
            if (!layers[i].planes[c] || layers[i].stride < 1 || layers[i].stride > 1024)
                return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                               "%s: layer %u has no data or no valid stride", path, i);
        }
        total += letters;
    }
    if (total == 0)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: an image without layers", path);

    channel *list = gn_alloc_zero(context, total, sizeof *list);
    if (!list)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);
    uint32_t used = 0;
    for (uint32_t i = 0; i < layer_count; i++) {
        const gn_layer *layer = &layers[i];
        for (uint32_t c = 0; layer->channels[c]; c++) {
            channel *out = &list[used++];
            bool named = layer->name && *layer->name;
            snprintf(out->name, sizeof out->name, "%s%s%c", named ? layer->name : "",
                     named ? "." : "", layer->channels[c]);
            out->plane = layer->planes[c];
            out->stride = layer->stride;
            out->full_precision = layer->full_precision != 0;
        }
    }
    qsort(list, used, sizeof *list, compare_channels);
    for (uint32_t i = 1; i < used; i++) {
        if (strcmp(list[i - 1].name, list[i].name) == 0) {
            gn_result result = gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                                       "%s: two channels are called '%s'", path, list[i].name);
            gn_free(context, list);
            return result;
        }
    }
    *channels = list;
    *count = used;
    return GN_OK;
}

static exr_result_t write_header(exr_context_t exr, uint32_t width, uint32_t height,
                                 const channel *channels, uint32_t channel_count,
                                 const gn_attribute *attributes, uint32_t attribute_count)
{
    int part;
    exr_set_longname_support(exr, 1);
    exr_result_t code = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr_simple(exr, part, (int32_t)width, (int32_t)height,
                                                   EXR_COMPRESSION_ZIP);
    for (uint32_t i = 0; code == EXR_ERR_SUCCESS && i < channel_count; i++)
        code = exr_add_channel(exr, part, channels[i].name,
                               channels[i].full_precision ? EXR_PIXEL_FLOAT : EXR_PIXEL_HALF,
                               EXR_PERCEPTUALLY_LINEAR, 1, 1);
    for (uint32_t i = 0; code == EXR_ERR_SUCCESS && i < attribute_count; i++) {
        char name[MAX_NAME + 1];
        snprintf(name, sizeof name, "gnomon.%s", attributes[i].key);
        code = exr_attr_set_string(exr, part, name, attributes[i].value ? attributes[i].value : "");
    }
    return code == EXR_ERR_SUCCESS ? exr_write_header(exr) : code;
}

static exr_result_t write_chunks(exr_context_t exr, uint32_t width, uint32_t height,
                                 const channel *channels, uint32_t channel_count)
{
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(exr, 0, &lines);
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool ready = false;
    for (uint32_t y = 0; code == EXR_ERR_SUCCESS && y < height; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        code = exr_write_scanline_chunk_info(exr, 0, (int)y, &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = ready ? exr_encoding_update(exr, 0, &chunk, &pipeline)
                         : exr_encoding_initialize(exr, 0, &chunk, &pipeline);
        if (code != EXR_ERR_SUCCESS)
            break;
        for (uint32_t i = 0; i < channel_count; i++) {
            exr_coding_channel_info_t *info = &pipeline.channels[i];
            const size_t first = (size_t)y * width * channels[i].stride;
            info->user_bytes_per_element = sizeof(float);
            info->user_data_type = EXR_PIXEL_FLOAT;
            info->user_pixel_stride = (int32_t)(channels[i].stride * sizeof(float));
            info->user_line_stride = (int32_t)(width * channels[i].stride * sizeof(float));
            info->encode_from_ptr = (const uint8_t *)(channels[i].plane + first);
        }
        if (!ready)
            code = exr_encoding_choose_default_routines(exr, 0, &pipeline);
        ready = true;
        if (code == EXR_ERR_SUCCESS)
            code = exr_encoding_run(exr, 0, &pipeline);
    }
    if (ready)
        exr_encoding_destroy(exr, &pipeline);
    return code;
}

gn_result gn_write_exr(gn_device *device, const char *path, uint32_t width, uint32_t height,
                       const gn_layer *layers, uint32_t layer_count, const gn_attribute *attributes,
                       uint32_t attribute_count)
{
    gn_context *context = (gn_context *)device;
    if (width == 0 || height == 0 || width > 65536 || height > 65536)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: cannot write an EXR of %u x %u pixels", path, width, height);
    channel *channels = NULL;
    uint32_t channel_count = 0;
    gn_result result = collect(context, path, layers, layer_count, &channels, &channel_count);
    if (result != GN_OK)
        return result;

    gn_file file;
    result = gn_file_begin(context, path, &file);
    if (result != GN_OK) {
        gn_free(context, channels);
        return result;
    }
    sink out = {.descriptor = fileno(file.stream)};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_silent;
    setup.user_data = &out;
    setup.write_fn = write_at;
    exr_context_t exr = NULL;
    exr_result_t code = exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup);
    if (code == EXR_ERR_SUCCESS)
        code =
            write_header(exr, width, height, channels, channel_count, attributes, attribute_count);
    if (code == EXR_ERR_SUCCESS)
        code = write_chunks(exr, width, height, channels, channel_count);
    if (exr) {
        /* The table of chunks is written here. */
        exr_result_t finish = exr_finish(&exr);
        if (code == EXR_ERR_SUCCESS)
            code = finish;
    }
    gn_free(context, channels);

    if (code != EXR_ERR_SUCCESS || out.error) {
        result = gn_file_fail(&file, out.error, exr_get_default_error_message(code));
        gn_file_abort(&file);
        return result;
    }
    return gn_file_commit(&file);
}
