/* OpenEXR to linear RGB: scan lines or tiles of the first part. */
#include <string.h>

#include <openexr.h>

#include "output/output.h"

#define MAX_SIZE 16384 /* a side */
/* Deflate never packs more than 1032 bytes into one, a PXR24 float has lost one of four before. */
#define MAX_RATIO 1376u

typedef struct exr_file {
    gn_context *context;
    const char *name;
    const uint8_t *data;
    size_t size;
    exr_context_t exr;
    uint32_t width, height;
    int32_t first_line;
    uint32_t tile[2];   /* columns and rows of a chunk */
    int16_t channel[3]; /* of red, green, blue; the same where there is luminance alone */
    float *rgb;
    float *unread; /* a row for all that is not asked for: OpenEXR 3.1 may write it to NULL */
} exr_file;

static gn_result fail(const exr_file *file, gn_result result, const char *reason)
{
    return gn_fail(file->context, result, "%s: OpenEXR: %s", file->name, reason);
}

/* What OpenEXR says, as a reason. */
static gn_result check(const exr_file *file, exr_result_t code)
{
    if (code == EXR_ERR_SUCCESS)
        return GN_OK;
    const gn_result result = code == EXR_ERR_OUT_OF_MEMORY             ? GN_ERROR_OUT_OF_MEMORY
                             : code == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? GN_ERROR_UNSUPPORTED
                                                                       : GN_ERROR_FORMAT;
    return fail(file, result, exr_get_default_error_message(code));
}

/* The file as a stream in memory ----------------------------------------------------------------
 */

static int64_t size_of(exr_const_context_t exr, void *user)
{
    (void)exr;
    return (int64_t)((const exr_file *)user)->size;
}

static int64_t read_at(exr_const_context_t exr, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void)exr;
    (void)error;
    const exr_file *file = user;
    if (offset >= file->size)
        return 0;
    if (size > file->size - offset)
        size = file->size - offset;
    memcpy(buffer, file->data + offset, size);
    return (int64_t)size;
}

/* OpenEXR would print. */
static void keep_silent(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    (void)message;
}

/* Header ----------------------------------------------------------------------------------------
 */

static gn_result find_channels(exr_file *file, uint64_t *pixel_size)
{
    const exr_attr_chlist_t *list;
    GN_TRY(check(file, exr_get_channels(file->exr, 0, &list)));
    static const char names[] = "RGBY";
    int16_t found[4] = {-1, -1, -1, -1};
    *pixel_size = 0;
    for (int16_t i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        *pixel_size += entry->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return fail(file, GN_ERROR_UNSUPPORTED, "subsampled channels are not supported");
        const char *letter = entry->name.length == 1 ? strchr(names, entry->name.str[0]) : NULL;
        if (!letter)
            continue;
        if (entry->pixel_type == EXR_PIXEL_UINT)
            return fail(file, GN_ERROR_UNSUPPORTED, "colours as integers are not supported");
        found[letter - names] = i;
    }
    const bool color = found[0] >= 0 && found[1] >= 0 && found[2] >= 0;
    if (!color && found[3] < 0)
        return fail(file, GN_ERROR_UNSUPPORTED, "neither channels R, G and B nor Y");
    for (int c = 0; c < 3; c++)
        file->channel[c] = color ? found[c] : found[3];
    return GN_OK;
}

static gn_result read_header(exr_file *file)
{
    exr_storage_t storage;
    exr_attr_box2i_t data, display;
    GN_TRY(check(file, exr_get_storage(file->exr, 0, &storage)));
    GN_TRY(check(file, exr_get_data_window(file->exr, 0, &data)));
    GN_TRY(check(file, exr_get_display_window(file->exr, 0, &display)));
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return fail(file, GN_ERROR_UNSUPPORTED, "deep pictures are not supported");
    if (memcmp(&data, &display, sizeof data) != 0)
        return fail(file, GN_ERROR_UNSUPPORTED, "its data do not fill just its display window");
    const int64_t width = (int64_t)data.max.x - data.min.x + 1;
    const int64_t height = (int64_t)data.max.y - data.min.y + 1;
    if (width < 1 || height < 1 || width > MAX_SIZE || height > MAX_SIZE)
        return gn_fail(file->context, GN_ERROR_UNSUPPORTED,
                       "%s: %lld x %lld pixels; at most %d a side can be read", file->name,
                       (long long)width, (long long)height, MAX_SIZE);
    file->width = (uint32_t)width;
    file->height = (uint32_t)height;
    file->first_line = data.min.y;

    if (storage == EXR_STORAGE_TILED) {
        exr_tile_level_mode_t levels;
        exr_tile_round_mode_t rounding;
        GN_TRY(check(file, exr_get_tile_descriptor(file->exr, 0, &file->tile[0], &file->tile[1],
                                                   &levels, &rounding)));
    } else {
        int32_t lines;
        GN_TRY(check(file, exr_get_scanlines_per_chunk(file->exr, 0, &lines)));
        file->tile[0] = 0; /* as wide as the picture */
        file->tile[1] = (uint32_t)lines;
    }
    if (file->tile[1] == 0 || (storage == EXR_STORAGE_TILED && file->tile[0] == 0))
        return fail(file, GN_ERROR_FORMAT, "chunks without pixels");

    /* A few bytes cannot ask for a gigabyte. */
    uint64_t pixel_size;
    GN_TRY(find_channels(file, &pixel_size));
    if (file->size < (uint64_t)width * (uint64_t)height * pixel_size / MAX_RATIO)
        return fail(file, GN_ERROR_FORMAT, "truncated");
    return GN_OK;
}

/* Pixels ----------------------------------------------------------------------------------------
 */

/* One chunk, its first pixel at x, y of the picture. */
static gn_result read_chunk(exr_file *file, exr_decode_pipeline_t *pipeline, uint32_t x, uint32_t y)
{
    exr_chunk_info_t chunk;
    const bool tiled = file->tile[0] != 0;
    if (tiled)
        GN_TRY(check(file, exr_read_tile_chunk_info(file->exr, 0, (int)(x / file->tile[0]),
                                                    (int)(y / file->tile[1]), 0, 0, &chunk)));
    else
        GN_TRY(check(file, exr_read_scanline_chunk_info(file->exr, 0, file->first_line + (int32_t)y,
                                                        &chunk)));
    if (chunk.width < 1 || chunk.height < 1 || (uint32_t)chunk.width > file->width - x ||
        (uint32_t)chunk.height > file->height - y)
        return fail(file, GN_ERROR_FORMAT, "a chunk beyond the picture");
    const bool first = pipeline->channels == NULL;
    GN_TRY(check(file, first ? exr_decoding_initialize(file->exr, 0, &chunk, pipeline)
                             : exr_decoding_update(file->exr, 0, &chunk, pipeline)));
    for (int16_t i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 3 * sizeof(float);
        channel->user_line_stride = 0;
        channel->decode_to_ptr = (uint8_t *)file->unread;
    }
    for (int c = 2; c >= 0; c--) { /* luminance alone goes into the first */
        exr_coding_channel_info_t *channel = &pipeline->channels[file->channel[c]];
        channel->user_line_stride = (int32_t)(3 * sizeof(float) * file->width);
        channel->decode_to_ptr =
            (uint8_t *)(file->rgb + 3 * ((size_t)y * file->width + x) + (size_t)c);
    }
    if (first || tiled)
        GN_TRY(check(file, exr_decoding_choose_default_routines(file->exr, 0, pipeline)));
    return check(file, exr_decoding_run(file->exr, 0, pipeline));
}

static gn_result read_pixels(exr_file *file)
{
    const size_t pixels = (size_t)file->width * file->height;
    file->rgb = gn_alloc(file->context, pixels, 3 * sizeof *file->rgb);
    file->unread = gn_alloc(file->context, file->width, 3 * sizeof *file->unread);
    if (!file->rgb || !file->unread)
        return fail(file, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    const uint32_t columns = file->tile[0] ? file->tile[0] : file->width;
    gn_result result = GN_OK;
    for (uint64_t y = 0; y < file->height && result == GN_OK; y += file->tile[1])
        for (uint64_t x = 0; x < file->width && result == GN_OK; x += columns)
            result = read_chunk(file, &pipeline, (uint32_t)x, (uint32_t)y);
    exr_decoding_destroy(file->exr, &pipeline);
    if (result == GN_OK && file->channel[0] == file->channel[1])
        for (size_t i = 0; i < pixels; i++)
            file->rgb[3 * i + 1] = file->rgb[3 * i + 2] = file->rgb[3 * i];
    return result;
}

bool gn_exr_is(const void *data, size_t size)
{
    return size >= 4 && memcmp(data, "\x76\x2f\x31\x01", 4) == 0;
}

gn_result gn_exr_decode(gn_context *context, const char *name, const void *data, size_t size,
                        uint32_t *width, uint32_t *height, float **rgb)
{
    exr_file file = {.context = context, .name = name, .data = data, .size = size};
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_silent;
    setup.user_data = &file;
    setup.size_fn = size_of;
    setup.read_fn = read_at;
    gn_result result = check(&file, exr_start_read(&file.exr, name, &setup));
    if (result == GN_OK)
        result = read_header(&file);
    if (result == GN_OK)
        result = read_pixels(&file);
    if (file.exr)
        exr_finish(&file.exr);
    gn_free(context, file.unread);
    if (result != GN_OK) {
        gn_free(context, file.rgb);
        return result;
    }
    *width = file.width;
    *height = file.height;
    *rgb = file.rgb;
    return GN_OK;
}
