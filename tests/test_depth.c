/* Depth maps: drawn by tiles as rays see them. */
#include "depth_testing.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes),  cmocka_unit_test(test_alpha_rules),
        cmocka_unit_test(test_opacity), cmocka_unit_test(test_wrapped_textures),
        cmocka_unit_test(test_soups),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
