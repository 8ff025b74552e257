/* Animation: glTF 2.0 channels, sampled at any time (specification, appendix C). */
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static const char *const path_names[] = {"translation", "rotation", "scale"};

static uint32_t component_count(gn_animation_path path)
{
    return path == GN_PATH_ROTATION ? 4 : 3;
}

static size_t value_count(const gn_channel_desc *desc)
{
    const size_t elements = desc->interpolation == GN_INTERPOLATION_CUBICSPLINE ? 3 : 1;
    return (size_t)desc->key_count * component_count(desc->path) * elements;
}

/* Sampling ----------------------------------------------------------------------------------- */

static bool normalize4(double q[4])
{
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 0))
        return false;
    for (int i = 0; i < 4; i++)
        q[i] /= length;
    return true;
}

/* Spherical interpolation of unit quaternions, the shorter way. */
static void slerp(const float *from, const float *to, double t, double result[4])
{
    double a[4], b[4], cosine = 0;
    for (int i = 0; i < 4; i++) {
        a[i] = from[i];
        b[i] = to[i];
    }
    normalize4(a);
    normalize4(b);
    for (int i = 0; i < 4; i++)
        cosine += a[i] * b[i];
    const double sign = cosine < 0 ? -1 : 1;
    const double angle = acos(fmin(fabs(cosine), 1));
    /* Nearly equal: the sines' ratio is that of the angles. */
    const double sine = sin(angle);
    const double wa = sine > 1e-9 ? sin((1 - t) * angle) / sine : 1 - t;
    const double wb = sine > 1e-9 ? sin(t * angle) / sine : t;
    for (int i = 0; i < 4; i++)
        result[i] = wa * a[i] + sign * wb * b[i];
}

/* The last key at or before seconds; times[0] <= seconds < times[count - 1]. */
static uint32_t find_key(const float *times, uint32_t count, double seconds)
{
    uint32_t low = 0, high = count - 1;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (times[middle] <= seconds)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void sample(const gn_channel_desc *desc, double seconds, double result[4])
{
    const uint32_t n = component_count(desc->path), last = desc->key_count - 1;
    const bool cubic = desc->interpolation == GN_INTERPOLATION_CUBICSPLINE;
    const uint32_t stride = cubic ? 3 * n : n;
    const float *values = desc->values + (cubic ? n : 0); /* past the first in-tangent */

    if (seconds <= desc->times[0] || seconds >= desc->times[last]) {
        const uint32_t key = seconds <= desc->times[0] ? 0 : last;
        for (uint32_t i = 0; i < n; i++)
            result[i] = values[(size_t)key * stride + i];
        return;
    }
    const uint32_t key = find_key(desc->times, desc->key_count, seconds);
    const float *from = values + (size_t)key * stride, *to = from + stride;
    const double interval = (double)desc->times[key + 1] - desc->times[key];
    const double t = (seconds - desc->times[key]) / interval;

    switch (desc->interpolation) {
    case GN_INTERPOLATION_STEP:
        for (uint32_t i = 0; i < n; i++)
            result[i] = from[i];
        break;
    case GN_INTERPOLATION_LINEAR:
        if (desc->path == GN_PATH_ROTATION)
            slerp(from, to, t, result);
        else
            for (uint32_t i = 0; i < n; i++)
                result[i] = from[i] + t * ((double)to[i] - from[i]);
        break;
    case GN_INTERPOLATION_CUBICSPLINE: {
        const float *out_tangent = from + n, *in_tangent = to - n;
        const double t2 = t * t, t3 = t2 * t;
        for (uint32_t i = 0; i < n; i++)
            result[i] = (2 * t3 - 3 * t2 + 1) * from[i] +
                        interval * (t3 - 2 * t2 + t) * out_tangent[i] + (-2 * t3 + 3 * t2) * to[i] +
                        interval * (t3 - t2) * in_tangent[i];
        break;
    }
    }
}

static void apply(gn_scene *scene, const gn_channel_desc *channel)
{
    gn_node *node = &scene->nodes[channel->node];
    double value[4];
    sample(channel, scene->time, value);
    float *target = channel->path == GN_PATH_TRANSLATION ? node->translation
                    : channel->path == GN_PATH_SCALE     ? node->scale
                                                         : node->rotation;
    /* A spline through opposite rotations can vanish: the rotation before stays. */
    if (channel->path == GN_PATH_ROTATION && !normalize4(value))
        return;
    for (uint32_t i = 0; i < component_count(channel->path); i++)
        target[i] = (float)value[i];
}

static void compose(gn_node *node)
{
    gn_compose(node->translation, node->rotation, node->scale, node->local);
}

gn_result gn_scene_set_time(gn_scene *scene, double seconds)
{
    if (!isfinite(seconds))
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT, "the time is not finite");
    scene->time = seconds;
    for (uint32_t i = 0; i < scene->channel_count; i++)
        apply(scene, &scene->channels[i].desc);
    for (uint32_t i = 0; i < scene->node_count; i++) {
        if (scene->nodes[i].paths != 0)
            compose(&scene->nodes[i]);
    }
    scene->edits++;
    return GN_OK;
}

/* Editing ------------------------------------------------------------------------------------ */

static gn_result check_keys(gn_scene *scene, const gn_channel_desc *desc, const gn_label *label)
{
    gn_context *context = scene->context;
    const uint32_t n = component_count(desc->path);
    const size_t stride = value_count(desc) / desc->key_count;
    const size_t first = desc->interpolation == GN_INTERPOLATION_CUBICSPLINE ? n : 0;
    for (uint32_t i = 0; i < desc->key_count; i++) {
        if (!isfinite(desc->times[i]) || desc->times[i] < 0 ||
            (i > 0 && desc->times[i] <= desc->times[i - 1]))
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "%s: time %u is %g, times must be finite, >= 0 and increasing",
                           label->text, i, (double)desc->times[i]);
        const float *value = desc->values + i * stride;
        if (!gn_all_finite(value, stride))
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: key %u is not finite",
                           label->text, i);
        value += first;
        if (desc->path == GN_PATH_ROTATION && value[0] == 0 && value[1] == 0 && value[2] == 0 &&
            value[3] == 0)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "%s: the rotation of key %u has no length", label->text, i);
    }
    return GN_OK;
}

static gn_result check_channel(gn_scene *scene, const gn_channel_desc *desc, const gn_label *label)
{
    gn_context *context = scene->context;
    if (desc->node >= scene->node_count)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: node %u does not exist, there are %u", label->text, desc->node,
                       scene->node_count);
    if ((unsigned)desc->path > GN_PATH_SCALE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: unknown path", label->text);
    if ((unsigned)desc->interpolation > GN_INTERPOLATION_CUBICSPLINE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: unknown interpolation",
                       label->text);
    const gn_node *node = &scene->nodes[desc->node];
    const gn_label node_label = gn_make_label("node", desc->node, node->name);
    if (node->desc.use_matrix)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s: %s has a matrix, and cannot be animated", label->text, node_label.text);
    if (node->paths & 1u << desc->path)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: the %s of %s is animated already",
                       label->text, path_names[desc->path], node_label.text);
    if (desc->key_count == 0 || !desc->times || !desc->values)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: no keys", label->text);
    return check_keys(scene, desc, label);
}

gn_result gn_scene_add_channel(gn_scene *scene, const gn_channel_desc *desc)
{
    gn_context *context = scene->context;
    GN_CHECK_DESC(context, desc, gn_channel_desc);
    const gn_label label = gn_make_label("channel", scene->channel_count, NULL);
    gn_result result = check_channel(scene, desc, &label);
    if (result != GN_OK)
        return result;

    gn_channel channel = {.desc = *desc};
    channel.desc.cookie = 0;
    float *times = gn_alloc_copy(context, desc->times, desc->key_count, sizeof *times);
    float *values = gn_alloc_copy(context, desc->values, value_count(desc), sizeof *values);
    if (!times || !values ||
        !gn_grow(context, (void **)&scene->channels, scene->channel_count, &scene->channel_capacity,
                 sizeof *scene->channels)) {
        gn_free(context, times);
        gn_free(context, values);
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", label.text);
    }
    channel.desc.times = times;
    channel.desc.values = values;
    scene->channels[scene->channel_count++] = channel;

    gn_node *node = &scene->nodes[desc->node];
    node->paths |= 1u << desc->path;
    node->animated = true;
    apply(scene, &channel.desc);
    compose(node);
    scene->edits++;
    return GN_OK;
}
