/* Visibility behind opaque geometry, against ray casting in double by this test. */
#include "render_testing.h"

#define PI 3.14159265358979323846

/* Analytic boxes ----------------------------------------------------------------------------- */

/* Where a ray is inside a box that is grown by `grow` on all sides: false nowhere. */
static bool box_span(vec low, vec high, double grow, vec origin, vec direction, double *enter,
                     double *leave)
{
    const double o[3] = {origin.x, origin.y, origin.z},
                 d[3] = {direction.x, direction.y, direction.z};
    const double l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z};
    *enter = -INFINITY;
    *leave = INFINITY;
    for (int i = 0; i < 3; i++) {
        double a = l[i] - grow - o[i], b = h[i] + grow - o[i];
        if (a > b) /* nothing is left of a thin box but its middle */
            a = b = 0.5 * (l[i] + h[i]) - o[i];
        if (d[i] == 0) {
            if (a > 0 || b < 0)
                return false;
            continue;
        }
        *enter = fmax(*enter, fmin(a / d[i], b / d[i]));
        *leave = fmin(*leave, fmax(a / d[i], b / d[i]));
    }
    return *enter <= *leave;
}

/* What stands between a point and a light. */
typedef struct occluders {
    const vec (*boxes)[2];
    size_t count;
} occluders;

static bool blocked(const occluders *o, vec from, vec direction, double distance, double grow)
{
    for (size_t i = 0; i < o->count; i++) {
        double enter, leave;
        if (box_span(o->boxes[i][0], o->boxes[i][1], grow, from, direction, &enter, &leave) &&
            leave > 0 && enter < distance)
            return true;
    }
    return false;
}

/* Lit (1), shadowed (0), or too close to a border to tell (-1): within `slack` metres of it. */
static int expected_visibility(const gn_scene *scene, uint32_t light, const occluders *o, vec p,
                               vec n, double slack)
{
    const gn_light *l = &scene->lights[light];
    const vec travel =
        v3((double)l->direction[0], (double)l->direction[1], (double)l->direction[2]);
    vec direction = mul(travel, -1);
    double distance = INFINITY;
    if (l->desc.type != GN_LIGHT_DIRECTIONAL) {
        const vec to =
            sub(v3((double)l->position[0], (double)l->position[1], (double)l->position[2]), p);
        distance = length(to);
        direction = unit(to);
        if (distance > (double)l->desc.range + slack)
            return 0;
        if (distance > (double)l->desc.range - slack)
            return -1;
    }
    if (l->desc.type == GN_LIGHT_SPOT) {
        const double outside = acos(-dot(direction, travel)) - (double)l->desc.outer_cone_angle;
        if (fabs(outside) * distance < slack)
            return -1;
        if (outside > 0)
            return 0;
    }
    if (fabs(dot(n, direction)) < 1e-6)
        return -1;
    if (dot(n, direction) < 0)
        return 0;
    /* The point lies on a surface: leave it. */
    const vec off = add(p, mul(n, 2 * slack));
    const bool surely = blocked(o, off, direction, distance, -slack);
    return surely == blocked(o, off, direction, distance, slack) ? !surely : -1;
}

/* Every pixel is what the boxes say; few are too close to a border to tell. */
static void check_frame(const gn_scene *scene, const frame *f, uint32_t light, const occluders *o,
                        double slack, double undecided_share, const char *what)
{
    size_t wrong = 0, undecided = 0, count[2] = {0, 0}, first = 0;
    for (size_t i = 0; i < f->pixels; i++) {
        if (f->g->surface[i] == GN_NONE) {
            wrong += f->visibility[i] != 0;
            continue;
        }
        const int expected =
            expected_visibility(scene, light, o, position_at(f->g, i), normal_at(f->g, i), slack);
        if (expected < 0) {
            undecided++;
            continue;
        }
        count[expected]++;
        if ((double)f->visibility[i] != expected && wrong++ == 0)
            first = i;
    }
    if (wrong > 0)
        print_error("first wrong pixel (%zu, %zu): visibility %g\n", first % f->g->width,
                    first / f->g->width, (double)f->visibility[first]);
    few(wrong, f->pixels, 0, "%s: wrong", what);
    few(undecided, f->pixels, undecided_share, "%s: undecided", what);
    if (count[0] == 0 || count[1] == 0)
        fail_msg("%s: %zu pixels lit, %zu shadowed: nothing is tested", what, count[1], count[0]);
}

/* A box over a plane, each kind of light ----------------------------------------------------- */

static void test_box_over_plane(void **state)
{
    (void)state;
    static const vec boxes[][2] = {{{-1, 0.5, -1}, {1, 2, 1}}, {{2, 0, -1.5}, {2.5, 1.5, 1}}};
    const occluders o = {boxes, 2};
    for (int moving = 0; moving < 2; moving++) {
        gn_scene *scene = new_scene();
        const uint32_t sided = add_single_sided(scene);
        place(scene, add_floor(scene, 10, 0, GN_NONE), false);
        for (int i = 0; i < 2; i++)
            place(scene, add_box(scene, boxes[i][0], boxes[i][1], sided), moving);
        const uint32_t camera = add_camera(scene, v3(5, 6, 9), v3(0, 0.5, 0), 0.8, 0.1);
        gn_light_desc spot = gn_light_desc_default();
        spot.type = GN_LIGHT_SPOT;
        spot.intensity = 100;
        spot.inner_cone_angle = 0.2f;
        spot.outer_cone_angle = 0.45f;
        spot.range = 8.5f;
        const uint32_t lights[] = {
            add_sun(scene, v3(-0.7, 1, 0.3)), add_lamp(scene, v3(-2, 5, 1.3)),
            add_light(scene, &spot, v3(-4, 5.5, 2), v3(0, 0, 0)), add_sun(scene, v3(1e-3, 1, 2e-3)),
            add_lamp(scene, v3(0, 0.25, 0))};
        static const char *const names[] = {"sun", "lamp", "spot", "noon", "lamp under the box"};
        ok(gn_scene_commit(scene));
        for (int i = 0; i < 5; i++) {
            frame f = render(scene, camera, lights[i], 320, 240);
            char name[64];
            snprintf(name, sizeof name, "box %s%s", names[i], moving ? ", instances" : "");
            picture(&f, name);
            check_frame(scene, &f, lights[i], &o, 5e-5, 1e-3, name);
            end(&f);
        }
        gn_scene_destroy(&scene);
    }
}

/* The G-buffer holds what a camera ray in double meets. */
static void test_gbuffer(void **state)
{
    (void)state;
    const vec low = v3(-1, 0.5, -1), high = v3(1, 2, 1);
    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 10, 0, GN_NONE), false);
    place(scene, add_box(scene, low, high, GN_NONE), false);
    const vec eye = v3(5, 6, 9), target = v3(0, 0.5, 0);
    const double yfov = 0.8;
    const uint32_t camera = add_camera(scene, eye, target, yfov, 0.1);
    const uint32_t sun = add_sun(scene, v3(0, 1, 0));
    ok(gn_scene_commit(scene));
    const uint32_t width = 320, height = 200;
    frame f = render(scene, camera, sun, width, height);
    const vec back = unit(sub(eye, target)), right = unit(cross(v3(0, 1, 0), back));
    const vec up = cross(back, right);
    const double spread = atan(2 * tan(yfov / 2) / height);
    size_t borders = 0;
    for (size_t i = 0; i < f.pixels; i++) {
        const double x = (2 * ((double)(i % width) + 0.5) / width - 1) * width / height;
        const double y = 1 - 2 * ((double)(i / width) + 0.5) / height;
        const vec d =
            unit(sub(add(mul(right, x * tan(yfov / 2)), mul(up, y * tan(yfov / 2))), back));
        double enter, leave, ground = d.y < 0 ? -eye.y / d.y : INFINITY;
        const vec q = add(eye, mul(d, ground < INFINITY ? ground : 0));
        if (fabs(q.x) > 10 || fabs(q.z) > 10)
            ground = INFINITY;
        const bool box = box_span(low, high, 0, eye, d, &enter, &leave) && enter > 0;
        double other_enter, other_leave;
        if (box != box_span(low, high, 1e-4, eye, d, &other_enter, &other_leave) ||
            box != box_span(low, high, -1e-4, eye, d, &other_enter, &other_leave) ||
            fabs(fabs(q.x) - 10) < 1e-4 || fabs(fabs(q.z) - 10) < 1e-4) {
            borders++;
            continue;
        }
        const double t = box ? fmin(enter, ground) : ground;
        if (!(t < INFINITY)) {
            assert_int_equal(f.g->surface[i], GN_NONE);
            assert_true(f.visibility[i] == 0.0f);
            continue;
        }
        assert_int_not_equal(f.g->surface[i], GN_NONE);
        const vec p = add(eye, mul(d, t)), n = normal_at(f.g, i);
        const double off = length(sub(position_at(f.g, i), p));
        if (off > 3e-5)
            fail_msg("pixel %zu lies %g m off", i, off);
        if (fabs(length(n) - 1) > 1e-6 || dot(n, d) >= 0)
            fail_msg("pixel %zu: normal (%g %g %g)", i, n.x, n.y, n.z);
        const double cone = t * spread / -dot(n, d);
        if (fabs((double)f.g->cone_width[i] / cone - 1) > 1e-4)
            fail_msg("pixel %zu: cone width %g, expected %g", i, (double)f.g->cone_width[i], cone);
        const double depth = -dot(mul(d, t), back);
        if (fabs((double)f.g->depth[i] - depth) > 1e-5 * depth)
            fail_msg("pixel %zu: depth %.9g, expected %.9g", i, (double)f.g->depth[i], depth);
        /* The position is off its plane by no more than origin_error. */
        const double plane = box && enter < ground ? 0 : fabs(position_at(f.g, i).y);
        if (plane > (double)f.g->origin_error[i])
            fail_msg("pixel %zu: %g m off its plane, bound %g", i, plane,
                     (double)f.g->origin_error[i]);
    }
    few(borders, f.pixels, 1e-3, "undecided");
    end(&f);
    gn_scene_destroy(&scene);
}

/* Walls -------------------------------------------------------------------------------------- */

/* Behind the foot of a thin wall, from 0.5 m, a pixel is half a millimetre: no light there. */
static void test_wall_foot(void **state)
{
    (void)state;
    static const vec thin[][2] = {{{-2, 0, 0}, {2, 2, 0}}},
                     closed[][2] = {{{-2, 0, 0}, {2, 2, 1e-3}}};
    static const char *const names[] = {"thin wall", "thin wall, instance", "closed wall",
                                        "closed wall, instance"};
    for (int kind = 0; kind < 4; kind++) {
        const vec(*box)[2] = kind < 2 ? thin : closed;
        gn_scene *scene = new_scene();
        const vec p[4] = {v3(-2, 0, 0), v3(2, 0, 0), v3(2, 2, 0), v3(-2, 2, 0)};
        place(scene, add_floor(scene, 10, 0, GN_NONE), false);
        place(scene,
              kind < 2 ? add_quad(scene, p, 1, GN_NONE)
                       : add_box(scene, box[0][0], box[0][1], GN_NONE),
              kind & 1);
        const uint32_t camera = add_camera(scene, v3(0.1, 0.3, -0.4), v3(0, 0, 0), 0.4, 0.01);
        const uint32_t side = add_camera(scene, v3(2.4, 0.3, -0.1), v3(2, 0, 0), 0.4, 0.01);
        const uint32_t sun = add_sun(scene, v3(0.2, 0.7, 1)), lamp = add_lamp(scene, v3(0, 1, 1.5));
        ok(gn_scene_commit(scene));
        const occluders o = {box, 1};
        for (int light = 0; light < 2; light++) {
            /* All of what this camera sees lies in shadow: a leak would be a lit pixel. */
            frame f = render(scene, camera, light ? lamp : sun, 300, 200);
            picture(&f, names[kind]);
            size_t lit = 0;
            for (size_t i = 0; i < f.pixels; i++)
                lit += f.visibility[i] != 0 && position_at(f.g, i).z < 0;
            few(lit, f.pixels, 0, "%s: leaks", names[kind]);
            end(&f);
            f = render(scene, side, light ? lamp : sun, 300, 200);
            check_frame(scene, &f, light ? lamp : sun, &o, 6e-5, 4e-3, names[kind]);
            end(&f);
        }
        gn_scene_destroy(&scene);
    }
}

/* Inside a closed room with walls of 1 mm it is dark. */
static void test_dark_room(void **state)
{
    (void)state;
    static const vec walls[][2] = {{{-2.001, -0.001, -2.001}, {2.001, 0, 2.001}},
                                   {{-2.001, 3, -2.001}, {2.001, 3.001, 2.001}},
                                   {{-2.001, 0, -2.001}, {-2, 3, 2.001}},
                                   {{2, 0, -2.001}, {2.001, 3, 2.001}},
                                   {{-2, 0, -2.001}, {2, 3, -2}},
                                   {{-2, 0, 2}, {2, 3, 2.001}}};
    static const vec turn[] = {{0, 0, 0}, {0.3, 0.5, 0.1}};
    for (int kind = 0; kind < 4; kind++) {
        gn_scene *scene = new_scene();
        const vec axis = turn[kind / 2];
        gn_node_desc node = gn_node_desc_default();
        node.rotation[0] = (float)axis.x;
        node.rotation[1] = (float)axis.y;
        node.rotation[2] = (float)axis.z;
        for (int i = 0; i < 6; i++) {
            node.mesh = add_box(scene, walls[i][0], walls[i][1], GN_NONE);
            place_desc(scene, &node, kind & 1);
        }
        /* In the room's middle, so that turning the room keeps it inside. */
        float m[16];
        gn_compose((const float[3]){0, 0, 0}, scene->nodes[0].rotation, (const float[3]){1, 1, 1},
                   m);
        const uint32_t cameras[] = {add_camera(scene, transform(m, v3(1.8, 2.7, 1.8)),
                                               transform(m, v3(-2, 0, -2)), 1.4, 0.01),
                                    add_camera(scene, transform(m, v3(-1.8, 0.3, 1.8)),
                                               transform(m, v3(2, 3, -2)), 1.4, 0.01)};
        const uint32_t lights[] = {add_sun(scene, v3(0.5, 1, 0.4)),
                                   add_sun(scene, v3(-1, 0.001, 0.4)),
                                   add_lamp(scene, v3(4, 4, -3))};
        ok(gn_scene_commit(scene));
        for (int camera = 0; camera < 2; camera++)
            for (int light = 0; light < 3; light++) {
                frame f = render(scene, cameras[camera], lights[light], 320, 240);
                size_t lit = 0, sky = 0;
                for (size_t i = 0; i < f.pixels; i++) {
                    lit += f.visibility[i] != 0;
                    sky += f.g->surface[i] == GN_NONE;
                }
                few(lit, f.pixels, 0, "room %d, light %d: leaks", kind, light);
                few(sky, f.pixels, 0, "room %d: holes", kind);
                end(&f);
            }
        gn_scene_destroy(&scene);
    }
}

/* Spheres: no acne --------------------------------------------------------------------------- */

#define SPHERE_EDGES 92 /* 12 * 92^2: 101,568 triangles */

/* A sphere is convex: it is lit exactly where it faces the light. tolerance: of the cosine. */
static void check_sphere(const frame *f, uint32_t surface, vec towards, double tolerance,
                         const char *what)
{
    size_t acne = 0, lit_behind = 0, sphere = 0, grazing = 0;
    for (size_t i = 0; i < f->pixels; i++) {
        if (f->g->surface[i] != surface)
            continue;
        sphere++;
        const double cosine = dot(normal_at(f->g, i), towards);
        grazing += fabs(cosine) < 0.02;
        acne += cosine > tolerance && f->visibility[i] != 1;
        lit_behind += cosine < -tolerance && f->visibility[i] != 0;
    }
    few(acne, f->pixels, 0, "%s: acne", what);
    few(lit_behind, f->pixels, 0, "%s: lit from behind", what);
    if (sphere < f->pixels / 20 || grazing < 100)
        fail_msg("%s: %zu pixels see the sphere, %zu of them at grazing angles", what, sphere,
                 grazing);
}

static void test_sphere(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double offset, scale, turn;
        bool moving, vertices; /* the vertices themselves are moved and scaled */
    } cases[] = {{"sphere", 0, 1, 0, false, false},
                 {"sphere, turned", 0, 1, 0.4, false, false},
                 {"sphere at 1000 m", 1000, 1, 0, false, false},
                 {"sphere by 1e-3", 0, 1e-3, 0, false, false},
                 {"sphere by 1e3", 0, 1e3, 0, false, false},
                 {"sphere, instance", 0, 1, 0, true, false},
                 {"sphere, turned, instance", 0, 1, 0.4, true, false},
                 {"sphere at 1000 m, instance", 1000, 1, 0.4, true, false},
                 {"sphere by 1e-3, instance", 0, 1e-3, 0.4, true, false},
                 {"sphere by 1e3, instance", 0, 1e3, 0.4, true, false},
                 {"vertices at 1000 m", 1000, 1, 0, false, true},
                 {"vertices at 1000 m, instance", 1000, 1, 0, true, true},
                 {"vertices by 1e-3, instance", 0, 1e-3, 0, true, true}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double s = cases[k].scale;
        const vec center = v3(cases[k].offset, -cases[k].offset, cases[k].offset);
        gn_scene *scene = new_scene();
        gn_node_desc node = gn_node_desc_default();
        node.rotation[2] = (float)cases[k].turn;
        if (cases[k].vertices) {
            node.mesh = add_sphere(scene, center, s, SPHERE_EDGES, GN_NONE);
        } else {
            node.mesh = add_sphere(scene, v3(0, 0, 0), 1, SPHERE_EDGES, GN_NONE);
            node.translation[0] = (float)center.x;
            node.translation[1] = (float)center.y;
            node.translation[2] = (float)center.z;
            for (int i = 0; i < 3; i++)
                node.scale[i] = (float)s;
        }
        place_desc(scene, &node, cases[k].moving);
        const uint32_t camera =
            add_camera(scene, add(center, mul(v3(0.5, 0.8, 2.6), s)), center, 0.8, 0.01 * s);
        const vec towards = unit(v3(1, 0.15, 0.05));
        const uint32_t sun = add_sun(scene, towards);
        ok(gn_scene_commit(scene));
        frame f = render(scene, camera, sun, 256, 256);
        picture(&f, cases[k].name);
        const gn_light *light = &scene->lights[sun];
        check_sphere(&f, 0,
                     v3(-(double)light->direction[0], -(double)light->direction[1],
                        -(double)light->direction[2]),
                     1e-6, cases[k].name);
        end(&f);
        gn_scene_destroy(&scene);
    }
}

/* Triangles of very different sizes: 20 km of ground under a sun one degree high. */
static void test_low_sun(void **state)
{
    (void)state;
    for (int moving = 0; moving < 2; moving++) {
        gn_scene *scene = new_scene();
        place(scene, add_floor(scene, 1e4, 0, GN_NONE), moving & 1);
        place(scene, add_sphere(scene, v3(0, 1, 0), 1, SPHERE_EDGES, GN_NONE), moving & 1);
        const uint32_t camera = add_camera(scene, v3(-3, 1.8, 6), v3(-2, 0.5, 0), 0.8, 0.1);
        const vec towards = unit(v3(cos(PI / 180), sin(PI / 180), 0.1));
        const uint32_t sun = add_sun(scene, towards);
        ok(gn_scene_commit(scene));
        frame f = render(scene, camera, sun, 320, 200);
        picture(&f, moving ? "low sun, instances" : "low sun");
        check_sphere(&f, 1, towards, 1e-5, "low sun");
        size_t wrong = 0, ground = 0, shadowed = 0;
        for (size_t i = 0; i < f.pixels; i++) {
            if (f.g->surface[i] != 0)
                continue;
            ground++;
            const vec p = position_at(f.g, i), to = sub(v3(0, 1, 0), p);
            const double along = dot(to, towards);
            const double beside = length(sub(to, mul(towards, along)));
            shadowed += along > 0 && beside < 0.995;
            wrong += (along <= 0 || beside > 1.005) && f.visibility[i] != 1;
            wrong += along > 0 && beside < 0.995 && f.visibility[i] != 0;
        }
        few(wrong, f.pixels, 0, "low sun%s: ground", moving ? ", instances" : "");
        assert_true(ground > f.pixels / 4 && shadowed > 500);
        end(&f);
        gn_scene_destroy(&scene);
    }
}

/* Planes of any size, place and tilt do not shadow themselves, however low the sun. */
static double next_random(void)
{
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return (double)state / 2147483648.0 - 1;
}

static void test_tilted_planes(void **state)
{
    (void)state;
    for (int k = 0; k < 60; k++) {
        const vec n = unit(v3(next_random(), next_random(), next_random()));
        const vec s = unit(cross(n, v3(next_random(), next_random(), next_random())));
        const double size = pow(10, 4 * next_random()), far = pow(10, 2 * next_random());
        const vec t = mul(cross(n, s), size * pow(10, next_random())), r = mul(s, size);
        const vec c = mul(v3(next_random(), next_random(), next_random()), size * far);
        const vec p[4] = {sub(sub(c, r), t), sub(add(c, r), t), add(add(c, r), t),
                          add(sub(c, r), t)};
        const double distance = fmin(size, length(t)) * pow(10, 2 * next_random() - 2);
        const vec at = add(c, add(mul(r, 0.8 * next_random()), mul(t, 0.8 * next_random())));
        gn_scene *scene = new_scene();
        place(scene, add_quad(scene, p, 1, GN_NONE), k & 1);
        const vec eye = add(at, mul(add(n, mul(s, next_random())), distance));
        const uint32_t camera = add_camera(scene, eye, at, 0.8, distance * 1e-3);
        const uint32_t sun = add_sun(scene, add(n, mul(s, 100 * next_random())));
        ok(gn_scene_commit(scene));
        frame f = render(scene, camera, sun, 64, 64);
        size_t acne = 0;
        for (size_t i = 0; i < f.pixels; i++)
            acne += f.g->surface[i] == 0 && f.visibility[i] != 1;
        few(acne, f.pixels, 0, "plane %d, %g m, at %g m", k, size, size * far);
        end(&f);
        gn_scene_destroy(&scene);
    }
}

/* Nodes -------------------------------------------------------------------------------------- */

/* A unit box under mirrored and stretched nodes, single sided: looks and shades like the box that
 * it becomes. */
static void test_node_scales(void **state)
{
    (void)state;
    static const float scales[][3] = {
        {1, 2, 0.5f}, {-1, 1, 1}, {1, -2, 0.25f}, {-1, -1, -1}, {3, 0.1f, -0.2f}};
    for (size_t k = 0; k < 10; k++) {
        const float *scale = scales[k / 2];
        gn_scene *scene = new_scene();
        const uint32_t sided = add_single_sided(scene);
        place(scene, add_floor(scene, 10, 0, sided), false);
        gn_node_desc node = gn_node_desc_default();
        node.mesh = add_box(scene, v3(-1, -1, -1), v3(1, 1, 1), sided);
        memcpy(node.scale, scale, sizeof node.scale);
        node.translation[1] = 2.5f;
        place_desc(scene, &node, k & 1);
        const uint32_t camera = add_camera(scene, v3(5, 6, 9), v3(0, 1, 0), 0.8, 0.1);
        const uint32_t lights[] = {add_sun(scene, v3(-0.3, 1, 0.6)), add_lamp(scene, v3(-2, 7, 3))};
        ok(gn_scene_commit(scene));
        const vec half = v3(fabs((double)scale[0]), fabs((double)scale[1]), fabs((double)scale[2]));
        const vec box[1][2] = {{sub(v3(0, 2.5, 0), half), add(v3(0, 2.5, 0), half)}};
        const occluders o = {box, 1};
        for (int light = 0; light < 2; light++) {
            frame f = render(scene, camera, lights[light], 320, 240);
            char name[64];
            snprintf(name, sizeof name, "scale %g %g %g%s", (double)scale[0], (double)scale[1],
                     (double)scale[2], k & 1 ? ", instance" : "");
            picture(&f, name);
            check_frame(scene, &f, lights[light], &o, 5e-5, 1e-3, name);
            /* The camera sees outer sides: every point of the box lies on one that faces it. */
            size_t inside = 0;
            for (size_t i = 0; i < f.pixels; i++) {
                const vec n = normal_at(f.g, i), p = sub(position_at(f.g, i), v3(0, 2.5, 0));
                inside += f.g->surface[i] == 1 && dot(n, p) < 0;
            }
            few(inside, f.pixels, 0, "%s: inner sides seen", name);
            end(&f);
        }
        gn_scene_destroy(&scene);
    }
}

/* A node scaled to nothing is not there, whether it moves or not. */
static void test_zero_scale(void **state)
{
    (void)state;
    for (int moving = 0; moving < 2; moving++) {
        gn_scene *scene = new_scene();
        place(scene, add_floor(scene, 10, 0, GN_NONE), false);
        gn_node_desc node = gn_node_desc_default();
        node.mesh = add_box(scene, v3(-1, 1, -1), v3(1, 2, 1), GN_NONE);
        memset(node.scale, 0, sizeof node.scale);
        place_desc(scene, &node, moving);
        const uint32_t camera = add_camera(scene, v3(5, 6, 9), v3(0, 0, 0), 0.8, 0.1);
        const uint32_t sun = add_sun(scene, v3(0, 1, 0));
        ok(gn_scene_commit(scene));
        frame f = render(scene, camera, sun, 160, 120);
        size_t wrong = 0;
        for (size_t i = 0; i < f.pixels; i++)
            wrong += f.g->surface[i] == 1 || (f.g->surface[i] == 0 && f.visibility[i] != 1);
        few(wrong, f.pixels, 0, "zero scale");
        end(&f);
        gn_scene_destroy(&scene);
    }
}

/* Camera rays pass the back of a single-sided surface, shadow rays do not. */
static void test_sides(void **state)
{
    (void)state;
    for (int kind = 0; kind < 8; kind++) {
        const bool double_sided = kind & 1, up = kind & 2, moving = kind & 4;
        gn_scene *scene = new_scene();
        const uint32_t sided = add_single_sided(scene);
        place(scene, add_floor(scene, 10, 0, GN_NONE), false);
        vec p[4] = {v3(-1, 1, 1), v3(1, 1, 1), v3(1, 1, -1), v3(-1, 1, -1)};
        if (!up) {
            const vec swapped = p[1];
            p[1] = p[3];
            p[3] = swapped;
        }
        place(scene, add_quad(scene, p, 1, double_sided ? GN_NONE : sided), moving);
        const uint32_t camera = add_camera(scene, v3(1, 8, 6), v3(0, 0, 0), 0.8, 0.1);
        const uint32_t sun = add_sun(scene, v3(0.2, 1, 0.1));
        ok(gn_scene_commit(scene));
        const vec box[1][2] = {{v3(-1, 1, -1), v3(1, 1, 1)}};
        const occluders o = {box, 1};
        frame f = render(scene, camera, sun, 160, 120);
        size_t seen = 0;
        for (size_t i = 0; i < f.pixels; i++)
            seen += f.g->surface[i] == 1;
        if ((seen > 0) != (double_sided || up))
            fail_msg("double sided %d, facing the camera %d: %zu pixels see it", double_sided, up,
                     seen);
        check_frame(scene, &f, sun, &o, 5e-5, 5e-3, "sides");
        end(&f);
        gn_scene_destroy(&scene);
    }
}

/* More layers of back faces than a ray is likely to pass. */
static void test_many_back_faces(void **state)
{
    (void)state;
    gn_scene *scene = new_scene();
    const uint32_t sided = add_single_sided(scene);
    place(scene, add_floor(scene, 10, 0, GN_NONE), false);
    for (int i = 1; i <= 40; i++) {
        const double y = 0.05 * i;
        const vec p[4] = {v3(-1, y, 1), v3(-1, y, -1), v3(1, y, -1), v3(1, y, 1)};
        place(scene, add_quad(scene, p, 1, sided), false);
    }
    const uint32_t camera = add_camera(scene, v3(0, 8, 0.1), v3(0, 0, 0), 0.2, 0.1);
    const uint32_t sun = add_sun(scene, v3(0.2, 1, 0.1));
    ok(gn_scene_commit(scene));
    frame f = render(scene, camera, sun, 64, 64);
    for (size_t i = 0; i < f.pixels; i++)
        if (f.g->surface[i] != 0)
            fail_msg("pixel %zu sees surface %u, not the floor", i, f.g->surface[i]);
    end(&f);
    gn_scene_destroy(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_box_over_plane),  cmocka_unit_test(test_gbuffer),
        cmocka_unit_test(test_wall_foot),       cmocka_unit_test(test_dark_room),
        cmocka_unit_test(test_sphere),          cmocka_unit_test(test_low_sun),
        cmocka_unit_test(test_tilted_planes),   cmocka_unit_test(test_node_scales),
        cmocka_unit_test(test_zero_scale),      cmocka_unit_test(test_sides),
        cmocka_unit_test(test_many_back_faces),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
