/* Image decoding: every kind of PNG, JPEG and WebP gives the right texels, damaged ones an error.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <spng.h>
#include <turbojpeg.h>
#include <webp/encode.h>

#include "scene/scene.h"

/* Remembers the largest allocation. */
static size_t largest;

static void *count_alloc(size_t size, void *user)
{
    (void)user;
    if (size > largest)
        largest = size;
    return aligned_alloc(64, size);
}

static void count_free(void *pointer, size_t size, void *user)
{
    (void)size;
    (void)user;
    free(pointer);
}

static gn_context context = {
    .mutex = PTHREAD_MUTEX_INITIALIZER, .threads = 1, .allocator = {count_alloc, count_free, NULL}};

static uint8_t *decode(const void *data, size_t size, uint32_t width, uint32_t height)
{
    uint32_t w = 0, h = 0;
    uint8_t *pixels = NULL;
    if (gn_image_decode(&context, "image", data, size, &w, &h, &pixels) != GN_OK)
        fail_msg("%s", context.message);
    assert_int_equal(w, width);
    assert_int_equal(h, height);
    return pixels;
}

static void assert_texels(const uint8_t *pixels, const uint8_t *expected, size_t count, int slack)
{
    for (size_t i = 0; i < count * 4; i++) {
        if (abs(pixels[i] - expected[i]) > slack)
            fail_msg("texel %zu, channel %zu is %u, not %u", i / 4, i % 4, pixels[i], expected[i]);
    }
}

/* Refused, naming the image and the reason, and nothing is kept. */
static void assert_refused(const void *data, size_t size, const char *reason)
{
    uint32_t width = 0, height = 0;
    uint8_t *pixels = NULL;
    const gn_result result =
        gn_image_decode(&context, "image 7", data, size, &width, &height, &pixels);
    if (result == GN_OK)
        fail_msg("%zu bytes were accepted, where \"%s\" was expected", size, reason);
    assert_null(pixels);
    if (!strstr(context.message, "image 7") || !strstr(context.message, reason))
        fail_msg("\"%s\" does not hold \"image 7\" and \"%s\"", context.message, reason);
    assert_int_equal(context.bytes, 0);
}

/* Every prefix of a file is refused. The data is copied, so that reads beyond it are found. */
static void assert_prefixes_refused(const uint8_t *data, size_t size)
{
    for (size_t length = 0; length < size; length++) {
        uint8_t *prefix = malloc(length + 1);
        assert_non_null(prefix);
        memcpy(prefix, data, length);
        assert_refused(prefix, length, ": ");
        free(prefix);
    }
}

/* PNG --------------------------------------------------------------------------------------- */

typedef struct png_case {
    uint8_t color_type, depth;
    uint8_t data[16]; /* 2 x 1 texels as in the file */
    size_t size;
    bool palette_alpha, color_key;
    uint8_t expected[8];
} png_case;

static uint8_t *encode_png(const png_case *image, size_t *size)
{
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    assert_non_null(png);
    spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    struct spng_ihdr header = {
        .width = 2, .height = 1, .bit_depth = image->depth, .color_type = image->color_type};
    assert_int_equal(spng_set_ihdr(png, &header), 0);
    struct spng_plte palette = {.n_entries = 2, .entries = {{10, 20, 30, 0}, {40, 50, 60, 0}}};
    struct spng_trns alpha = {.n_type3_entries = 1, .type3_alpha = {99}};
    struct spng_trns key = {.gray = 1, .red = 7, .green = 8, .blue = 9};
    if (image->color_type == SPNG_COLOR_TYPE_INDEXED)
        assert_int_equal(spng_set_plte(png, &palette), 0);
    if (image->palette_alpha)
        assert_int_equal(spng_set_trns(png, &alpha), 0);
    if (image->color_key)
        assert_int_equal(spng_set_trns(png, &key), 0);
    assert_int_equal(
        spng_encode_image(png, image->data, image->size, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    int error = 0;
    uint8_t *bytes = spng_get_png_buffer(png, size, &error);
    assert_non_null(bytes);
    spng_ctx_free(png);
    return bytes;
}

static void png_kinds(void **state)
{
    (void)state;
    static const png_case cases[] = {
        {.color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA,
         .depth = 8,
         .data = {1, 2, 3, 4, 250, 251, 252, 253},
         .size = 8,
         .expected = {1, 2, 3, 4, 250, 251, 252, 253}},
        {.color_type = SPNG_COLOR_TYPE_TRUECOLOR,
         .depth = 8,
         .data = {7, 8, 9, 1, 2, 3},
         .size = 6,
         .color_key = true,
         .expected = {7, 8, 9, 0, 1, 2, 3, 255}},
        {.color_type = SPNG_COLOR_TYPE_GRAYSCALE,
         .depth = 1,
         .data = {0x40},
         .size = 1,
         .color_key = true,
         .expected = {0, 0, 0, 255, 255, 255, 255, 0}},
        {.color_type = SPNG_COLOR_TYPE_GRAYSCALE_ALPHA,
         .depth = 8,
         .data = {100, 50, 200, 150},
         .size = 4,
         .expected = {100, 100, 100, 50, 200, 200, 200, 150}},
        {.color_type = SPNG_COLOR_TYPE_INDEXED,
         .depth = 1,
         .data = {0x40},
         .size = 1,
         .palette_alpha = true,
         .expected = {10, 20, 30, 99, 40, 50, 60, 255}},
        /* 16 bits: equal bytes, so that the order does not matter */
        {.color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA,
         .depth = 16,
         .data = {1, 1, 2, 2, 3, 3, 4, 4, 250, 250, 251, 251, 252, 252, 253, 253},
         .size = 16,
         .expected = {1, 2, 3, 4, 250, 251, 252, 253}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t size = 0;
        uint8_t *bytes = encode_png(&cases[i], &size);
        uint8_t *pixels = decode(bytes, size, 2, 1);
        assert_texels(pixels, cases[i].expected, 2, 0);
        gn_free(&context, pixels);
        assert_prefixes_refused(bytes, size - 4); /* the end's checksum guards nothing */
        free(bytes);
    }
}

static void put_be32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(value >> (24 - 8 * i));
}

static uint8_t *put_chunk(uint8_t *at, const char *type, const uint8_t *data, uint32_t size)
{
    put_be32(at, size);
    memcpy(at + 4, type, 4);
    if (size > 0)
        memcpy(at + 8, data, size);
    uint32_t crc = 0xffffffffu;
    for (uint32_t i = 4; i < 8 + size; i++) {
        crc ^= at[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    put_be32(at + 8 + size, ~crc);
    return at + 12 + size;
}

/* A grey PNG whose rows are stored, not packed. */
static size_t write_grey_png(uint8_t *file, uint32_t width, uint32_t height, uint8_t interlace,
                             const uint8_t *rows, uint16_t size)
{
    uint8_t header[13] = {[8] = 8, [12] = interlace};
    put_be32(header, width);
    put_be32(header + 4, height);
    uint8_t packed[64] = {
        0x78, 0x01, 1, (uint8_t)size, (uint8_t)(size >> 8), (uint8_t)~size, (uint8_t)(~size >> 8)};
    memcpy(packed + 7, rows, size);
    uint32_t a = 1, b = 0;
    for (uint32_t i = 0; i < size; i++) {
        a = (a + rows[i]) % 65521;
        b = (b + a) % 65521;
    }
    put_be32(packed + 7 + size, b << 16 | a);
    memcpy(file, "\x89PNG\r\n\x1a\n", 8);
    uint8_t *end = put_chunk(file + 8, "IHDR", header, sizeof header);
    end = put_chunk(end, "IDAT", packed, size + 11u);
    end = put_chunk(end, "IEND", NULL, 0);
    return (size_t)(end - file);
}

/* Adam7 of 2 x 2: passes 1, 6 and 7 hold (0,0), (1,0) and the second row. */
static void interlaced_png(void **state)
{
    (void)state;
    static const uint8_t rows[] = {0, 11, 0, 22, 0, 33, 44};
    uint8_t file[256];
    const size_t size = write_grey_png(file, 2, 2, 1, rows, sizeof rows);
    uint8_t *pixels = decode(file, size, 2, 2);
    assert_texels(pixels,
                  (uint8_t[]){11, 11, 11, 255, 22, 22, 22, 255, 33, 33, 33, 255, 44, 44, 44, 255},
                  4, 0);
    gn_free(&context, pixels);
    assert_prefixes_refused(file, size - 4);
}

/* A few bytes that claim a huge image are refused before the memory is asked for. */
static void huge_png(void **state)
{
    (void)state;
    static const uint8_t rows[2] = {0};
    uint8_t file[256];
    largest = 0;
    size_t size = write_grey_png(file, 16384, 16384, 0, rows, sizeof rows);
    assert_refused(file, size, "truncated");
    size = write_grey_png(file, 16385, 1, 0, rows, sizeof rows);
    assert_refused(file, size, "PNG");
    assert_in_range(largest, 0, 1 << 20);
}

static void damaged_png(void **state)
{
    (void)state;
    static const uint8_t rows[] = {0, 1, 2};
    uint8_t file[256];
    const size_t size = write_grey_png(file, 2, 1, 0, rows, sizeof rows);
    file[50] ^= 1; /* inside the texels: the checksum is wrong */
    assert_refused(file, size, "PNG");
}

/* JPEG -------------------------------------------------------------------------------------- */

static uint8_t *encode_jpeg(int format, int subsampling, int flags, const uint8_t *pixels,
                            unsigned long *size)
{
    tjhandle jpeg = tjInitCompress();
    assert_non_null(jpeg);
    uint8_t *bytes = NULL;
    assert_int_equal(
        tjCompress2(jpeg, pixels, 16, 0, 16, format, &bytes, size, subsampling, 95, flags), 0);
    tjDestroy(jpeg);
    return bytes;
}

static void jpeg_kinds(void **state)
{
    (void)state;
    uint8_t flat[16 * 16 * 3], expected[16 * 16 * 4], grey[16 * 16 * 4];
    for (size_t i = 0; i < 256; i++) {
        memcpy(flat + 3 * i, (uint8_t[]){200, 100, 50}, 3);
        memcpy(expected + 4 * i, (uint8_t[]){200, 100, 50, 255}, 4);
        memcpy(grey + 4 * i, (uint8_t[]){124, 124, 124, 255}, 4); /* its luma */
    }
    static const struct {
        int subsampling, flags;
    } kinds[] = {{TJSAMP_444, 0}, {TJSAMP_420, TJFLAG_PROGRESSIVE}, {TJSAMP_GRAY, 0}};
    for (size_t i = 0; i < 3; i++) {
        unsigned long size = 0;
        uint8_t *bytes = encode_jpeg(TJPF_RGB, kinds[i].subsampling, kinds[i].flags, flat, &size);
        uint8_t *pixels = decode(bytes, size, 16, 16);
        assert_texels(pixels, kinds[i].subsampling == TJSAMP_GRAY ? grey : expected, 256, 3);
        gn_free(&context, pixels);
        assert_prefixes_refused(bytes, size);
        tjFree(bytes);
    }
}

static void cmyk_jpeg(void **state)
{
    (void)state;
    static const uint8_t flat[16 * 16 * 4];
    unsigned long size = 0;
    uint8_t *bytes = encode_jpeg(TJPF_CMYK, TJSAMP_444, 0, flat, &size);
    assert_refused(bytes, size, "CMYK");
    tjFree(bytes);
}

/* WebP -------------------------------------------------------------------------------------- */

static void webp_kinds(void **state)
{
    (void)state;
    uint8_t texels[8 * 8 * 4];
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = i % 4 == 3 ? (uint8_t)(255 - i / 8) : (uint8_t)(100 + i / 32 * 4);
    uint8_t *bytes = NULL;
    size_t size = WebPEncodeLosslessRGBA(texels, 8, 8, 32, &bytes);
    uint8_t *pixels = decode(bytes, size, 8, 8);
    assert_texels(pixels, texels, 64, 0);
    gn_free(&context, pixels);
    assert_prefixes_refused(bytes, size);
    WebPFree(bytes);

    size = WebPEncodeRGBA(texels, 8, 8, 32, 100, &bytes);
    pixels = decode(bytes, size, 8, 8);
    assert_texels(pixels, texels, 64, 12);
    gn_free(&context, pixels);
    assert_prefixes_refused(bytes, size);
    WebPFree(bytes);
}

static void unknown_formats(void **state)
{
    (void)state;
    assert_refused("", 0, "neither PNG nor JPEG nor WebP");
    assert_refused("GIF89a......", 12, "neither PNG nor JPEG nor WebP");
    assert_refused("RIFF\4\0\0\0WAVE", 12, "neither PNG nor JPEG nor WebP");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_kinds),  cmocka_unit_test(interlaced_png),
        cmocka_unit_test(huge_png),   cmocka_unit_test(damaged_png),
        cmocka_unit_test(jpeg_kinds), cmocka_unit_test(cmyk_jpeg),
        cmocka_unit_test(webp_kinds), cmocka_unit_test(unknown_formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
