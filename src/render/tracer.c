#include "render/tracer.h"

#include <math.h>
#include <string.h>

#include "render/cascade.h"
#include "render/device.h"

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

gn_result gn_choose_tracer(const gn_scene *scene, const gn_visibility_desc *desc,
                           gn_history *history, gn_tracer *tracer)
{
    *tracer = (gn_tracer){.accel = scene->accel};
    if (desc->tracer != GN_TRACER_LIGHT_BUFFER)
        return GN_OK;
    const gn_light *light = &scene->lights[desc->light];
    const gn_light_frame frame = frame_of(light, desc->point_light_clip);
    size_t others;
    gn_light_buffer *buffer;
    GN_TRY(gn_history_reserve_light_buffer(history, scene, desc->light, &buffer, &others));
    const size_t limit = desc->light_buffer_limit > others ? desc->light_buffer_limit - others : 0;
    GN_TRY(gn_light_buffer_update(buffer, scene, &frame, limit));
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
