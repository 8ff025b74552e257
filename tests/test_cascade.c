/* Fitting of cascades and lamps: what is in view is held, texels stay on their grid. */
#include "render_testing.h"

#include "render/cascade.h"

#define MARGIN     6u
#define RESOLUTION 1024u

/* A city block: wide, flat, off the origin. */
static const float city_min[3] = {-180, -2, -140}, city_max[3] = {220, 40, 260};

static double uniform(void)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

static double between(double low, double high)
{
    return low + uniform() * (high - low);
}

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g, expected %.9g within %g", value, expected, tolerance);
}

static gn_camera camera_at(vec eye, vec target, double yfov, double znear)
{
    gn_camera camera = {.desc = gn_camera_desc_default()};
    camera.desc.yfov = (float)yfov;
    camera.desc.znear = (float)znear;
    aim(eye, target, camera.world);
    return camera;
}

static gn_map_desc desc_for(uint32_t cascades)
{
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = RESOLUTION;
    desc.cascades = cascades;
    return desc;
}

static void direction_of(vec d, float direction[3])
{
    d = unit(d);
    direction[0] = (float)d.x;
    direction[1] = (float)d.y;
    direction[2] = (float)d.z;
}

static gn_cascades cascades_of(const gn_camera *camera, const float low[3], const float high[3],
                               vec light, const gn_map_desc *desc)
{
    float direction[3];
    direction_of(light, direction);
    return gn_cascades_make(camera, 16.0f / 9.0f, low, high, false, direction, desc, MARGIN);
}

/* Where a layer has a point, by the formulas of gn_map_layer_info: column, row, depth. */
static vec place_in(const gn_map_projection *p, vec point)
{
    double q[3] = {0, 0, 0};
    const double d[3] = {point.x - (double)p->origin[0], point.y - (double)p->origin[1],
                         point.z - (double)p->origin[2]};
    for (int k = 0; k < 3; k++) {
        q[0] += d[k] * (double)p->right[k];
        q[1] += d[k] * (double)p->up[k];
        q[2] += d[k] * (double)p->forward[k];
    }
    const double w = p->perspective ? q[2] : 1, e = (double)p->extent;
    if (w <= 0)
        return v3(-1, -1, -1);
    return v3((q[0] / w / e + 1) / 2 * p->resolution, (1 - q[1] / w / e) / 2 * p->resolution,
              (q[2] - (double)p->near) / ((double)p->far - (double)p->near));
}

static bool holds(const gn_map_projection *p, vec point)
{
    const vec t = place_in(p, point);
    const double end = (double)p->resolution - MARGIN;
    return t.x >= MARGIN && t.x <= end && t.y >= MARGIN && t.y <= end && t.z >= 0 && t.z <= 1;
}

/* A point in view at a depth, or outside where the bounds end before. */
static vec point_in_view(const gn_camera *camera, double aspect, double depth)
{
    const double half = camera->desc.orthographic ? (double)camera->desc.ymag
                                                  : depth * tan((double)camera->desc.yfov / 2);
    return transform(camera->world,
                     v3(between(-1, 1) * half * aspect, between(-1, 1) * half, -depth));
}

static bool inside(const float low[3], const float high[3], vec p)
{
    return p.x >= (double)low[0] && p.x <= (double)high[0] && p.y >= (double)low[1] &&
           p.y <= (double)high[1] && p.z >= (double)low[2] && p.z <= (double)high[2];
}

/* Levels as a map keeps them. */
typedef struct levels {
    gn_cascade at[GN_MAX_CASCADES];
    bool placed[GN_MAX_CASCADES];
    uint32_t count, fitted;
} levels;

static void update(levels *l, const gn_cascades *c)
{
    l->fitted = 0;
    l->count = 0;
    while (l->count < c->count) {
        const uint32_t i = l->count++;
        if (!l->placed[i] || !gn_cascade_serves(&l->at[i], c, i)) {
            l->at[i] = gn_cascade_fit(c, i);
            l->placed[i] = true;
            l->fitted++;
        }
        if (l->at[i].whole)
            break;
    }
}

/* Every point in view and in the bounds, up to the distance, lies in a level: its slice's, or one
 * before. Returns how many points were looked at. */
static uint32_t check_held(const levels *l, const gn_cascades *c, const gn_camera *camera,
                           const float low[3], const float high[3], uint32_t points,
                           const char *what)
{
    uint32_t seen = 0;
    const double near = c->ends[0], far = c->ends[c->count];
    for (uint32_t n = 0; n < points; n++) {
        const double depth =
            n % 2 ? near * pow(far / fmax(near, 1e-3), uniform()) : between(near, far);
        const vec p = point_in_view(camera, 16.0 / 9.0, depth);
        if (depth > far || depth < near || !inside(low, high, p))
            continue;
        seen++;
        uint32_t slice = 0, level = 0;
        while (slice + 1 < l->count && depth > c->ends[slice + 1])
            slice++;
        while (level < l->count && !holds(&l->at[level].projection, p))
            level++;
        if (level > slice)
            fail_msg("%s: a point at depth %g of slice %u is held by level %u of %u", what, depth,
                     slice, level, l->count);
    }
    return seen;
}

/* -------------------------------------------------------------------------------------------- */

static void test_axes_are_orthonormal_and_smooth(void **state)
{
    (void)state;
    for (int n = 0; n < 2000; n++) {
        const vec d = n == 0   ? v3(0, -1, 0)
                      : n == 1 ? v3(0, 1, 0)
                      : n == 2 ? v3(1e-9, 1, -1e-9)
                               : v3(between(-1, 1), between(-1, 1), between(-1, 1));
        float direction[3];
        direction_of(d, direction);
        const gn_axes a = gn_light_axes(direction);
        const vec right = v3(a.right[0], a.right[1], a.right[2]),
                  up = v3(a.up[0], a.up[1], a.up[2]),
                  forward = v3(a.forward[0], a.forward[1], a.forward[2]);
        assert_near(length(right), 1, 1e-6);
        assert_near(length(up), 1, 1e-6);
        assert_near(dot(right, up), 0, 1e-6);
        assert_near(length(add(cross(right, up), forward)), 0, 1e-6);
    }
    /* A sun that goes through the zenith: steps of 0.1 degrees turn the axes by little more. */
    gn_axes before = {{0}, {0}, {0}};
    for (int step = -300; step <= 300; step++) {
        const double tilt = step * 0.1 * atan(1) / 45;
        float direction[3];
        direction_of(v3(sin(tilt) * 0.8, -cos(tilt), sin(tilt) * 0.6), direction);
        const gn_axes a = gn_light_axes(direction);
        for (int k = 0; step > -300 && k < 3; k++)
            assert_near(a.right[k], before.right[k], 0.004);
        before = a;
    }
}

static void test_splits(void **state)
{
    (void)state;
    const gn_camera camera = camera_at(v3(0, 2, 0), v3(0, 2, -10), 1, 0.5);
    gn_map_desc desc = desc_for(4);
    desc.distance = 100;
    desc.split_weight = 0;
    gn_cascades c = cascades_of(&camera, city_min, city_max, v3(0.3, -1, 0.2), &desc);
    assert_int_equal(c.count, 4);
    for (uint32_t i = 0; i <= 4; i++)
        assert_near(c.ends[i], 0.5 + 99.5 * i / 4, 1e-9);
    desc.split_weight = 1;
    c = cascades_of(&camera, city_min, city_max, v3(0.3, -1, 0.2), &desc);
    for (uint32_t i = 0; i <= 4; i++)
        assert_near(c.ends[i], 0.5 * pow(200, i / 4.0), 1e-9);
    desc.split_weight = 0.25f;
    c = cascades_of(&camera, city_min, city_max, v3(0.3, -1, 0.2), &desc);
    assert_near(c.ends[2], 0.75 * 50.25 + 0.25 * 0.5 * pow(200, 0.5), 1e-6);
    desc.split_count = 4;
    memcpy(desc.splits, (float[]){0.0625f, 0.125f, 0.5f, 1}, 4 * sizeof(float));
    c = cascades_of(&camera, city_min, city_max, v3(0.3, -1, 0.2), &desc);
    assert_near(c.ends[1], 6.25, 1e-9);
    assert_near(c.ends[3], 50, 1e-9);
    assert_near(c.ends[4], 100, 1e-9);
    /* Without a distance: the farthest corner in view, at most a step beyond. */
    desc = desc_for(4);
    c = cascades_of(&camera, city_min, city_max, v3(0.3, -1, 0.2), &desc);
    if (!(c.ends[4] >= 140 && c.ends[4] < 140 * 1.1893))
        fail_msg("the last level ends at %g m, the scene at 140", c.ends[4]);
    /* From outside: the first level begins at the scene. */
    const gn_camera outside = camera_at(v3(0, 20, 1260), v3(0, 20, 0), 0.5, 0.1);
    c = cascades_of(&outside, city_min, city_max, v3(0.3, -1, 0.2), &desc);
    if (!(c.ends[0] <= 1000 && c.ends[0] > 1000 / 1.1893))
        fail_msg("the first level begins at %g m, the scene at 1000", c.ends[0]);
}

static void test_whatever_is_in_view_is_held(void **state)
{
    (void)state;
    uint32_t seen = 0;
    for (int n = 0; n < 300; n++) {
        const vec eye = v3(between(-300, 300), between(0, 60), between(-300, 300));
        gn_camera camera =
            camera_at(eye, v3(between(-150, 200), between(-2, 40), between(-100, 200)),
                      between(0.2, 2), n % 7 == 0 ? 0 : between(0.01, 1));
        if (n % 4 == 3) {
            camera.desc.orthographic = true;
            camera.desc.ymag = (float)between(1, 100);
        }
        gn_map_desc desc = desc_for(1 + (uint32_t)n % 8);
        desc.distance = n % 3 ? 0 : (float)between(1, 400);
        desc.enlarge = n % 2 ? 0.15f : 0;
        const vec light = n % 5 == 0   ? v3(0, -1, 0)
                          : n % 5 == 1 ? v3(0, 1, 0)
                                       : v3(between(-1, 1), between(-1, 0), between(-1, 1));
        const gn_cascades c = cascades_of(&camera, city_min, city_max, light, &desc);
        levels l = {.count = 0};
        update(&l, &c);
        if (l.count > 0)
            seen += check_held(&l, &c, &camera, city_min, city_max, 400, "any camera");
        for (uint32_t i = 0; i < l.count; i++) {
            /* What was placed for a view serves it. */
            assert_true(gn_cascade_serves(&l.at[i], &c, i));
            if (i + 1 < l.count)
                assert_false(l.at[i].whole);
        }
    }
    print_message("%u points in view were held\n", seen);
    assert_true(seen > 20000);
}

/* No level is larger than the scene's square, and one that is ends the chain. */
static void test_no_level_is_larger_than_the_scene(void **state)
{
    (void)state;
    const gn_map_desc desc = desc_for(4);
    const gn_camera camera = camera_at(v3(500, 30, 900), v3(0, 0, 0), 1, 0.1);
    const gn_cascades c = cascades_of(&camera, city_min, city_max, v3(0, -1, 0), &desc);
    levels l = {.count = 0};
    update(&l, &c);
    assert_true(l.count >= 1 && l.at[l.count - 1].whole);
    for (uint32_t i = 0; i < l.count; i++) {
        const double usable =
            (double)l.at[i].projection.extent * (1 - 2.0 * (MARGIN + 1) / RESOLUTION);
        if (usable > 200.1)
            fail_msg("level %u holds %g m to each side, the scene 200", i, usable);
    }
}

/* A walk with turns: levels are kept while they hold their slice; those placed anew have their
 * texels on the same grid. */
static void test_texels_do_not_swim(void **state)
{
    (void)state;
    gn_map_desc desc = desc_for(4);
    desc.distance = 120;
    levels l = {.count = 0}, before;
    uint32_t fits = 0, moved = 0, frames = 600, seen = 0;
    for (uint32_t n = 0; n < frames; n++) {
        const double t = n / 60.0; /* seconds: 1.4 m/s, turning */
        const vec eye = v3(20 + 1.4 * t, 1.7, 60 - 1.1 * t);
        const vec ahead = v3(sin(0.5 * sin(t)), -0.1, -cos(0.5 * sin(t)));
        const gn_camera camera = camera_at(eye, add(eye, ahead), 1, 0.1);
        const gn_cascades c = cascades_of(&camera, city_min, city_max, v3(0.4, -1, 0.3), &desc);
        before = l;
        update(&l, &c);
        fits += l.fitted;
        for (uint32_t i = 0; n > 0 && i < l.count; i++) {
            const gn_map_projection *p = &l.at[i].projection, *q = &before.at[i].projection;
            if (memcmp(&before.at[i], &l.at[i], sizeof l.at[i]) == 0)
                continue;
            moved++;
            assert_memory_equal(p->right, q->right, sizeof p->right);
            assert_memory_equal(p->up, q->up, sizeof p->up);
            assert_true(p->extent == q->extent);
            /* The centre of a texel of the new grid, in texels of the old one. */
            const double texel = (double)gn_map_texel_size(p, 1);
            vec corner = v3((double)p->origin[0], (double)p->origin[1], (double)p->origin[2]);
            corner =
                add(corner, mul(v3((double)p->right[0], (double)p->right[1], (double)p->right[2]),
                                (10.5 - RESOLUTION / 2.0) * texel));
            const vec there = place_in(q, corner);
            if (fabs(there.x - floor(there.x) - 0.5) > 0.02 ||
                fabs(there.y - round(there.y)) > 0.02)
                fail_msg("frame %u level %u: texels moved to %g, %g", n, i, there.x, there.y);
        }
        seen += check_held(&l, &c, &camera, city_min, city_max, 60, "on the way");
    }
    print_message("%u levels, %u frames: %u were placed, %u of them anew; %u points held\n",
                  l.count, frames, fits, moved, seen);
    assert_int_equal(l.count, 4);
    assert_true(moved > 3 && fits < frames * l.count / 20);
}

static void test_turning_around_in_one_frame(void **state)
{
    (void)state;
    const gn_map_desc desc = desc_for(4);
    levels l = {.count = 0};
    for (int turn = 0; turn < 4; turn++) {
        const vec eye = v3(10, 3, 20);
        const gn_camera camera = camera_at(eye, add(eye, v3(turn % 2 ? 1 : -1, -0.1, 0.3)), 1, 0.1);
        const gn_cascades c = cascades_of(&camera, city_min, city_max, v3(0.4, -1, 0.3), &desc);
        update(&l, &c);
        assert_true(l.fitted > 0);
        assert_true(check_held(&l, &c, &camera, city_min, city_max, 2000, "turned") > 100);
    }
}

/* Coming closer to the ground shrinks what is asked for: a level twice too large is placed anew. */
static void test_levels_that_became_too_large_are_placed_anew(void **state)
{
    (void)state;
    const gn_map_desc desc = desc_for(1);
    levels l = {.count = 0};
    float extents[2];
    for (int n = 0; n < 2; n++) {
        const double height = n ? 4 : 100;
        const gn_camera camera = camera_at(v3(0, height, 0), v3(0, 0, 0.1), 0.8, 0.1);
        static const float low[3] = {-200, 0, -200}, high[3] = {200, 0, 200};
        const gn_cascades c = cascades_of(&camera, low, high, v3(0.2, -1, 0), &desc);
        update(&l, &c);
        assert_int_equal(l.fitted, 1);
        extents[n] = l.at[0].projection.extent;
    }
    print_message("from 100 m: %g m, from 4 m: %g m\n", (double)extents[0], (double)extents[1]);
    assert_true(extents[1] < 0.1f * extents[0]);
}

static void test_far_is_1e5_times_near(void **state)
{
    (void)state;
    static const float low[3] = {-3000, 0, -3000}, high[3] = {3000, 80, 3000};
    const gn_camera camera = camera_at(v3(0, 2, 0), v3(100, 2, 30), 1, 0.01);
    gn_map_desc desc = desc_for(4);
    desc.distance = 1000;
    const gn_cascades c = cascades_of(&camera, low, high, v3(0.5, -1, 0.2), &desc);
    levels l = {.count = 0};
    update(&l, &c);
    assert_int_equal(l.count, 4);
    assert_true(check_held(&l, &c, &camera, low, high, 4000, "far away") > 1000);
    for (uint32_t i = 0; i < l.count; i++)
        print_message("level %u: to %g m, %g texels a metre, %g m deep\n", i, c.ends[i + 1],
                      1.0 / (double)gn_map_texel_size(&l.at[i].projection, 1),
                      (double)l.at[i].projection.far);
    if (!(c.ends[1] > 2 && c.ends[1] < 100))
        fail_msg("the first level ends at %g m", c.ends[1]);
    /* The first level's depth does not span the whole city. */
    assert_true(l.at[0].projection.far < 10 * l.at[0].projection.extent);
}

/* A scene a thousand times as large, in steps that floats hold exactly, has levels a thousand times
 * as large, to the bit. */
static void test_nothing_depends_on_the_unit(void **state)
{
    (void)state;
    for (int exponent = -20; exponent <= 20; exponent += 10) {
        const double s = ldexp(1, exponent);
        float low[3], high[3];
        for (int k = 0; k < 3; k++) {
            low[k] = (float)(s * (double)city_min[k]);
            high[k] = (float)(s * (double)city_max[k]);
        }
        const gn_camera one = camera_at(v3(8, 2, 4), v3(40, 1, -100), 1, 0.125);
        gn_camera other = one;
        other.desc.znear = (float)(0.125 * s);
        for (int k = 0; k < 3; k++)
            other.world[12 + k] = (float)(s * (double)one.world[12 + k]);
        const gn_map_desc desc = desc_for(4);
        const gn_cascades a = cascades_of(&one, city_min, city_max, v3(0.3, -1, 0.2), &desc);
        const gn_cascades b = cascades_of(&other, low, high, v3(0.3, -1, 0.2), &desc);
        assert_int_equal(a.count, b.count);
        for (uint32_t i = 0; i < a.count; i++) {
            const gn_map_projection p = gn_cascade_fit(&a, i).projection;
            const gn_map_projection q = gn_cascade_fit(&b, i).projection;
            if ((double)q.extent != s * (double)p.extent || (double)q.far != s * (double)p.far ||
                (double)q.origin[0] != s * (double)p.origin[0])
                fail_msg("times %g, level %u: %.9g m, expected %.9g", s, i, (double)q.extent,
                         s * (double)p.extent);
        }
    }
}

static void test_small_scenes(void **state)
{
    (void)state;
    /* A triangle that lies flat, one that stands, and a point. */
    static const float lows[3][3] = {{-1, 0, -1}, {0, 0, 0}, {0.5f, 0.25f, 0.125f}},
                       highs[3][3] = {{1, 0, 1}, {1, 2, 0}, {0.5f, 0.25f, 0.125f}};
    const gn_map_desc desc = desc_for(4);
    static const vec lights[4] = {{0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0.3, -1, 0.2}};
    for (int n = 0; n < 12; n++) {
        const gn_camera camera = camera_at(v3(1, 2, 5), v3(0.5, 0.2, 0), 0.8, 0.1);
        const gn_cascades c = cascades_of(&camera, lows[n / 4], highs[n / 4], lights[n % 4], &desc);
        levels l = {.count = 0};
        update(&l, &c);
        assert_int_equal(l.count, 1);
        const gn_map_projection *p = &l.at[0].projection;
        assert_true(p->extent > 0 && p->far > p->near && isfinite(p->extent) && isfinite(p->far));
        for (int i = 0; i < 3; i++) {
            const vec corner = v3((double)(i & 1 ? highs : lows)[n / 4][0],
                                  (double)(i & 1 ? lows : highs)[n / 4][1],
                                  (double)(i & 2 ? highs : lows)[n / 4][2]);
            if (!holds(p, corner))
                fail_msg("scene %d, light %d: corner %d is not held", n / 4, n % 4, i);
        }
    }
}

static void test_nothing_in_view(void **state)
{
    (void)state;
    const gn_map_desc desc = desc_for(4);
    const gn_camera away = camera_at(v3(0, 2, 300), v3(0, 2, 400), 1, 0.1);
    assert_int_equal(cascades_of(&away, city_min, city_max, v3(0, -1, 0), &desc).count, 0);
    const gn_camera beside = camera_at(v3(0, 2, 300), v3(100, 2, 301), 0.2, 0.1);
    assert_int_equal(cascades_of(&beside, city_min, city_max, v3(0, -1, 0), &desc).count, 0);
    gn_map_desc near = desc_for(4);
    near.distance = 5;
    const gn_camera far = camera_at(v3(0, 2, 300), v3(0, 2, 0), 1, 0.1);
    assert_int_equal(cascades_of(&far, city_min, city_max, v3(0, -1, 0), &near).count, 0);
}

/* Lamps -------------------------------------------------------------------------------------- */

static gn_light lamp_at(gn_light_type type, vec position, vec direction, double outer)
{
    gn_light light = {.desc = gn_light_desc_default()};
    light.desc.type = type;
    light.desc.outer_cone_angle = (float)outer;
    light.position[0] = (float)position.x;
    light.position[1] = (float)position.y;
    light.position[2] = (float)position.z;
    direction_of(direction, light.direction);
    return light;
}

static void test_faces_hold_every_direction(void **state)
{
    (void)state;
    static const float low[3] = {-10, -1, -10}, high[3] = {10, 5, 12};
    const gn_map_desc desc = desc_for(4);
    const gn_light light = lamp_at(GN_LIGHT_POINT, v3(1, 2, -3), v3(0, -1, 0), 0.5);
    const gn_lamp lamp = gn_lamp_make(&light, low, high, false, &desc, MARGIN);
    assert_int_equal(lamp.count, 6);
    for (int n = 0; n < 20000; n++) {
        vec p = v3(between(-10, 10), between(-1, 5), between(-10, 12));
        if (n % 2) { /* just beside an edge of the cube of faces */
            const double s = between(0.1, 3), e = between(-1e-6, 1e-6);
            p = add(v3(1, 2, -3), v3(s, n % 4 == 1 ? s + e : -s + e, between(-s, s)));
        }
        const gn_map_projection *first = NULL;
        double depth = 0;
        for (uint32_t face = 0; face < 6; face++) {
            if (!holds(&lamp.faces[face], p))
                continue;
            const double d = place_in(&lamp.faces[face], p).z;
            if (!first)
                depth = d;
            first = first ? first : &lamp.faces[face];
            if (fabs(d - depth) > 0.02) /* within the guard band depths differ by its width */
                fail_msg("depth %g in one face, %g in another", depth, d);
        }
        if (!first)
            fail_msg("no face holds %g %g %g", p.x, p.y, p.z);
    }
    /* On the edge itself all faces say the same. */
    const vec corner = add(v3(1, 2, -3), v3(2, 2, 2));
    assert_near(place_in(&lamp.faces[0], corner).z, place_in(&lamp.faces[2], corner).z, 1e-6);
    assert_near(place_in(&lamp.faces[0], corner).z, place_in(&lamp.faces[4], corner).z, 1e-6);
}

static void test_a_spot_light_has_one_view_up_to_75_degrees(void **state)
{
    (void)state;
    static const float low[3] = {-10, 0, -10}, high[3] = {10, 4, 10};
    const gn_map_desc desc = desc_for(4);
    for (int degrees = 5; degrees <= 90; degrees += 5) {
        const double outer = degrees * atan(1) / 45;
        const vec axis = unit(v3(0.2, -1, 0.4));
        const gn_light light = lamp_at(GN_LIGHT_SPOT, v3(0, 3, 0), axis, outer);
        const gn_lamp lamp = gn_lamp_make(&light, low, high, false, &desc, MARGIN);
        assert_int_equal(lamp.count, degrees <= 75 ? 1 : 6);
        for (int n = 0; n < 2000; n++) {
            const vec p = v3(between(-10, 10), between(0, 4), between(-10, 10));
            const vec d = sub(p, v3(0, 3, 0));
            if (dot(unit(d), axis) < cos(outer) || length(d) < 0.1)
                continue;
            bool held = false;
            for (uint32_t face = 0; face < lamp.count; face++)
                held = held || holds(&lamp.faces[face], p);
            if (!held)
                fail_msg("a spot of %d degrees does not hold %g %g %g", degrees, p.x, p.y, p.z);
        }
    }
}

/* In the middle of things, outside, far away, with ranges that end before the scene. */
static void test_lamps_anywhere(void **state)
{
    (void)state;
    static const float low[3] = {-1, 0, -1}, high[3] = {1, 2, 1}, zero[3] = {0, 0, 0};
    const gn_map_desc desc = desc_for(4);
    static const double ranges[5] = {1e-35, 1e-3, 2, 1e30, INFINITY};
    static const vec places[5] = {{0, 0, 0}, {0, 1, 0}, {1, 2, 1}, {1e5, 3, 0}, {0, 1e-20, 0}};
    for (int n = 0; n < 100; n++) {
        gn_light light = lamp_at(n % 2 ? GN_LIGHT_SPOT : GN_LIGHT_POINT, places[n / 2 % 5],
                                 v3(0, n % 4 < 2 ? -1 : 1, 0), 0.7);
        light.desc.range = (float)ranges[n / 10 % 5];
        const gn_lamp lamp = n < 50 ? gn_lamp_make(&light, low, high, n % 3 == 0, &desc, MARGIN)
                                    : gn_lamp_make(&light, zero, zero, n % 3 == 0, &desc, MARGIN);
        for (uint32_t face = 0; face < lamp.count; face++) {
            const gn_map_projection *p = &lamp.faces[face];
            if (!(p->near > 0 && p->far > p->near && isfinite(p->far) && p->extent > 0))
                fail_msg("case %d: from %g to %g m", n, (double)p->near, (double)p->far);
            assert_true(gn_lamp_serves(p, &lamp));
        }
    }
}

static void test_what_a_projection_sees(void **state)
{
    (void)state;
    static const float low[3] = {-10, 0, -10}, high[3] = {10, 4, 10};
    const gn_map_desc desc = desc_for(4);
    const gn_light light = lamp_at(GN_LIGHT_SPOT, v3(0, 3, 0), v3(0, -1, 0), 0.5);
    const gn_lamp lamp = gn_lamp_make(&light, low, high, false, &desc, MARGIN);
    const gn_bounds under = {{-0.1, 0, -0.1}, {0.1, 1, 0.1}}, beside = {{3, 0, 0}, {4, 1, 1}},
                    above = {{-1, 4, -1}, {1, 5, 1}}, around = {{-9, -9, -9}, {9, 9, 9}};
    assert_true(gn_projection_sees(&lamp.faces[0], &under));
    assert_false(gn_projection_sees(&lamp.faces[0], &beside));
    assert_false(gn_projection_sees(&lamp.faces[0], &above));
    assert_true(gn_projection_sees(&lamp.faces[0], &around));
    /* A cascade is reached from any height in front of it. */
    const gn_camera camera = camera_at(v3(0, 1, 9), v3(0, 0, 0), 0.5, 0.1);
    const gn_cascades c = cascades_of(&camera, low, high, v3(0, -1, 0), &desc);
    const gn_cascade level = gn_cascade_fit(&c, 0);
    const gn_bounds high_up = {{-20, 90, -20}, {20, 91, 20}},
                    below = {{-20, -91, -20}, {20, -90, 20}};
    assert_true(gn_projection_sees(&level.projection, &high_up));
    assert_false(gn_projection_sees(&level.projection, &below));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axes_are_orthonormal_and_smooth),
        cmocka_unit_test(test_splits),
        cmocka_unit_test(test_whatever_is_in_view_is_held),
        cmocka_unit_test(test_no_level_is_larger_than_the_scene),
        cmocka_unit_test(test_texels_do_not_swim),
        cmocka_unit_test(test_turning_around_in_one_frame),
        cmocka_unit_test(test_levels_that_became_too_large_are_placed_anew),
        cmocka_unit_test(test_far_is_1e5_times_near),
        cmocka_unit_test(test_nothing_depends_on_the_unit),
        cmocka_unit_test(test_small_scenes),
        cmocka_unit_test(test_nothing_in_view),
        cmocka_unit_test(test_faces_hold_every_direction),
        cmocka_unit_test(test_a_spot_light_has_one_view_up_to_75_degrees),
        cmocka_unit_test(test_lamps_anywhere),
        cmocka_unit_test(test_what_a_projection_sees)};
    return cmocka_run_group_tests_name("cascade", tests, NULL, NULL);
}
