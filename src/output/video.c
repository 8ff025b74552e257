/* Videos through libav: H.264 in MP4. */
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avstring.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>

#include "output/output.h"

struct gn_video {
    gn_context *context;
    gn_file file;
    int error; /* errno of the first write that failed */
    uint32_t width, height;
    AVFormatContext *muxer;
    AVCodecContext *encoder;
    AVStream *stream;
    AVFrame *frame;
    AVPacket *packet;
    struct SwsContext *scaler;
    bool has_header;
};

enum {
    IO_BYTES = 1 << 16,
    /* What x264 makes of a video depends on how many threads it is told to take, not on how many
     * there are. */
    THREADS = 4
};

static gn_result fail(const gn_video *v, int error, const char *what)
{
    char text[128];
    if (v->error || error == AVERROR(ENOSPC))
        return gn_file_fail(&v->file, v->error ? v->error : ENOSPC, NULL);
    if (error == AVERROR(ENOMEM))
        return gn_fail(v->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", v->file.path);
    av_strerror(error, text, sizeof text);
    return gn_fail(v->context, GN_ERROR_IO, "%s: %s: %s", v->file.path, what, text);
}

/* The file, as libav sees it ------------------------------------------------------------------- */

static int write_bytes(void *user, uint8_t *data, int size)
{
    gn_video *v = user;
    const int descriptor = fileno(v->file.stream);
    for (int done = 0; done < size;) {
        const ssize_t written = write(descriptor, data + done, (size_t)(size - done));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) {
            v->error = v->error ? v->error : written < 0 ? errno : ENOSPC;
            return AVERROR(v->error);
        }
        done += (int)written;
    }
    return size;
}

static int64_t seek(void *user, int64_t offset, int whence)
{
    const gn_video *v = user;
    const off_t at = whence & AVSEEK_SIZE
                         ? -1
                         : lseek(fileno(v->file.stream), (off_t)offset, whence & ~AVSEEK_FORCE);
    return at < 0 ? AVERROR(whence & AVSEEK_SIZE ? ENOSYS : errno) : at;
}

/* Life ----------------------------------------------------------------------------------------- */

static void release(gn_video *v)
{
    if (v->muxer && v->muxer->pb) {
        av_freep(&v->muxer->pb->buffer);
        avio_context_free(&v->muxer->pb);
    }
    avformat_free_context(v->muxer);
    avcodec_free_context(&v->encoder);
    av_frame_free(&v->frame);
    av_packet_free(&v->packet);
    sws_freeContext(v->scaler);
    gn_free(v->context, v);
}

void gn_video_abort(gn_video **video)
{
    if (!*video)
        return;
    gn_file_abort(&(*video)->file);
    release(*video);
    *video = NULL;
}

const char *gn_video_partial(const gn_video *video)
{
    return video->file.temporary;
}

static gn_result open_encoder(gn_video *v, double fps)
{
    const AVCodec *codec = avcodec_find_encoder_by_name("libx264");
    if (!codec)
        return gn_fail(v->context, GN_ERROR_UNSUPPORTED,
                       "%s: this machine's libavcodec has no H.264 encoder (libx264)",
                       v->file.path);
    v->encoder = avcodec_alloc_context3(codec);
    if (!v->encoder)
        return fail(v, AVERROR(ENOMEM), "");
    const AVRational rate = av_d2q(fps, 1000000);
    AVCodecContext *e = v->encoder;
    e->width = (int)v->width + (int)(v->width & 1);
    e->height = (int)v->height + (int)(v->height & 1);
    e->pix_fmt = AV_PIX_FMT_YUV420P;
    e->time_base = av_inv_q(rate);
    e->framerate = rate;
    e->color_range = AVCOL_RANGE_MPEG;
    e->color_primaries = AVCOL_PRI_BT709;
    e->color_trc = AVCOL_TRC_BT709;
    e->colorspace = AVCOL_SPC_BT709;
    e->chroma_sample_location = AVCHROMA_LOC_LEFT;
    e->thread_count = THREADS;
    e->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    /* Fine shadows are what such a video is about. */
    av_opt_set(e->priv_data, "crf", "16", 0);
    const int error = avcodec_open2(e, codec, NULL);
    return error < 0 ? fail(v, error, "the H.264 encoder does not start") : GN_OK;
}

static gn_result open_muxer(gn_video *v)
{
    int error = avformat_alloc_output_context2(&v->muxer, NULL, "mp4", NULL);
    if (error < 0)
        return fail(v, error, "no MP4 is made");
    AVFormatContext *m = v->muxer;
    v->stream = avformat_new_stream(m, NULL);
    uint8_t *buffer = av_malloc(IO_BYTES);
    m->pb = buffer ? avio_alloc_context(buffer, IO_BYTES, 1, v, NULL, write_bytes, seek) : NULL;
    /* The index goes to the front at the end: what is there is read under this name. */
    m->url = av_asprintf("file:%s", v->file.temporary);
    if (!m->pb)
        av_free(buffer);
    if (!v->stream || !m->pb || !m->url)
        return fail(v, AVERROR(ENOMEM), "");
    m->flags |= AVFMT_FLAG_BITEXACT;
    v->stream->time_base = v->encoder->time_base;
    v->stream->avg_frame_rate = v->encoder->framerate;
    error = avcodec_parameters_from_context(v->stream->codecpar, v->encoder);
    AVDictionary *options = NULL;
    if (error >= 0)
        error = av_dict_set(&options, "movflags", "faststart", 0);
    if (error >= 0)
        error = avformat_write_header(m, &options);
    av_dict_free(&options);
    v->has_header = error >= 0;
    return error < 0 ? fail(v, error, "no MP4 is begun") : GN_OK;
}

/* sRGB to the 16 to 235 of BT.709. */
static gn_result open_scaler(gn_video *v)
{
    const AVCodecContext *e = v->encoder;
    v->frame = av_frame_alloc();
    v->packet = av_packet_alloc();
    v->scaler =
        sws_getContext(e->width, e->height, AV_PIX_FMT_RGB24, e->width, e->height, e->pix_fmt,
                       SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT, NULL, NULL, NULL);
    if (!v->frame || !v->packet || !v->scaler)
        return fail(v, AVERROR(ENOMEM), "");
    const int *table = sws_getCoefficients(SWS_CS_ITU709);
    if (sws_setColorspaceDetails(v->scaler, table, 1, table, 0, 0, 1 << 16, 1 << 16) < 0)
        return fail(v, AVERROR(EINVAL), "no conversion of colours");
    v->frame->format = e->pix_fmt;
    v->frame->width = e->width;
    v->frame->height = e->height;
    const int error = av_frame_get_buffer(v->frame, 0);
    return error < 0 ? fail(v, error, "no frame") : GN_OK;
}

gn_result gn_video_begin(gn_context *context, const char *path, uint32_t width, uint32_t height,
                         double fps, gn_video **video)
{
    *video = NULL;
    if (width < 1 || height < 1 || width > 16384 || height > 16384 || !(fps >= 0.001) ||
        !(fps <= 1e6))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: cannot write a video of %u x %u pixels and %g frames a second: the "
                       "ranges are 1 to 16384, and 0.001 to 1e6",
                       path ? path : "(no path)", width, height, fps);
    gn_video *v = gn_alloc_zero(context, 1, sizeof *v);
    if (!v)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);
    v->context = context;
    v->width = width;
    v->height = height;
    av_log_set_level(AV_LOG_QUIET); /* errors are ours to tell */
    gn_result result = gn_file_begin(context, path, &v->file);
    if (result != GN_OK) {
        release(v);
        return result;
    }
    if (!v->file.temporary)
        result = gn_fail(context, GN_ERROR_UNSUPPORTED,
                         "%s: cannot write: a video needs a regular file, in which its index can "
                         "be put first",
                         path);
    if (result == GN_OK)
        result = open_encoder(v, fps);
    if (result == GN_OK)
        result = open_muxer(v);
    if (result == GN_OK)
        result = open_scaler(v);
    *video = v;
    if (result != GN_OK)
        gn_video_abort(video);
    return result;
}

/* Frames --------------------------------------------------------------------------------------- */

/* Gives a frame to the encoder, NULL after the last, and what it has finished to the file. */
static gn_result encode(gn_video *v, const AVFrame *frame)
{
    int error = avcodec_send_frame(v->encoder, frame);
    while (error >= 0) {
        error = avcodec_receive_packet(v->encoder, v->packet);
        if (error < 0)
            break;
        v->packet->stream_index = v->stream->index;
        v->packet->duration = 1;
        av_packet_rescale_ts(v->packet, v->encoder->time_base, v->stream->time_base);
        error = av_interleaved_write_frame(v->muxer, v->packet);
        if (error >= 0 && v->error)
            error = AVERROR(v->error);
    }
    const bool good = error == AVERROR(EAGAIN) || (error == AVERROR_EOF && !frame);
    return good ? GN_OK : fail(v, error, "a frame is not encoded");
}

gn_result gn_video_add(gn_video *v, const uint8_t *rgb)
{
    const size_t row = (size_t)v->width * 3;
    const size_t even = (size_t)v->encoder->width * 3;
    const uint8_t *pixels = rgb;
    uint8_t *padded = NULL;
    if (even > row || v->encoder->height > (int)v->height) {
        /* Chroma is a value for four pixels: an odd edge is doubled. */
        if (!(padded = gn_alloc(v->context, (size_t)v->encoder->height, even)))
            return fail(v, AVERROR(ENOMEM), "");
        for (uint32_t y = 0; y < (uint32_t)v->encoder->height; y++) {
            const uint8_t *from = rgb + (y < v->height ? y : v->height - 1) * row;
            memcpy(padded + y * even, from, row);
            memcpy(padded + y * even + row, from + row - 3, even - row);
        }
        pixels = padded;
    }
    int error = av_frame_make_writable(v->frame);
    if (error >= 0)
        sws_scale(v->scaler, (const uint8_t *const[4]){pixels}, (const int[4]){(int)even}, 0,
                  v->encoder->height, v->frame->data, v->frame->linesize);
    gn_free(v->context, padded);
    v->frame->pts = v->frame->pts == AV_NOPTS_VALUE ? 0 : v->frame->pts + 1;
    return error < 0 ? fail(v, error, "no frame") : encode(v, v->frame);
}

gn_result gn_video_commit(gn_video **video)
{
    gn_video *v = *video;
    gn_result result = encode(v, NULL);
    if (result == GN_OK) {
        const int error = av_write_trailer(v->muxer);
        if (error < 0 || v->error)
            result = fail(v, error, "the MP4 is not ended");
    }
    if (result == GN_OK)
        result = gn_file_commit(&v->file);
    else
        gn_file_abort(&v->file);
    release(v);
    *video = NULL;
    return result;
}
