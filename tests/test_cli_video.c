/* gnomon render -o OUT.mp4, and --antialias. */
#include "cli_testing.h"

#include <math.h>

#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>

#define SHOT "render leafbox --fps 4 -q "

/* Size and count of the frames of a video, and the mean luma of each vertical stripe of the last,
 * stripes parts wide. */
static uint32_t read_video(const char *path, int *width, int *height, uint32_t stripes,
                           double *means)
{
    AVFormatContext *file = NULL;
    assert_int_equal(avformat_open_input(&file, path, NULL, NULL), 0);
    assert_true(avformat_find_stream_info(file, NULL) >= 0);
    const AVCodecParameters *parameters = file->streams[0]->codecpar;
    const AVCodec *codec = avcodec_find_decoder(parameters->codec_id);
    AVCodecContext *decoder = avcodec_alloc_context3(codec);
    assert_true(avcodec_parameters_to_context(decoder, parameters) >= 0);
    assert_int_equal(avcodec_open2(decoder, codec, NULL), 0);
    AVPacket *packet = av_packet_alloc();
    AVFrame *frame = av_frame_alloc();
    *width = parameters->width;
    *height = parameters->height;
    uint32_t count = 0;
    for (bool more = true; more;) {
        more = av_read_frame(file, packet) >= 0;
        avcodec_send_packet(decoder, more ? packet : NULL);
        av_packet_unref(packet);
        for (; avcodec_receive_frame(decoder, frame) == 0; count++)
            for (uint32_t s = 0; s < stripes; s++) {
                const int part = *width / (int)stripes, left = (int)s * part;
                double sum = 0;
                for (int y = 0; y < *height; y++)
                    for (int x = left; x < left + part; x++)
                        sum += frame->data[0][y * frame->linesize[0] + x];
                means[s] = sum / part / *height;
            }
    }
    av_frame_free(&frame);
    av_packet_free(&packet);
    avcodec_free_context(&decoder);
    avformat_close_input(&file);
    return count;
}

static void test_video(void **state)
{
    (void)state;
    int width, height;
    double mean, both[2];
    expect(0, SHOT "--size 64x48 -m ray --frames 2:6 -o a.mp4 --json");
    cJSON *json = parse_output();
    assert_string_equal(get_string(json, "file"), "a.mp4");
    assert_int_equal(cJSON_GetArraySize(member(json, "frames")), 5);
    cJSON_Delete(json);
    assert_int_equal(read_video("a.mp4", &width, &height, 1, &mean), 5);
    assert_int_equal(width, 64);
    assert_int_equal(height, 48);

    /* The last frame of a sequence of pictures is as bright. */
    expect(0, SHOT "--size 64x48 -m ray --frames 6:6 -o a.png");
    expect(0, SHOT "--size 64x48 -m ray --frames 6:6 -o one.mp4");
    double one;
    assert_int_equal(read_video("one.mp4", &width, &height, 1, &one), 1);
    if (fabs(one - mean) > 0.5)
        fail_msg("luma %.2f alone and %.2f at the end", one, mean);

    expect(0, SHOT "--size 65x49 -m ray --beside lt-vsm --map-size 64 --frames 0:2 -o b.mp4 "
                   "--json");
    json = parse_output();
    const cJSON *frames = member(json, "frames");
    assert_int_equal(cJSON_GetArraySize(frames), 6);
    assert_string_equal(get_string(cJSON_GetArrayItem(frames, 3), "method"), "lt-vsm");
    cJSON_Delete(json);
    assert_int_equal(read_video("b.mp4", &width, &height, 2, both), 3);
    assert_int_equal(width, 2 * 65 + 4); /* and a divider */
    assert_int_equal(height, 50);
    if (fabs(both[0] - both[1]) > 6)
        fail_msg("luma %.2f left and %.2f right", both[0], both[1]);
    assert_int_equal(count_files(), 4);
}

/* Sequences that are antialiased go on with the same bytes, from the first frame again. */
static void test_antialias(void **state)
{
    (void)state;
    static const char *const kinds[] = {"none", "taa", "smaa-t2x"};
    char arguments[256];
    for (int k = 0; k < 3; k++) {
        snprintf(arguments, sizeof arguments,
                 SHOT "--size 64x48 -m ray -o %s.png --json --antialias %s", kinds[k], kinds[k]);
        expect(0, arguments);
        cJSON *json = parse_output();
        assert_string_equal(get_string(json, "antialias"), kinds[k]);
        const cJSON *ms = member(cJSON_GetArrayItem(member(json, "frames"), 0), "ms");
        assert_int_equal(cJSON_HasObjectItem(ms, "antialias"), k > 0);
        cJSON_Delete(json);
    }
    assert_false(same_files("none.png", "taa.png"));
    assert_false(same_files("taa.png", "smaa-t2x.png"));

    for (int k = 1; k < 3; k++) {
        snprintf(arguments, sizeof arguments,
                 SHOT "--size 64x48 -m ray --frames 0:3 -o all.png --antialias %s", kinds[k]);
        expect(0, arguments);
        snprintf(arguments, sizeof arguments,
                 SHOT "--size 64x48 -m ray --frames 0:3 -o part.png --resume --antialias %s",
                 kinds[k]);
        assert_int_equal(system("cp all.0000.png part.0000.png; cp all.0002.png part.0002.png"), 0);
        expect(0, arguments);
        assert_true(same_files("all.0001.png", "part.0001.png"));
        assert_true(same_files("all.0003.png", "part.0003.png"));
        assert_int_equal(system("rm all.* part.*"), 0);
    }

    expect(0, SHOT "--size 64x48 -m ray-raw --antialias taa --beside ray-mip0,ray-mip0+smaa-t2x "
                   "--frames 0:1 -o a.mp4 --json");
    cJSON *json = parse_output();
    const cJSON *frames = member(json, "frames");
    static const char *const names[] = {"ray-raw+taa", "ray-mip0", "ray-mip0+smaa-t2x"};
    for (int k = 0; k < 3; k++)
        assert_string_equal(get_string(cJSON_GetArrayItem(frames, 3 + k), "method"), names[k]);
    cJSON_Delete(json);
}

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *reason;
    } wrong[] = {{"-o a.mp4", "--frames A:B, which is missing"},
                 {"-o a.mp4 --frames 0:1 --resume", "--resume is for pictures"},
                 {"-o a.mp4 --frames 0:1 --aov depth", "--aov is for pictures"},
                 {"-o a.png --beside ray", "--beside is for a video"},
                 {"-o a.mp4 --frames 0:1 --beside ray,nothing", "nothing"},
                 {"-o a.mp4 --frames 0:1 --beside ray,", "''"},
                 {"-o a.mp4 --frames 0:1 --beside ray,ray,ray,ray,ray,ray,ray,ray", "at most 7"},
                 {"-o a.mp4 --frames 0:1 --beside ray --history-out h", "exclude each other"},
                 {"-o a.mp4 --frames 0:1 --beside ray+dlss", "stands taa or smaa-t2x"},
                 {"-o a.png --antialias msaa", "msaa"},
                 {"-o a.png --antialias taa --spp 4", "--antialias and --spp exclude"},
                 {"-o a.png --antialias taa --history-out h", "--antialias and --history-out"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char arguments[256];
        snprintf(arguments, sizeof arguments, "render leafbox %s", wrong[i].arguments);
        expect(2, arguments);
        expect_text(err, wrong[i].reason);
    }
    expect(1, SHOT "--size 64x48 --frames 0:1 -o no/a.mp4");
    expect_text(err, "no/a.mp4: cannot write: No such file");
    expect(1, SHOT "--size 16384x16 --frames 0:1 -o a.mp4 --beside ray");
    expect_text(err, "a.mp4: cannot write a video of 32772 x 16 pixels");
    assert_int_equal(count_files(), 0);
}

/* Once, and twice in a row: the second ends it at once. */
static void test_interrupt(void **state)
{
    (void)state;
    char name[64];
    const pid_t hasty = start("render leafbox --size 640x480 --frames 0:9 --spp 4096 -o a.mp4");
    snprintf(name, sizeof name, "a.mp4.%ld-0.part", (long)hasty);
    wait_for_file(name);
    int status;
    kill(hasty, SIGINT);
    for (int i = 0; i < 5; i++) {
        usleep(20000);
        kill(hasty, SIGINT);
    }
    assert_int_equal(waitpid(hasty, &status, 0), hasty);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 130);
    assert_int_equal(count_files(), 0);

    const pid_t child = start("render leafbox --size 64x48 --frames 0:99999 -m ray -o a.mp4");
    usleep(500000);
    snprintf(name, sizeof name, "a.mp4.%ld-0.part", (long)child);
    assert_int_equal(interrupt(child, name, SIGINT), 130);
    assert_true(strstr(err, "no video is kept") || strstr(err, "nothing is finished"));
    assert_int_equal(count_files(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_video, setup, teardown),
        cmocka_unit_test_setup_teardown(test_antialias, setup, teardown),
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_interrupt, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
