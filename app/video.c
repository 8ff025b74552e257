/* gnomon render -o OUT.mp4: frames of one method, or of several side by side, as a video. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output/output.h"
#include "render.h"

enum { DIVIDER = 4 }; /* pixels between methods; even, as chroma is */

typedef struct film {
    gn_shot *shots;
    uint32_t count;
    uint32_t width, height; /* of all */
    uint8_t *picture, *part;
} film;

/* Each method's picture at its place, with its name where there are several. */
static void compose(const film *f)
{
    const gn_app *app = f->shots[0].frame.app;
    const uint32_t width = app->options.size[0];
    const size_t row = (size_t)width * 3;
    for (uint32_t k = 0; k < f->count; k++) {
        const uint32_t left = k * (width + DIVIDER);
        gn_encode_srgb(f->shots[k].frame.image, f->part, row * f->height);
        for (uint32_t y = 0; y < f->height; y++)
            memcpy(f->picture + ((size_t)y * f->width + left) * 3, f->part + y * row, row);
        if (f->count > 1) {
            const uint32_t scale = f->height >= 720 ? f->height / 360 : 1;
            gn_draw_label(f->picture, left + width, f->height, f->width, left + 4 * scale,
                          4 * scale, scale, f->shots[k].name);
        }
    }
}

static bool render_frame(film *f, const gn_render_options *o, uint32_t number, gn_video *video,
                         cJSON *frames)
{
    if (!gn_shot_move(&f->shots[0], o, number))
        return false;
    for (uint32_t k = 0; k < f->count; k++)
        if (!gn_shot_render(&f->shots[k]))
            return false;
    const double start = gn_milliseconds();
    compose(f);
    if (gn_video_add(video, f->picture) != GN_OK)
        return false;
    const double write_ms = (gn_milliseconds() - start) / f->count;
    for (uint32_t k = 0; k < f->count; k++) {
        f->shots[k].update_ms = f->shots[0].update_ms;
        cJSON *entry = gn_shot_report(&f->shots[k], o, number, write_ms);
        if (f->count > 1)
            cJSON_AddStringToObject(entry, "method", f->shots[k].name);
        cJSON_AddItemToArray(frames, entry);
    }
    return true;
}

static bool render_frames(film *f, const gn_render_options *o, gn_video *video, cJSON *frames)
{
    gn_app *app = f->shots[0].frame.app;
    const uint32_t first = o->frames.first, last = o->frames.last;
    const double share = 0.85 / (last - first + 1.0);
    bool good = true;
    gn_bar_step(&app->bar, 0.1, 0.05, "frames before the first");
    for (uint32_t k = 0; k < f->count && good; k++)
        good = gn_shot_warm_up(&f->shots[k], o, first);
    for (uint32_t n = first; n <= last && good; n++) {
        gn_bar_step(&app->bar, 0.15 + share * (n - first), share, "frame %u of %u to %u", n, first,
                    last);
        if (n > first)
            gn_app_finished(app, "of frames %u to %u, %u were rendered, and no video is kept",
                            first, last, n - first);
        good = render_frame(f, o, n, video, frames);
    }
    return good;
}

bool gn_render_video(gn_shot *shots, uint32_t count, const gn_render_options *o, cJSON *frames)
{
    gn_app *app = shots[0].frame.app;
    const uint32_t *size = app->options.size;
    film f = {.shots = shots,
              .count = count,
              .width = count * size[0] + (count - 1) * DIVIDER,
              .height = size[1]};
    const size_t pixels = (size_t)f.width * f.height;
    gn_video *video;
    gn_app_set_partial("");
    const gn_result begun = gn_video_begin(gn_device_context(app->device), o->output, f.width,
                                           f.height, o->fps, &video);
    gn_app_set_partial(begun == GN_OK ? gn_video_partial(video) : NULL);
    if (begun != GN_OK)
        return false;
    f.picture = malloc(pixels * 3);
    f.part = malloc(pixels * 3);
    bool good = f.picture && f.part;
    if (!good)
        gn_app_error(app, "%s: out of memory", o->output);
    else
        memset(f.picture, 0xc0, pixels * 3); /* the dividers */
    good = good && render_frames(&f, o, video, frames);
    if (good)
        good = gn_video_commit(&video) == GN_OK;
    gn_video_abort(&video);
    gn_app_set_partial(NULL);
    free(f.picture);
    free(f.part);
    return good &&
           (!o->history_out || gn_view_save_history(shots[0].frame.view, o->history_out) == GN_OK);
}
