/* The light buffer and triangles of every kind: slivers, degenerate, edge-on, huge and tiny ones,
 * alone and in closed meshes, as they are and as instances. Rays start anywhere, not only where a
 * camera looks. */
#include "light_buffer_testing.h"

#ifdef __SANITIZE_ADDRESS__
#define SHARE 10 /* of the rays */
#else
#define SHARE 1
#endif

static uint32_t seed = 1;

static double in(double low, double high)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return low + (high - low) * (double)(seed >> 8) / 16777216.0;
}

static double size_in(double low, double high)
{
    return low * pow(high / low, in(0, 1));
}

static vec direction(void)
{
    for (;;) {
        const vec v = v3(in(-1, 1), in(-1, 1), in(-1, 1));
        if (dot(v, v) > 0.01 && dot(v, v) < 1)
            return unit(v);
    }
}

static vec point(double half)
{
    return v3(in(-half, half), in(-half, half), in(-half, half));
}

/* Triangles, three corners each. */
typedef struct soup {
    vec *corners;
    size_t count, capacity;
} soup;

static void add_three(soup *s, vec a, vec b, vec c)
{
    if (s->count == s->capacity) {
        s->capacity = s->capacity * 2 + 256;
        s->corners = realloc(s->corners, s->capacity * 3 * sizeof *s->corners);
        assert_non_null(s->corners);
    }
    s->corners[3 * s->count] = a;
    s->corners[3 * s->count + 1] = b;
    s->corners[3 * s->count++ + 2] = c;
}

static uint32_t add_soup(gn_scene *scene, const soup *s)
{
    float *positions = malloc(s->count * 9 * sizeof *positions);
    uint32_t *indices = malloc(s->count * 3 * sizeof *indices);
    assert_true(positions && indices);
    for (size_t i = 0; i < s->count * 3; i++) {
        const double p[3] = {s->corners[i].x, s->corners[i].y, s->corners[i].z};
        for (int k = 0; k < 3; k++)
            positions[3 * i + (size_t)k] = (float)p[k];
        indices[i] = (uint32_t)i;
    }
    const gn_mesh_part part = {.vertex_count = (uint32_t)s->count * 3,
                               .positions = positions,
                               .index_count = (uint32_t)s->count * 3,
                               .indices = indices,
                               .material = GN_NONE};
    uint32_t mesh;
    ok(gn_scene_add_mesh(scene, "soup", &part, 1, &mesh));
    free(positions);
    free(indices);
    return mesh;
}

/* Of all kinds, in and around a cube of size 2. sun: some lie along its direction. */
static soup random_soup(size_t count, vec sun)
{
    soup s = {0};
    while (s.count < count) {
        const vec at = point(1), along = direction(), across = unit(cross(along, direction()));
        const double size = size_in(1e-3, 0.5);
        switch (s.count % 8) {
        case 0: /* slivers */
            add_three(
                &s, at, add(at, mul(along, size)),
                add(at, add(mul(along, 0.5 * size), mul(across, size * size_in(1e-7, 1e-2)))));
            break;
        case 1: /* lines and points */
            add_three(&s, at, add(at, mul(along, size)),
                      in(0, 1) < 0.5 ? at : add(at, mul(along, 2 * size)));
            break;
        case 2: /* edge-on */
            add_three(&s, at, add(at, mul(sun, size)), add(at, mul(across, size)));
            break;
        case 3: /* huge, but for a hole in the middle */
            add_three(&s, add(at, mul(along, 1.8)), add(at, add(mul(along, 1e5), mul(across, 1e5))),
                      add(at, add(mul(along, 1e5), mul(across, -1e4))));
            break;
        case 4: /* tiny */
            add_three(&s, at, add(at, mul(along, 1e-6)), add(at, mul(across, 1e-6)));
            break;
        case 5: /* one upon another, in one plane */
            add_three(&s, at, add(at, mul(along, size)), add(at, mul(across, size)));
            add_three(&s, add(at, mul(along, 0.2 * size)), add(at, mul(across, 0.8 * size)),
                      sub(at, mul(along, 0.5 * size)));
            break;
        default:
            add_three(&s, at, add(at, mul(direction(), size)), add(at, mul(direction(), size)));
        }
    }
    return s;
}

/* Receivers in the cube, and on triangles of the soup. */
static cloud soup_cloud(const gn_scene *scene, uint32_t light, const soup *s, uint32_t count)
{
    cloud c = new_cloud(count);
    for (uint32_t i = 0; i < count; i++) {
        vec p = point(1);
        if (i % 2) {
            const vec *t = s->corners + 3 * (size_t)(in(0, 1) * (double)s->count);
            const double u = in(0, 1), v = in(0, 1 - u);
            p = add(t[0], add(mul(sub(t[1], t[0]), u), mul(sub(t[2], t[0]), v)));
            if (dot(p, p) > 1e4)
                p = t[0];
        }
        const vec l = towards_light(scene, light, p);
        /* Not in rounding's reach of what it lies on, where each tracer has its own. */
        put_receiver(&c, i, p, unit(add(l, mul(direction(), 0.5))), 1e-4, 2e-3);
    }
    return c;
}

static void add_all_lights(gn_scene *scene, vec sun)
{
    add_sun(scene, sun);
    add_sun(scene, v3(0, 1, 0));
    add_lamp(scene, v3(0.1, 0.2, -0.1));
    add_lamp(scene, v3(3, 2, 1));
    add_spot(scene, v3(-1, 3, 1), v3(0, 0, 0), 0.6);
}

static void test_soups(void **state)
{
    (void)state;
    enum { RAYS = 40000 / SHARE };
    tally sum = {0};
    for (int k = 0; k < 3; k++) {
        const vec sun = direction();
        soup s = random_soup(1500, sun);
        gn_scene *scene = new_scene();
        place(scene, add_soup(scene, &s), k == 1);
        add_all_lights(scene, sun);
        ok(gn_scene_commit(scene));
        for (uint32_t light = 0; light < scene->light_count; light++) {
            cloud c = soup_cloud(scene, light, &s, RAYS);
            /* The wide bound: floats 1e5 m away, where huge triangles end, are 8 mm apart. */
            const gn_visibility_desc desc = ray_desc("ray-mip0", light, GN_TRACER_AUTO);
            compare_tracers(scene, &c.g, &desc, NULL, &sum, "soup");
            end_cloud(&c);
        }
        gn_scene_destroy(&scene);
        free(s.corners);
    }
    print_tally("soups", &sum);
    assert_true(sum.rays > 10 * RAYS && sum.tree_rays < sum.rays / 10);
    assert_true((double)sum.different <= fmax(5, 3e-5 * (double)sum.rays));
}

/* Closed meshes ------------------------------------------------------------------------------- */

/* Points of a sphere whose radius varies, and what lies in it: a blend of corners and the middle.
 */
static void test_closed(void **state)
{
    (void)state;
    enum { RAYS = 60000 / SHARE };
    size_t rays = 0, lit = 0;
    for (int k = 0; k < 16; k++) {
        gn_scene *scene = new_scene();
        /* Scaled unevenly, mirrored, turned; flat as a leaf or long as a needle; on its own or an
         * instance; at the origin or far from it. */
        gn_node_desc node = gn_node_desc_default();
        const double far = k % 4 < 2 ? 0 : 100, size = size_in(1e-2, 1e2);
        for (int i = 0; i < 3; i++) {
            node.scale[i] = (float)(size * (k % 3 == 2 ? size_in(1e-3, 1) : size_in(0.3, 1)));
            node.translation[i] = (float)(in(-1, 1) * far * size);
            node.rotation[i] = k % 5 == 0 ? 0.0f : (float)in(-1, 1);
        }
        if (k % 2)
            node.scale[k % 3] *= -1.0f;
        node.mesh = k % 4 == 3 ? add_box(scene, v3(-1, -1, -1), v3(1, 1, 1), GN_NONE)
                               : add_sphere(scene, v3(0, 0, 0), 1, 2u + (uint32_t)k * 2, GN_NONE);
        place_desc(scene, &node, k % 2);
        ok(gn_scene_commit(scene));
        float world[16];
        memcpy(world, scene->nodes[0].world, sizeof world);
        const vec middle = transform(world, v3(0, 0, 0));
        add_sun(scene, k % 5 == 0 ? v3(0, 1, 0) : direction());
        add_lamp(scene, add(middle, mul(direction(), size * size_in(2, 20))));
        ok(gn_scene_commit(scene));
        for (uint32_t light = 0; light < 2; light++) {
            cloud c = new_cloud(RAYS);
            for (uint32_t i = 0; i < RAYS; i++) {
                /* Inside the largest sphere that fits in, however few triangles there are. */
                const vec p = transform(world, mul(direction(), 0.55 * in(0, 1)));
                put_receiver(&c, i, p, towards_light(scene, light, p), 0, 1e-2 * size);
            }
            float *visibility = calloc(RAYS, sizeof *visibility);
            assert_non_null(visibility);
            const gn_visibility_desc desc = ray_desc("ray", light, GN_TRACER_LIGHT_BUFFER);
            gn_visibility_stats stats = {0};
            ok(gn_scene_visibility(scene, &c.g, &desc, visibility, &stats));
            assert_true(stats.light_buffer.tree_rays < stats.rays / 10 + 1);
            rays += stats.rays;
            for (uint32_t i = 0; i < RAYS; i++)
                lit += visibility[i] > 0;
            if (lit > 0)
                fail_msg("mesh %d, light %u: %zu of %d receivers inside are lit", k, light, lit,
                         (int)RAYS);
            free(visibility);
            end_cloud(&c);
        }
        gn_scene_destroy(&scene);
    }
    print_message("%zu rays from inside of closed meshes, none comes out\n", rays);
    assert_true(rays > 20 * RAYS);
}

/* Planes -------------------------------------------------------------------------------------- */

/* Planes of any size, tilt and place, as many triangles in one plane as there are, at grazing
 * angles: rounding has them lie upon each other, and which is upper it alone knows. What the camera
 * sees should be lit, and is where the tree finds it lit. */
static void test_planes(void **state)
{
    (void)state;
    size_t rays = 0, worse = 0, better = 0;
    for (int k = 0; k < 30; k++) {
        const vec n = direction(), s = unit(cross(n, direction())), t = cross(n, s);
        const double size = size_in(1e-3, 1e4), far = size * size_in(0.01, 100);
        const vec middle = mul(direction(), far);
        soup triangles = {0};
        for (int i = 0; i < 40; i++) {
            vec corner[3];
            for (int j = 0; j < 3; j++)
                corner[j] = add(middle, add(mul(s, size * in(-1, 1) * (i == 0 ? 30 : 1)),
                                            mul(t, size * in(-1, 1) * (i == 0 ? 30 : 1))));
            add_three(&triangles, corner[0], corner[1], corner[2]);
        }
        gn_scene *scene = new_scene();
        place(scene, add_soup(scene, &triangles), k & 1);
        const uint32_t camera = add_camera(scene, add(middle, mul(add(n, mul(s, in(-1, 1))), size)),
                                           middle, 0.8, 1e-3 * size);
        add_sun(scene, add(n, mul(t, size_in(0.1, 100))));
        add_lamp(scene, add(middle, add(mul(n, size * size_in(0.02, 10)), mul(s, size))));
        gn_view *view = new_view(48, 48);
        const gn_gbuffer *g = look(view, scene, camera, 0);
        float tree[48 * 48], grid[48 * 48];
        for (uint32_t light = 0; light < 2; light++) {
            gn_visibility_desc desc = ray_desc("ray", light, GN_TRACER_BVH);
            gn_visibility_stats stats = {0};
            ok(gn_scene_visibility(scene, g, &desc, tree, &stats));
            desc.tracer = GN_TRACER_LIGHT_BUFFER;
            ok(gn_scene_visibility(scene, g, &desc, grid, NULL));
            for (size_t i = 0; i < 48 * 48; i++) {
                worse += grid[i] < 0.5f && tree[i] > 0.5f;
                better += grid[i] > 0.5f && tree[i] < 0.5f;
            }
            rays += stats.rays;
        }
        gn_view_destroy(&view);
        gn_scene_destroy(&scene);
        free(triangles.corners);
    }
    print_message("%zu rays from planes; dark where the tree finds light: %zu, light where it does "
                  "not: %zu\n",
                  rays, worse, better);
    assert_true(rays > 20000 && (double)worse <= 1e-4 * (double)rays);
}

/* A convex shape is lit wherever it faces the light, but for angles at which the rounding of its
 * corners turns its triangles away. */
static void test_no_acne(void **state)
{
    (void)state;
    static const double sizes[] = {1, 1e-3, 1e3};
    size_t rays = 0;
    for (int k = 0; k < 9; k++) {
        const double size = sizes[k % 3];
        const vec middle = mul(direction(), k % 2 ? 300 * size : 0);
        gn_scene *scene = new_scene();
        gn_node_desc node = gn_node_desc_default();
        node.mesh = add_sphere(scene, v3(0, 0, 0), size, 24, GN_NONE);
        node.translation[0] = (float)middle.x;
        node.translation[1] = (float)middle.y;
        node.translation[2] = (float)middle.z;
        place_desc(scene, &node, k % 4 < 2);
        const uint32_t camera =
            add_camera(scene, add(middle, mul(direction(), 3 * size)), middle, 0.8, 0.01 * size);
        add_sun(scene, direction());
        add_lamp(scene, add(middle, mul(direction(), 4 * size)));
        gn_view *view = new_view(96, 96);
        const gn_gbuffer *g = look(view, scene, camera, 0);
        float *visibility = calloc((size_t)96 * 96, sizeof *visibility);
        assert_non_null(visibility);
        for (uint32_t light = 0; light < 2; light++) {
            tally sum = {0};
            const gn_visibility_desc desc = ray_desc("ray", light, GN_TRACER_AUTO);
            compare_tracers(scene, g, &desc, visibility, &sum, "sphere");
            rays += sum.rays;
            for (size_t i = 0; i < (size_t)96 * 96; i++) {
                if (g->surface[i] == GN_NONE)
                    continue;
                const double cosine =
                    dot(normal_at(g, i), towards_light(scene, light, position_at(g, i)));
                if (cosine > 2e-3 && visibility[i] != 1)
                    fail_msg("sphere %d, light %u: %g at a cosine of %g", k, light,
                             (double)visibility[i], cosine);
            }
        }
        free(visibility);
        gn_view_destroy(&view);
        gn_scene_destroy(&scene);
    }
    print_message("%zu rays from spheres\n", rays);
    assert_true(rays > 20000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_soups), cmocka_unit_test(test_closed),
                                       cmocka_unit_test(test_planes),
                                       cmocka_unit_test(test_no_acne)};
    return cmocka_run_group_tests(tests, open_device, close_device);
}
