#include <math.h>
#include <string.h>

#include <gnomon/shadow/ray_cone.h>

#include "render/device.h"
#include "render/history_file.h"

struct gn_view {
    gn_device *device;
    gn_view_desc desc;
    float jitter[2]; /* of one sample */
    gn_gbuffer gbuffer;
    float *planes; /* all of the G-buffer's floats */
    uint32_t *words;
    float *image;
    float *visibility; /* light_capacity planes */
    float *sample;     /* the visibility of one sample, where there are several */
    uint32_t light_capacity, light_count;
    gn_timings timings;
    gn_last_frame last;
    gn_history *history;
    gn_visibility_stats *stats; /* the caller's, one a light, or NULL */
};

gn_view_desc gn_view_desc_default(void)
{
    return (gn_view_desc){.cookie = GN_COOKIE, .width = 1920, .height = 1080, .samples = 1};
}

gn_visibility_desc gn_visibility_desc_default(void)
{
    return (gn_visibility_desc){.cookie = GN_COOKIE,
                                .method = gn_method_find("ray"),
                                .rescale_alpha = true,
                                .map = gn_map_desc_default(),
                                .leak = {.epsilon = 0.01f, .expand = true, .remove = true},
                                .cutoff = 0.01f,
                                .light_buffer_limit = (size_t)512 << 20};
}

/* Floats a pixel: position, normal, shading normal, motion, origin error, cone width, depth. */
#define PLANES 15

static gn_result allocate(gn_view *view)
{
    gn_context *context = gn_device_context(view->device);
    const size_t pixels = (size_t)view->desc.width * view->desc.height;
    view->planes = gn_alloc_zero(context, pixels * PLANES, sizeof(float));
    view->words = gn_alloc_zero(context, pixels * 2, sizeof(uint32_t));
    view->image = gn_alloc_zero(context, pixels * 3, sizeof(float));
    if (!view->planes || !view->words || !view->image)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a view of %u x %u",
                       view->desc.width, view->desc.height);
    gn_gbuffer *g = &view->gbuffer;
    g->width = view->desc.width;
    g->height = view->desc.height;
    float *plane = view->planes;
    float **const groups[4] = {g->position, g->normal, g->shading_normal, g->motion};
    for (int group = 0; group < 4; group++)
        for (int i = 0; i < 3; i++, plane += pixels)
            groups[group][i] = plane;
    g->origin_error = plane;
    g->cone_width = plane + pixels;
    g->depth = plane + 2 * pixels;
    g->albedo = view->words;
    g->surface = view->words + pixels;
    memset(g->surface, 0xff, pixels * sizeof *g->surface);
    return GN_OK;
}

gn_result gn_view_create(gn_device *device, const gn_view_desc *desc, gn_view **view)
{
    gn_context *context = gn_device_context(device);
    *view = NULL;
    const gn_view_desc defaults = gn_view_desc_default();
    if (!desc)
        desc = &defaults;
    GN_CHECK_DESC(context, desc, gn_view_desc);
    if (desc->width < 1 || desc->width > 16384 || desc->height < 1 || desc->height > 16384)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a view of %u x %u pixels: the range is 1 to 16384", desc->width,
                       desc->height);
    if (desc->samples < 1 || desc->samples > 4096)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%u samples a pixel: the range is 1 to 4096", desc->samples);
    gn_view *made = gn_alloc_zero(context, 1, sizeof *made);
    if (!made)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a view");
    made->device = device;
    made->desc = *desc;
    made->jitter[0] = made->jitter[1] = 0.5f;
    gn_result result = allocate(made);
    if (result == GN_OK)
        result = gn_history_create(device, &made->history);
    if (result != GN_OK)
        gn_view_destroy(&made);
    *view = made;
    return result;
}

void gn_view_destroy(gn_view **view)
{
    if (!view || !*view)
        return;
    gn_view *v = *view;
    *view = NULL;
    gn_context *context = gn_device_context(v->device);
    gn_history_destroy(&v->history);
    gn_free(context, v->planes);
    gn_free(context, v->words);
    gn_free(context, v->image);
    gn_free(context, v->visibility);
    gn_free(context, v->sample);
    gn_free(context, v->last.world);
    gn_free(context, v);
}

const gn_gbuffer *gn_view_gbuffer(const gn_view *view)
{
    return &view->gbuffer;
}

const float *gn_view_visibility(const gn_view *view, uint32_t nth_light)
{
    if (nth_light >= view->light_count)
        return NULL;
    return view->visibility + (size_t)nth_light * view->desc.width * view->desc.height;
}

const float *gn_view_image(const gn_view *view)
{
    return view->image;
}

gn_timings gn_view_timings(const gn_view *view)
{
    return view->timings;
}

gn_result gn_view_set_jitter(gn_view *view, float x, float y)
{
    if (!(x >= 0.0f && x < 1.0f && y >= 0.0f && y < 1.0f))
        return gn_fail(gn_device_context(view->device), GN_ERROR_INVALID_ARGUMENT,
                       "a jitter of %g, %g pixels: the range is 0 to below 1", (double)x,
                       (double)y);
    view->jitter[0] = x;
    view->jitter[1] = y;
    return GN_OK;
}

void gn_view_set_stats(gn_view *view, gn_visibility_stats *stats)
{
    view->stats = stats;
}

void gn_view_reset_history(gn_view *view)
{
    view->last.valid = false;
    gn_history_cut(view->history);
}

gn_history *gn_view_history(gn_view *view)
{
    return view->history;
}

gn_result gn_view_save_history(const gn_view *view, const char *path)
{
    if (!view->last.valid)
        return gn_fail(gn_device_context(view->device), GN_ERROR_STATE,
                       "%s: the view has no frame to go on from", path ? path : "(no path)");
    return gn_history_write(view->history, &view->last, path);
}

gn_result gn_view_load_history(gn_view *view, const gn_scene *scene, const char *path)
{
    gn_context *context = gn_device_context(view->device);
    if (scene->device != view->device)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "the view was made by another device than the scene");
    gn_history *history;
    gn_last_frame last = {.width = view->desc.width, .height = view->desc.height};
    GN_TRY(gn_history_read(scene, path, &history, &last));
    gn_history_take(view->history, &history);
    gn_free(context, view->last.world);
    view->last = last;
    return GN_OK;
}

static gn_result check_ready(gn_context *context, const gn_scene *scene, uint32_t camera)
{
    if (!scene->accel || scene->edits != scene->committed)
        return gn_fail(context, GN_ERROR_STATE, "the scene has edits that are not committed");
    if (camera >= scene->camera_count)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "camera %u does not exist: the scene has %u", camera, scene->camera_count);
    return GN_OK;
}

/* The view's rays, with the ray cone of one pixel (Equation 1); of several samples a pixel each
 * takes its share of the pixel's width. */
static gn_rays make_rays(const gn_view *view, const gn_camera *camera)
{
    const float *m = camera->world;
    const float aspect = (float)view->desc.width / (float)view->desc.height;
    const bool orthographic = camera->desc.orthographic;
    const double half =
        orthographic ? (double)camera->desc.ymag : tan(0.5 * (double)camera->desc.yfov);
    const double height = (double)view->desc.height * sqrt((double)view->desc.samples);
    gn_rays rays = {.orthographic = orthographic, .near = camera->desc.znear};
    for (int i = 0; i < 3; i++) {
        rays.origin[i] = m[12 + i];
        rays.right[i] = m[i] * (float)half * aspect;
        rays.up[i] = m[4 + i] * (float)half;
        rays.back[i] = m[8 + i];
    }
    rays.cone_width = orthographic ? (float)(2.0 * half / height) : 0.0f;
    rays.cone_angle = orthographic ? 0.0f : gn_ray_cone_spread((float)half, (float)height);
    return rays;
}

static gn_result remember(gn_view *view, const gn_scene *scene, const gn_rays *rays)
{
    gn_context *context = gn_device_context(view->device);
    gn_last_frame *last = &view->last;
    if (last->node_count != scene->node_count || !last->world) {
        gn_free(context, last->world);
        last->valid = false;
        last->node_count = scene->node_count;
        last->world = gn_alloc(context, (size_t)scene->node_count * 16 + 1, sizeof(float));
        if (!last->world)
            return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for %u nodes",
                           scene->node_count);
    }
    for (uint32_t i = 0; i < scene->node_count; i++)
        memcpy(last->world + 16 * (size_t)i, scene->nodes[i].world, 16 * sizeof(float));
    last->scene = scene->number;
    last->width = view->desc.width;
    last->height = view->desc.height;
    last->rays = *rays;
    last->valid = true;
    return GN_OK;
}

/* The first frame, and the one after a reset, has not moved: no mask fits it. */
static gn_result start_history(gn_view *view, const gn_scene *scene, const gn_rays *rays,
                               gn_history *history)
{
    GN_TRY(gn_history_use_scene(view->history, scene));
    if (view->last.valid && view->last.scene == scene->number &&
        view->last.node_count == scene->node_count)
        return GN_OK;
    gn_history_cut(view->history);
    gn_history_cut(history);
    return remember(view, scene, rays);
}

/* The view's motion goes on by a picture, whichever history is used for it. */
static void begin_frame(gn_view *view, gn_history *history)
{
    gn_history_begin_frame(view->history);
    if (history != view->history)
        gn_history_begin_frame(history);
    if (view->desc.samples > 1)
        gn_history_cut(history);
}

static void trace_gbuffer(gn_view *view, const gn_scene *scene, const gn_rays *rays,
                          const float jitter[2])
{
    const gn_gbuffer_job job = {.scene = scene,
                                .accel = scene->accel,
                                .now = *rays,
                                .before = view->last.rays,
                                .world_before = view->last.world,
                                .jitter = {jitter[0], jitter[1]},
                                .gbuffer = &view->gbuffer};
    gn_cpu_gbuffer(&view->device->cpu, &job);
}

gn_result gn_view_trace_gbuffer(gn_view *view, const gn_scene *scene, uint32_t camera)
{
    gn_result result = check_ready(gn_device_context(view->device), scene, camera);
    if (result != GN_OK)
        return result;
    const gn_rays rays = make_rays(view, &scene->cameras[camera]);
    if ((result = start_history(view, scene, &rays, view->history)) != GN_OK)
        return result;
    begin_frame(view, view->history);
    const double start = gn_milliseconds();
    trace_gbuffer(view, scene, &rays, view->jitter);
    view->timings.gbuffer = gn_milliseconds() - start;
    return remember(view, scene, &rays);
}

/* Sample i of the R2 sequence (Roberts 2018): even in the pixel for any count. One sample lies
 * where it was told to. */
static void sample_position(const gn_view *view, uint32_t i, float jitter[2])
{
    if (view->desc.samples == 1) {
        memcpy(jitter, view->jitter, sizeof view->jitter);
        return;
    }
    const double a[2] = {0.7548776662466927, 0.5698402909980532};
    for (int axis = 0; axis < 2; axis++) {
        const double x = 0.5 + a[axis] * (double)(i + 1);
        jitter[axis] = (float)(x - floor(x));
    }
}

static gn_result reserve_lights(gn_view *view, uint32_t count)
{
    gn_context *context = gn_device_context(view->device);
    const size_t pixels = (size_t)view->desc.width * view->desc.height;
    if (count > view->light_capacity) {
        gn_free(context, view->visibility);
        gn_free(context, view->sample);
        view->light_capacity = 0;
        view->light_count = 0;
        view->visibility = gn_alloc(context, pixels * count, sizeof(float));
        view->sample =
            view->desc.samples > 1 ? gn_alloc(context, pixels * count, sizeof(float)) : NULL;
        if (!view->visibility || (view->desc.samples > 1 && !view->sample))
            return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for %u lights", count);
        view->light_capacity = count;
    }
    view->light_count = count;
    return GN_OK;
}

/* One sample: G-buffer, every light, shading. visibility: light_count planes, overwritten. */
static gn_result render_sample(gn_view *view, const gn_scene *scene, uint32_t camera,
                               const gn_rays *rays, const gn_visibility_desc *desc,
                               const uint32_t *lights, uint32_t light_count, uint32_t sample,
                               float *visibility)
{
    const size_t pixels = (size_t)view->desc.width * view->desc.height;
    gn_shade_light shade_lights[light_count + 1];
    float jitter[2];
    sample_position(view, sample, jitter);
    gn_history *history = desc->history ? desc->history : view->history;
    begin_frame(view, history);
    double start = gn_milliseconds();
    trace_gbuffer(view, scene, rays, jitter);
    view->timings.gbuffer += gn_milliseconds() - start;

    start = gn_milliseconds();
    for (uint32_t i = 0; i < light_count; i++) {
        gn_visibility_desc one = *desc;
        one.light = lights[i];
        one.camera = camera;
        one.frame = desc->frame * view->desc.samples + sample;
        one.history = history;
        gn_visibility_stats unused = {0}, *stats = view->stats ? &view->stats[i] : &unused;
        GN_TRY(gn_scene_visibility(scene, &view->gbuffer, &one, visibility + i * pixels, stats));
        view->timings.shadow_map += stats->map.depth_ms;
        view->timings.filter += stats->map.filter_ms;
        view->timings.test += stats->test_ms;
        view->timings.trace += stats->trace_ms;
        shade_lights[i] = (gn_shade_light){&scene->lights[lights[i]], visibility + i * pixels};
    }
    view->timings.visibility += gn_milliseconds() - start;

    start = gn_milliseconds();
    gn_cpu_shade(&view->device->cpu, &view->gbuffer, rays, shade_lights, light_count,
                 1.0f / (float)view->desc.samples, view->image);
    view->timings.shade += gn_milliseconds() - start;
    return GN_OK;
}

gn_result gn_view_render(gn_view *view, const gn_scene *scene, uint32_t camera,
                         const gn_visibility_desc *desc, const uint32_t *lights,
                         uint32_t light_count)
{
    gn_context *context = gn_device_context(view->device);
    const gn_visibility_desc defaults = gn_visibility_desc_default();
    if (!desc)
        desc = &defaults;
    if (light_count > 256)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%u lights: at most 256 a frame",
                       light_count);
    gn_result result = check_ready(context, scene, camera);
    if (result != GN_OK)
        return result;
    const gn_rays rays = make_rays(view, &scene->cameras[camera]);
    gn_history *history = desc->history ? desc->history : view->history;
    if ((result = start_history(view, scene, &rays, history)) != GN_OK ||
        (result = reserve_lights(view, light_count)) != GN_OK)
        return result;

    const size_t pixels = (size_t)view->desc.width * view->desc.height;
    const uint32_t samples = view->desc.samples;
    view->timings = (gn_timings){0};
    memset(view->image, 0, pixels * 3 * sizeof *view->image);
    if (samples == 1) {
        result = render_sample(view, scene, camera, &rays, desc, lights, light_count, 0,
                               view->visibility);
    } else if (light_count > 0) {
        memset(view->visibility, 0, pixels * light_count * sizeof *view->visibility);
    }
    for (uint32_t s = 0; samples > 1 && s < samples && result == GN_OK; s++) {
        result =
            render_sample(view, scene, camera, &rays, desc, lights, light_count, s, view->sample);
        for (size_t i = 0; i < pixels * light_count && result == GN_OK; i++)
            view->visibility[i] += view->sample[i] / (float)samples;
        if (gn_report(context, (double)(s + 1) / samples, "samples"))
            result = gn_fail(context, GN_ERROR_CANCELLED, "cancelled after %u of %u samples", s + 1,
                             samples);
    }
    if (result != GN_OK) {
        gn_history_cut(history); /* masks of a frame that no other one follows */
        return result;
    }
    if (samples > 1) /* the G-buffer that is shown belongs to the pixels' centres */
        trace_gbuffer(view, scene, &rays, (const float[2]){0.5f, 0.5f});
    return remember(view, scene, &rays);
}
