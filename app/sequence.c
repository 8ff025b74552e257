/* The frames of gnomon render. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render.h"

/* The run of '#' or the "%04d" that stands for the frame number: its start and length; NULL where
 * there is none. */
static const char *find_number(const char *path, size_t *length, int *digits)
{
    const char *hash = strchr(path, '#');
    if (hash) {
        *length = strspn(hash, "#");
        *digits = (int)*length;
        return hash;
    }
    for (const char *percent = strchr(path, '%'); percent; percent = strchr(percent + 1, '%')) {
        size_t width = strspn(percent + 1, "0123456789");
        if (percent[1 + width] == 'd' && width <= 2) {
            *length = width + 2;
            *digits = atoi(percent + 1);
            return percent;
        }
    }
    return NULL;
}

/* text in place of the mark, or after a dot before the extension. */
static bool put_in_path(gn_app *app, const char *pattern, const char *text, char *out, size_t size)
{
    size_t length;
    int digits;
    char suffix[48];
    const char *mark = find_number(pattern, &length, &digits);
    if (!mark) {
        snprintf(suffix, sizeof suffix, ".%s", text);
        return gn_insert_suffix(app, pattern, suffix, out, size);
    }
    const int used =
        snprintf(out, size, "%.*s%s%s", (int)(mark - pattern), pattern, text, mark + length);
    return (used >= 0 && (size_t)used < size) ||
           gn_app_error(app, "%s: the name is too long", pattern);
}

bool gn_frame_path(gn_app *app, const char *pattern, uint32_t frame, char *out, size_t size)
{
    size_t length;
    int digits = 4;
    char number[32];
    find_number(pattern, &length, &digits);
    snprintf(number, sizeof number, "%0*u", digits < 16 ? digits : 16, frame);
    return put_in_path(app, pattern, number, out, size);
}

bool gn_sequence_path(gn_app *app, const char *pattern, const char *word, char *out, size_t size)
{
    return put_in_path(app, pattern, word, out, size);
}

/* What colours stand for, where no one reads the JSON. */
static void note_lists(gn_app *app, const cJSON *lists)
{
    const cJSON *entry;
    cJSON_ArrayForEach(entry, lists)
    {
        const cJSON *extent = cJSON_GetObjectItem(entry, "extent");
        char width[48] = "";
        if (extent)
            snprintf(width, sizeof width, "; %.4g m wide", extent->valuedouble);
        gn_app_note(app, "%s: %s, at most %.0f triangles in a list%s",
                    cJSON_GetStringValue(cJSON_GetObjectItem(entry, "file")),
                    cJSON_GetStringValue(cJSON_GetObjectItem(entry, "light")),
                    cJSON_GetObjectItem(entry, "most")->valuedouble, width);
    }
}

/* Renders and writes one frame. */
static bool render_frame(const gn_render_options *o, gn_shot *shot, uint32_t number, cJSON *frames)
{
    gn_frame *frame = &shot->frame;
    gn_app *app = frame->app;
    const bool exr = gn_ends_with(o->output, ".exr");
    if (!gn_shot_move(shot, o, number) || !gn_shot_render(shot))
        return false;

    char path[4096];
    snprintf(path, sizeof path, "%s", o->output);
    if (o->frames.given && !gn_frame_path(app, o->output, number, path, sizeof path))
        return false;
    gn_settings settings;
    gn_settings_fill(&settings, app, frame->method->name, o->samples, gn_time_of(o, number));
    gn_settings_add_method(&settings, frame->method);
    if (gn_app_has_rays(frame->method))
        gn_settings_add_tracing(&settings, &frame->tracing);
    if (shot->antialias)
        gn_settings_add(&settings, "antialias", gn_app_antialias_names[o->antialias]);
    frame->settings = &settings;
    cJSON *files = cJSON_CreateArray();
    frame->lists = cJSON_CreateArray();
    const double start = gn_milliseconds();
    const bool written =
        exr ? gn_frame_write_exr(frame, path, files) : gn_frame_write_png(frame, path, files);
    frame->settings = NULL; /* they end with this function */
    if (!written) {
        cJSON_Delete(files);
        cJSON_Delete(frame->lists);
        return false;
    }
    if (!o->frames.given)
        note_lists(app, frame->lists);
    cJSON *entry = gn_shot_report(shot, o, number, gn_milliseconds() - start);
    cJSON_AddItemToObject(entry, "files", files);
    if (cJSON_GetArraySize(frame->lists) > 0)
        cJSON_AddItemToObject(entry, "lists", frame->lists);
    else
        cJSON_Delete(frame->lists);
    cJSON_AddItemToArray(frames, entry);
    return true;
}

static bool start(const gn_render_options *o, gn_shot *shot, gn_resume *resume)
{
    const uint32_t first = o->frames.given ? o->frames.first : 0;
    *resume = (gn_resume){.first = first, .last = o->frames.given ? o->frames.last : 0};
    resume->from = first;
    gn_bar_step(&shot->frame.app->bar, 0.1, 0.05, "frames before the first");
    if (o->resume && !gn_resume_begin(resume, o, &shot->frame))
        return false;
    return resume->first > resume->last || resume->from > first || gn_shot_warm_up(shot, o, first);
}

bool gn_render_sequence(gn_shot *shot, const gn_render_options *o, cJSON *frames, uint32_t *skipped)
{
    gn_app *app = shot->frame.app;
    gn_resume resume;
    bool good = start(o, shot, &resume);
    const uint32_t first = o->frames.given ? o->frames.first : 0, last = resume.last;
    const double share = 0.85 / (last - resume.from + 1.0);
    bool seen = resume.loaded || resume.from == first; /* the frame before */
    for (uint32_t f = resume.from; f <= last && good; f++) {
        gn_bar_step(&app->bar, 0.15 + share * (f - resume.from), share,
                    o->frames.given ? "frame %u of %u to %u" : "rendering", f, first, last);
        if (f > first)
            gn_app_finished(app, "frames %u to %u are finished", first, f - 1);
        const bool there = o->resume && gn_resume_has(&resume, f);
        if (there && !resume.keeps) {
            seen = false;
            continue;
        }
        good = seen || gn_shot_look_back(shot, o, f - 1);
        seen = true;
        good = good &&
               (there ? gn_shot_move(shot, o, f) && gn_shot_render(shot)
                      : render_frame(o, shot, f, frames)) &&
               (!o->resume || gn_resume_save(&resume, f));
    }
    *skipped = resume.there;
    if (good && o->resume)
        gn_resume_end(&resume);
    return good &&
           (!o->history_out || gn_view_save_history(shot->frame.view, o->history_out) == GN_OK);
}
