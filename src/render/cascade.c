#include "render/cascade.h"

#include <math.h>
#include <string.h>

/* The far end over the nearest place where the logarithmic split begins. Nearer levels would
 * sharpen the first centimetres at the cost of everything else. */
#define LOG_RANGE 1000.0

/* A level reaches further towards the light than it must, by this share of half its depth: what
 * is flattened onto its near end lies clearly before what it is meant for. */
#define FRONT 0.5

/* The least depth of a level as a share of its width. */
#define FLATTEST 0.02

/* A level that is so many times as wide as it would be placed now is placed anew. */
#define WASTEFUL 2.0

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static const gn_bounds empty = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void grow(gn_bounds *box, const double p[3])
{
    for (int i = 0; i < 3; i++) {
        box->low[i] = fmin(box->low[i], p[i]);
        box->high[i] = fmax(box->high[i], p[i]);
    }
}

static void corner_of(const gn_bounds *box, uint32_t corner, double p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = corner >> i & 1u ? box->high[i] : box->low[i];
}

static void to_axes(const gn_axes *axes, const double p[3], double q[3])
{
    const double x = dot(p, axes->right), y = dot(p, axes->up), z = dot(p, axes->forward);
    q[0] = x;
    q[1] = y;
    q[2] = z;
}

static gn_bounds box_in(const gn_axes *axes, const double origin[3], const gn_bounds *box)
{
    gn_bounds result = empty;
    for (uint32_t corner = 0; corner < 8; corner++) {
        double p[3];
        corner_of(box, corner, p);
        for (int i = 0; i < 3; i++)
            p[i] -= origin[i];
        to_axes(axes, p, p);
        grow(&result, p);
    }
    return result;
}

static const double nowhere[3] = {0, 0, 0}; /* the world's origin */

/* Frisvad 2012, whose one singular direction is turned to +Y: light from below. */
gn_axes gn_light_axes(const float direction[3])
{
    const double a = (double)direction[0], b = (double)direction[2], c = -(double)direction[1];
    const double s = c < 0.0 ? (a * a + b * b) / (1.0 - c) : 1.0 + c;
    double right[3] = {1, 0, 0}, down[3] = {0, -1, 0};
    if (s > 1e-12) {
        right[0] = 1.0 - a * a / s;
        right[1] = -a * b / s;
        right[2] = -a;
        down[0] = -a * b / s;
        down[1] = 1.0 - b * b / s;
        down[2] = -b;
    }
    gn_axes axes = {.right = {right[0], -right[2], right[1]},
                    .up = {-down[0], down[2], -down[1]},
                    .forward = {a, -c, b}};
    return axes;
}

/* What a camera sees -------------------------------------------------------------------------- */

typedef struct plane {
    double normal[3], offset; /* inside: dot(p, normal) + offset >= 0 */
} plane;

/* A convex polygon. Six cuts of a quad leave at most ten corners; rounding may add a few that
 * coincide. */
#define MAX_CORNERS 16u
typedef struct polygon {
    uint32_t count;
    double p[MAX_CORNERS][3];
} polygon;

static void cut(polygon *shape, const plane *by)
{
    const polygon from = *shape;
    uint32_t count = 0;
    for (uint32_t i = 0; i < from.count && count < MAX_CORNERS - 1; i++) {
        const double *a = from.p[i], *b = from.p[(i + 1) % from.count];
        const double da = dot(a, by->normal) + by->offset, db = dot(b, by->normal) + by->offset;
        if (da >= 0.0)
            memcpy(shape->p[count++], a, sizeof from.p[0]);
        if ((da >= 0.0) != (db >= 0.0)) {
            const double t = da / (da - db);
            for (int k = 0; k < 3; k++)
                shape->p[count][k] = a[k] + t * (b[k] - a[k]);
            count++;
        }
    }
    shape->count = count;
}

/* Six quads, by corners whose bits are sides along three axes. */
static const uint8_t quads[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                    {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};

/* Grows a box along axes by the part of a convex body's surface inside planes. */
static void add_surface(double corners[8][3], const plane planes[6], const gn_axes *axes,
                        gn_bounds *box)
{
    for (int face = 0; face < 6; face++) {
        polygon shape = {.count = 4};
        for (int i = 0; i < 4; i++)
            memcpy(shape.p[i], corners[quads[face][i]], sizeof shape.p[0]);
        for (int i = 0; i < 6 && shape.count > 0; i++)
            cut(&shape, &planes[i]);
        for (uint32_t i = 0; i < shape.count; i++) {
            double p[3];
            to_axes(axes, shape.p[i], p);
            grow(box, p);
        }
    }
}

/* The plane of dot(p - eye, normal) >= least. */
static plane plane_at(const double eye[3], const double normal[3], double least)
{
    plane made = {.offset = -dot(eye, normal) - least};
    memcpy(made.normal, normal, sizeof made.normal);
    return made;
}

/* The box along axes, through the world's origin, of the view from near to far inside bounds: of
 * the corners of both bodies' surfaces inside the other. */
static gn_bounds box_of_slice(const gn_cascades *c, double near, double far, const gn_axes *axes)
{
    double corners[8][3], bounds[8][3];
    plane slice[6], sides[6];
    for (uint32_t i = 0; i < 8; i++) {
        const double z = i & 4u ? far : near, scale = c->orthographic ? 1.0 : z;
        const double x = (i & 1u ? 1.0 : -1.0) * c->half_width * scale;
        const double y = (i & 2u ? 1.0 : -1.0) * c->half_height * scale;
        for (int k = 0; k < 3; k++)
            corners[i][k] =
                c->eye[k] + x * c->camera.right[k] + y * c->camera.up[k] + z * c->camera.forward[k];
        corner_of(&c->bounds, i, bounds[i]);
    }
    double back[3];
    for (int k = 0; k < 3; k++)
        back[k] = -c->camera.forward[k];
    slice[0] = plane_at(c->eye, c->camera.forward, near);
    slice[1] = plane_at(c->eye, back, -far);
    for (int side = 0; side < 4; side++) {
        const double *axis = side < 2 ? c->camera.right : c->camera.up;
        const double half = side < 2 ? c->half_width : c->half_height;
        double normal[3];
        for (int k = 0; k < 3; k++)
            normal[k] = (side & 1 ? -axis[k] : axis[k]) +
                        (c->orthographic ? 0.0 : half * c->camera.forward[k]);
        slice[2 + side] = plane_at(c->eye, normal, c->orthographic ? -half : 0.0);
    }
    for (int k = 0; k < 3; k++) {
        sides[k] = (plane){.offset = -c->bounds.low[k]};
        sides[3 + k] = (plane){.offset = c->bounds.high[k]};
        sides[k].normal[k] = 1.0;
        sides[3 + k].normal[k] = -1.0;
    }
    gn_bounds box = empty;
    add_surface(corners, sides, axes, &box);
    add_surface(bounds, slice, axes, &box);
    return box;
}

/* Slices -------------------------------------------------------------------------------------- */

/* The power of 2^(1/4), times `unit`, next to x > 0, not below it (up) or not above it. By tables:
 * the same everywhere. */
static double round_to_step(double x, double unit, bool up)
{
    static const double steps[5] = {0.5, 0.5946035575013605, 0.7071067811865476, 0.8408964152537145,
                                    1.0};
    int exponent;
    const double mantissa = frexp(x / unit, &exponent);
    int step = 0;
    while (step < 4 && steps[step + 1] <= mantissa)
        step++;
    if (up && steps[step] < mantissa)
        step++;
    return unit * ldexp(steps[step], exponent);
}

static void split(gn_cascades *c, double near, double far, double seen_far, const gn_map_desc *desc)
{
    const double begin = fmax(near, far / LOG_RANGE);
    const double split = desc->split_weight < 0.0f ? 0.85 : (double)desc->split_weight;
    const double weight = c->orthographic ? 0.0 : split;
    c->ends[0] = near;
    for (uint32_t i = 1; i <= desc->cascades; i++) {
        const double t = (double)i / desc->cascades;
        const double even = near + (far - near) * t, logarithmic = begin * pow(far / begin, t);
        const double end = desc->split_count > 0 ? far * (double)desc->splits[i - 1]
                           : i == desc->cascades ? far
                                                 : even + weight * (logarithmic - even);
        c->ends[i] = fmax(end, c->ends[i - 1]);
    }
    while (c->count < desc->cascades && c->ends[c->count] < seen_far)
        c->count++;
}

static double magnitude(const gn_bounds *box)
{
    double largest = 0.0;
    for (int i = 0; i < 3; i++)
        largest = fmax(largest, fmax(fabs(box->low[i]), fabs(box->high[i])));
    return largest;
}

/* The scene's bounds, larger by what positions in floats may be off. */
static gn_bounds bounds_of(const float bounds_min[3], const float bounds_max[3])
{
    gn_bounds box;
    for (int i = 0; i < 3; i++) {
        box.low[i] = (double)bounds_min[i];
        box.high[i] = (double)bounds_max[i];
    }
    const double off = 2e-6 * magnitude(&box);
    for (int i = 0; i < 3; i++) {
        box.low[i] -= off;
        box.high[i] += off;
    }
    return box;
}

gn_cascades gn_cascades_make(const gn_camera *camera, float aspect, const float bounds_min[3],
                             const float bounds_max[3], bool moving, const float direction[3],
                             const gn_map_desc *desc, uint32_t margin)
{
    gn_cascades c = {.light = gn_light_axes(direction),
                     .orthographic = camera->desc.orthographic,
                     .bounds = bounds_of(bounds_min, bounds_max),
                     .slack = moving ? (double)desc->enlarge : 0.0,
                     .enlarge = (double)desc->enlarge,
                     .resolution = desc->resolution,
                     .margin = margin};
    c.half_height =
        c.orthographic ? (double)camera->desc.ymag : tan(0.5 * (double)camera->desc.yfov);
    c.half_width = c.half_height * (double)aspect;
    for (int i = 0; i < 3; i++) {
        c.camera.right[i] = (double)camera->world[i];
        c.camera.up[i] = (double)camera->world[4 + i];
        c.camera.forward[i] = -(double)camera->world[8 + i];
        c.eye[i] = (double)camera->world[12 + i];
    }
    memcpy(c.direction, direction, sizeof c.direction);
    c.scene = box_in(&c.light, nowhere, &c.bounds);

    const double begin = (double)camera->desc.znear;
    const double end = box_in(&c.camera, c.eye, &c.bounds).high[2];
    if (!(end > begin))
        return c;
    const gn_bounds seen = box_of_slice(&c, begin, end, &c.camera);
    const double offset = dot(c.eye, c.camera.forward);
    const double seen_near = seen.low[2] - offset, seen_far = fmin(seen.high[2] - offset, end);
    /* A length that is the camera's, so that a scene in other units has the same cascades: a metre
     * where the near plane is at 0.1. One that begins at the eye has none. */
    const double unit = c.orthographic ? c.half_height : begin > 0.0 ? 10.0 * begin : 1.0;
    const double far = desc->distance > 0.0f ? (double)desc->distance
                                             : round_to_step(fmax(seen_far, 1e-30), unit, true);
    const double near =
        seen_near > begin ? fmax(begin, round_to_step(seen_near, unit, false)) : begin;
    if (seen_near <= seen_far && near < far)
        split(&c, near, far, seen_far, desc);
    return c;
}

gn_cascades gn_cascades_turned(const gn_cascades *c, const float direction[3])
{
    gn_cascades turned = *c;
    memcpy(turned.direction, direction, sizeof turned.direction);
    turned.light = gn_light_axes(direction);
    turned.scene = box_in(&turned.light, nowhere, &turned.bounds);
    return turned;
}

gn_bounds gn_cascade_need(const gn_cascades *c, uint32_t i)
{
    return box_of_slice(c, c->ends[i], c->ends[i + 1], &c->light);
}

/* Levels -------------------------------------------------------------------------------------- */

/* The radius of the smallest sphere around a slice of the view. */
static double radius_of(const gn_cascades *c, double near, double far)
{
    const double corner = hypot(c->half_width, c->half_height);
    if (c->orthographic)
        return hypot(corner, 0.5 * (far - near));
    /* Its centre is as far from the near corners as from the far ones, or in the far plane. */
    const double center = fmin(0.5 * (near + far) * (1.0 + corner * corner), far);
    return hypot(far - center, far * corner);
}

/* The middle of `of`, moved so that `half` to both sides of it lies inside `inside`, or the middle
 * of that where it is too small. */
static double place(double of_low, double of_high, double half, double inside_low,
                    double inside_high)
{
    const double middle = 0.5 * (inside_low + inside_high);
    if (2.0 * half >= inside_high - inside_low || of_low > of_high)
        return middle;
    return fmin(fmax(0.5 * (of_low + of_high), inside_low + half), inside_high - half);
}

/* Half the side of a square of light space that holds the scene. */
static double scene_half(const gn_cascades *c)
{
    const double width = c->scene.high[0] - c->scene.low[0];
    const double height = c->scene.high[1] - c->scene.low[1];
    return 0.5 * fmax(width, height) * (1.0 + c->slack);
}

/* Half the side of the square that level i is to hold. */
static double level_half(const gn_cascades *c, uint32_t i)
{
    return fmin(radius_of(c, c->ends[i], c->ends[i + 1]) * (1.0 + c->enlarge), scene_half(c));
}

/* Sides with and without the margin; a texel more is kept for the grid and for rounding. */
static double usable_share(uint32_t resolution, uint32_t margin)
{
    return 1.0 - 2.0 * (margin + 1.0) / resolution;
}

/* A level in the middle of `need`. */
static gn_cascade fit(const gn_cascades *c, double half, gn_bounds need)
{
    gn_cascade made = {.whole = half >= scene_half(c)};
    memcpy(made.direction, c->direction, sizeof made.direction);
    gn_map_projection *p = &made.projection;
    p->resolution = c->resolution;
    p->extent = (float)(half / usable_share(c->resolution, c->margin));
    const double texel = 2.0 * (double)p->extent / c->resolution;
    double center[3], reach = half; /* half of what it holds along the light */
    for (int axis = 0; axis < 2; axis++)
        center[axis] = round(place(need.low[axis], need.high[axis], half, c->scene.low[axis],
                                   c->scene.high[axis]) /
                             texel) *
                       texel;
    const double scene_reach =
        fmax(0.5 * (c->scene.high[2] - c->scene.low[2]) * (1.0 + c->slack), FLATTEST * half);
    const bool deep = made.whole || (1.0 + 0.5 * FRONT) * reach >= scene_reach;
    if (deep)
        reach = scene_reach;
    center[2] = place(need.low[2], need.high[2], reach, c->scene.low[2], c->scene.high[2]);
    /* The box is where the projection is, after its origin is rounded to floats. */
    const double front = reach * (deep ? 1.02 : 1.0 + FRONT);
    double origin[3];
    for (int k = 0; k < 3; k++) {
        p->right[k] = (float)c->light.right[k];
        p->up[k] = (float)c->light.up[k];
        p->forward[k] = (float)c->light.forward[k];
        p->origin[k] = (float)(center[0] * c->light.right[k] + center[1] * c->light.up[k] +
                               (center[2] - front) * c->light.forward[k]);
        origin[k] = (double)p->origin[k];
    }
    p->near = 0.0f;
    p->far = (float)(front + 1.02 * reach);
    to_axes(&c->light, origin, center);
    const double side = (double)p->extent - (c->margin + 0.25) * texel;
    for (int axis = 0; axis < 2; axis++) {
        made.box.low[axis] = center[axis] - side;
        made.box.high[axis] = center[axis] + side;
    }
    made.box.low[2] = center[2] + (front - reach) - 0.01 * reach;
    made.box.high[2] = center[2] + (front + reach) + 0.01 * reach;
    return made;
}

gn_cascade gn_cascade_fit(const gn_cascades *c, uint32_t i)
{
    return fit(c, level_half(c, i), gn_cascade_need(c, i));
}

static bool is_nothing(const gn_bounds *box)
{
    return box->low[0] > box->high[0];
}

static bool meets(const gn_bounds *a, const gn_bounds *b)
{
    bool meet = true;
    for (int axis = 0; axis < 3; axis++)
        meet = meet && a->low[axis] <= b->high[axis] && b->low[axis] <= a->high[axis];
    return meet;
}

gn_cascade gn_cascade_fit_ahead(const gn_cascades *c, const gn_cascades *ahead, uint32_t i)
{
    const gn_bounds need = gn_cascade_need(c, i), then = gn_cascade_need(ahead, i);
    if (i >= ahead->count || is_nothing(&need) || is_nothing(&then))
        return gn_cascade_fit(c, i);
    /* Of a jump nothing follows: the level must be of use now. */
    const double least = level_half(c, i), most = fmax(least, level_half(ahead, i));
    const double half = most < WASTEFUL * least ? most : least;
    const gn_cascade here = fit(c, half, need);
    if (!meets(&here.box, &then))
        return gn_cascade_fit(c, i);
    gn_bounds moved = need;
    for (int axis = 0; axis < 3; axis++) {
        const double by =
            0.5 * (then.low[axis] + then.high[axis]) - 0.5 * (need.low[axis] + need.high[axis]);
        /* A texel less: levels lie on the grid. */
        const double texel = 2.0 * (double)here.projection.extent / c->resolution;
        const double back = fmax(here.box.high[axis] - need.high[axis] - texel, 0.0);
        const double forth = fmax(need.low[axis] - here.box.low[axis] - texel, 0.0);
        const double shift = fmin(fmax(by, -back), forth);
        moved.low[axis] += shift;
        moved.high[axis] += shift;
    }
    return fit(c, half, moved);
}

static gn_bounds need_under(const gn_cascade *placed, const gn_cascades *c, uint32_t i)
{
    if (memcmp(placed->direction, c->direction, sizeof c->direction) == 0)
        return gn_cascade_need(c, i);
    const gn_cascades turned = gn_cascades_turned(c, placed->direction);
    return gn_cascade_need(&turned, i);
}

bool gn_cascade_serves(const gn_cascade *placed, const gn_cascades *c, uint32_t i)
{
    const double largest = WASTEFUL * level_half(c, i) / usable_share(c->resolution, c->margin);
    const gn_bounds need = need_under(placed, c, i);
    bool holds = (double)placed->projection.extent < largest;
    for (int axis = 0; axis < 3; axis++)
        holds = holds &&
                (need.low[axis] > need.high[axis] || (need.low[axis] >= placed->box.low[axis] &&
                                                      need.high[axis] <= placed->box.high[axis]));
    return holds;
}

bool gn_cascade_meets(const gn_cascade *placed, const gn_cascades *c, uint32_t i)
{
    const gn_bounds need = need_under(placed, c, i);
    return is_nothing(&need) || meets(&placed->box, &need);
}

double gn_cascade_shift(const gn_cascade *placed, const gn_cascades *c, const float direction[3])
{
    double from[3], to[3], across[3], reach = INFINITY;
    for (int i = 0; i < 3; i++) {
        from[i] = (double)placed->direction[i];
        to[i] = (double)direction[i];
        /* A line along the light lies in the bounds for so long at most. */
        if (from[i] != 0.0)
            reach = fmin(reach, (c->bounds.high[i] - c->bounds.low[i]) / fabs(from[i]));
    }
    cross(from, to, across);
    const double cosine = dot(from, to), sine = sqrt(dot(across, across));
    if (!(cosine > 0.0))
        return INFINITY;
    return reach * sine / cosine * c->resolution / (2.0 * (double)placed->projection.extent);
}

/* Lamps --------------------------------------------------------------------------------------- */

static gn_map_projection lamp_face(const gn_light *light, const gn_axes *axes, double extent,
                                   double near, double far, uint32_t resolution)
{
    gn_map_projection p = {.perspective = true,
                           .extent = (float)extent,
                           .near = (float)near,
                           .far = (float)far,
                           .resolution = resolution};
    for (int k = 0; k < 3; k++) {
        p.origin[k] = light->position[k];
        p.right[k] = (float)axes->right[k];
        p.up[k] = (float)axes->up[k];
        p.forward[k] = (float)axes->forward[k];
    }
    return p;
}

/* +X -X +Y -Y +Z -Z. */
static gn_axes cube_axes(uint32_t face)
{
    gn_axes axes = {.forward = {0, 0, 0}, .up = {0, 1, 0}};
    axes.forward[face / 2] = face & 1u ? -1.0 : 1.0;
    if (face / 2 == 1)
        memcpy(axes.up, (double[3]){0, 0, 1}, sizeof axes.up);
    cross(axes.forward, axes.up, axes.right);
    return axes;
}

gn_lamp gn_lamp_make(const gn_light *light, const float bounds_min[3], const float bounds_max[3],
                     bool moving, const gn_map_desc *desc, uint32_t margin)
{
    const bool cube = light->desc.type == GN_LIGHT_POINT ||
                      (double)light->desc.outer_cone_angle > GN_SPOT_MAX_ANGLE;
    const gn_bounds bounds = bounds_of(bounds_min, bounds_max);
    const gn_axes axes = cube ? cube_axes(0) : gn_light_axes(light->direction);
    const double position[3] = {(double)light->position[0], (double)light->position[1],
                                (double)light->position[2]};
    gn_bounds box = box_in(&axes, position, &bounds);
    double nearest = 0.0, farthest = 0.0;
    if (cube) {
        for (int i = 0; i < 3; i++) {
            nearest = fmax(nearest, fmax(box.low[i], -box.high[i]));
            farthest = fmax(farthest, fmax(-box.low[i], box.high[i]));
        }
    } else {
        nearest = fmax(box.low[2], 0.0);
        farthest = box.high[2] > 0.0 ? box.high[2] : magnitude(&box);
    }
    gn_lamp lamp = {.count = cube ? 6 : 1};
    /* Depth is linear, so that a near end close to the light costs nothing. */
    lamp.far = fmax(fmin(farthest, (double)light->desc.range), 1e-30);
    lamp.near = fmin(fmax(nearest, 1e-4 * lamp.far), 0.5 * lamp.far);
    const double slack = 1.01 + (moving ? (double)desc->enlarge : 0.0);
    /* Receivers at the border of a cone move outwards with their bias, in wide cones by more texels
     * than along their normal; faces of a cube hold them wherever they move. */
    const double half = (cube ? 1.0 : 1.03 * tan((double)light->desc.outer_cone_angle)) /
                        usable_share(desc->resolution, margin);
    for (uint32_t face = 0; face < lamp.count; face++) {
        const gn_axes of_face = cube ? cube_axes(face) : axes;
        lamp.faces[face] =
            lamp_face(light, &of_face, half, lamp.near / slack, lamp.far * slack, desc->resolution);
    }
    return lamp;
}

bool gn_lamp_serves(const gn_map_projection *placed, const gn_lamp *now)
{
    return (double)placed->near <= now->near && (double)placed->far >= now->far &&
           (double)placed->far <= WASTEFUL * now->far;
}

bool gn_projection_sees(const gn_map_projection *p, const gn_bounds *box)
{
    bool outside[6] = {true, true, true, true, true, p->perspective};
    for (uint32_t corner = 0; corner < 8; corner++) {
        double q[3], x = 0.0, y = 0.0, w = 0.0;
        corner_of(box, corner, q);
        for (int k = 0; k < 3; k++) {
            const double d = q[k] - (double)p->origin[k];
            x += d * (double)p->right[k];
            y += d * (double)p->up[k];
            w += d * (double)p->forward[k];
        }
        const double side = (double)p->extent * (p->perspective ? w : 1.0);
        outside[0] = outside[0] && x < -side;
        outside[1] = outside[1] && x > side;
        outside[2] = outside[2] && y < -side;
        outside[3] = outside[3] && y > side;
        outside[4] = outside[4] && w > (double)p->far;
        outside[5] = outside[5] && w < (double)p->near;
    }
    bool sees = true;
    for (int side = 0; side < 6; side++)
        sees = sees && !outside[side];
    return sees;
}
