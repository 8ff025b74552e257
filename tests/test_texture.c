/* Colour mips, beside a computation in doubles. */
#include "texture_testing.h"

static double srgb_to_linear(double value)
{
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

static double linear_to_srgb(double value)
{
    return value <= 0.0031308 ? value * 12.92 : 1.055 * pow(value, 1 / 2.4) - 0.055;
}

static void check_mips(uint32_t width, uint32_t height)
{
    gn_texture texture = make_texture(width, height);
    const size_t count = (size_t)width * height;
    double *planes[4]; /* alpha-weighted linear colour; alpha */
    for (int c = 0; c < 4; c++) {
        planes[c] = malloc(count * sizeof **planes);
        assert_non_null(planes[c]);
    }
    for (size_t i = 0; i < count; i++) {
        uint8_t *texel = texture.rgba[0] + 4 * i;
        for (int c = 0; c < 4; c++)
            texel[c] = (uint8_t)next_random();
        if (texel[3] == 0)
            texel[3] = 1; /* the brute force has no rule for wholly transparent footprints */
        for (int c = 0; c < 3; c++)
            planes[c][i] = srgb_to_linear(texel[c] / 255.0) * texel[3];
        planes[3][i] = texel[3];
    }
    assert_int_equal(gn_texture_build_mips(&context, &texture), GN_OK);
    for (uint32_t level = 0; level < texture.levels; level++) {
        const uint32_t w = gn_level_size(width, level), h = gn_level_size(height, level);
        for (size_t i = 0; i < (size_t)w * h; i++) {
            const uint8_t *texel = texture.rgba[level] + 4 * i;
            for (int c = 0; c < 4; c++) {
                const double expected =
                    c == 3 ? planes[3][i] : 255 * linear_to_srgb(planes[c][i] / planes[3][i]);
                if (fabs(texel[c] - expected) > 0.51)
                    fail_msg("%u x %u, level %u, texel %zu, channel %d: %d, expected %g", width,
                             height, level, i, c, texel[c], expected);
            }
        }
        for (int c = 0; c < 4; c++)
            shrink_plane(&planes[c], w, h);
    }
    assert_int_equal(gn_level_size(width, texture.levels - 1), 1);
    assert_int_equal(gn_level_size(height, texture.levels - 1), 1);
    for (int c = 0; c < 4; c++)
        free(planes[c]);
    gn_free(&context, texture.rgba[0]);
}

static void mips_are_linear_alpha_weighted_boxes(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZE_COUNT; s++)
        check_mips(sizes[s][0], sizes[s][1]);
}

static void transparent_texels_do_not_bleed(void **state)
{
    (void)state;
    gn_texture texture = make_texture(16, 16);
    for (uint32_t i = 0; i < 256; i++) {
        const bool leaf = i % 16 < 3;
        const uint8_t color[4] = {leaf ? 30 : 255, leaf ? 120 : 255, leaf ? 10 : 255,
                                  leaf ? 255 : 0};
        memcpy(texture.rgba[0] + (size_t)4 * i, color, 4);
    }
    assert_int_equal(gn_texture_build_mips(&context, &texture), GN_OK);
    const uint8_t *last = texture.rgba[4];
    assert_int_equal(last[0], 30);
    assert_int_equal(last[1], 120);
    assert_int_equal(last[2], 10);
    assert_int_equal(last[3], 48);                          /* 255 * 3 / 16 */
    const uint8_t *clear = texture.rgba[1] + (size_t)4 * 7; /* nothing but white there */
    assert_int_equal(clear[0], 255);
    assert_int_equal(clear[3], 0);
    gn_free(&context, texture.rgba[0]);
}

static void nothing_is_left_allocated(void **state)
{
    (void)state;
    assert_int_equal(context.bytes, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mips_are_linear_alpha_weighted_boxes),
        cmocka_unit_test(transparent_texels_do_not_bleed),
        cmocka_unit_test(nothing_is_left_allocated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
