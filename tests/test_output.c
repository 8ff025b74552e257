/* PNG and OpenEXR: what is written reads back exactly, and failures leave nothing behind. */
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>

#include <gnomon/image.h>
#include <openexr.h>
#include <spng.h>

#include "output/output.h"

static gn_context context = {.mutex = PTHREAD_MUTEX_INITIALIZER, .threads = 1};
static char folder[64];

/* The context is the first member of every device. */
static gn_device *device(void)
{
    return (gn_device *)&context;
}

static const char *in_folder(const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static unsigned count_files(void)
{
    unsigned count = 0;
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static int setup(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/gnomon-output-XXXXXX");
    context.message[0] = '\0';
    return mkdtemp(folder) ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        if (entry->d_name[0] != '.')
            remove(in_folder(entry->d_name));
    }
    closedir(directory);
    rmdir(folder);
    return 0;
}

static void assert_message(const char *path, const char *reason)
{
    if (!strstr(context.message, path) || !strstr(context.message, reason))
        fail_msg("message '%s' names not both '%s' and '%s'", context.message, path, reason);
}

static void test_srgb(void **state)
{
    (void)state;
    /* Every code goes to linear by the standard's inverse and comes back. */
    for (int code = 0; code < 256; code++) {
        double s = code / 255.0;
        float linear = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
        uint8_t back;
        gn_encode_srgb(&linear, &back, 1);
        assert_int_equal(back, code);
    }
    const float odd[] = {-1.0f, NAN, INFINITY, 2.0f, -INFINITY};
    const uint8_t expected[] = {0, 0, 255, 255, 0};
    uint8_t coded[5];
    gn_encode_srgb(odd, coded, 5);
    assert_memory_equal(coded, expected, 5);
}

static void read_png(const char *path, uint32_t width, uint32_t height, uint32_t channels,
                     uint8_t *pixels, char *seed, size_t seed_size, char *camera,
                     size_t camera_size)
{
    FILE *stream = fopen(path, "rb");
    assert_non_null(stream);
    spng_ctx *png = spng_ctx_new(0);
    assert_int_equal(spng_set_png_file(png, stream), 0);
    struct spng_ihdr header;
    assert_int_equal(spng_get_ihdr(png, &header), 0);
    assert_int_equal(header.width, width);
    assert_int_equal(header.height, height);
    assert_int_equal(header.bit_depth, 8);
    assert_int_equal(
        spng_decode_image(png, pixels, (size_t)width * height * channels, SPNG_FMT_RAW, 0), 0);
    uint8_t intent = 9;
    assert_int_equal(spng_get_srgb(png, &intent), 0);
    struct spng_text texts[8];
    uint32_t count = 0;
    assert_int_equal(spng_get_text(png, NULL, &count), 0);
    assert_int_equal(count, 2);
    assert_int_equal(spng_get_text(png, texts, &count), 0);
    assert_string_equal(texts[0].keyword, "gnomon.seed");
    assert_string_equal(texts[1].keyword, "gnomon.camera");
    snprintf(seed, seed_size, "%s", texts[0].text);
    snprintf(camera, camera_size, "%s", texts[1].text);
    spng_ctx_free(png);
    fclose(stream);
}

static void test_png(void **state)
{
    (void)state;
    enum { WIDTH = 37, HEIGHT = 19 };
    const gn_attribute attributes[] = {{"seed", "7"},
                                       {"empty", ""},
                                       {"camera", "Stra\xc3\x9f"
                                                  "e"}};
    const uint32_t kinds[] = {1, 3, 4};
    for (int k = 0; k < 3; k++) {
        uint8_t pixels[WIDTH * HEIGHT * 4], back[WIDTH * HEIGHT * 4];
        const size_t size = (size_t)WIDTH * HEIGHT * kinds[k];
        for (size_t i = 0; i < size; i++)
            pixels[i] = (uint8_t)(i * 37 + i / 5);
        assert_int_equal(gn_write_png(device(), in_folder("a.png"), WIDTH, HEIGHT, kinds[k], pixels,
                                      attributes, 3),
                         GN_OK);
        char seed[16], camera[32];
        read_png(in_folder("a.png"), WIDTH, HEIGHT, kinds[k], back, seed, sizeof seed, camera,
                 sizeof camera);
        assert_memory_equal(pixels, back, size);
        assert_string_equal(seed, "7");
        assert_string_equal(camera, attributes[2].value);
    }
    assert_int_equal(count_files(), 1);
}

#define EXR_WIDTH  21
#define EXR_HEIGHT 53 /* more than one chunk of 16 lines, the last one short */

static void read_channel(const char *path, const char *name, exr_pixel_type_t type, float *plane)
{
    exr_context_t exr = NULL;
    assert_int_equal(exr_start_read(&exr, path, NULL), EXR_ERR_SUCCESS);
    int32_t lines = 0;
    assert_int_equal(exr_get_scanlines_per_chunk(exr, 0, &lines), EXR_ERR_SUCCESS);
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    bool found = false;
    for (int y = 0; y < EXR_HEIGHT; y += lines) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_read_scanline_chunk_info(exr, 0, y, &chunk), EXR_ERR_SUCCESS);
        assert_int_equal(y == 0 ? exr_decoding_initialize(exr, 0, &chunk, &pipeline)
                                : exr_decoding_update(exr, 0, &chunk, &pipeline),
                         EXR_ERR_SUCCESS);
        for (int c = 0; c < pipeline.channel_count; c++) {
            exr_coding_channel_info_t *channel = &pipeline.channels[c];
            channel->decode_to_ptr = NULL;
            if (c > 0 && strcmp(pipeline.channels[c - 1].channel_name, channel->channel_name) >= 0)
                fail_msg("channel %s comes after %s", channel->channel_name,
                         pipeline.channels[c - 1].channel_name);
            if (strcmp(channel->channel_name, name) != 0)
                continue;
            found = true;
            assert_int_equal(channel->data_type, type);
            channel->user_bytes_per_element = 4;
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_pixel_stride = 4;
            channel->user_line_stride = 4 * EXR_WIDTH;
            channel->decode_to_ptr = (uint8_t *)(plane + (size_t)y * EXR_WIDTH);
        }
        if (y == 0)
            assert_int_equal(exr_decoding_choose_default_routines(exr, 0, &pipeline),
                             EXR_ERR_SUCCESS);
        assert_int_equal(exr_decoding_run(exr, 0, &pipeline), EXR_ERR_SUCCESS);
    }
    assert_int_equal(exr_decoding_destroy(exr, &pipeline), EXR_ERR_SUCCESS);
    assert_int_equal(exr_finish(&exr), EXR_ERR_SUCCESS);
    if (!found)
        fail_msg("no channel %s", name);
}

static void test_exr(void **state)
{
    (void)state;
    enum { COUNT = EXR_WIDTH * EXR_HEIGHT };
    static float rgb[3 * COUNT], depth[COUNT], visibility[COUNT], back[COUNT];
    for (int i = 0; i < COUNT; i++) {
        /* Multiples of 1/1024 under 1 are exact in half precision; depth has all 24 bits. */
        for (int c = 0; c < 3; c++)
            rgb[3 * i + c] = (float)((i * 3 + c) % 1024) / 1024.0f;
        depth[i] = 1.0f / (float)(i + 3);
        visibility[i] = (float)(i % 257) / 256.0f;
    }
    const gn_layer layers[] = {
        {"light0.visibility", "Y", {visibility}, 1, 0},
        {NULL, "RGB", {rgb, rgb + 1, rgb + 2}, 3, 0},
        {"depth", "Z", {depth}, 1, 1},
    };
    const gn_attribute attributes[] = {{"method", "ray-saturate"}, {"note", ""}};
    const char *path = in_folder("a.exr");
    assert_int_equal(gn_write_exr(device(), path, EXR_WIDTH, EXR_HEIGHT, layers, 3, attributes, 2),
                     GN_OK);

    read_channel(path, "light0.visibility.Y", EXR_PIXEL_HALF, back);
    assert_memory_equal(back, visibility, sizeof back);
    read_channel(path, "depth.Z", EXR_PIXEL_FLOAT, back);
    assert_memory_equal(back, depth, sizeof back);
    const char *names[] = {"R", "G", "B"};
    for (int c = 0; c < 3; c++) {
        read_channel(path, names[c], EXR_PIXEL_HALF, back);
        for (int i = 0; i < COUNT; i++) {
            if (back[i] != rgb[3 * i + c])
                fail_msg("%s[%d]: %g, not %g", names[c], i, (double)back[i],
                         (double)rgb[3 * i + c]);
        }
    }

    exr_context_t exr = NULL;
    assert_int_equal(exr_start_read(&exr, path, NULL), EXR_ERR_SUCCESS);
    int32_t length = 0;
    const char *value = NULL;
    assert_int_equal(exr_attr_get_string(exr, 0, "gnomon.method", &length, &value),
                     EXR_ERR_SUCCESS);
    assert_string_equal(value, "ray-saturate");
    exr_compression_t compression;
    assert_int_equal(exr_get_compression(exr, 0, &compression), EXR_ERR_SUCCESS);
    assert_int_equal(compression, EXR_COMPRESSION_ZIP);
    exr_finish(&exr);
    assert_int_equal(count_files(), 1);
}

static void test_exr_refuses(void **state)
{
    (void)state;
    float plane[4] = {0};
    const gn_layer twice[] = {{"a", "Y", {plane}, 1, 0}, {"a", "Y", {plane}, 1, 1}};
    assert_int_equal(gn_write_exr(device(), in_folder("b.exr"), 2, 2, twice, 2, NULL, 0),
                     GN_ERROR_INVALID_ARGUMENT);
    assert_message("b.exr", "'a.Y'");
    const gn_layer missing = {"a", "XY", {plane}, 1, 0};
    assert_int_equal(gn_write_exr(device(), in_folder("b.exr"), 2, 2, &missing, 1, NULL, 0),
                     GN_ERROR_INVALID_ARGUMENT);
    assert_int_equal(gn_write_exr(device(), in_folder("b.exr"), 2, 2, NULL, 0, NULL, 0),
                     GN_ERROR_INVALID_ARGUMENT);
    assert_int_equal(count_files(), 0);
}

/* Writes a picture that is larger than any buffer on the way. */
static gn_result write_any(const char *path, bool exr)
{
    enum { SIZE = 256 };
    static float plane[SIZE * SIZE];
    static uint8_t pixels[SIZE * SIZE];
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        plane[i] = (float)(i * 2654435761u);
        pixels[i] = (uint8_t)((i * 2654435761u) >> 13);
    }
    const gn_layer layer = {NULL, "Y", {plane}, 1, 1};
    return exr ? gn_write_exr(device(), path, SIZE, SIZE, &layer, 1, NULL, 0)
               : gn_write_png(device(), path, SIZE, SIZE, 1, pixels, NULL, 0);
}

static void test_failures(void **state)
{
    (void)state;
    for (int exr = 0; exr < 2; exr++) {
        assert_int_equal(write_any("/dev/full", exr), GN_ERROR_IO);
        assert_message("/dev/full", "No space left on device");
        assert_int_equal(write_any("/nowhere/at/all", exr), GN_ERROR_IO);
        assert_message("/nowhere/at/all", "No such file or directory");
        assert_int_equal(write_any(folder, exr), GN_ERROR_IO);
        assert_message(folder, "Is a directory");
        assert_int_equal(write_any("", exr), GN_ERROR_INVALID_ARGUMENT);
        assert_int_equal(write_any("/proc/version/a", exr), GN_ERROR_IO);
        assert_message("/proc/version/a", "Not a directory");
    }
    struct stat status;
    assert_int_equal(stat("/dev/full", &status), 0);
    assert_true(S_ISCHR(status.st_mode));
    assert_int_equal(count_files(), 0);
    assert_int_equal(context.bytes, 0);
}

static void test_unwritable_folder(void **state)
{
    (void)state;
    if (geteuid() == 0)
        skip(); /* root may write anywhere */
    assert_int_equal(chmod(folder, 0500), 0);
    gn_result result = write_any(in_folder("a.png"), false);
    chmod(folder, 0700);
    assert_int_equal(result, GN_ERROR_IO);
    assert_message("a.png", "Permission denied");
    assert_int_equal(count_files(), 0);
}

static void write_text(gn_file *file, const char *text)
{
    assert_int_equal(gn_file_write(file, text, strlen(text)), GN_OK);
}

static void assert_content(const char *path, const char *text)
{
    char content[64] = "";
    FILE *stream = fopen(path, "rb");
    assert_non_null(stream);
    size_t size = fread(content, 1, sizeof content - 1, stream);
    fclose(stream);
    content[size] = '\0';
    assert_string_equal(content, text);
}

static void test_replacement(void **state)
{
    (void)state;
    const char *path = in_folder("a.txt");
    gn_file file;
    assert_int_equal(gn_file_begin(&context, path, &file), GN_OK);
    write_text(&file, "one");
    assert_int_not_equal(access(path, F_OK), 0); /* not there before it is whole */
    assert_int_equal(gn_file_commit(&file), GN_OK);
    assert_content(path, "one");

    assert_int_equal(gn_file_begin(&context, path, &file), GN_OK);
    write_text(&file, "two");
    assert_content(path, "one");
    gn_file_abort(&file);
    gn_file_abort(&file); /* harmless */
    assert_content(path, "one");
    assert_int_equal(count_files(), 1);

    /* A symbolic link stays one; its target gets the data. */
    char link[256];
    snprintf(link, sizeof link, "%s/link.txt", folder);
    assert_int_equal(symlink("a.txt", link), 0);
    assert_int_equal(gn_file_begin(&context, link, &file), GN_OK);
    write_text(&file, "three");
    assert_int_equal(gn_file_commit(&file), GN_OK);
    struct stat status;
    assert_int_equal(lstat(link, &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    assert_content(in_folder("a.txt"), "three");
    assert_int_equal(count_files(), 2);
    assert_int_equal(context.bytes, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_srgb, setup, teardown),
        cmocka_unit_test_setup_teardown(test_png, setup, teardown),
        cmocka_unit_test_setup_teardown(test_exr, setup, teardown),
        cmocka_unit_test_setup_teardown(test_exr_refuses, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_unwritable_folder, setup, teardown),
        cmocka_unit_test_setup_teardown(test_replacement, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
