/* Videos, read back by libav. */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>
#include <cmocka.h>

#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>

#include "output/output.h"

static gn_device *device;
static char folder[64];

static void ok(gn_result result)
{
    if (result != GN_OK)
        fail_msg("%s", gn_device_message(device));
}

/* A colour of its own for each frame and quarter of the picture. */
static void color_of(uint32_t frame, uint32_t quarter, int rgb[3])
{
    for (uint32_t c = 0; c < 3; c++)
        rgb[c] = (int)(20 + (frame * 29 + quarter * 57 + c * 83) % 216);
}

static void paint(uint8_t *rgb, uint32_t width, uint32_t height, uint32_t frame)
{
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            int color[3];
            color_of(frame, (y >= height / 2) * 2u + (x >= width / 2), color);
            for (uint32_t c = 0; c < 3; c++)
                rgb[3 * ((size_t)y * width + x) + c] = (uint8_t)color[c];
        }
}

static gn_result write_video(const char *path, uint32_t width, uint32_t height, double fps,
                             uint32_t frames)
{
    uint8_t *rgb = malloc((size_t)width * height * 3);
    gn_video *video;
    gn_result result = gn_video_begin(gn_device_context(device), path, width, height, fps, &video);
    for (uint32_t f = 0; f < frames && result == GN_OK; f++) {
        paint(rgb, width, height, f);
        result = gn_video_add(video, rgb);
    }
    if (result == GN_OK)
        result = gn_video_commit(&video);
    gn_video_abort(&video);
    free(rgb);
    return result;
}

typedef struct reader {
    AVFormatContext *file;
    AVCodecContext *decoder;
    AVFrame *frame;
    AVPacket *packet;
    bool ended;
} reader;

static void open_video(reader *r, const char *path)
{
    memset(r, 0, sizeof *r);
    assert_int_equal(avformat_open_input(&r->file, path, NULL, NULL), 0);
    assert_true(avformat_find_stream_info(r->file, NULL) >= 0);
    assert_int_equal(r->file->nb_streams, 1);
    const AVCodecParameters *codec = r->file->streams[0]->codecpar;
    assert_int_equal(codec->codec_id, AV_CODEC_ID_H264);
    assert_int_equal(codec->format, AV_PIX_FMT_YUV420P);
    assert_int_equal(codec->color_range, AVCOL_RANGE_MPEG);
    assert_int_equal(codec->color_space, AVCOL_SPC_BT709);
    assert_int_equal(codec->color_primaries, AVCOL_PRI_BT709);
    assert_int_equal(codec->color_trc, AVCOL_TRC_BT709);
    const AVCodec *decoder = avcodec_find_decoder(codec->codec_id);
    assert_non_null(decoder);
    r->decoder = avcodec_alloc_context3(decoder);
    assert_true(avcodec_parameters_to_context(r->decoder, codec) >= 0);
    assert_int_equal(avcodec_open2(r->decoder, decoder, NULL), 0);
    r->frame = av_frame_alloc();
    r->packet = av_packet_alloc();
}

static bool next_frame(reader *r)
{
    for (;;) {
        if (avcodec_receive_frame(r->decoder, r->frame) == 0)
            return true;
        if (r->ended)
            return false;
        r->ended = av_read_frame(r->file, r->packet) < 0;
        avcodec_send_packet(r->decoder, r->ended ? NULL : r->packet);
        av_packet_unref(r->packet);
    }
}

static void close_video(reader *r)
{
    av_frame_free(&r->frame);
    av_packet_free(&r->packet);
    avcodec_free_context(&r->decoder);
    avformat_close_input(&r->file);
}

/* Equations of ITU-R BT.709, limited range. */
static void to_rgb(double y, double cb, double cr, double rgb[3])
{
    const double luma = (y - 16) / 219, blue = (cb - 128) / 224, red = (cr - 128) / 224;
    rgb[0] = 255 * (luma + 1.5748 * red);
    rgb[2] = 255 * (luma + 1.8556 * blue);
    rgb[1] = (255 * luma - 0.2126 * rgb[0] - 0.0722 * rgb[2]) / 0.7152;
}

/* The middle of each quarter has its colour. */
static void check_colors(const AVFrame *frame, uint32_t width, uint32_t height, uint32_t number)
{
    for (uint32_t q = 0; q < 4; q++) {
        const uint32_t x = width * (1 + 2 * (q & 1)) / 4, y = height * (1 + 2 * (q >> 1)) / 4;
        const size_t luma = (size_t)y * (size_t)frame->linesize[0] + x;
        double rgb[3];
        int color[3];
        to_rgb(frame->data[0][luma], frame->data[1][y / 2 * (uint32_t)frame->linesize[1] + x / 2],
               frame->data[2][y / 2 * (uint32_t)frame->linesize[2] + x / 2], rgb);
        color_of(number, q, color);
        for (int c = 0; c < 3; c++)
            if (fabs(rgb[c] - color[c]) > 4)
                fail_msg("frame %u, quarter %u, channel %d: %.1f, not %d", number, q, c, rgb[c],
                         color[c]);
    }
}

static void check_video(uint32_t width, uint32_t height, double fps, uint32_t frames)
{
    ok(write_video("a.mp4", width, height, fps, frames));
    reader r;
    open_video(&r, "a.mp4");
    const AVStream *stream = r.file->streams[0];
    assert_int_equal(stream->codecpar->width, width + (width & 1));
    assert_int_equal(stream->codecpar->height, height + (height & 1));
    const double rate = av_q2d(stream->avg_frame_rate);
    if (fabs(rate - fps) > 1e-3 * fps)
        fail_msg("%g frames a second, not %g", rate, fps);
    uint32_t count = 0;
    for (int64_t last = INT64_MIN; next_frame(&r); count++) {
        check_colors(r.frame, width, height, count);
        assert_true(r.frame->pts > last);
        last = r.frame->pts;
    }
    close_video(&r);
    assert_int_equal(count, frames);
}

static void test_round_trip(void **state)
{
    (void)state;
    check_video(96, 64, 30, 40);
    check_video(96, 64, 29.97, 3);
    check_video(161, 75, 60, 5); /* made even */
    check_video(64, 48, 0.5, 2);
    check_video(64, 48, 1000, 1);
}

static size_t read_file(const char *path, uint8_t **data)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    *data = malloc(1 << 20);
    const size_t size = fread(*data, 1, 1 << 20, file);
    fclose(file);
    return size;
}

/* Boxes of the file in order: name and length. */
static size_t find_box(const uint8_t *data, size_t size, const char *name)
{
    for (size_t at = 0; at + 8 <= size;) {
        const size_t length = (size_t)data[at] << 24 | (size_t)data[at + 1] << 16 |
                              (size_t)data[at + 2] << 8 | data[at + 3];
        if (memcmp(data + at + 4, name, 4) == 0)
            return at;
        assert_true(length >= 8);
        at += length;
    }
    fail_msg("no box '%s'", name);
    return 0;
}

static void test_index_first_and_same_bytes(void **state)
{
    (void)state;
    uint8_t *a, *b;
    ok(write_video("a.mp4", 320, 180, 30, 60));
    ok(write_video("b.mp4", 320, 180, 30, 60));
    const size_t size = read_file("a.mp4", &a), other = read_file("b.mp4", &b);
    assert_true(find_box(a, size, "moov") < find_box(a, size, "mdat"));
    assert_int_equal(size, other);
    assert_memory_equal(a, b, size);
    free(a);
    free(b);
}

static unsigned files_left(void)
{
    FILE *list = popen("ls -A | wc -l", "r");
    unsigned count = 99;
    assert_non_null(list);
    assert_int_equal(fscanf(list, "%u", &count), 1);
    pclose(list);
    return count;
}

static void refused(const char *path, uint32_t width, uint32_t height, double fps,
                    gn_result expected, const char *reason)
{
    const gn_result result = write_video(path, width, height, fps, 30);
    const char *message = gn_device_message(device);
    if (result != expected || !strstr(message, reason))
        fail_msg("%s: result %d, not %d; '%s' is to be in: %s", path, (int)result, (int)expected,
                 reason, message);
    assert_int_equal(files_left(), 0);
}

static void test_refusals(void **state)
{
    (void)state;
    assert_int_equal(system("rm -f *.mp4"), 0);
    refused("", 16, 16, 30, GN_ERROR_INVALID_ARGUMENT, "path is empty");
    refused("no/a.mp4", 16, 16, 30, GN_ERROR_IO, "no/a.mp4: cannot write: No such file");
    refused("/proc/a.mp4", 16, 16, 30, GN_ERROR_IO, "/proc/a.mp4: cannot write");
    refused(folder, 16, 16, 30, GN_ERROR_IO, "Is a directory");
    refused("/dev/null", 16, 16, 30, GN_ERROR_UNSUPPORTED, "regular file");
    refused("a.mp4", 0, 16, 30, GN_ERROR_INVALID_ARGUMENT, "0 x 16 pixels");
    refused("a.mp4", 16, 16385, 30, GN_ERROR_INVALID_ARGUMENT, "16384");
    refused("a.mp4", 16, 16, 0, GN_ERROR_INVALID_ARGUMENT, "0.001 to 1e6");
    refused("a.mp4", 16, 16, NAN, GN_ERROR_INVALID_ARGUMENT, "0.001 to 1e6");
}

/* Files may not grow: at whatever moment it is found out, nothing is left. */
static void test_full_disk(void **state)
{
    (void)state;
    struct rlimit was;
    getrlimit(RLIMIT_FSIZE, &was);
    signal(SIGXFSZ, SIG_IGN);
    const size_t held = gn_device_bytes(device);
    for (rlim_t limit = 0; limit < 3000; limit = limit * 2 + 20) {
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){limit, was.rlim_max});
        const gn_result result = write_video("a.mp4", 64, 64, 30, 60);
        setrlimit(RLIMIT_FSIZE, &was);
        assert_int_equal(result, GN_ERROR_IO);
        if (!strstr(gn_device_message(device), "a.mp4: cannot write: File too large"))
            fail_msg("%s", gn_device_message(device));
        assert_int_equal(files_left(), 0);
    }
    assert_int_equal(gn_device_bytes(device), held);
}

static void test_abort(void **state)
{
    (void)state;
    uint8_t rgb[16 * 16 * 3] = {0};
    gn_video *video;
    ok(gn_video_begin(gn_device_context(device), "a.mp4", 16, 16, 30, &video));
    for (int i = 0; i < 100; i++)
        ok(gn_video_add(video, rgb));
    gn_video_abort(&video);
    assert_null(video);
    assert_int_equal(files_left(), 0);
    gn_video_abort(&video);
}

static int open_all(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/gnomon-video-XXXXXX");
    return mkdtemp(folder) && chdir(folder) == 0 && gn_device_create(NULL, &device) == GN_OK ? 0
                                                                                             : -1;
}

static int close_all(void **state)
{
    (void)state;
    char command[96];
    snprintf(command, sizeof command, "rm -r %s", folder);
    gn_device_destroy(&device);
    return chdir("/") == 0 && system(command) == 0 ? 0 : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_index_first_and_same_bytes),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_abort)};
    return cmocka_run_group_tests_name("video", tests, open_all, close_all);
}
