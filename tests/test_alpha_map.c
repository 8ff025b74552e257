/* Alpha maps: the share of passing texels, coverage and averages, each beside an
 * independent computation in doubles. */
#include "texture_testing.h"

/* Patterns ----------------------------------------------------------------------------------- */

static uint8_t discs(uint32_t x, uint32_t y)
{
    const double dx = (x % 40) - 19.5, dy = (y % 40) - 19.5, edge = 14 - sqrt(dx * dx + dy * dy);
    return (uint8_t)(255 * fmin(fmax(edge / 3 + 0.5, 0), 1));
}

static uint8_t hard_discs(uint32_t x, uint32_t y)
{
    const double dx = (x % 23) - 11.0, dy = (y % 23) - 11.0;
    return dx * dx + dy * dy < 81 ? 255 : 0;
}

static uint8_t noise(uint32_t x, uint32_t y)
{
    (void)x, (void)y;
    return (uint8_t)next_random();
}

static uint8_t sparse(uint32_t x, uint32_t y)
{
    (void)x, (void)y;
    return next_random() % 50 == 0 ? 200 : 0;
}

static uint8_t checkers(uint32_t x, uint32_t y)
{
    return (x + y) % 2 ? 255 : 0;
}

static uint8_t wide_checkers(uint32_t x, uint32_t y)
{
    return (x / 3 + y / 3) % 2 ? 255 : 0;
}

static uint8_t ties(uint32_t x, uint32_t y)
{
    (void)y;
    return x % 2 ? 128 : 127;
}

static uint8_t constant(uint32_t x, uint32_t y)
{
    return x == 0 && y == 0 ? 0 : 128;
}

static uint8_t lines(uint32_t x, uint32_t y)
{
    return x % 17 == 3 || y % 29 == 5 ? 255 : 0;
}

static uint8_t ramp(uint32_t x, uint32_t y)
{
    return (uint8_t)(3 * x + 5 * y);
}

static uint8_t nothing(uint32_t x, uint32_t y)
{
    (void)x, (void)y;
    return 20;
}

typedef uint8_t (*alpha_pattern)(uint32_t x, uint32_t y);

static const struct {
    const char *name;
    alpha_pattern alpha;
} patterns[] = {
    {"discs", discs},         {"hard discs", hard_discs}, {"noise", noise},
    {"sparse noise", sparse}, {"checkers", checkers},     {"wide checkers", wide_checkers},
    {"ties", ties},           {"constant", constant},     {"lines", lines},
    {"ramp", ramp},           {"nothing", nothing}};
#define PATTERN_COUNT (sizeof patterns / sizeof *patterns)

static gn_texture make_pattern(alpha_pattern alpha, uint32_t width, uint32_t height)
{
    gn_texture texture = make_texture(width, height);
    random_state = 7;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++)
            texture.rgba[0][4 * ((size_t)y * width + x) + 3] = alpha(x, y);
    }
    return texture;
}

static gn_material_desc mask_desc(float cutoff)
{
    gn_material_desc desc = gn_material_desc_default();
    desc.alpha_mode = GN_ALPHA_MASK;
    desc.alpha_cutoff = cutoff;
    return desc;
}

/* The share of passing texels (R11) ---------------------------------------------------------- */

static double share_of(const uint8_t *texels, size_t count, double cutoff)
{
    size_t passing = 0;
    for (size_t i = 0; i < count; i++)
        passing += texels[i] >= ceil(cutoff * 255 - 1e-5);
    return (double)passing / (double)count;
}

static void check_shares(const gn_alpha_map *map, double cutoff, const char *name)
{
    const double first = share_of(map->rescaled[0], (size_t)map->width * map->height, cutoff);
    for (uint32_t level = 0; level < map->levels; level++) {
        const size_t count =
            (size_t)gn_level_size(map->width, level) * gn_level_size(map->height, level);
        const double share = share_of(map->rescaled[level], count, cutoff);
        if (!(fabs(share - first) <= fmax(0.01, 1.0 / (double)count)))
            fail_msg("%s, %u x %u, cutoff %g: the share at level %u is %g, at level 0 %g", name,
                     map->width, map->height, cutoff, level, share, first);
    }
}

static void every_level_passes_the_same_share(void **state)
{
    (void)state;
    static const float cutoffs[] = {0.004f, 0.2f, 0.5f, 0.9f, 1.0f};
    for (size_t p = 0; p < PATTERN_COUNT; p++) {
        for (size_t s = 0; s < SIZE_COUNT; s++) {
            gn_texture texture = make_pattern(patterns[p].alpha, sizes[s][0], sizes[s][1]);
            for (size_t c = 0; c < sizeof cutoffs / sizeof *cutoffs; c++) {
                gn_material_desc desc = mask_desc(cutoffs[c]);
                gn_alpha_map map;
                assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
                if (map.levels > 0)
                    check_shares(&map, (double)cutoffs[c], patterns[p].name);
                else
                    assert_true(share_of(texture.rgba[0] + 3, 1, (double)cutoffs[c]) == 1);
                gn_alpha_map_free(&context, &map);
            }
            gn_free(&context, texture.rgba[0]);
        }
    }
}

/* Plain averages do lose the share: the test above would notice. */
static void averages_alone_lose_the_share(void **state)
{
    (void)state;
    gn_texture texture = make_pattern(lines, 128, 128);
    gn_material_desc desc = mask_desc(0.5f);
    gn_alpha_map map;
    assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
    const double first = share_of(map.averaged[0], 128 * 128, 0.5);
    const double third = share_of(map.averaged[3], 16 * 16, 0.5);
    if (fabs(first - third) < 0.05)
        fail_msg("averaged share %g at level 3, %g at level 0", third, first);
    gn_alpha_map_free(&context, &map);
    gn_free(&context, texture.rgba[0]);
}

/* Where all texels of a level are equal, those that pass are spread over it. */
static void ties_are_spread(void **state)
{
    (void)state;
    gn_texture texture = make_pattern(checkers, 128, 128);
    gn_material_desc desc = mask_desc(0.5f);
    gn_alpha_map map;
    assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
    for (uint32_t block = 0; block < 64; block++) {
        const uint32_t x0 = block % 8 * 8, y0 = block / 8 * 8;
        int passing = 0;
        for (uint32_t i = 0; i < 64; i++) {
            const uint8_t value = map.rescaled[1][(y0 + i / 8) * 64 + x0 + i % 8];
            passing += value >= 128;
            assert_in_range(value, 127, 128); /* moved by the least amount */
        }
        if (abs(passing - 32) > 6)
            fail_msg("block %u: %d of 64 pass, expected about 32", block, passing);
    }
    gn_alpha_map_free(&context, &map);
    gn_free(&context, texture.rgba[0]);
}

/* A texel never overtakes another one by more than rounding, and few leave the proportion. */
static void rescaled_keeps_the_order(void **state)
{
    (void)state;
    for (size_t p = 0; p < PATTERN_COUNT; p++) {
        gn_texture texture = make_pattern(patterns[p].alpha, 61, 47);
        gn_material_desc desc = mask_desc(0.5f);
        gn_alpha_map map;
        assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
        for (uint32_t level = 1; level < map.levels; level++) {
            const size_t count = (size_t)gn_level_size(61, level) * gn_level_size(47, level);
            const uint8_t *a = map.averaged[level], *r = map.rescaled[level];
            for (size_t i = 0; i < count; i++) {
                for (size_t j = 0; j < count; j++) {
                    if (a[i] > a[j] + 1 && r[i] < r[j])
                        fail_msg("%s, level %u: averages %d > %d became %d < %d", patterns[p].name,
                                 level, a[i], a[j], r[i], r[j]);
                }
            }
        }
        gn_alpha_map_free(&context, &map);
        gn_free(&context, texture.rgba[0]);
    }
}

static void check_scene_materials(const char *path)
{
    gn_device *device = NULL;
    gn_scene *scene = NULL;
    assert_int_equal(gn_device_create(NULL, &device), GN_OK);
    if (gn_scene_load(device, path, &scene) != GN_OK)
        fail_msg("%s", gn_device_message(device));
    uint32_t checked = 0;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const gn_material *material = &scene->materials[i];
        if (material->desc.alpha_mode != GN_ALPHA_MASK || !material->masked)
            continue;
        check_shares(&material->alpha, (double)material->desc.alpha_cutoff, material->name);
        checked++;
    }
    print_message("%u leaf textures of %s\n", checked, path);
    assert_true(checked > 0);
    gn_scene_destroy(&scene);
    gn_device_destroy(&device);
}

static void real_leaves_pass_the_same_share(void **state)
{
    (void)state;
    const char *folder = getenv("GNOMON_SCENES");
    char path[1024];
    snprintf(path, sizeof path, "%s/grove.glb", folder ? folder : "");
    FILE *file = folder ? fopen(path, "rb") : NULL;
    if (!file) {
        print_message("skipped: GNOMON_SCENES names no folder with grove.glb\n");
        skip();
    }
    fclose(file);
    check_scene_materials(path);
}

/* Box filter ------------------------------------------------------------------------------ */

static void averages_are_box_averages(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZE_COUNT; s++) {
        const uint32_t width = sizes[s][0], height = sizes[s][1];
        gn_texture texture = make_pattern(noise, width, height);
        gn_material_desc desc = mask_desc(1);
        desc.base_color[3] = 0.8f;
        gn_alpha_map map;
        assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
        double *plane = malloc(sizeof *plane * width * height);
        assert_non_null(plane);
        for (size_t i = 0; i < (size_t)width * height; i++)
            plane[i] = floor(texture.rgba[0][4 * i + 3] * (double)0.8f + 0.5);
        for (uint32_t level = 0; level < map.levels; level++) {
            const uint32_t w = gn_level_size(width, level), h = gn_level_size(height, level);
            for (size_t i = 0; i < (size_t)w * h; i++) {
                if (fabs(map.averaged[level][i] - plane[i]) > 0.501)
                    fail_msg("%u x %u, level %u, texel %zu: %d, expected %g", width, height, level,
                             i, map.averaged[level][i], plane[i]);
            }
            shrink_plane(&plane, w, h);
        }
        free(plane);
        gn_alpha_map_free(&context, &map);
        gn_free(&context, texture.rgba[0]);
    }
}

/* Coverage ----------------------------------------------------------------------------------- */

static double texel_alpha(const gn_texture *texture, gn_wrap wrap, int x, int y)
{
    const int n[2] = {(int)texture->width, (int)texture->height};
    int at[2] = {x, y};
    for (int axis = 0; axis < 2; axis++) {
        if (wrap == GN_WRAP_REPEAT)
            at[axis] = (at[axis] + 4 * n[axis]) % n[axis];
        else /* one texel beyond the border: clamped and mirrored are the same */
            at[axis] = at[axis] < 0 ? 0 : at[axis] >= n[axis] ? n[axis] - 1 : at[axis];
    }
    return texture->rgba[0][4 * ((size_t)at[1] * texture->width + (size_t)at[0]) + 3] / 255.0;
}

static double bilinear(const gn_texture *texture, gn_wrap wrap, double u, double v)
{
    const int x = (int)floor(u - 0.5), y = (int)floor(v - 0.5);
    const double fx = u - 0.5 - x, fy = v - 0.5 - y;
    return (1 - fy) * ((1 - fx) * texel_alpha(texture, wrap, x, y) +
                       fx * texel_alpha(texture, wrap, x + 1, y)) +
           fy * ((1 - fx) * texel_alpha(texture, wrap, x, y + 1) +
                 fx * texel_alpha(texture, wrap, x + 1, y + 1));
}

#define FINE 16

/* By one random sample in each of FINE x FINE cells. */
static double fine_coverage(const gn_texture *texture, gn_wrap wrap, uint32_t x, uint32_t y,
                            double cutoff)
{
    int passing = 0;
    for (int j = 0; j < FINE; j++) {
        for (int i = 0; i < FINE; i++) {
            const double u = x + (i + next_random() / 16777216.0) / FINE;
            const double v = y + (j + next_random() / 16777216.0) / FINE;
            passing += bilinear(texture, wrap, u, v) >= cutoff - 1e-9;
        }
    }
    return (double)passing / (FINE * FINE);
}

static void check_coverage(const gn_texture *texture, gn_wrap wrap, float cutoff, const char *name)
{
    gn_material_desc desc = mask_desc(cutoff);
    desc.wrap_u = desc.wrap_v = wrap;
    gn_alpha_map map;
    assert_int_equal(gn_alpha_map_build(&context, texture, &desc, &map), GN_OK);
    if (map.levels == 0)
        return;
    double truth = 0;
    for (uint32_t y = 0; y < map.height; y++) {
        for (uint32_t x = 0; x < map.width; x++) {
            const double expected = fine_coverage(texture, wrap, x, y, (double)cutoff);
            const double value = map.coverage[0][(size_t)y * map.width + x] / 255.0;
            if (fabs(value - expected) > 0.05)
                fail_msg("%s, wrap %d, cutoff %g: coverage of texel %u %u is %g, expected %g", name,
                         (int)wrap, (double)cutoff, x, y, value, expected);
            truth += expected;
        }
    }
    truth /= (double)map.width * map.height;
    for (uint32_t level = 0; level < map.levels; level++) {
        const size_t count =
            (size_t)gn_level_size(map.width, level) * gn_level_size(map.height, level);
        double mean = 0;
        for (size_t i = 0; i < count; i++)
            mean += map.coverage[level][i] / 255.0 / (double)count;
        if (fabs(mean - truth) > 0.004)
            fail_msg("%s, %u x %u, wrap %d, cutoff %g: mean coverage at level %u is %g, the share "
                     "of the surface that passes %g",
                     name, map.width, map.height, (int)wrap, (double)cutoff, level, mean, truth);
    }
    gn_alpha_map_free(&context, &map);
}

static void coverage_is_the_share_of_the_surface(void **state)
{
    (void)state;
    static const uint32_t some_sizes[][2] = {{32, 32}, {27, 19}, {1, 50}, {41, 1}};
    static const float cutoffs[] = {0.2f, 0.5f};
    for (size_t p = 0; p < PATTERN_COUNT; p++) {
        for (size_t s = 0; s < 4; s++) {
            gn_texture texture =
                make_pattern(patterns[p].alpha, some_sizes[s][0], some_sizes[s][1]);
            for (size_t c = 0; c < 2; c++) {
                for (int wrap = GN_WRAP_REPEAT; wrap <= GN_WRAP_MIRROR; wrap++)
                    check_coverage(&texture, (gn_wrap)wrap, cutoffs[c], patterns[p].name);
            }
            gn_free(&context, texture.rgba[0]);
        }
    }
}

/* Special cases ------------------------------------------------------------------------------ */

static void opaque_materials_need_no_map(void **state)
{
    (void)state;
    gn_texture texture = make_pattern(constant, 8, 8);
    gn_material_desc desc = mask_desc(0);
    gn_alpha_map map;
    assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
    assert_int_equal(map.levels, 0); /* everything passes a cutoff of 0 */
    desc.alpha_cutoff = 0.1f;
    assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
    assert_int_equal(map.levels, 4); /* one texel of 0 fails */
    gn_alpha_map_free(&context, &map);
    desc.alpha_mode = GN_ALPHA_BLEND;
    assert_int_equal(gn_alpha_map_build(&context, NULL, &desc, &map), GN_OK);
    assert_int_equal(map.levels, 0);
    desc.base_color[3] = 0.25f;
    assert_int_equal(gn_alpha_map_build(&context, NULL, &desc, &map), GN_OK);
    assert_int_equal(map.levels, 1);
    assert_int_equal(map.averaged[0][0], 64);
    gn_alpha_map_free(&context, &map);
    gn_free(&context, texture.rgba[0]);
}

static void blend_has_one_chain(void **state)
{
    (void)state;
    gn_texture texture = make_pattern(noise, 20, 9);
    gn_material_desc desc = mask_desc(0.5f);
    desc.alpha_mode = GN_ALPHA_BLEND;
    gn_alpha_map map;
    assert_int_equal(gn_alpha_map_build(&context, &texture, &desc, &map), GN_OK);
    assert_int_equal(map.levels, 5);
    for (uint32_t level = 0; level < map.levels; level++) {
        const size_t count = (size_t)gn_level_size(20, level) * gn_level_size(9, level);
        assert_memory_equal(map.averaged[level], map.rescaled[level], count);
        assert_memory_equal(map.averaged[level], map.coverage[level], count);
    }
    gn_alpha_map_free(&context, &map);
    gn_free(&context, texture.rgba[0]);
}

static void threshold_is_the_first_value_that_passes(void **state)
{
    (void)state;
    assert_int_equal(gn_alpha_threshold(0), 0);
    assert_int_equal(gn_alpha_threshold(0.2f), 51);
    assert_int_equal(gn_alpha_threshold(0.5f), 128);
    assert_int_equal(gn_alpha_threshold(1), 255);
}

static void range_finds_the_extremes_across_borders(void **state)
{
    (void)state;
    const uint8_t level[] = {10, 20, 30, 40, 50, 60}; /* 3 x 2 */
    gn_texel_range range =
        gn_alpha_range(level, 3, 2, GN_WRAP_REPEAT, GN_WRAP_REPEAT, -1, -1, 0, -1);
    assert_int_equal(range.min, 40); /* columns 2 and 0 of row 1 */
    assert_int_equal(range.max, 60);
    range = gn_alpha_range(level, 3, 2, GN_WRAP_CLAMP, GN_WRAP_CLAMP, -5, -5, 0, 0);
    assert_int_equal(range.min, 10);
    assert_int_equal(range.max, 10);
    range = gn_alpha_range(level, 3, 2, GN_WRAP_MIRROR, GN_WRAP_MIRROR, 3, 2, 4, 2);
    assert_int_equal(range.min, 50); /* columns 2 and 1 of row 1 */
    assert_int_equal(range.max, 60);
    range = gn_alpha_range(level, 3, 2, GN_WRAP_REPEAT, GN_WRAP_REPEAT, -1000000, -1000000, 1000000,
                           1000000);
    assert_int_equal(range.min, 10);
    assert_int_equal(range.max, 60);
}

static void nothing_is_left_allocated(void **state)
{
    (void)state;
    assert_int_equal(context.bytes, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_level_passes_the_same_share),
        cmocka_unit_test(averages_alone_lose_the_share),
        cmocka_unit_test(ties_are_spread),
        cmocka_unit_test(rescaled_keeps_the_order),
        cmocka_unit_test(real_leaves_pass_the_same_share),
        cmocka_unit_test(averages_are_box_averages),
        cmocka_unit_test(coverage_is_the_share_of_the_surface),
        cmocka_unit_test(opaque_materials_need_no_map),
        cmocka_unit_test(blend_has_one_chain),
        cmocka_unit_test(threshold_is_the_first_value_that_passes),
        cmocka_unit_test(range_finds_the_extremes_across_borders),
        cmocka_unit_test(nothing_is_left_allocated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
