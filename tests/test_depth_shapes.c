/* Depth maps: closed, of known shapes, split by casters; the same bits everywhere. */
#include "depth_testing.h"

/* Static and moving casters -------------------------------------------------------------------*/

static void test_casters(void **state)
{
    (void)state;
    random_state = 3;
    gn_scene *scene = new_scene();
    const vec along = v3(0, -1, 0);
    place(scene, add_soup(scene, ANY, 100, along), false);
    place(scene, add_soup(scene, ANY, 100, along), true);
    ok(gn_scene_commit(scene));
    const gn_map_projection p = look(v3(3, 9, 1), v3(0, 0, 0), false, 5, 0, 20, 200);
    size_t moving = 0, still = 0;
    for (int rays = 0; rays < 2; rays++) {
        map maps[3];
        for (int c = 0; c < 3; c++)
            maps[c] = draw(scene, &p, (settings){(gn_casters)c, GN_MAP_ALPHA_TEST, 1, rays});
        for (size_t i = 0; i < maps[0].texels; i++) {
            const float nearer =
                fminf(maps[GN_CASTERS_STATIC].depth[i], maps[GN_CASTERS_DYNAMIC].depth[i]);
            still += maps[GN_CASTERS_STATIC].depth[i] < 1;
            moving += maps[GN_CASTERS_DYNAMIC].depth[i] < 1;
            if (nearer != maps[GN_CASTERS_ALL].depth[i])
                fail_msg("texel %zu: %.9g of both, %.9g of all", i, (double)nearer,
                         (double)maps[GN_CASTERS_ALL].depth[i]);
        }
        for (int c = 0; c < 3; c++)
            free(maps[c].depth);
    }
    assert_true(still > 1000 && moving > 1000);

    /* A node that begins to move changes sides. */
    const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5f, 0, 0, 1};
    ok(gn_scene_set_node_matrix(scene, 0, matrix));
    ok(gn_scene_commit(scene));
    for (int rays = 0; rays < 2; rays++) {
        const map none = draw(scene, &p, (settings){GN_CASTERS_STATIC, GN_MAP_ALPHA_TEST, 1, rays});
        for (size_t i = 0; i < none.texels; i++)
            assert_true(none.depth[i] == 1);
        assert_true(none.covered.x0 >= none.covered.x1);
        free(none.depth);
    }
    gn_scene_destroy(&scene);
}

/* Shapes that are known -----------------------------------------------------------------------*/

/* A sphere of many triangles, large and below a texel, has no hole and its own depth. */
static void test_sphere(void **state)
{
    (void)state;
    static const uint32_t sides[] = {3, 16, 90}, resolutions[] = {16, 200, 333};
    for (int s = 0; s < 3; s++) {
        gn_scene *scene = new_scene();
        place(scene, add_sphere(scene, v3(0.1, 0.2, 0.3), 2, sides[s], GN_NONE), false);
        ok(gn_scene_commit(scene));
        for (int r = 0; r < 3; r++)
            for (int perspective = 0; perspective < 2; perspective++) {
                const gn_map_projection p = look(v3(3.1, 8.2, 1.3), v3(0.1, 0.2, 0.3), perspective,
                                                 2.5, 1, 20, resolutions[r]);
                const map m = draw_simply(scene, &p, 4);
                const double reach = length(v3(3, 8, 1));
                /* The inscribed sphere of the coarsest one. */
                const double radius = sides[s] == 3 ? 1.7 : 1.95;
                const double tangent = radius / sqrt(reach * reach - radius * radius);
                const double inside = perspective ? tangent / (double)p.extent : radius / 2.5;
                size_t covered = 0;
                for (size_t i = 0; i < m.texels; i++) {
                    const size_t texel = i % (m.texels / 4), plane = i / (m.texels / 4);
                    const double half = 0.5 * resolutions[r];
                    const double x =
                        (double)(texel % resolutions[r]) + (double)gn_map_samples[plane][0] - half;
                    const double y =
                        (double)(texel / resolutions[r]) + (double)gn_map_samples[plane][1] - half;
                    if (x * x + y * y > inside * inside * half * half)
                        continue;
                    covered++;
                    if (!(m.depth[i] < 1))
                        fail_msg("a hole at sample %zu of sphere %u, %u texels, perspective %d", i,
                                 sides[s], resolutions[r], perspective);
                    const double nearest = (reach - 2 - 1) / 19;
                    assert_true((double)m.depth[i] > nearest - 1e-5 &&
                                (double)m.depth[i] < (reach - 1) / 19);
                }
                assert_true(covered > m.texels / 4);
                free(m.depth);
            }
        gn_scene_destroy(&scene);
    }
}

/* Ground far larger than the map, of no symmetry: full, at the plane's depth. */
static void test_ground(void **state)
{
    (void)state;
    for (double half = 10; half < 1e6; half *= 30)
        for (int perspective = 0; perspective < 2; perspective++) {
            gn_scene *scene = new_scene();
            const vec corners[4] = {v3(-half, 0, 0.7 * half), v3(1.3 * half, 0, half),
                                    v3(0.9 * half, 0, -1.1 * half), v3(-0.8 * half, 0, -half)};
            place(scene, add_quad(scene, corners, 1, GN_NONE), half > 1e3);
            ok(gn_scene_commit(scene));
            const gn_map_projection p =
                look(v3(3, 9, 2), v3(0, 0, 0), perspective, 4, 0.5, 30, 300);
            const map m = draw_simply(scene, &p, 1);
            for (size_t i = 0; i < m.texels; i++) {
                const double x = (2 * ((double)(i % 300) + 0.5) / 300 - 1) * (double)p.extent;
                const double y = (1 - 2 * ((double)(i / 300) + 0.5) / 300) * (double)p.extent;
                vec o = v3((double)p.origin[0], (double)p.origin[1], (double)p.origin[2]);
                const vec side =
                    add(mul(v3((double)p.right[0], (double)p.right[1], (double)p.right[2]), x),
                        mul(v3((double)p.up[0], (double)p.up[1], (double)p.up[2]), y));
                vec d = v3((double)p.forward[0], (double)p.forward[1], (double)p.forward[2]);
                if (perspective)
                    d = add(d, side);
                else
                    o = add(o, side);
                const double expected = (-o.y / d.y - 0.5) / 29.5;
                if (fabs((double)m.depth[i] - expected) > QUANTUM)
                    fail_msg("ground of %g metres, perspective %d, texel %zu: %.9g, expected %.9g",
                             half, perspective, i, (double)m.depth[i], expected);
            }
            free(m.depth);
            gn_scene_destroy(&scene);
        }
}

/* A square of n^2 quads whose inner corners are moved about: no crack between any two. */
static void test_cracks(void **state)
{
    (void)state;
    random_state = 11;
    for (uint32_t n = 2; n < 300; n *= 5) {
        const uint32_t side = n + 1;
        float *positions = malloc((size_t)side * side * 3 * sizeof *positions);
        uint32_t *indices = malloc((size_t)n * n * 6 * sizeof *indices);
        assert_true(positions && indices);
        for (uint32_t i = 0; i < side * side; i++) {
            const uint32_t x = i % side, y = i / side;
            const bool border = x == 0 || y == 0 || x == n || y == n;
            /* As far as the neighbours: slivers. */
            const double dx = border ? 0 : random_between(-0.49, 0.49);
            const double dy = border ? 0 : random_between(-0.49, 0.49);
            positions[3 * i] = (float)(((double)x + dx) / n * 8 - 4);
            positions[3 * i + 1] = (float)random_between(-0.1, 0.1);
            positions[3 * i + 2] = (float)(((double)y + dy) / n * 8 - 4);
        }
        for (uint32_t i = 0; i < n * n; i++) {
            const uint32_t c = i / n * side + i % n;
            const uint32_t corners[6] = {c, c + side, c + 1, c + 1, c + side, c + side + 1};
            memcpy(indices + (size_t)i * 6, corners, sizeof corners);
        }
        const gn_mesh_part part = {.vertex_count = side * side,
                                   .positions = positions,
                                   .index_count = n * n * 6,
                                   .indices = indices,
                                   .material = GN_NONE};
        uint32_t mesh;
        gn_scene *scene = new_scene();
        ok(gn_scene_add_mesh(scene, "sheet", &part, 1, &mesh));
        place(scene, mesh, false);
        ok(gn_scene_commit(scene));
        for (int perspective = 0; perspective < 2; perspective++)
            for (uint32_t samples = 1; samples <= 4; samples += 3) {
                const gn_map_projection p =
                    look(v3(1, 9, 2), v3(0, 0, 0), perspective, 2.5, 0.5, 30, 256);
                const map m = draw_simply(scene, &p, samples);
                for (size_t i = 0; i < m.texels; i++)
                    if (!(m.depth[i] < 1))
                        fail_msg("a crack at sample %zu of %u^2 quads", i, n);
                free(m.depth);
            }
        gn_scene_destroy(&scene);
        free(positions);
        free(indices);
    }
}

/* Strips much longer than the map is wide, each sharing two long edges: no crack along them. */
static void test_long_edges(void **state)
{
    (void)state;
    enum { STRIPS = 150 };
    random_state = 13;
    for (double reach = 20; reach < 1e5; reach *= 15) {
        float positions[(STRIPS + 1) * 6];
        uint32_t indices[STRIPS * 6];
        for (uint32_t i = 0; i <= STRIPS; i++) {
            const double z = 8.0 * i / STRIPS - 4, turn = i == 0 || i == STRIPS ? 0 : 0.01;
            for (uint32_t end = 0; end < 2; end++) {
                const double x = (end ? 1 : -0.8) * reach * random_between(0.9, 1);
                positions[6 * i + 3 * end] = (float)x;
                positions[6 * i + 3 * end + 1] = 0;
                /* All edges turn about the middle alike, so that strips do not cross. */
                positions[6 * i + 3 * end + 2] = (float)(z + turn * z * x / reach);
            }
            const uint32_t c = 2 * i, corners[6] = {c, c + 1, c + 2, c + 2, c + 1, c + 3};
            if (i < STRIPS)
                memcpy(indices + (size_t)i * 6, corners, sizeof corners);
        }
        const gn_mesh_part part = {.vertex_count = 2 * (STRIPS + 1),
                                   .positions = positions,
                                   .index_count = STRIPS * 6,
                                   .indices = indices,
                                   .material = GN_NONE};
        uint32_t mesh;
        gn_scene *scene = new_scene();
        ok(gn_scene_add_mesh(scene, "strips", &part, 1, &mesh));
        place(scene, mesh, false);
        ok(gn_scene_commit(scene));
        for (int turn = 0; turn < 8; turn++) {
            const gn_map_projection p = look(v3(0.3 * turn - 1, 9, 2 - 0.2 * turn), v3(0, 0, 0),
                                             turn & 1, 2.5, 0.5, 30, 512);
            const map m = draw_simply(scene, &p, 1);
            for (size_t i = 0; i < m.texels; i++)
                if (!(m.depth[i] < 1))
                    fail_msg("a crack at sample %zu, strips of %g metres, view %d", i, reach, turn);
            free(m.depth);
        }
        gn_scene_destroy(&scene);
    }
}

/* Nearer than near: on the near plane of a sun, unseen by a lamp; beyond far: nowhere. */
static void test_range(void **state)
{
    (void)state;
    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 10, 5, GN_NONE), false);
    ok(gn_scene_commit(scene));
    const struct {
        bool perspective;
        double near, far;
        float depth;
    } cases[] = {{false, 6, 9, 0}, {false, 1, 4, 1},     {true, 6, 9, 1},
                 {true, 1, 4, 1},  {false, 4, 8, 0.25f}, {true, 4, 8, 0.25f}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const gn_map_projection p = look(v3(0, 10, 0), v3(0, 0, 0), cases[c].perspective, 2,
                                         cases[c].near, cases[c].far, 64);
        for (int rays = 0; rays < 2; rays++) {
            const map m = draw(scene, &p, (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, 1, rays});
            for (size_t i = 0; i < m.texels; i++)
                if (!(fabsf(m.depth[i] - cases[c].depth) < 1e-6f))
                    fail_msg("case %zu, rays %d, texel %zu: %.9g, expected %.9g", c, rays, i,
                             (double)m.depth[i], (double)cases[c].depth);
            free(m.depth);
        }
    }
    gn_scene_destroy(&scene);
}

static void test_covered(void **state)
{
    (void)state;
    gn_scene *scene = new_scene();
    place(scene, add_box(scene, v3(-1, 0, -0.5), v3(0.3, 1, 0.7), GN_NONE), false);
    ok(gn_scene_commit(scene));
    for (int where = 0; where < 4; where++) {
        const vec to = v3(where * 1.7 - 2, 0, where - 1.5);
        const gn_map_projection p = look(add(to, v3(1, 9, 2)), to, where & 1, 3, 1, 30, 303);
        map drawn = draw_simply(scene, &p, 4);
        map traced = draw(scene, &p, (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, 4, true});
        size_t seen = 0;
        for (size_t i = 0; i < drawn.texels; i++) {
            const uint32_t x = (uint32_t)(i % 303), y = (uint32_t)(i / 303 % 303);
            if (!(drawn.depth[i] < 1))
                continue;
            seen++;
            assert_true(x >= drawn.covered.x0 && x < drawn.covered.x1);
            assert_true(y >= drawn.covered.y0 && y < drawn.covered.y1);
        }
        assert_true(seen > 100);
        /* Not much larger than need be: to whole blocks of 4. */
        assert_true(drawn.covered.x0 + 5 > traced.covered.x0 &&
                    drawn.covered.x1 < traced.covered.x1 + 5);
        assert_true(drawn.covered.y0 + 5 > traced.covered.y0 &&
                    drawn.covered.y1 < traced.covered.y1 + 5);
        free(drawn.depth);
        free(traced.depth);
    }
    const gn_map_projection away = look(v3(50, 9, 2), v3(50, 0, 0), false, 3, 1, 30, 64);
    const map nothing = draw_simply(scene, &away, 1);
    for (size_t i = 0; i < nothing.texels; i++)
        assert_true(nothing.depth[i] == 1);
    assert_true(nothing.covered.x0 >= nothing.covered.x1);
    free(nothing.depth);
    gn_scene_destroy(&scene);
}

/* The same bits ------------------------------------------------------------------------------ */

static void test_determinism(void **state)
{
    (void)state;
    static const struct {
        uint32_t threads;
        gn_isa isa;
    } devices[] = {{1, GN_ISA_SCALAR},
                   {2, GN_ISA_AUTO},
                   {4, GN_ISA_AUTO},
                   {4, GN_ISA_AVX2},
                   {1, GN_ISA_AVX512}};
    enum { VIEWS = 12 };
    map first[KINDS][VIEWS];
    for (size_t d = 0; d < sizeof devices / sizeof *devices; d++) {
        gn_device *other;
        gn_device_desc desc = gn_device_desc_default();
        desc.threads = devices[d].threads;
        desc.isa = devices[d].isa;
        const gn_result made = gn_device_create(&desc, &other);
        if (made == GN_ERROR_UNSUPPORTED)
            continue; /* this processor lacks it */
        assert_int_equal(made, GN_OK);
        for (size_t k = 0; k < KINDS; k++) {
            gn_scene *scene = built_in(other, kinds[k], 0.1);
            for (int v = 0; v < VIEWS; v++) {
                const gn_map_projection p = view_of(scene, v & 1, 300);
                const map m = draw(scene, &p,
                                   (settings){GN_CASTERS_ALL,
                                              v < 8 ? (gn_map_alpha)(v / 2) : GN_MAP_ALPHA_TEST,
                                              v < 10 ? 1 : 4, false});
                if (d == 0) {
                    first[k][v] = m;
                    continue;
                }
                if (memcmp(m.depth, first[k][v].depth, m.texels * sizeof *m.depth) != 0)
                    fail_msg("%s, view %d, %u threads, %s: other bits", kinds[k], v,
                             devices[d].threads, gn_device_get_info(other).isa_name);
                assert_memory_equal(&m.covered, &first[k][v].covered, sizeof m.covered);
                free(m.depth);
            }
            gn_scene_destroy(&scene);
        }
        gn_device_destroy(&other);
    }
    for (size_t k = 0; k < KINDS; k++)
        for (int v = 0; v < VIEWS; v++)
            free(first[k][v].depth);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_casters),    cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_ground),     cmocka_unit_test(test_cracks),
        cmocka_unit_test(test_long_edges), cmocka_unit_test(test_range),
        cmocka_unit_test(test_covered),    cmocka_unit_test(test_determinism),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
