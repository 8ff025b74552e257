/* The frames of gnomon render. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render.h"

/* AOVs that visibility gives on its way. */
#define FACTS                                                                                      \
    (1u << GN_AOV_LOD | 1u << GN_AOV_LOOKUPS | 1u << GN_AOV_RAYS | 1u << GN_AOV_CLASS |            \
     1u << GN_AOV_LISTS | 1u << GN_AOV_CASCADE | 1u << GN_AOV_TEST)

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

static void report_frame(cJSON *frames, uint32_t number, double time, const gn_frame *frame,
                         const gn_visibility_stats *stats, double update, double write,
                         cJSON *files, cJSON *lists)
{
    const gn_app *app = frame->app;
    const gn_timings timings = gn_view_timings(frame->view);
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddNumberToObject(entry, "frame", number);
    cJSON_AddNumberToObject(entry, "time", time);
    cJSON *ms = cJSON_AddObjectToObject(entry, "ms");
    cJSON_AddNumberToObject(ms, "update", update);
    cJSON_AddNumberToObject(ms, "gbuffer", timings.gbuffer);
    cJSON_AddNumberToObject(ms, "visibility", timings.visibility);
    cJSON_AddNumberToObject(ms, "shadow_map", timings.shadow_map);
    cJSON_AddNumberToObject(ms, "filter", timings.filter);
    cJSON_AddNumberToObject(ms, "test", timings.test);
    cJSON_AddNumberToObject(ms, "trace", timings.trace);
    cJSON_AddNumberToObject(ms, "shade", timings.shade);
    cJSON_AddNumberToObject(ms, "write", write);
    cJSON *means = cJSON_AddArrayToObject(entry, "mean_visibility");
    gn_leak_counts leak = {0};
    for (uint32_t l = 0; l < app->light_count; l++) {
        gn_app_add_counts(&leak, &stats[l].leak);
        const float *visibility = gn_view_visibility(frame->view, l);
        double sum = 0;
        for (size_t i = 0; i < pixels; i++)
            sum += (double)visibility[i];
        cJSON_AddItemToArray(means, cJSON_CreateNumber(sum / (double)pixels));
    }
    cJSON_AddNumberToObject(entry, "rays", (double)frame->tracing.rays);
    if (gn_app_has_rays(frame->method))
        gn_app_add_tracing_json(entry, &frame->tracing);
    if (frame->method->method.trace == GN_TRACE_LEAK)
        cJSON_AddItemToObject(entry, "leak",
                              gn_app_leak_json(&leak, (double)pixels * app->light_count));
    cJSON_AddItemToObject(entry, "files", files);
    if (cJSON_GetArraySize(lists) > 0)
        cJSON_AddItemToObject(entry, "lists", lists);
    else
        cJSON_Delete(lists);
    cJSON_AddItemToArray(frames, entry);
}

/* Seconds; frames before the animation stand still at its start, those of one picture at its time.
 */
static double time_of(const gn_render_options *o, int64_t number)
{
    return o->frames.given ? (number > 0 ? (double)number : 0) / o->fps : o->common.time;
}

/* One frame, up to its pictures. */
static bool render_view(const gn_frame *frame, const gn_render_options *o, int64_t number,
                        double *update)
{
    gn_app *app = frame->app;
    app->frame = (uint32_t)number;
    const double start = gn_milliseconds();
    if (o->frames.given && !gn_app_set_time(app, time_of(o, number)))
        return false;
    *update = gn_milliseconds() - start;
    if (frame->method->no_reuse)
        gn_history_reset_maps(gn_view_history(frame->view));
    gn_visibility_desc desc = gn_app_visibility_desc(app, frame->method);
    desc.history = NULL; /* the view's, which can be saved */
    return gn_view_render(frame->view, app->scene, app->camera, &desc, app->lights,
                          app->light_count) == GN_OK &&
           !gn_app_interrupted();
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
static bool render_frame(const gn_render_options *o, gn_frame *frame,
                         const gn_visibility_stats *stats, uint32_t number, cJSON *frames)
{
    gn_app *app = frame->app;
    const bool exr = gn_ends_with(o->output, ".exr");
    double update;
    if (!render_view(frame, o, number, &update))
        return false;

    char path[4096];
    snprintf(path, sizeof path, "%s", o->output);
    if (o->frames.given && !gn_frame_path(app, o->output, number, path, sizeof path))
        return false;
    gn_settings settings;
    gn_settings_fill(&settings, app, frame->method->name, o->samples, time_of(o, number));
    gn_settings_add_method(&settings, frame->method);
    frame->tracing = (gn_app_tracing){0};
    for (uint32_t l = 0; l < app->light_count; l++)
        gn_app_add_stats(&frame->tracing, &stats[l]);
    if (gn_app_has_rays(frame->method))
        gn_settings_add_tracing(&settings, &frame->tracing);
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
    report_frame(frames, number, time_of(o, number), frame, stats, update,
                 gn_milliseconds() - start, files, frame->lists);
    return true;
}

/* The frames that are not shown: those of a history, or before the first. */
static bool warm_up(const gn_render_options *o, const gn_frame *frame, uint32_t first)
{
    gn_app *app = frame->app;
    if (o->history_in)
        return (first == 0 || gn_app_set_time(app, time_of(o, (int64_t)first - 1))) &&
               gn_view_load_history(frame->view, app->scene, o->history_in) == GN_OK;
    double update;
    for (uint32_t i = o->warm_up; i > 0; i--)
        if (!render_view(frame, o, (int64_t)first - i, &update))
            return false;
    return true;
}

/* A frame that nobody looks at, for what the next one is measured against. */
static bool look_back(const gn_render_options *o, const gn_frame *frame, uint32_t number)
{
    gn_app *app = frame->app;
    return gn_app_set_time(app, time_of(o, number)) &&
           gn_view_trace_gbuffer(frame->view, app->scene, app->camera) == GN_OK;
}

static bool start(const gn_render_options *o, const gn_frame *frame, gn_resume *resume)
{
    const uint32_t first = o->frames.given ? o->frames.first : 0;
    *resume = (gn_resume){.first = first, .last = o->frames.given ? o->frames.last : 0};
    resume->from = first;
    gn_bar_step(&frame->app->bar, 0.1, 0.05, "frames before the first");
    if (o->resume && !gn_resume_begin(resume, o, frame))
        return false;
    return resume->first > resume->last || resume->from > first || warm_up(o, frame, first);
}

static bool render_frames(const gn_render_options *o, gn_frame *frame,
                          const gn_visibility_stats *stats, cJSON *frames, gn_app_tracing *tracing,
                          uint32_t *skipped)
{
    gn_app *app = frame->app;
    gn_resume resume;
    bool good = start(o, frame, &resume);
    const uint32_t first = o->frames.given ? o->frames.first : 0, last = resume.last;
    const double share = 0.85 / (last - resume.from + 1.0);
    bool seen = resume.loaded || resume.from == first; /* the frame before */
    for (uint32_t f = resume.from; f <= last && good; f++) {
        gn_bar_step(&app->bar, 0.15 + share * (f - resume.from), share,
                    o->frames.given ? "frame %u of %u to %u" : "rendering", f, first, last);
        if (f > first)
            gn_app_finished(app, "frames %u to %u are finished", first, f - 1);
        double update;
        const bool there = o->resume && gn_resume_has(&resume, f);
        if (there && !resume.keeps) {
            seen = false;
            continue;
        }
        good = seen || look_back(o, frame, f - 1);
        seen = true;
        good = good && (there ? render_view(frame, o, f, &update)
                              : render_frame(o, frame, stats, f, frames));
        if (!there)
            gn_app_add_tracing(tracing, &frame->tracing);
        good = good && (!o->resume || gn_resume_save(&resume, f));
    }
    *skipped = resume.there;
    if (good && o->resume)
        gn_resume_end(&resume);
    char text[256];
    if (good && gn_app_fallback(app, frame->method, tracing, text))
        gn_app_note(app, "%s", text);
    return good && (!o->history_out || gn_view_save_history(frame->view, o->history_out) == GN_OK);
}

bool gn_render_sequence(gn_app *app, const gn_render_options *o, const gn_app_method *method,
                        uint32_t aovs, cJSON *frames, gn_app_tracing *tracing, uint32_t *skipped)
{
    const size_t pixels = (size_t)app->options.size[0] * app->options.size[1];
    const gn_view_desc desc = gn_app_view_desc(app, o->samples);
    gn_frame frame = {.app = app, .method = method, .aovs = aovs};
    gn_visibility_stats *stats = calloc(app->light_count, sizeof *stats);
    bool good = stats || gn_app_error(app, "out of memory");
    good = good && gn_view_create(app->device, &desc, &frame.view) == GN_OK;
    for (uint32_t aov = 0; aov < GN_AOV_COUNT && good; aov++)
        if (aovs & FACTS & 1u << aov)
            good = (frame.facts[aov] = malloc(pixels * app->light_count * sizeof(float))) ||
                   gn_app_error(app, "out of memory");
    for (uint32_t l = 0; l < app->light_count && good; l++) {
        float **const planes[] = {
            [GN_AOV_LOD] = &stats[l].lod,       [GN_AOV_LOOKUPS] = &stats[l].lookups,
            [GN_AOV_RAYS] = &stats[l].traced,   [GN_AOV_CLASS] = &stats[l].leak_class,
            [GN_AOV_LISTS] = &stats[l].entries, [GN_AOV_CASCADE] = &stats[l].layer,
            [GN_AOV_TEST] = &stats[l].test};
        for (uint32_t aov = 0; aov < sizeof planes / sizeof *planes; aov++)
            if (frame.facts[aov])
                *planes[aov] = frame.facts[aov] + l * pixels;
    }
    if (good) {
        gn_view_set_stats(frame.view, stats);
        good = render_frames(o, &frame, stats, frames, tracing, skipped);
    }
    for (uint32_t aov = 0; aov < GN_AOV_COUNT; aov++)
        free(frame.facts[aov]);
    gn_view_destroy(&frame.view);
    free(stats);
    return good;
}
