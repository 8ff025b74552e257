/* PNG, JPEG and WebP to RGBA8. */
#include "scene/scene.h"

#include <string.h>

#include <spng.h>
#include <turbojpeg.h>
#include <webp/decode.h>

/* What a decoder works on. */
typedef struct coded_image {
    gn_context *context;
    const char *name;
    const uint8_t *data;
    size_t size;
    uint32_t width, height;
    uint8_t *pixels;
} coded_image;

static gn_result fail(coded_image *image, gn_result result, const char *reason)
{
    return gn_fail(image->context, result, "%s: %s", image->name, reason);
}

/* Checks the size and makes room for the pixels. bytes_per_texel bounds from below what the file
 * must hold for each texel, so that a few bytes cannot ask for a gigabyte; 0: unknown. */
static gn_result allocate(coded_image *image, double bytes_per_texel)
{
    if (image->width == 0 || image->height == 0 || image->width > GN_MAX_TEXTURE_SIZE ||
        image->height > GN_MAX_TEXTURE_SIZE)
        return gn_fail(image->context, GN_ERROR_UNSUPPORTED,
                       "%s: %u x %u texels; at most %u a side can be read", image->name,
                       image->width, image->height, GN_MAX_TEXTURE_SIZE);
    const size_t texels = (size_t)image->width * image->height;
    if ((double)image->size < (double)texels * bytes_per_texel)
        return fail(image, GN_ERROR_FORMAT, "truncated");
    image->pixels = gn_alloc(image->context, texels, 4);
    return image->pixels ? GN_OK : fail(image, GN_ERROR_OUT_OF_MEMORY, "out of memory");
}

/* PNG --------------------------------------------------------------------------------------- */

static gn_result read_png(coded_image *image, spng_ctx *png)
{
    struct spng_ihdr header;
    spng_set_image_limits(png, GN_MAX_TEXTURE_SIZE, GN_MAX_TEXTURE_SIZE);
    /* Ancillary chunks: no larger than the file, and what is kept of them no larger than a multiple
     * of it: of a chunk of few bytes, more are kept than it has. */
    spng_set_chunk_limits(png, image->size, 16 * image->size);
    int error = spng_set_png_buffer(png, image->data, image->size);
    if (!error)
        error = spng_get_ihdr(png, &header);
    if (error)
        return gn_fail(image->context, GN_ERROR_FORMAT, "%s: PNG: %s", image->name,
                       spng_strerror(error));
    image->width = header.width;
    image->height = header.height;
    /* Deflate never packs more than 1032 bytes into one; a byte holds 8 texels at most. */
    gn_result result = allocate(image, 1.0 / (1032 * 8));
    if (result != GN_OK)
        return result;
    error = spng_decode_image(png, image->pixels, (size_t)image->width * image->height * 4,
                              SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
    if (!error)
        error = spng_decode_chunks(png); /* a missing end is a truncated file */
    if (error)
        return gn_fail(image->context, GN_ERROR_FORMAT, "%s: PNG: %s%s", image->name,
                       error == SPNG_EIO ? "truncated: " : "", spng_strerror(error));
    return GN_OK;
}

static gn_result decode_png(coded_image *image)
{
    spng_ctx *png = spng_ctx_new(0);
    if (!png)
        return fail(image, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    const gn_result result = read_png(image, png);
    spng_ctx_free(png);
    return result;
}

/* JPEG -------------------------------------------------------------------------------------- */

static gn_result read_jpeg(coded_image *image, tjhandle jpeg)
{
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    if (tjDecompressHeader3(jpeg, image->data, image->size, &width, &height, &subsampling,
                            &colorspace) != 0)
        return gn_fail(image->context, GN_ERROR_FORMAT, "%s: JPEG: %s", image->name,
                       tjGetErrorStr2(jpeg));
    if (colorspace == TJCS_CMYK || colorspace == TJCS_YCCK)
        return fail(image, GN_ERROR_UNSUPPORTED, "JPEG: CMYK colours are not supported");
    image->width = (uint32_t)width;
    image->height = (uint32_t)height;
    /* At least one bit for each block of 8 x 8, and 1.5 blocks for 16 x 16 with subsampling; with
     * a margin of 8. */
    gn_result result = allocate(image, 1.0 / 8192);
    if (result != GN_OK)
        return result;
    /* Warnings mean damage: what is missing would be filled with grey. */
    if (tjDecompress2(jpeg, image->data, image->size, image->pixels, width, 0, height, TJPF_RGBA,
                      TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0)
        return gn_fail(image->context, GN_ERROR_FORMAT, "%s: JPEG: truncated or damaged: %s",
                       image->name, tjGetErrorStr2(jpeg));
    return GN_OK;
}

static gn_result decode_jpeg(coded_image *image)
{
    tjhandle jpeg = tjInitDecompress();
    if (!jpeg)
        return fail(image, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    const gn_result result = read_jpeg(image, jpeg);
    tjDestroy(jpeg);
    return result;
}

/* WebP -------------------------------------------------------------------------------------- */

static gn_result decode_webp(coded_image *image)
{
    WebPBitstreamFeatures features;
    const VP8StatusCode status = WebPGetFeatures(image->data, image->size, &features);
    if (status != VP8_STATUS_OK)
        return fail(image, GN_ERROR_FORMAT,
                    status == VP8_STATUS_NOT_ENOUGH_DATA ? "WebP: truncated" : "WebP: damaged");
    if (features.has_animation)
        return fail(image, GN_ERROR_UNSUPPORTED, "WebP: animations are not supported");
    image->width = (uint32_t)features.width;
    image->height = (uint32_t)features.height;
    gn_result result = allocate(image, 0); /* one colour packs into a few bytes */
    if (result != GN_OK)
        return result;
    if (!WebPDecodeRGBAInto(image->data, image->size, image->pixels,
                            (size_t)image->width * image->height * 4, features.width * 4))
        return fail(image, GN_ERROR_FORMAT, "WebP: truncated or damaged");
    return GN_OK;
}

/* The choice -------------------------------------------------------------------------------- */

gn_result gn_image_decode(gn_context *context, const char *name, const void *data, size_t size,
                          uint32_t *width, uint32_t *height, uint8_t **pixels)
{
    coded_image image = {.context = context, .name = name, .data = data, .size = size};
    gn_result result;
    if (size >= 8 && memcmp(data, "\x89PNG\r\n\x1a\n", 8) == 0)
        result = decode_png(&image);
    else if (size >= 3 && memcmp(data, "\xff\xd8\xff", 3) == 0)
        result = decode_jpeg(&image);
    else if (size >= 12 && memcmp(data, "RIFF", 4) == 0 && memcmp(image.data + 8, "WEBP", 4) == 0)
        result = decode_webp(&image);
    else
        result = fail(&image, GN_ERROR_FORMAT, "neither PNG nor JPEG nor WebP");
    if (result != GN_OK) {
        gn_free(context, image.pixels);
        return result;
    }
    *width = image.width;
    *height = image.height;
    *pixels = image.pixels;
    return GN_OK;
}
