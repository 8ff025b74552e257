/* What tests of leak tracing share: several methods over one sequence of frames, each with its own
 * history, beside tracing every pixel with the same alpha rule. */
#ifndef LEAK_TESTING_H
#define LEAK_TESTING_H

#include "render_testing.h"

/* The frames: a scene, camera and light, and what is true of the frame at hand. */
typedef struct stage {
    gn_scene *scene;
    uint32_t camera, light;
    gn_view *view;
    const gn_gbuffer *g;
    size_t pixels;
    uint32_t frame;
    gn_map_desc map;
    float *truth, *before; /* visibility of every pixel by a ray; of the frame before */
} stage;

/* One method, and what it made of the frame at hand. */
typedef struct run {
    const char *name;
    const gn_method *method;
    gn_history *history;
    gn_leak_desc leak;
    float *visibility, *traced, *leak_class, *test, *layer;
    gn_leak_counts counts;
    uint64_t rays;
    size_t wrong;        /* pixels off by more than a half */
    size_t wrong_traced; /* of them, those that were traced */
} run;

static inline float *new_plane(size_t pixels)
{
    float *plane = calloc(pixels, sizeof *plane);
    assert_non_null(plane);
    return plane;
}

static inline gn_scene *built_in(const char *name, double scale, double unit)
{
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = scale;
    desc.unit = unit;
    gn_scene *scene;
    ok(gn_scene_create_procedural(device, name, &desc, &scene));
    return scene;
}

/* Light 0, maps of `resolution`. */
static inline stage new_stage(gn_scene *scene, const char *camera, uint32_t width, uint32_t height,
                              uint32_t resolution)
{
    stage s = {.scene = scene, .pixels = (size_t)width * height, .map = gn_map_desc_default()};
    s.camera = camera ? gn_scene_find_camera(scene, camera) : 0;
    assert_true(s.camera != GN_NONE);
    s.map.resolution = resolution;
    gn_view_desc desc = gn_view_desc_default();
    desc.width = width;
    desc.height = height;
    ok(gn_view_create(scene->device, &desc, &s.view));
    s.truth = new_plane(s.pixels);
    s.before = new_plane(s.pixels);
    return s;
}

static inline void end_stage(stage *s)
{
    gn_view_destroy(&s->view);
    free(s->truth);
    free(s->before);
    gn_scene_destroy(&s->scene);
}

static inline run new_run(const stage *s, const char *method)
{
    const gn_visibility_desc defaults = gn_visibility_desc_default();
    run r = {.name = method, .method = gn_method_find(method), .leak = defaults.leak};
    assert_non_null(r.method);
    ok(gn_history_create(s->scene->device, &r.history));
    r.visibility = new_plane(s->pixels);
    r.traced = new_plane(s->pixels);
    r.leak_class = new_plane(s->pixels);
    r.test = new_plane(s->pixels);
    r.layer = new_plane(s->pixels);
    return r;
}

static inline void end_run(run *r)
{
    gn_history_destroy(&r->history);
    free(r->visibility);
    free(r->traced);
    free(r->leak_class);
    free(r->test);
    free(r->layer);
}

static inline gn_visibility_desc stage_desc(const stage *s, const gn_method *method)
{
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = method;
    desc.light = s->light;
    desc.camera = s->camera;
    desc.frame = s->frame;
    desc.map = s->map;
    return desc;
}

/* The frame at `seconds`, once its nodes are where they should be: geometry, and the truth by rays
 * with the alpha rule of leak tracing. */
static inline void show(stage *s, double seconds)
{
    static const char *const rules[] = {"ray-mip0", "ray-raw", "ray-test", "ray-saturate",
                                        "ray-coverage"};
    ok(gn_scene_set_time(s->scene, seconds));
    ok(gn_scene_commit(s->scene));
    ok(gn_view_trace_gbuffer(s->view, s->scene, s->camera));
    s->g = gn_view_gbuffer(s->view);
    float *swap = s->before;
    s->before = s->truth;
    s->truth = swap;
    const gn_method *all = gn_method_find(rules[gn_method_find("lt-vsm")->alpha]);
    const gn_visibility_desc desc = stage_desc(s, all);
    ok(gn_scene_visibility(s->scene, s->g, &desc, s->truth, NULL));
}

static inline bool is_wrong(const stage *s, const run *r, size_t pixel)
{
    return fabsf(r->visibility[pixel] - s->truth[pixel]) > 0.5f;
}

/* Visibility of the frame at hand. A traced pixel has the ray's answer. */
static inline void step(const stage *s, run *r)
{
    gn_visibility_desc desc = stage_desc(s, r->method);
    desc.history = r->history;
    desc.leak = r->leak;
    gn_visibility_stats stats = {
        .traced = r->traced, .leak_class = r->leak_class, .test = r->test, .layer = r->layer};
    ok(gn_scene_visibility(s->scene, s->g, &desc, r->visibility, &stats));
    r->counts = stats.leak;
    r->rays = stats.rays;
    r->wrong = r->wrong_traced = 0;
    uint64_t traced = 0;
    for (size_t i = 0; i < s->pixels; i++) {
        const bool wrong = is_wrong(s, r, i);
        r->wrong += wrong;
        r->wrong_traced += wrong && r->traced[i] > 0.0f;
        traced += r->traced[i] > 0.0f;
    }
    if (r->wrong_traced > 0)
        fail_msg("%s, frame %u: %zu traced pixels are wrong", r->name, s->frame, r->wrong_traced);
    if (traced != r->rays)
        fail_msg("%s, frame %u: %zu pixels are marked as traced, %zu rays are counted", r->name,
                 s->frame, (size_t)traced, (size_t)r->rays);
}

/* Two frames that leave a mask which knows the test's own rays alone: what the paper starts from.
 * (gnomon's first frame traces all, so that errors of the test are known from the start.) */
static inline void forget_errors(stage *s, run *r)
{
    r->leak.expand = r->leak.remove = false;
    for (int i = 0; i < 2; i++, s->frame++)
        step(s, r);
    r->leak.expand = r->leak.remove = true;
}

/* What a run made of several frames. */
typedef struct tally {
    size_t frames, sum, least, most; /* wrong pixels */
    uint64_t rays;
} tally;

static inline void count(tally *t, const run *r)
{
    t->least = t->frames == 0 || r->wrong < t->least ? r->wrong : t->least;
    t->most = r->wrong > t->most ? r->wrong : t->most;
    t->sum += r->wrong;
    t->rays += r->rays;
    t->frames++;
}

static inline double mean(const tally *t)
{
    return (double)t->sum / (double)t->frames;
}

static inline void print_tally(const tally *t, const stage *s, const char *view, const char *method)
{
    const double percent = 100.0 / (double)s->pixels;
    print_message("%s, %s: wrong pixels %zu to %zu, mean %.1f (%.4f %%); rays %.2f %%\n", view,
                  method, t->least, t->most, mean(t), percent * mean(t),
                  percent * (double)t->rays / (double)t->frames);
}

/* Truth (grey), wrong pixels (red: lit, green: in shadow), and what was traced (blue). */
static inline void leak_picture(const stage *s, const run *r, const char *name)
{
    const char *folder = getenv("GNOMON_PICTURES");
    if (!folder)
        return;
    uint8_t *rgb = malloc(s->pixels * 3);
    assert_non_null(rgb);
    for (size_t i = 0; i < s->pixels; i++) {
        const uint8_t grey = (uint8_t)(s->truth[i] * 180.0f);
        const bool wrong = is_wrong(s, r, i);
        rgb[3 * i] = wrong && r->visibility[i] > 0.5f ? 255 : grey;
        rgb[3 * i + 1] = wrong && r->visibility[i] < 0.5f ? 255 : wrong ? 0 : grey;
        rgb[3 * i + 2] = wrong ? 0 : r->traced[i] > 0.0f ? 255 : grey;
    }
    char path[512];
    snprintf(path, sizeof path, "%s/%s-%s-%u.png", folder, name, r->name, s->frame);
    ok(gn_write_png(device, path, s->g->width, s->g->height, 3, rgb, NULL, 0));
    free(rgb);
}

#endif
