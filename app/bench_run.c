/* Running the benchmark: each frame is rendered once, then every method finds its visibility, in
 * turns, so that a slow moment of the machine hits them all. A repeat runs the whole path again,
 * from nothing: masks and maps go through the same frames with the same bits. */
#include "bench.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "naive.h"

typedef struct runner {
    gn_app *app;
    const gn_bench_options *options;
    gn_app_method *methods;
    uint32_t method_count;
    gn_bench_result *result;

    gn_context *context;
    gn_view *view, *reference;
    gn_naive *naive;
    size_t pixels, plane_floats; /* of a frame; of all lights of a frame */
    float *planes;               /* method_count + 1 sets of visibility */
    gn_flicker_state *states;    /* a method and light each */
    gn_flicker_state *residuals; /* the same less the reference */
    double *series;              /* a number a frame, for a moment */
    double *gbuffer, *update;
    uint32_t measured, reference_frames;
    uint64_t rays; /* of the last frame */
} runner;

static gn_bench_frame *frame_of(const runner *r, uint32_t method, uint32_t frame)
{
    return &r->result->frames[(size_t)method * r->options->frames + frame];
}

static float *planes_of(const runner *r, uint32_t method)
{
    return r->planes + method * r->plane_floats;
}

/* The method whose visibility this one's is held against, or GN_NONE. */
static uint32_t yardstick_of(const runner *r, uint32_t method)
{
    gn_app_method yardstick;
    gn_app_yardstick_of(&r->methods[method], &yardstick);
    for (uint32_t i = 0; i < r->method_count; i++)
        if (strcmp(r->methods[i].name, yardstick.name) == 0)
            return i;
    return GN_NONE;
}

/* One method on one G-buffer. */
static bool run_method(runner *r, uint32_t m, gn_app_cost *cost)
{
    const gn_gbuffer *g = gn_view_gbuffer(r->view);
    if (!r->methods[m].pseudo)
        return gn_app_visibility(r->app, g, &r->methods[m], planes_of(r, m), cost);
    const double start = gn_milliseconds();
    for (uint32_t i = 0; i < r->app->light_count; i++)
        gn_naive_visibility(r->naive, g, r->app->lights[i], planes_of(r, m) + i * r->pixels);
    *cost = (gn_app_cost){0};
    cost->total = cost->trace = gn_milliseconds() - start;
    return !gn_app_interrupted();
}

/* All methods, in an order that turns from frame to frame. */
static bool time_methods(runner *r, uint32_t repeat, uint32_t frame)
{
    uint64_t rays = 0;
    for (uint32_t turn = 0; turn < r->method_count; turn++) {
        const uint32_t m = (turn + repeat + frame) % r->method_count;
        gn_bench_frame *f = frame_of(r, m, frame);
        gn_app_cost cost;
        double before[GN_COUNTER_COUNT], after[GN_COUNTER_COUNT];
        gn_machine_read(r->options->machine, before);
        if (!run_method(r, m, &cost))
            return false;
        gn_machine_read(r->options->machine, after);
        if (repeat == 0 || cost.total < f->cost.total) {
            f->cost = cost;
            for (int i = 0; i < GN_COUNTER_COUNT; i++)
                f->counts[i] = after[i] - before[i];
        }
        f->slowest = fmax(f->slowest, cost.total);
        rays = cost.tracing.rays > rays ? cost.tracing.rays : rays;
    }
    if (repeat == 0)
        r->result->rays += rays;
    return true;
}

/* Wrong pixels against the yardstick. */
static void compare_methods(runner *r, uint32_t frame)
{
    for (uint32_t m = 0; m < r->method_count; m++) {
        const uint32_t yardstick = yardstick_of(r, m);
        if (yardstick == GN_NONE || yardstick == m)
            continue;
        const gn_difference d =
            gn_measure_difference(planes_of(r, m), planes_of(r, yardstick), NULL, r->plane_floats);
        frame_of(r, m, frame)->wrong = d.wrong;
        frame_of(r, m, frame)->mean_abs = d.mean_abs;
    }
}

/* What changed since the frame before, the mean of the lights. reference: of all lights, or NULL.
 */
static gn_flicker find_flicker(runner *r, gn_flicker_state *states, const float *planes,
                               const float *reference)
{
    const gn_gbuffer *g = gn_view_gbuffer(r->view);
    const uint32_t lights = r->app->light_count;
    gn_flicker mean = {0};
    for (uint32_t i = 0; i < lights; i++) {
        const gn_flicker f = gn_measure_residual_flicker(
            &states[i], g, planes + i * r->pixels, reference ? reference + i * r->pixels : NULL);
        mean.flicker += f.flicker / lights;
        mean.toggles += f.toggles / lights;
    }
    return mean;
}

/* The first frame has none before it. */
static void add_flicker(runner *r, uint32_t row)
{
    const gn_flicker f =
        find_flicker(r, r->states + row * r->app->light_count, planes_of(r, row), NULL);
    if (row < r->method_count)
        frame_of(r, row, r->measured)->flicker = r->measured > 0 ? f.flicker : NAN;
    if (r->measured == 0)
        return;
    r->result->rows[row].flicker += f.flicker;
    r->result->rows[row].toggles += f.toggles;
}

static void add_residual(runner *r, uint32_t row)
{
    const gn_flicker f = find_flicker(r, r->residuals + row * r->app->light_count,
                                      planes_of(r, row), planes_of(r, r->method_count));
    if (r->measured == 0)
        return;
    r->result->rows[row].residual_flicker += f.flicker;
    r->result->rows[row].residual_toggles += f.toggles;
}

/* Is there a reference for this frame? They are spread evenly. */
static bool wants_reference(const gn_bench_options *o, uint32_t frame)
{
    if (o->reference == 0)
        return false;
    const uint64_t n = o->reference_frames < o->frames ? o->reference_frames : o->frames;
    return frame * n / o->frames != (frame + 1) * n / o->frames;
}

/* Squared error where the frame shows a surface. */
static bool compare_reference(runner *r, bool steady)
{
    const gn_app_method mip0 = gn_app_yardstick();
    const gn_visibility_desc desc = gn_app_visibility_desc(r->app, &mip0);
    if (gn_view_render(r->reference, r->app->scene, r->app->camera, &desc, r->app->lights,
                       r->app->light_count) != GN_OK)
        return false;
    const gn_gbuffer *g = gn_view_gbuffer(r->view);
    uint8_t *mask = gn_alloc(r->context, r->pixels, 1);
    if (!mask)
        return gn_app_error(r->app, "out of memory for the reference");
    for (size_t i = 0; i < r->pixels; i++)
        mask[i] = g->surface[i] != GN_NONE;
    for (uint32_t i = 0; i < r->app->light_count; i++) {
        const float *truth = gn_view_visibility(r->reference, i);
        memcpy(planes_of(r, r->method_count) + i * r->pixels, truth, r->pixels * sizeof *truth);
        for (uint32_t m = 0; m < r->method_count; m++) {
            const gn_difference d =
                gn_measure_difference(planes_of(r, m) + i * r->pixels, truth, mask, r->pixels);
            r->result->rows[m].mse += d.mse / r->app->light_count;
            r->result->rows[m].mean += d.mean_a / r->app->light_count;
            if (m == 0)
                r->result->reference_mean += d.mean_b / r->app->light_count;
        }
    }
    gn_free(r->context, mask);
    r->reference_frames++;
    if (steady)
        add_flicker(r, r->method_count);
    for (uint32_t m = 0; m <= r->method_count && steady; m++)
        add_residual(r, m);
    return true;
}

/* The row of the profile, as a method sees it. */
static void keep_profile(runner *r, uint32_t row, uint32_t frame)
{
    const gn_gbuffer *g = gn_view_gbuffer(r->view);
    const size_t first = (size_t)r->options->profile_row * g->width;
    float *to = r->result->profile + ((size_t)row * r->options->frames + frame) * g->width;
    for (uint32_t x = 0; x < g->width; x++) {
        to[x] = g->surface[first + x] == GN_NONE ? NAN : 0;
        for (uint32_t i = 0; i < r->app->light_count; i++)
            to[x] += planes_of(r, row)[i * r->pixels + first + x] / (float)r->app->light_count;
    }
}

/* What is measured but the time is so in the first repeat. */
static bool run_frame(runner *r, uint32_t repeat, int32_t frame)
{
    const bool measured = frame >= 0;
    const bool every =
        r->options->reference > 0 && r->options->reference_frames >= r->options->frames;
    double start = gn_milliseconds();
    if (!gn_app_set_time(r->app, fmax(r->options->start + frame / r->options->fps, 0.0)))
        return false;
    const double update = gn_milliseconds() - start;
    if (r->naive)
        gn_naive_update(r->naive);
    start = gn_milliseconds();
    if (gn_view_trace_gbuffer(r->view, r->app->scene, r->app->camera) != GN_OK)
        return false;
    r->app->frame = (uint32_t)(frame + (int32_t)r->options->warm_up);
    if (!measured) { /* warm-up: caches, clocks, memory, maps */
        gn_app_cost cost;
        for (uint32_t m = 0; m < r->method_count; m++) {
            if (!run_method(r, m, &cost))
                return false;
            if (repeat == 0)
                gn_app_add_tracing(&r->result->rows[m].before, &cost.tracing);
        }
        return true;
    }
    const double gbuffer = gn_milliseconds() - start;
    if (!time_methods(r, repeat, (uint32_t)frame))
        return false;
    if (repeat > 0)
        return true;
    r->gbuffer[frame] = gbuffer;
    r->update[frame] = update;
    compare_methods(r, (uint32_t)frame);
    for (uint32_t m = 0; m < r->method_count; m++)
        add_flicker(r, m);
    if (wants_reference(r->options, (uint32_t)frame) && !compare_reference(r, every))
        return false;
    for (uint32_t m = 0; m < r->method_count + every && r->result->profile; m++)
        keep_profile(r, m, (uint32_t)frame);
    r->measured++;
    return true;
}

static bool prepare(runner *r)
{
    const gn_bench_options *o = r->options;
    gn_app *app = r->app;
    const gn_view_desc desc = gn_app_view_desc(app, 1);
    const gn_view_desc many = gn_app_view_desc(app, o->reference ? o->reference : 1);
    r->pixels = (size_t)desc.width * desc.height;
    r->plane_floats = r->pixels * app->light_count;
    if (gn_view_create(app->device, &desc, &r->view) != GN_OK ||
        (o->reference && gn_view_create(app->device, &many, &r->reference) != GN_OK))
        return false;
    for (uint32_t m = 0; m < r->method_count; m++)
        if (r->methods[m].pseudo && !r->naive) {
            r->naive = gn_naive_create(app->scene, gn_device_get_info(app->device).threads);
            if (!r->naive)
                return gn_app_error(app, "out of memory for the baseline");
        }
    const size_t sets = r->method_count + 1u;
    r->planes = gn_alloc_zero(r->context, sets * r->plane_floats, sizeof *r->planes);
    r->states = gn_alloc_zero(r->context, sets * app->light_count, sizeof *r->states);
    r->residuals = gn_alloc_zero(r->context, sets * app->light_count, sizeof *r->residuals);
    r->result->frame_count = o->frames;
    r->result->light_count = app->light_count;
    r->result->frames =
        gn_alloc_zero(r->context, (size_t)r->method_count * o->frames, sizeof *r->result->frames);
    const bool profile = o->profile_row != GN_NONE;
    if (profile)
        r->result->profile =
            gn_alloc_zero(r->context, sets * o->frames * desc.width, sizeof(float));
    r->series = gn_alloc_zero(r->context, o->frames, sizeof *r->series);
    r->gbuffer = gn_alloc_zero(r->context, o->frames, sizeof *r->gbuffer);
    r->update = gn_alloc_zero(r->context, o->frames, sizeof *r->update);
    if ((profile && !r->result->profile) || !r->planes || !r->states || !r->residuals ||
        !r->result->frames || !r->series || !r->gbuffer || !r->update)
        return gn_app_error(app, "out of memory for %zu methods at this size", sets - 1);
    return true;
}

/* The series, summarised; it is sorted then. */
static gn_bench_part part_of_series(runner *r)
{
    const uint32_t frames = r->options->frames;
    gn_bench_part part = {0};
    for (uint32_t f = 0; f < frames; f++)
        part.mean += r->series[f] / frames;
    part.spread = gn_measure_spread(r->series, frames);
    return part;
}

/* One part of a method's costs; offset: where it lies in gn_app_cost. */
static gn_bench_part part_of(runner *r, uint32_t m, size_t offset)
{
    for (uint32_t f = 0; f < r->options->frames; f++)
        memcpy(&r->series[f], (const char *)&frame_of(r, m, f)->cost + offset, sizeof *r->series);
    return part_of_series(r);
}

/* How many times as fast as another method, frame by frame. */
static gn_bench_part speedup_of(runner *r, uint32_t m, uint32_t other)
{
    if (other == GN_NONE)
        return (gn_bench_part){0};
    for (uint32_t f = 0; f < r->options->frames; f++)
        r->series[f] = frame_of(r, other, f)->cost.total / frame_of(r, m, f)->cost.total;
    return part_of_series(r);
}

static double noise_of(runner *r, uint32_t m)
{
    for (uint32_t f = 0; f < r->options->frames; f++)
        r->series[f] = frame_of(r, m, f)->slowest / frame_of(r, m, f)->cost.total;
    return part_of_series(r).spread.median;
}

/* What a method keeps from frame to frame. */
static void describe_history(const runner *r, uint32_t m, gn_bench_row *row)
{
    if (!gn_app_has_map(&r->methods[m]))
        return;
    const gn_history *history = r->methods[m].history;
    for (uint32_t i = 0; i < r->app->light_count; i++) {
        const gn_shadow_map *map = gn_history_map(history, r->app->lights[i]);
        row->map_layers += map ? gn_shadow_map_layer_count(map) : 0;
        row->map_bytes += map ? gn_shadow_map_bytes(map) : 0;
    }
    row->mask_bytes = gn_history_mask_bytes(history);
}

static void summarise_method(runner *r, uint32_t m, uint32_t naive)
{
    const uint32_t frames = r->options->frames, yardstick = yardstick_of(r, m);
    const gn_app_method *method = &r->methods[m];
    gn_bench_row *row = &r->result->rows[m];
    row->name = method->name;
    row->timed = true;
    row->method = method;
    row->trace = method->pseudo ? GN_TRACE_ALL : method->method.trace;
    row->yardstick = yardstick == GN_NONE ? NULL : r->methods[yardstick].name;
    row->frames = frame_of(r, m, 0);
    row->visibility = part_of(r, m, offsetof(gn_app_cost, total));
    row->shadow_map = part_of(r, m, offsetof(gn_app_cost, shadow_map));
    row->filter = part_of(r, m, offsetof(gn_app_cost, filter));
    row->test = part_of(r, m, offsetof(gn_app_cost, test));
    row->trace_rays = part_of(r, m, offsetof(gn_app_cost, trace));
    row->build = part_of(r, m, offsetof(gn_app_cost, tracing.light_buffer.build_ms));
    row->speedup_naive = speedup_of(r, m, naive).spread;
    row->speedup = speedup_of(r, m, yardstick);
    row->noise = noise_of(r, m);
    for (uint32_t f = 0; f < frames; f++) {
        const gn_bench_frame *frame = &row->frames[f];
        row->wrong += frame->wrong / frames;
        row->wrong_max = fmax(row->wrong_max, frame->wrong);
        row->mean_abs += frame->mean_abs / frames;
        row->mean_abs_max = fmax(row->mean_abs_max, frame->mean_abs);
        row->rays += (double)frame->cost.tracing.rays / frames;
        for (int i = 0; i < GN_COUNTER_COUNT; i++)
            row->counts[i] += frame->counts[i] / frames;
        row->map_fits += (double)frame->cost.fitted / frames;
        row->map_pending += (double)frame->cost.pending / frames;
        gn_app_add_counts(&row->leak, &frame->cost.leak);
        if (gn_app_has_rays(method))
            gn_app_add_tracing(&row->tracing, &frame->cost.tracing);
    }
    if (method->pseudo) /* it does not count them */
        row->rays = (double)r->result->rays / frames;
    describe_history(r, m, row);
}

static void summarise(runner *r)
{
    const uint32_t frames = r->options->frames;
    const double pairs = frames > 1 ? frames - 1 : 1;
    gn_bench_result *result = r->result;
    uint32_t naive = GN_NONE;
    for (uint32_t m = 0; m < r->method_count; m++)
        if (r->methods[m].pseudo)
            naive = m;
    for (uint32_t m = 0; m <= r->method_count; m++) {
        gn_bench_row *row = &result->rows[m];
        row->steady = frames > 1;
        row->flicker /= pairs;
        row->toggles /= pairs;
        row->residual_flicker /= pairs;
        row->residual_toggles /= pairs;
        row->mse /= fmax(r->reference_frames, 1);
        row->mean /= fmax(r->reference_frames, 1);
        if (m < r->method_count)
            summarise_method(r, m, naive);
    }
    result->count = r->method_count;
    result->others = gn_machine_others(r->options->machine);
    result->rays = frames > 0 ? result->rays / frames : 0;
    result->referenced = r->reference_frames;
    result->reference_mean /= fmax(r->reference_frames, 1);
    result->gbuffer = gn_measure_spread(r->gbuffer, frames);
    result->update = gn_measure_spread(r->update, frames);
    result->residual = frames > 1 && r->reference_frames == frames;
    if (r->reference_frames == frames && frames > 0) {
        gn_bench_row *row = &result->rows[result->count++];
        row->name = "reference";
        row->mean = result->reference_mean;
    }
}

static void clean_up(runner *r)
{
    const size_t states = (r->method_count + 1u) * (size_t)r->app->light_count;
    for (size_t i = 0; r->states && i < states; i++)
        gn_flicker_state_free(&r->states[i]);
    for (size_t i = 0; r->residuals && i < states; i++)
        gn_flicker_state_free(&r->residuals[i]);
    gn_free(r->context, r->planes);
    gn_free(r->context, r->states);
    gn_free(r->context, r->residuals);
    gn_free(r->context, r->series);
    gn_free(r->context, r->gbuffer);
    gn_free(r->context, r->update);
    gn_naive_destroy(r->naive);
    gn_view_destroy(&r->view);
    gn_view_destroy(&r->reference);
}

/* All that methods keep is forgotten. */
static void begin_repeat(runner *r)
{
    gn_view_reset_history(r->view);
    for (uint32_t m = 0; m < r->method_count; m++)
        if (r->methods[m].history)
            gn_history_reset(r->methods[m].history);
}

void gn_bench_free(gn_app *app, gn_bench_result *result)
{
    gn_free(gn_device_context(app->device), result->frames);
    gn_free(gn_device_context(app->device), result->profile);
    result->frames = NULL;
    result->profile = NULL;
}

bool gn_bench_run(gn_app *app, const gn_bench_options *options, gn_app_method *methods,
                  uint32_t method_count, gn_bench_result *result)
{
    runner r = {.app = app,
                .options = options,
                .methods = methods,
                .method_count = method_count,
                .result = result,
                .context = gn_device_context(app->device)};
    memset(result, 0, sizeof *result);
    bool good = prepare(&r);
    const int32_t first = -(int32_t)options->warm_up, end = (int32_t)options->frames;
    const double whole = (double)(end - first) * options->repeats;
    for (uint32_t repeat = 0; repeat < options->repeats && good; repeat++) {
        begin_repeat(&r);
        if (repeat > 0)
            gn_app_finished(r.app, "%u of %u repeats are finished, and no table printed", repeat,
                            options->repeats);
        for (int32_t frame = first; frame < end && good; frame++) {
            const double done = (double)(end - first) * repeat + (frame - first);
            gn_bar_step(&app->bar, done / whole, 1.0 / whole,
                        frame < 0 ? "run %u of %u: warm-up" : "run %u of %u: frame %d of %d",
                        repeat + 1, options->repeats, frame + 1, end);
            good = run_frame(&r, repeat, frame);
        }
        result->repeats += good;
        gn_app_finished(app, "%u of %u runs of the path are finished", result->repeats,
                        options->repeats);
    }
    gn_bar_clear(&app->bar);
    if (good || (result->repeats > 0 && gn_app_interrupted()))
        summarise(&r);
    clean_up(&r);
    return good;
}

const gn_bench_row *gn_bench_find(const gn_bench_result *result, const char *name)
{
    for (uint32_t i = 0; i < result->count; i++)
        if (strcmp(result->rows[i].name, name) == 0)
            return &result->rows[i];
    return NULL;
}

const gn_bench_row *gn_bench_rival(const gn_bench_result *result)
{
    const gn_bench_row *rival = gn_bench_find(result, "ray-mip0");
    return rival ? rival : gn_bench_find(result, "ray-mip0:bvh");
}

bool gn_bench_busy(const gn_bench_result *result, char text[256])
{
    int used = 0;
    text[0] = '\0';
    if (result->others > 0.1)
        used = snprintf(text, 256, "other programs used %.0f %% of its processors",
                        result->others * 100);
    for (uint32_t i = 0; i < result->count; i++)
        if (result->rows[i].timed && result->rows[i].noise > 1.15) {
            used += snprintf(text + used, 256 - (size_t)used,
                             "%srepeats of %.80s differ by a factor of %.2f", used ? "; " : "",
                             result->rows[i].name, result->rows[i].noise);
            break;
        }
    return used > 0;
}

double gn_bench_ratio(double value, double rival)
{
    return rival > 0 ? value / rival : -1;
}

double gn_bench_ns_per_pixel(const gn_bench_row *row, double pixels)
{
    return row->test.spread.median * 1e6 / pixels;
}
