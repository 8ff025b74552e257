#include "render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The state's note ---------------------------------------------------------------------------- */

static void put_map(FILE *text, const gn_map_desc *map)
{
    fprintf(text, "placing of maps: distance=%.9g weight=%.9g splits=", (double)map->distance,
            (double)map->split_weight);
    for (uint32_t i = 0; i < map->split_count; i++)
        fprintf(text, "%s%.9g", i ? "," : "", (double)map->splits[i]);
    fprintf(text, " undrawn=%u enlarge=%.9g refresh=%u seed=%u\n", map->undrawn,
            (double)map->enlarge, map->refresh, map->seed);
    fprintf(text, "biases: depth=%.9g normal=%.9g variance=%.9g moments=%.9g\n",
            (double)map->depth_bias, (double)map->normal_bias, (double)map->minimum_variance,
            (double)map->moment_bias);
}

/* Everything that the bits of a frame hang on, a line each: the frame, and then the settings.
 * free()d by the caller; NULL: no memory. */
static char *make_note(const gn_resume *r, uint32_t frame)
{
    const gn_render_options *o = r->options;
    const gn_app_method *method = r->frame->method;
    const gn_map_format *format = &method->method.map;
    char *note = NULL;
    size_t size;
    FILE *text = open_memstream(&note, &size);
    if (!text)
        return NULL;
    fprintf(text, "frame: %u\n", frame);
    gn_settings settings;
    gn_settings_fill(&settings, r->frame->app, method->name, o->samples, 0);
    gn_settings_add_method(&settings, method);
    for (uint32_t i = 0; i < settings.count; i++)
        if (strcmp(settings.attributes[i].key, "time") != 0)
            fprintf(text, "%s: %s\n", settings.attributes[i].key, settings.attributes[i].value);
    fprintf(text, "built-in scene: seed=%u scale=%.17g\n", o->common.seed, o->common.scale);
    fprintf(text, "camera path: %s\n", o->common.camera_path ? o->common.camera_path : "none");
    fprintf(text, "frames: %.17g a second, from %u, after %u more\n", o->fps, o->frames.first,
            o->warm_up);
    fprintf(text, "history before the first: %s\n", o->history_in ? o->history_in : "none");
    fprintf(text, "exponents of the map: %.9g, %.9g\n", (double)format->positive_exponent,
            (double)format->negative_exponent);
    put_map(text, &method->map);
    fprintf(text, "reuse of maps: %s\n", method->no_reuse ? "off" : "on");
    fprintf(text, "mips of alpha: %s\n", o->common.no_alpha_rescale ? "plain" : "rescaled");
    fprintf(text, "tracer: %s, %zu bytes\n",
            gn_app_tracer_names[gn_app_tracer(r->frame->app, method)],
            gn_app_light_buffer_limit(r->frame->app));
    const bool whole = !ferror(text);
    if (fclose(text) == 0 && whole)
        return note;
    free(note);
    return NULL;
}

/* Compares two notes but for their first lines, and names the line that differs. */
static bool same_settings(const gn_resume *r, const char *theirs, const char *ours)
{
    for (;;) {
        theirs += strcspn(theirs, "\n");
        ours += strcspn(ours, "\n");
        theirs += *theirs == '\n';
        ours += *ours == '\n';
        if (!*theirs && !*ours)
            return true;
        const size_t a = strcspn(theirs, "\n"), b = strcspn(ours, "\n");
        if (a != b || memcmp(theirs, ours, a) != 0)
            return gn_app_error(r->frame->app,
                                "%s: the frames that are there were made with other settings: "
                                "'%.*s', and now '%.*s'; remove it to go on all the same",
                                r->state, (int)a, theirs, (int)b, ours);
    }
}

/* What is there -------------------------------------------------------------------------------- */

bool gn_resume_has(const gn_resume *r, uint32_t frame)
{
    char path[4096];
    return gn_frame_path(r->frame->app, r->options->output, frame, path, sizeof path) &&
           access(path, F_OK) == 0;
}

/* The state is of use if it is not behind the first frame that is missing. */
static bool load(gn_resume *r)
{
    gn_app *app = r->frame->app;
    const gn_render_options *o = r->options;
    gn_history *history;
    if (gn_history_load(app->scene, r->state, &history) != GN_OK)
        return gn_app_error(app, "%s", gn_device_message(app->device));
    unsigned frame = 0;
    char *ours = make_note(r, 0);
    const char *theirs = gn_history_note(history);
    bool good = ours != NULL;
    if (!ours)
        gn_app_error(app, "out of memory");
    good = good &&
           (sscanf(theirs, "frame: %u\n", &frame) == 1 ||
            gn_app_error(app, "%s: it was not written by --resume", r->state)) &&
           same_settings(r, theirs, ours);
    free(ours);
    gn_history_destroy(&history);
    if (!good || frame < o->frames.first || frame >= r->first)
        return good;
    r->loaded = gn_app_set_time(app, frame / o->fps) &&
                gn_view_load_history(r->frame->view, app->scene, r->state) == GN_OK;
    r->from = frame + 1;
    return r->loaded;
}

bool gn_resume_begin(gn_resume *r, const gn_render_options *o, const gn_frame *frame)
{
    const gn_frames *wanted = &o->frames;
    const bool antialias = o->antialias != GN_APP_NO_ANTIALIAS, map = gn_app_has_map(frame->method);
    *r = (gn_resume){
        .options = o, .frame = frame, .keeps = map || antialias, .saves = map && !antialias};
    char name[4000];
    if (!gn_sequence_path(frame->app, o->output, "resume", name, sizeof name))
        return false;
    snprintf(r->state, sizeof r->state, "%s.history", name);
    r->first = wanted->last + 1;
    r->last = wanted->last;
    for (uint32_t f = wanted->first; f <= wanted->last; f++) {
        if (gn_resume_has(r, f)) {
            r->there++;
            continue;
        }
        r->first = f < r->first ? f : r->first;
        r->last = f;
    }
    const bool all = r->first > r->last;
    r->from = r->keeps && !all ? wanted->first : r->first;
    if (r->saves && !all && access(r->state, F_OK) == 0 && !load(r))
        return false;
    if (r->there > 0)
        gn_app_note(frame->app, "%u of %u frames are there already", r->there,
                    wanted->last - wanted->first + 1);
    if (r->first > wanted->first)
        gn_app_finished(frame->app, "frames %u to %u are finished", wanted->first, r->first - 1);
    if (r->from < r->first)
        gn_app_note(frame->app,
                    "frames %u to %u are rendered again, and not written: nothing newer was saved "
                    "of what %s keeps",
                    r->from, r->first - 1, frame->method->name);
    return true;
}

bool gn_resume_save(const gn_resume *r, uint32_t frame)
{
    if (!r->saves)
        return true;
    char *note = make_note(r, frame);
    const bool good = note ? gn_history_set_note(gn_view_history(r->frame->view), note) == GN_OK &&
                                 gn_view_save_history(r->frame->view, r->state) == GN_OK
                           : gn_app_error(r->frame->app, "out of memory");
    free(note);
    return good;
}

void gn_resume_end(const gn_resume *r)
{
    if (r->saves)
        unlink(r->state);
}
