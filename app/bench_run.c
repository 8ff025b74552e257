/* Running the benchmark: each frame is rendered once, then every method answers its shadow rays,
 * in turns, so that a slow moment of the machine hits them all. */
#include "bench.h"

#include <math.h>
#include <string.h>

#include "naive.h"

typedef struct runner {
    gn_app *app;
    const gn_bench_options *options;
    const gn_app_method *methods;
    uint32_t method_count;
    gn_bench_result *result;

    gn_context *context;
    gn_view *view, *reference;
    gn_naive *naive;
    size_t pixels, plane_floats; /* of a frame; of all lights of a frame */
    float *planes;               /* method_count + 1 sets of visibility */
    gn_flicker_state *states;    /* a method and light each */
    double *times;               /* [method][frame] fastest of the repeats */
    double *noise;               /* [method][frame] slowest / fastest */
    double *ratios, *gbuffer, *update;
    uint32_t measured, reference_frames;
    uint64_t rays; /* of the last frame */
} runner;

static float *planes_of(const runner *r, uint32_t method)
{
    return r->planes + method * r->plane_floats;
}

static bool is_naive(const gn_app_method *method)
{
    return method->method == NULL;
}

/* One method on one G-buffer; milliseconds. */
static bool run_method(runner *r, uint32_t m, uint64_t *rays, double *milliseconds)
{
    const gn_gbuffer *g = gn_view_gbuffer(r->view);
    if (!is_naive(&r->methods[m]))
        return gn_app_visibility(r->app, g, r->methods[m].method, planes_of(r, m), rays,
                                 milliseconds);
    const double start = gn_milliseconds();
    for (uint32_t i = 0; i < r->app->light_count; i++)
        gn_naive_visibility(r->naive, g, r->app->lights[i], planes_of(r, m) + i * r->pixels);
    *milliseconds = gn_milliseconds() - start;
    return !gn_app_interrupted();
}

/* All methods, repeats times each, in an order that turns from repeat to repeat. */
static bool time_methods(runner *r, uint32_t frame)
{
    double slowest[GN_APP_MAX_METHODS] = {0};
    for (uint32_t repeat = 0; repeat < r->options->repeats; repeat++)
        for (uint32_t turn = 0; turn < r->method_count; turn++) {
            const uint32_t m = (turn + repeat + frame) % r->method_count;
            double *best = &r->times[m * r->options->frames + frame], time;
            uint64_t rays = 0;
            if (!run_method(r, m, &rays, &time))
                return false;
            *best = repeat == 0 ? time : fmin(*best, time);
            slowest[m] = fmax(slowest[m], time);
            r->rays = rays > 0 ? rays : r->rays;
        }
    r->result->rays += r->rays;
    for (uint32_t m = 0; m < r->method_count; m++)
        r->noise[m * r->options->frames + frame] =
            slowest[m] / r->times[m * r->options->frames + frame];
    return true;
}

/* Wrong pixels against tracing all with the same alpha rule: for plain rays that is the method
 * itself; the baseline is held against ray-mip0. */
static void compare_methods(runner *r)
{
    uint32_t mip0 = GN_NONE;
    for (uint32_t m = 0; m < r->method_count; m++)
        if (strcmp(r->methods[m].name, "ray-mip0") == 0)
            mip0 = m;
    for (uint32_t m = 0; m < r->method_count; m++)
        if (is_naive(&r->methods[m]) && mip0 != GN_NONE) {
            const gn_difference d =
                gn_measure_difference(planes_of(r, m), planes_of(r, mip0), NULL, r->plane_floats);
            r->result->rows[m].wrong += d.wrong;
            r->result->rows[m].mean_abs += d.mean_abs;
        }
}

static void add_flicker(runner *r, uint32_t row, const float *planes, bool first)
{
    const gn_gbuffer *g = gn_view_gbuffer(r->view);
    for (uint32_t i = 0; i < r->app->light_count; i++) {
        const gn_flicker f = gn_measure_flicker(&r->states[row * r->app->light_count + i], g,
                                                planes + i * r->pixels);
        if (!first) {
            r->result->rows[row].flicker += f.flicker / r->app->light_count;
            r->result->rows[row].toggles += f.toggles / r->app->light_count;
        }
    }
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
    const gn_method *mip0 = gn_method_find("ray-mip0");
    const gn_visibility_desc desc = gn_app_visibility_desc(r->app, mip0);
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
        add_flicker(r, r->method_count, planes_of(r, r->method_count), r->measured == 0);
    return true;
}

static bool run_frame(runner *r, int32_t frame)
{
    const bool measured = frame >= 0;
    const bool every = r->options->reference_frames >= r->options->frames;
    double start = gn_milliseconds();
    if (!gn_app_set_time(r->app, fmax(r->options->start + frame / r->options->fps, 0.0)))
        return false;
    const double update = gn_milliseconds() - start;
    if (r->naive)
        gn_naive_update(r->naive);
    start = gn_milliseconds();
    if (gn_view_trace_gbuffer(r->view, r->app->scene, r->app->camera) != GN_OK)
        return false;
    if (!measured) { /* warm-up: caches, clocks, memory */
        double time;
        uint64_t rays;
        for (uint32_t m = 0; m < r->method_count; m++)
            if (!run_method(r, m, &rays, &time))
                return false;
        return true;
    }
    r->gbuffer[frame] = gn_milliseconds() - start;
    r->update[frame] = update;
    if (!time_methods(r, (uint32_t)frame))
        return false;
    compare_methods(r);
    for (uint32_t m = 0; m < r->method_count; m++)
        add_flicker(r, m, planes_of(r, m), r->measured == 0);
    if (wants_reference(r->options, (uint32_t)frame) && !compare_reference(r, every))
        return false;
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
        if (is_naive(&r->methods[m]) && !r->naive) {
            r->naive = gn_naive_create(app->scene, gn_device_get_info(app->device).threads);
            if (!r->naive)
                return gn_app_error(app, "out of memory for the baseline");
        }
    const size_t sets = r->method_count + 1u;
    r->planes = gn_alloc_zero(r->context, sets * r->plane_floats, sizeof *r->planes);
    r->states = gn_alloc_zero(r->context, sets * app->light_count, sizeof *r->states);
    r->times = gn_alloc_zero(r->context, (size_t)r->method_count * o->frames, sizeof *r->times);
    r->noise = gn_alloc_zero(r->context, (size_t)r->method_count * o->frames, sizeof *r->noise);
    r->ratios = gn_alloc_zero(r->context, o->frames, sizeof *r->ratios);
    r->gbuffer = gn_alloc_zero(r->context, o->frames, sizeof *r->gbuffer);
    r->update = gn_alloc_zero(r->context, o->frames, sizeof *r->update);
    if (!r->planes || !r->states || !r->times || !r->noise || !r->ratios || !r->gbuffer ||
        !r->update)
        return gn_app_error(app, "out of memory for %zu methods at this size", sets - 1);
    return true;
}

static void summarise(runner *r)
{
    const uint32_t frames = r->options->frames;
    const double pairs = frames > 1 ? frames - 1 : 1;
    gn_bench_result *result = r->result;
    const double *baseline = NULL;
    for (uint32_t m = 0; m < r->method_count; m++)
        if (is_naive(&r->methods[m]))
            baseline = r->times + (size_t)m * frames;

    /* Ratios frame by frame, before the times are sorted. */
    for (uint32_t m = 0; m < r->method_count && baseline; m++) {
        const double *times = r->times + (size_t)m * frames;
        for (uint32_t f = 0; f < frames; f++)
            r->ratios[f] = baseline[f] / times[f];
        result->rows[m].speedup = gn_measure_spread(r->ratios, frames);
    }
    for (uint32_t m = 0; m <= r->method_count; m++) {
        gn_bench_row *row = &result->rows[m];
        row->steady = frames > 1;
        row->flicker /= pairs;
        row->toggles /= pairs;
        row->wrong /= frames;
        row->mean_abs /= frames;
        row->mse /= fmax(r->reference_frames, 1);
        row->mean /= fmax(r->reference_frames, 1);
        if (m == r->method_count)
            break;
        row->name = r->methods[m].name;
        row->timed = true;
        row->visibility = gn_measure_spread(r->times + (size_t)m * frames, frames);
        row->noise = gn_measure_spread(r->noise + (size_t)m * frames, frames).median;
    }
    result->count = r->method_count;
    result->rays = frames > 0 ? result->rays / frames : 0;
    result->referenced = r->reference_frames;
    result->reference_mean /= fmax(r->reference_frames, 1);
    result->gbuffer = gn_measure_spread(r->gbuffer, frames);
    result->update = gn_measure_spread(r->update, frames);
    if (r->reference_frames == frames && frames > 0) {
        gn_bench_row *row = &result->rows[result->count++];
        row->name = "reference";
        row->mean = result->reference_mean;
    }
}

static void clean_up(runner *r)
{
    for (size_t i = 0; r->states && i < (r->method_count + 1u) * (size_t)r->app->light_count; i++)
        gn_flicker_state_free(&r->states[i]);
    gn_free(r->context, r->planes);
    gn_free(r->context, r->states);
    gn_free(r->context, r->times);
    gn_free(r->context, r->noise);
    gn_free(r->context, r->ratios);
    gn_free(r->context, r->gbuffer);
    gn_free(r->context, r->update);
    gn_naive_destroy(r->naive);
    gn_view_destroy(&r->view);
    gn_view_destroy(&r->reference);
}

bool gn_bench_run(gn_app *app, const gn_bench_options *options, const gn_app_method *methods,
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
    for (int32_t frame = first; frame < end && good; frame++) {
        gn_bar_step(&app->bar, (double)(frame - first) / (end - first), 1.0 / (end - first),
                    frame < 0 ? "warm-up" : "frame %d of %d", frame + 1, end);
        good = run_frame(&r, frame);
    }
    gn_bar_clear(&app->bar);
    if (good)
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
