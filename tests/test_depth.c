/* Depth maps: drawn by tiles as rays see them; closed; the same bits everywhere. */
#include "render_testing.h"

#include "cpu/cpu.h"
#include "cpu/map.h"
#include "render/device.h"

#define QUANTUM (1.0 / 65535.0)

/* Views ---------------------------------------------------------------------------------------*/

/* From `from` to `to`, half-width `half` there, from `near` to `far` metres. */
static gn_map_projection look(vec from, vec to, bool perspective, double half, double near,
                              double far, uint32_t resolution)
{
    float m[16];
    aim(from, to, m);
    const double reach = length(sub(to, from));
    gn_map_projection p = {.perspective = perspective,
                           .extent = (float)(perspective ? half / reach : half),
                           .near = (float)near,
                           .far = (float)far,
                           .resolution = resolution};
    for (int i = 0; i < 3; i++) {
        p.right[i] = m[i];
        p.up[i] = m[4 + i];
        p.forward[i] = -m[8 + i];
        p.origin[i] = m[12 + i];
    }
    return p;
}

typedef struct map {
    float *depth;
    size_t texels; /* of all planes */
    gn_rect covered;
} map;

typedef struct settings {
    gn_casters casters;
    gn_map_alpha alpha;
    uint32_t samples;
    bool rays;
} settings;

static map draw(const gn_scene *scene, const gn_map_projection *p, settings s)
{
    map m = {.texels = (size_t)p->resolution * p->resolution * s.samples};
    m.depth = malloc(m.texels * sizeof *m.depth);
    assert_non_null(m.depth);
    for (size_t i = 0; i < m.texels; i++)
        m.depth[i] = NAN; /* each must be written */
    gn_depth_job job = {.scene = scene,
                        .projection = *p,
                        .casters = s.casters,
                        .alpha = s.alpha,
                        .samples = s.samples,
                        .depth = m.depth};
    ok(s.rays ? gn_cpu_depth_rays(&scene->device->cpu, &job)
              : gn_cpu_depth(&scene->device->cpu, &job));
    m.covered = job.covered;
    return m;
}

static map draw_simply(const gn_scene *scene, const gn_map_projection *p, uint32_t samples)
{
    return draw(scene, p, (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, samples, false});
}

/* Where the surface breaks: a second difference between neighbours of more than 1e-4. */
static bool at_edge(const float *plane, uint32_t resolution, uint32_t x, uint32_t y)
{
    if (x == 0 || y == 0 || x + 1 == resolution || y + 1 == resolution)
        return true;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) {
            const int along = dy * (int)resolution + dx;
            const float *here = plane + (size_t)y * resolution + x;
            if (fabsf(here[along] + here[-along] - 2.0f * here[0]) > 1e-4f)
                return true;
        }
    return false;
}

typedef struct agreement {
    size_t texels, different, inside; /* inside: different away from edges */
} agreement;

static void compare_maps(const map *drawn, const map *traced, uint32_t resolution, agreement *sum)
{
    const size_t plane = (size_t)resolution * resolution;
    for (size_t i = 0; i < drawn->texels; i++) {
        assert_true(drawn->depth[i] >= 0 && drawn->depth[i] <= 1);
        sum->texels++;
        if (fabs((double)drawn->depth[i] - (double)traced->depth[i]) <= QUANTUM)
            continue;
        sum->different++;
        sum->inside +=
            !at_edge(traced->depth + i / plane * plane, resolution,
                     (uint32_t)(i % plane % resolution), (uint32_t)(i % plane / resolution));
    }
}

/* Draws and traces, and adds up where they differ. */
static void check(const gn_scene *scene, const gn_map_projection *p, settings s, agreement *sum)
{
    s.rays = false;
    map drawn = draw(scene, p, s);
    s.rays = true;
    map traced = draw(scene, p, s);
    compare_maps(&drawn, &traced, p->resolution, sum);
    free(drawn.depth);
    free(traced.depth);
}

static void report(const char *what, const agreement *sum, double most, double most_inside)
{
    print_message("%s: %zu of %zu texels differ by more than a quantum (%.4f %%), %zu away from "
                  "edges\n",
                  what, sum->different, sum->texels,
                  100.0 * (double)sum->different / (double)sum->texels, sum->inside);
    few(sum->different, sum->texels, most, "%s", what);
    few(sum->inside, sum->texels, most_inside, "%s, away from edges", what);
}

static gn_scene *built_in(gn_device *on, const char *kind, double scale)
{
    gn_scene *scene;
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = scale;
    ok(gn_scene_create_procedural(on, kind, &desc, &scene));
    ok(gn_scene_set_time(scene, 0.7));
    ok(gn_scene_commit(scene));
    return scene;
}

/* Around what the first camera of a scene sees. */
static gn_map_projection view_of(const gn_scene *scene, bool perspective, uint32_t resolution)
{
    const float *camera = scene->cameras[0].world;
    const vec eye = v3((double)camera[12], (double)camera[13], (double)camera[14]);
    const vec back = v3((double)camera[8], (double)camera[9], (double)camera[10]);
    const vec target = add(eye, mul(back, -5));
    const vec from = add(target, v3(9, 21, 7));
    return look(from, target, perspective, 7, perspective ? 0.1 : 0, 60, resolution);
}

static const char *const kinds[] = {"grove", "court", "leafbox", "railing"};
#define KINDS (sizeof kinds / sizeof *kinds)

/* Scenes --------------------------------------------------------------------------------------*/

static void test_scenes(void **state)
{
    (void)state;
    static const uint32_t resolutions[] = {16, 131, 512};
    for (size_t k = 0; k < KINDS; k++) {
        gn_scene *scene = built_in(device, kinds[k], 0.2);
        agreement sum = {0};
        for (int r = 0; r < 3; r++)
            for (int perspective = 0; perspective < 2; perspective++)
                for (uint32_t samples = 1; samples <= 4; samples += 3) {
                    const gn_map_projection p = view_of(scene, perspective, resolutions[r]);
                    check(scene, &p, (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, samples, false},
                          &sum);
                }
        report(kinds[k], &sum, 0.004, 2e-6);
        gn_scene_destroy(&scene);
    }
}

static uint64_t random_state;

static double random_between(double low, double high)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(random_state >> 40) / 16777216.0;
}

static void test_alpha_rules(void **state)
{
    (void)state;
    static const char *const names[] = {"test", "mip0", "hashed", "opaque"};
    gn_scene *scenes[2] = {built_in(device, "leafbox", 0.3), built_in(device, "grove", 0.2)};
    for (int alpha = 0; alpha < 4; alpha++) {
        agreement sum = {0};
        for (int s = 0; s < 2; s++)
            for (int perspective = 0; perspective < 2; perspective++) {
                const gn_map_projection p = view_of(scenes[s], perspective, 384);
                check(scenes[s], &p, (settings){GN_CASTERS_ALL, (gn_map_alpha)alpha, 1, false},
                      &sum);
            }
        report(names[alpha], &sum, 0.004, 1e-5);
    }
    gn_scene_destroy(&scenes[0]);
    gn_scene_destroy(&scenes[1]);
}

/* A square of one alpha, seen straight on and obliquely. */
static double blocked_share(double opacity, gn_alpha_mode mode, gn_map_alpha rule, bool perspective)
{
    gn_scene *scene = new_scene();
    gn_material_desc desc = gn_material_desc_default();
    desc.alpha_mode = mode;
    desc.base_color[3] = (float)opacity;
    desc.double_sided = true;
    uint32_t material;
    ok(gn_scene_add_material(scene, &desc, &material));
    place(scene, add_floor(scene, 10, 0.3, material), false);
    ok(gn_scene_commit(scene));
    const gn_map_projection p = look(v3(4, 20, 3), v3(0, 0, 0), perspective, 3, 1, 40, 256);
    const map m = draw(scene, &p, (settings){GN_CASTERS_ALL, rule, 1, false});
    size_t blocked = 0;
    for (size_t i = 0; i < m.texels; i++)
        blocked += m.depth[i] < 1;
    free(m.depth);
    gn_scene_destroy(&scene);
    return (double)blocked / (double)m.texels;
}

static void near_share(double share, double expected, double tolerance, const char *what)
{
    if (!(fabs(share - expected) <= tolerance))
        fail_msg("%s: a share of %g is blocked, expected %g", what, share, expected);
}

static void test_opacity(void **state)
{
    (void)state;
    for (int perspective = 0; perspective < 2; perspective++) {
        for (double opacity = 0.2; opacity < 1; opacity += 0.3) {
            const double passes = opacity >= 0.5;
            near_share(blocked_share(opacity, GN_ALPHA_BLEND, GN_MAP_ALPHA_TEST, perspective),
                       passes, 0, "blend, test");
            near_share(blocked_share(opacity, GN_ALPHA_BLEND, GN_MAP_ALPHA_MIP0, perspective),
                       passes, 0, "blend, mip 0");
            /* Stored alpha has 8 bits; the noise is of 65536 texels. */
            near_share(blocked_share(opacity, GN_ALPHA_BLEND, GN_MAP_ALPHA_HASHED, perspective),
                       opacity, 0.015, "blend, hashed");
            near_share(blocked_share(opacity, GN_ALPHA_MASK, GN_MAP_ALPHA_HASHED, perspective),
                       passes, 0, "mask, hashed");
        }
        near_share(blocked_share(0.2, GN_ALPHA_BLEND, GN_MAP_ALPHA_OPAQUE, perspective), 1, 0,
                   "opaque");
    }
}

/* Sixteen places at a time, one by one, and where rays hit: texture coordinates far outside [0, 1],
 * each wrap rule, textures of any size. */
static void test_wrapped_textures(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {2, 8}, {64, 64}, {7, 31}};
    random_state = 5;
    agreement sum = {0};
    for (int wrap = 0; wrap < 9; wrap++)
        for (int size = 0; size < 4; size++) {
            const uint32_t width = sizes[size][0], height = sizes[size][1];
            uint8_t rgba[64 * 64 * 4];
            for (uint32_t i = 0; i < width * height * 4; i++)
                rgba[i] = random_between(0, 1) < 0.5 ? 20 : 230;
            gn_scene *scene = new_scene();
            gn_texture_desc texture = gn_texture_desc_default();
            texture.width = width;
            texture.height = height;
            texture.rgba = rgba;
            gn_material_desc desc = gn_material_desc_default();
            ok(gn_scene_add_texture(scene, &texture, &desc.texture));
            desc.alpha_mode = GN_ALPHA_MASK;
            desc.double_sided = true;
            desc.wrap_u = (gn_wrap)(wrap % 3);
            desc.wrap_v = (gn_wrap)(wrap / 3);
            /* From -2.3 to 3.2 turns, or back. */
            const float turns[6] = {
                wrap & 1 ? -5.5f : 5.5f, 0, wrap & 1 ? 3.2f : -2.3f, 0, 5.5f, -2.7f};
            memcpy(desc.uv_transform, turns, sizeof turns);
            uint32_t material;
            ok(gn_scene_add_material(scene, &desc, &material));
            place(scene, add_floor(scene, 3, 0.3, material), wrap & 2);
            ok(gn_scene_commit(scene));
            const gn_map_projection p =
                look(v3(1, 9, 2), v3(0, 0, 0), size & 1, 3.5, 0.5, 30, size < 2 ? 300 : 96);
            check(scene, &p, (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, 1, false}, &sum);
            gn_scene_destroy(&scene);
        }
    report("wrapped textures", &sum, 0.004, 1e-5);
}

/* Soups ---------------------------------------------------------------------------------------*/

static vec random_point(double size)
{
    const double x = random_between(-size, size), y = random_between(-size, size);
    return v3(x, y, random_between(-size, size));
}

typedef enum shape { ANY, SLIVER, DEGENERATE, EDGE_ON, HUGE_ONE, TINY, SHAPES } shape;

/* Corners of a triangle around the origin, for light that travels along `along`. */
static void random_triangle(shape kind, vec along, vec p[3])
{
    const vec at = random_point(4);
    const double size = kind == HUGE_ONE ? 3e4 : kind == TINY ? 0.01 : 1.5;
    for (int i = 0; i < 3; i++)
        p[i] = add(at, random_point(size));
    const vec middle = add(p[0], mul(sub(p[1], p[0]), random_between(0, 1)));
    if (kind == SLIVER)
        p[2] = add(middle, random_point(1e-4));
    if (kind == DEGENERATE)
        p[2] = random_between(0, 1) < 0.5 ? p[1] : mul(add(p[0], p[1]), 0.5);
    if (kind == EDGE_ON)
        p[2] = add(middle, mul(along, random_between(-2, 2)));
}

static uint32_t add_soup(gn_scene *scene, shape kind, uint32_t count, vec along)
{
    float *positions = malloc((size_t)count * 9 * sizeof *positions);
    uint32_t *indices = malloc((size_t)count * 3 * sizeof *indices), mesh;
    assert_true(positions && indices);
    for (uint32_t i = 0; i < count; i++) {
        vec p[3];
        random_triangle(kind == SHAPES ? (shape)(i % SHAPES) : kind, along, p);
        for (uint32_t c = 0; c < 3; c++) {
            positions[9 * i + 3 * c] = (float)p[c].x;
            positions[9 * i + 3 * c + 1] = (float)p[c].y;
            positions[9 * i + 3 * c + 2] = (float)p[c].z;
            indices[3 * i + c] = 3 * i + c;
        }
    }
    const gn_mesh_part part = {.vertex_count = 3 * count,
                               .positions = positions,
                               .index_count = 3 * count,
                               .indices = indices,
                               .material = GN_NONE};
    ok(gn_scene_add_mesh(scene, "soup", &part, 1, &mesh));
    free(positions);
    free(indices);
    return mesh;
}

static void test_soups(void **state)
{
    (void)state;
    static const char *const names[SHAPES] = {"any",     "slivers", "degenerate",
                                              "edge-on", "huge",    "tiny"};
    random_state = 7;
    for (int kind = 0; kind < SHAPES; kind++) {
        agreement sum = {0};
        for (int turn = 0; turn < 3; turn++) {
            const vec from = add(mul(unit(random_point(1)), 9), v3(0, 2, 0));
            gn_scene *scene = new_scene();
            place(scene, add_soup(scene, (shape)kind, kind == HUGE_ONE ? 6 : 400, unit(from)),
                  turn == 1);
            ok(gn_scene_commit(scene));
            /* near 3: some are behind the light. */
            for (int perspective = 0; perspective < 2; perspective++) {
                const gn_map_projection p =
                    look(from, v3(0, 0, 0), perspective, 5, perspective ? 3 : 6, 16, 256);
                check(scene, &p,
                      (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, turn == 2 ? 4 : 1, false},
                      &sum);
            }
            gn_scene_destroy(&scene);
        }
        report(names[kind], &sum, 0.004, 2e-5);
    }
}

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
        cmocka_unit_test(test_scenes),      cmocka_unit_test(test_alpha_rules),
        cmocka_unit_test(test_opacity),     cmocka_unit_test(test_wrapped_textures),
        cmocka_unit_test(test_soups),       cmocka_unit_test(test_casters),
        cmocka_unit_test(test_sphere),      cmocka_unit_test(test_ground),
        cmocka_unit_test(test_cracks),      cmocka_unit_test(test_long_edges),
        cmocka_unit_test(test_range),       cmocka_unit_test(test_covered),
        cmocka_unit_test(test_determinism),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
