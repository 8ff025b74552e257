/* Reading OpenEXR: what gnomon writes and what others do, and files that are refused. */
#include "picture_testing.h"

#include <unistd.h>

#include <gnomon/image.h>
#include <openexr.h>

#include "output/output.h"

#define WIDTH  37
#define HEIGHT 29
#define PIXELS ((size_t)WIDTH * HEIGHT)

static char path[64];
static uint8_t bytes[1 << 16];
static size_t size;

static int setup(void **state)
{
    (void)state;
    strcpy(path, "/tmp/gnomon-exr-XXXXXX");
    const int descriptor = mkstemp(path);
    return descriptor >= 0 ? close(descriptor) : -1;
}

static int teardown(void **state)
{
    (void)state;
    return unlink(path);
}

static void load(void)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_true(size > 0 && size < sizeof bytes);
}

static gn_result decode(uint32_t *width, uint32_t *height, float **rgb)
{
    assert_true(gn_exr_is(bytes, size));
    return gn_exr_decode(&context, "input", bytes, size, width, height, rgb);
}

static void expect_pixels(const float *expected)
{
    uint32_t width, height;
    float *rgb;
    if (decode(&width, &height, &rgb) != GN_OK)
        fail_msg("%s", context.message);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    assert_memory_equal(rgb, expected, 3 * PIXELS * sizeof *rgb);
    gn_free(&context, rgb);
    assert_int_equal(context.bytes, 0);
}

static void expect_refusal(gn_result result, const char *reason)
{
    uint32_t width, height;
    float *rgb;
    assert_refused(decode(&width, &height, &rgb), result, reason);
    assert_true(strncmp(context.message, "input: ", 7) == 0);
    assert_int_equal(context.bytes, 0);
}

/* Files of gnomon ----------------------------------------------------------------------------- */

static float rgb_values[3 * PIXELS];

/* Exact in 16 bits. */
static void fill_values(void)
{
    for (size_t i = 0; i < 3 * PIXELS; i++)
        rgb_values[i] = (float)(i * 7 % 1024) / 512.0f - 0.5f;
}

static void test_own_files(void **state)
{
    (void)state;
    fill_values();
    float plane[PIXELS], grey[3 * PIXELS];
    for (size_t i = 0; i < PIXELS; i++) {
        plane[i] = (float)i / 2048.0f;
        grey[3 * i] = grey[3 * i + 1] = grey[3 * i + 2] = plane[i];
    }
    const gn_layer layers[] = {
        {"light0.visibility", "Y", {plane}, 1, 0},
        {NULL, "RGB", {rgb_values, rgb_values + 1, rgb_values + 2}, 3, 0},
        {"depth", "Z", {plane}, 1, 1},
    };
    assert_int_equal(gn_write_exr(device(), path, WIDTH, HEIGHT, layers, 3, NULL, 0), GN_OK);
    load();
    expect_pixels(rgb_values);
    const gn_layer luminance = {NULL, "Y", {plane}, 1, 1};
    assert_int_equal(gn_write_exr(device(), path, WIDTH, HEIGHT, &luminance, 1, NULL, 0), GN_OK);
    load();
    expect_pixels(grey);
    /* With channels before and behind it that are not read. */
    static const char *const others[] = {"Z", "ZX", "ZXW", "ABCD"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        for (int full = 0; full < 2; full++) {
            const gn_layer more[] = {
                {NULL, "Y", {grey}, 3, full},
                {NULL, others[i], {plane, plane, plane, plane}, 1, full},
                {"b", "Y", {plane}, 1, full},
            };
            for (uint32_t count = 2; count < 4; count++) {
                gn_write_exr(device(), path, WIDTH, HEIGHT, more, count, NULL, 0);
                load();
                expect_pixels(grey);
            }
        }
    assert_int_equal(gn_write_exr(device(), path, WIDTH, HEIGHT, layers, 1, NULL, 0), GN_OK);
    load();
    expect_refusal(GN_ERROR_UNSUPPORTED, "neither channels R, G and B nor Y");
}

/* Files of others ----------------------------------------------------------------------------- */

/* How a file of R, G and B differs from gnomon's own. */
typedef struct variant {
    exr_compression_t compression;
    bool tiled;
    exr_pixel_type_t type;
    exr_attr_box2i_t data, display;
} variant;

static variant plain(void)
{
    const exr_attr_box2i_t window = {.min = {.x = 0, .y = 0},
                                     .max = {.x = WIDTH - 1, .y = HEIGHT - 1}};
    return (variant){EXR_COMPRESSION_ZIP, false, EXR_PIXEL_FLOAT, window, window};
}

static void succeed(exr_result_t code)
{
    if (code != EXR_ERR_SUCCESS)
        fail_msg("OpenEXR: %s", exr_get_default_error_message(code));
}

enum { TILE = 16 };

/* R, G and B, interleaved in rgb, which is as large as the data window. */
static void write_variant(const variant *v, const void *rgb)
{
    exr_context_t exr = NULL;
    int part;
    const uint32_t width = (uint32_t)(v->data.max.x - v->data.min.x + 1);
    const uint32_t height = (uint32_t)(v->data.max.y - v->data.min.y + 1);
    succeed(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, NULL));
    succeed(exr_add_part(exr, NULL, v->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part));
    const exr_attr_v2f_t center = {.x = 0, .y = 0};
    succeed(exr_initialize_required_attr(exr, part, &v->display, &v->data, 1, &center, 1,
                                         EXR_LINEORDER_INCREASING_Y, v->compression));
    static const char *const names[] = {"B", "G", "R"};
    for (int c = 0; c < 3; c++)
        succeed(exr_add_channel(exr, part, names[c], v->type, EXR_PERCEPTUALLY_LINEAR, 1, 1));
    if (v->tiled)
        succeed(exr_set_tile_descriptor(exr, part, TILE, TILE, EXR_TILE_ONE_LEVEL,
                                        EXR_TILE_ROUND_DOWN));
    succeed(exr_write_header(exr));
    int32_t lines = TILE;
    if (!v->tiled)
        succeed(exr_get_scanlines_per_chunk(exr, part, &lines));
    const uint32_t columns = v->tiled ? TILE : width;
    for (uint32_t y = 0; y < height; y += (uint32_t)lines)
        for (uint32_t x = 0; x < width; x += columns) {
            exr_chunk_info_t chunk;
            exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
            succeed(v->tiled
                        ? exr_write_tile_chunk_info(exr, part, (int)(x / TILE), (int)(y / TILE), 0,
                                                    0, &chunk)
                        : exr_write_scanline_chunk_info(exr, part, v->data.min.y + (int)y, &chunk));
            succeed(exr_encoding_initialize(exr, part, &chunk, &pipeline));
            for (uint32_t c = 0; c < 3; c++) {
                exr_coding_channel_info_t *channel = &pipeline.channels[c];
                channel->user_bytes_per_element = 4;
                channel->user_data_type =
                    v->type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
                channel->user_pixel_stride = 12;
                channel->user_line_stride = (int32_t)(12 * width);
                channel->encode_from_ptr =
                    (const uint8_t *)rgb + 12 * ((size_t)y * width + x) + 4 * (2 - c);
            }
            succeed(exr_encoding_choose_default_routines(exr, part, &pipeline));
            succeed(exr_encoding_run(exr, part, &pipeline));
            succeed(exr_encoding_destroy(exr, &pipeline));
        }
    succeed(exr_finish(&exr));
    load();
}

static void test_forms(void **state)
{
    (void)state;
    fill_values();
    static const exr_compression_t compressions[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                                     EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                                     EXR_COMPRESSION_PIZ,  EXR_COMPRESSION_PXR24};
    for (size_t i = 0; i < sizeof compressions / sizeof *compressions; i++)
        for (int kind = 0; kind < 4; kind++) {
            variant v = plain();
            v.compression = compressions[i];
            v.tiled = kind & 1;
            v.type = kind & 2 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
            write_variant(&v, rgb_values);
            expect_pixels(rgb_values);
        }
    /* Somewhere else in the plane. */
    variant v = plain();
    v.data = v.display =
        (exr_attr_box2i_t){.min = {.x = -5, .y = 11}, .max = {.x = WIDTH - 6, .y = HEIGHT + 10}};
    write_variant(&v, rgb_values);
    expect_pixels(rgb_values);
    v.tiled = true;
    write_variant(&v, rgb_values);
    expect_pixels(rgb_values);
}

static void test_refusals(void **state)
{
    (void)state;
    fill_values();
    variant v = plain();
    v.display.max.x = 2 * WIDTH;
    write_variant(&v, rgb_values);
    expect_refusal(GN_ERROR_UNSUPPORTED, "display window");
    v = plain();
    v.type = EXR_PIXEL_UINT;
    write_variant(&v, rgb_values);
    expect_refusal(GN_ERROR_UNSUPPORTED, "integers");
    assert_false(gn_exr_is("v/1", 3));
    assert_false(gn_exr_is("\x89PNG", 4));
}

/* A file that ends early is refused, and no byte of it may do harm. */
static void test_damage(void **state)
{
    (void)state;
    fill_values();
    const variant v = plain();
    write_variant(&v, rgb_values);
    const size_t whole = size;
    uint32_t width, height;
    float *rgb;
    for (size = 4; size < whole; size += 13)
        assert_int_not_equal(decode(&width, &height, &rgb), GN_OK);
    size = whole - 1;
    assert_int_not_equal(decode(&width, &height, &rgb), GN_OK);
    size = whole;
    expect_pixels(rgb_values);
    unsigned refused = 0;
    for (size_t i = 4; i < whole; i += i < 600 ? 1 : 37) {
        const uint8_t before = bytes[i];
        bytes[i] = (uint8_t)~before;
        if (decode(&width, &height, &rgb) == GN_OK)
            gn_free(&context, rgb);
        else
            refused++;
        bytes[i] = before;
        assert_int_equal(context.bytes, 0);
    }
    assert_true(refused > 100);
}

static void *no_alloc(size_t wanted, void *user)
{
    (void)wanted;
    (void)user;
    return NULL;
}

static void test_without_memory(void **state)
{
    (void)state;
    fill_values();
    const variant v = plain();
    write_variant(&v, rgb_values);
    const gn_allocator before = context.allocator;
    context.allocator.alloc = no_alloc;
    expect_refusal(GN_ERROR_OUT_OF_MEMORY, "out of memory");
    context.allocator = before;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_own_files, setup, teardown),
        cmocka_unit_test_setup_teardown(test_forms, setup, teardown),
        cmocka_unit_test_setup_teardown(test_refusals, setup, teardown),
        cmocka_unit_test_setup_teardown(test_damage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_without_memory, setup, teardown),
    };
    return cmocka_run_group_tests_name("exr_read", tests, NULL, NULL);
}
