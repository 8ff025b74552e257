#include "render/tracer.h"

#include <math.h>
#include <string.h>

#include "render/cascade.h"
#include "render/device.h"

/* Triangles that move are put into lists anew every frame. One costs what the light buffer gains on
 * so many pixels: few where foliage makes the tree slow, many where nothing is masked. */
#define MASKED_PIXELS 32.0
#define OPAQUE_PIXELS 192.0

/* Orthogonal to the last bits of a double: a ray has one place in the view. */
static void set_axes(const float direction[3], double axes[3][3])
{
    const gn_axes rough = gn_light_axes(direction);
    double *x = axes[0], *y = axes[1], *z = axes[2];
    const double length = sqrt((double)direction[0] * (double)direction[0] +
                               (double)direction[1] * (double)direction[1] +
                               (double)direction[2] * (double)direction[2]);
    double along = 0.0, square = 0.0;
    for (int i = 0; i < 3; i++)
        z[i] = (double)direction[i] / length;
    for (int i = 0; i < 3; i++)
        along += rough.right[i] * z[i];
    for (int i = 0; i < 3; i++) {
        x[i] = rough.right[i] - along * z[i];
        square += x[i] * x[i];
    }
    for (int i = 0; i < 3; i++)
        x[i] /= sqrt(square);
    for (int i = 0; i < 3; i++)
        y[i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
}

static gn_light_frame frame_of(const gn_light *light, float clip)
{
    gn_light_frame frame;
    memset(&frame, 0, sizeof frame); /* frames are compared, padding and all */
    frame.central = light->desc.type != GN_LIGHT_DIRECTIONAL;
    frame.clip = frame.central ? (double)clip : 0.0;
    for (int i = 0; i < 3; i++) {
        frame.origin[i] = frame.central ? (double)light->position[i] : 0.0;
        frame.axes[i][i] = 1.0;
    }
    /* A spot light looks along a face. */
    if (light->desc.type != GN_LIGHT_POINT)
        set_axes(light->direction, frame.axes);
    return frame;
}

/* Pixels from which on the light buffer gains more than moving casters cost it. */
static double count_least_pixels(const gn_scene *scene)
{
    const gn_accel *accel = scene->accel;
    double moving = 0.0, masked = 0.0, all = 0.0;
    for (uint32_t i = 0; i < accel->instance_count; i++) {
        const gn_instance *instance = &accel->instances[i];
        const uint32_t *counts = instance->tree->counts;
        const double count = (double)counts[GN_GEOMETRY_OPAQUE] + counts[GN_GEOMETRY_MASKED];
        if (instance->node != GN_NONE && scene->nodes[instance->node].animated)
            moving += count;
        masked += counts[GN_GEOMETRY_MASKED];
        all += count;
    }
    const double share = all > 0.0 ? masked / all : 0.0;
    return moving * (share * MASKED_PIXELS + (1.0 - share) * OPAQUE_PIXELS);
}

/* Is the light buffer expected to be faster, over a walk through the scene (docs/decisions.md)?
 * Asks nothing but what a frame is of: its bits must not depend on the frames before. */
static bool suits_light_buffer(const gn_scene *scene, const gn_visibility_desc *desc, double pixels)
{
    const uint32_t node = scene->lights[desc->light].node;
    const bool stands = node == GN_NONE || !scene->nodes[node].animated;
    return desc->history && desc->method->trace == GN_TRACE_ALL && stands &&
           pixels >= count_least_pixels(scene);
}

gn_result gn_choose_tracer(const gn_scene *scene, const gn_visibility_desc *desc, size_t pixels,
                           gn_history *history, gn_tracer *tracer)
{
    const bool automatic = desc->tracer == GN_TRACER_AUTO;
    *tracer = (gn_tracer){.accel = scene->accel};
    if (desc->tracer == GN_TRACER_BVH ||
        (automatic && !suits_light_buffer(scene, desc, (double)pixels)))
        return GN_OK;
    const gn_light *light = &scene->lights[desc->light];
    const gn_light_frame frame = frame_of(light, desc->point_light_clip);
    size_t others;
    gn_light_buffer *buffer;
    GN_TRY(gn_history_reserve_light_buffer(history, scene, desc->light, &buffer, &others));
    const size_t limit = desc->light_buffer_limit > others ? desc->light_buffer_limit - others : 0;
    GN_TRY(gn_light_buffer_update(buffer, scene, &frame, automatic, limit));
    tracer->buffer = buffer;
    return GN_OK;
}

void gn_describe_tracer(const gn_tracer *tracer, gn_visibility_stats *stats)
{
    stats->tracer = tracer->buffer ? GN_TRACER_LIGHT_BUFFER : GN_TRACER_BVH;
    if (!tracer->buffer)
        return;
    stats->light_buffer = tracer->buffer->info;
    stats->light_buffer.tree_rays = tracer->buffer->tree_rays;
}
