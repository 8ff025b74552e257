/* Numbers about pictures: properties, and a plain computation of the definitions beside them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "measure/measure.h"

static void assert_near(double value, double expected, double tolerance, const char *what)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s is %.17g, expected %.17g within %g", what, value, expected, tolerance);
}

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static float random_unit(uint32_t *state)
{
    return (float)next_random(state) / 16777216.0f;
}

/* Differences ------------------------------------------------------------------------------- */

#define COUNT 1000

static void fill(float *values, uint32_t count, uint32_t seed)
{
    for (uint32_t i = 0; i < count; i++)
        values[i] = random_unit(&seed);
}

static void identical_images_do_not_differ(void **state)
{
    (void)state;
    float a[COUNT];
    fill(a, COUNT, 1);
    const gn_difference d = gn_measure_difference(a, a, NULL, COUNT);
    assert_near(d.wrong, 0, 0, "wrong");
    assert_near(d.mean_abs, 0, 0, "mean_abs");
    assert_near(d.mse, 0, 0, "mse");
    assert_near(d.max_abs, 0, 0, "max_abs");
    assert_near(d.mean_a, d.mean_b, 0, "mean_b");
    assert_int_equal(d.count, COUNT);
}

static void difference_is_symmetric(void **state)
{
    (void)state;
    float a[COUNT], b[COUNT];
    fill(a, COUNT, 1);
    fill(b, COUNT, 2);
    const gn_difference d = gn_measure_difference(a, b, NULL, COUNT);
    const gn_difference e = gn_measure_difference(b, a, NULL, COUNT);
    assert_near(e.wrong, d.wrong, 0, "wrong");
    assert_near(e.mean_abs, d.mean_abs, 0, "mean_abs");
    assert_near(e.mse, d.mse, 0, "mse");
    assert_near(e.max_abs, d.max_abs, 0, "max_abs");
    assert_near(e.mean_a, d.mean_b, 0, "mean_a");
    assert_near(e.mean_b, d.mean_a, 0, "mean_b");
}

static void difference_of_known_images(void **state)
{
    (void)state;
    /* Exactly half is not wrong; more than half is. */
    const float a[5] = {0.0f, 1.0f, 0.25f, 1.0f, 0.5f};
    const float b[5] = {0.5f, 0.25f, 0.25f, 0.0f, 0.75f};
    const gn_difference d = gn_measure_difference(a, b, NULL, 5);
    assert_near(d.wrong, 2.0 / 5, 1e-15, "wrong");
    assert_near(d.mean_abs, 2.5 / 5, 1e-15, "mean_abs");
    assert_near(d.mse, (0.25 + 0.5625 + 1 + 0.0625) / 5, 1e-15, "mse");
    assert_near(d.max_abs, 1, 0, "max_abs");
    assert_near(d.mean_a, 2.75 / 5, 1e-15, "mean_a");
    assert_near(d.mean_b, 1.75 / 5, 1e-15, "mean_b");
}

static void mask_equals_leaving_the_pixels_out(void **state)
{
    (void)state;
    float a[COUNT], b[COUNT], kept_a[COUNT], kept_b[COUNT];
    uint8_t mask[COUNT];
    fill(a, COUNT, 3);
    fill(b, COUNT, 4);
    uint32_t seed = 5, kept = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        mask[i] = (uint8_t)(next_random(&seed) % 3);
        if (mask[i]) {
            kept_a[kept] = a[i];
            kept_b[kept++] = b[i];
        }
    }
    const gn_difference d = gn_measure_difference(a, b, mask, COUNT);
    const gn_difference e = gn_measure_difference(kept_a, kept_b, NULL, kept);
    assert_int_equal(d.count, kept);
    assert_near(d.wrong, e.wrong, 0, "wrong");
    assert_near(d.mse, e.mse, 0, "mse");
    assert_near(d.mean_a, e.mean_a, 0, "mean_a");

    memset(mask, 0, sizeof mask);
    const gn_difference none = gn_measure_difference(a, b, mask, COUNT);
    assert_int_equal(none.count, 0);
    assert_near(none.mse, 0, 0, "mse of nothing");
}

static void not_a_number_is_wrong(void **state)
{
    (void)state;
    const float a[2] = {NAN, 1.0f}, b[2] = {1.0f, 1.0f};
    assert_near(gn_measure_difference(a, b, NULL, 2).wrong, 0.5, 0, "wrong");
}

static void psnr_follows_its_definition(void **state)
{
    (void)state;
    assert_true(isinf(gn_measure_psnr(0, 1)));
    assert_near(gn_measure_psnr(1, 1), 0, 0, "psnr of mse 1");
    assert_near(gn_measure_psnr(0.01, 1), 20, 1e-12, "psnr of mse 0.01");
    /* The same pictures in other units. */
    assert_near(gn_measure_psnr(0.02 * 255 * 255, 255), gn_measure_psnr(0.02, 1), 1e-12, "psnr");
}

/* Spread ------------------------------------------------------------------------------------ */

static void spread_of_known_values(void **state)
{
    (void)state;
    double odd[5] = {5, -1, 3, 2, 4}, even[4] = {4, 1, 3, 2}, one[1] = {7};
    gn_spread s = gn_measure_spread(odd, 5);
    assert_near(s.median, 3, 0, "median of five");
    assert_near(s.min, -1, 0, "min");
    assert_near(s.max, 5, 0, "max");
    s = gn_measure_spread(even, 4);
    assert_near(s.median, 2.5, 0, "median of four");
    for (int i = 0; i < 4; i++)
        assert_near(even[i], i + 1, 0, "sorted value");
    s = gn_measure_spread(one, 1);
    assert_near(s.median, 7, 0, "median of one");
    assert_near(s.min, 7, 0, "min of one");
    assert_near(s.max, 7, 0, "max of one");
}

/* Flicker ----------------------------------------------------------------------------------- */

#define WIDTH  61u
#define HEIGHT 37u
#define PIXELS (WIDTH * HEIGHT)

/* One frame of an imagined sequence; only the planes that flicker reads. */
typedef struct frame {
    gn_gbuffer gbuffer;
    float cone_width[PIXELS], motion[3][PIXELS], depth[PIXELS];
    uint32_t surface[PIXELS];
    float visibility[PIXELS];
} frame;

/* A wall of one surface, 10 m away, that stands still. */
static void frame_init(frame *f)
{
    memset(f, 0, sizeof *f);
    f->gbuffer.width = WIDTH;
    f->gbuffer.height = HEIGHT;
    f->gbuffer.cone_width = f->cone_width;
    f->gbuffer.depth = f->depth;
    f->gbuffer.surface = f->surface;
    for (int axis = 0; axis < 3; axis++)
        f->gbuffer.motion[axis] = f->motion[axis];
    for (uint32_t i = 0; i < PIXELS; i++) {
        f->cone_width[i] = 0.01f;
        f->depth[i] = 10.0f;
        f->surface[i] = 1;
    }
}

static gn_flicker compare(const frame *before, const frame *now)
{
    gn_flicker_state memory = {0};
    const gn_flicker first = gn_measure_flicker(&memory, &before->gbuffer, before->visibility);
    assert_int_equal(first.pixels, 0);
    assert_near(first.flicker, 0, 0, "flicker of the first frame");
    const gn_flicker result = gn_measure_flicker(&memory, &now->gbuffer, now->visibility);
    gn_flicker_state_free(&memory);
    return result;
}

static void a_still_picture_does_not_flicker(void **state)
{
    (void)state;
    static frame f;
    frame_init(&f);
    fill(f.visibility, PIXELS, 6);
    const gn_flicker result = compare(&f, &f);
    assert_near(result.flicker, 0, 0, "flicker");
    assert_near(result.toggles, 0, 0, "toggles");
    assert_int_equal(result.pixels, PIXELS);
}

/* The picture moves by (dx, dy) whole pixels and nearer by dz, and motion says so. */
static void a_translated_pattern_does_not_flicker(void **state)
{
    (void)state;
    static frame before, now;
    const int shifts[][2] = {{1, 0}, {0, 1}, {-3, 2}, {7, -5}, {-60, 36}};
    for (size_t s = 0; s < sizeof shifts / sizeof shifts[0]; s++) {
        const int dx = shifts[s][0], dy = shifts[s][1];
        frame_init(&before);
        frame_init(&now);
        fill(before.visibility, PIXELS, 7);
        fill(now.visibility, PIXELS, 8);
        uint32_t inside = 0;
        for (int y = 0; y < (int)HEIGHT; y++) {
            for (int x = 0; x < (int)WIDTH; x++) {
                const int i = y * (int)WIDTH + x, from_x = x - dx, from_y = y - dy;
                now.motion[0][i] = (float)-dx;
                now.motion[1][i] = (float)-dy;
                now.motion[2][i] = 2.0f;
                now.depth[i] = 8.0f;
                if (from_x < 0 || from_x >= (int)WIDTH || from_y < 0 || from_y >= (int)HEIGHT)
                    continue;
                now.visibility[i] = before.visibility[from_y * (int)WIDTH + from_x];
                inside++;
            }
        }
        const gn_flicker result = compare(&before, &now);
        assert_near(result.flicker, 0, 0, "flicker");
        assert_int_equal(result.pixels, inside);

        /* The same without motion: an unrelated pattern, E (a - b)^2 = 1/6 for uniform a, b. */
        memset(now.motion, 0, sizeof now.motion);
        memcpy(now.depth, before.depth, sizeof now.depth);
        if (inside > PIXELS / 2)
            assert_near(compare(&before, &now).flicker, 1.0 / 6, 0.02, "flicker without motion");
    }
}

static void random_toggles_are_counted(void **state)
{
    (void)state;
    static frame before, now;
    frame_init(&before);
    frame_init(&now);
    uint32_t seed = 9, toggled = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        before.visibility[i] = (float)(next_random(&seed) & 1);
        const bool toggle = next_random(&seed) % 10 == 0;
        now.visibility[i] = toggle ? 1.0f - before.visibility[i] : before.visibility[i];
        toggled += toggle;
    }
    const gn_flicker result = compare(&before, &now);
    assert_near(result.toggles, (double)toggled / PIXELS, 1e-15, "toggles");
    assert_near(result.flicker, (double)toggled / PIXELS, 1e-12, "flicker");
    assert_near(result.toggles, 0.1, 0.02, "rate");
    /* A still G-buffer makes it symmetric in time. */
    const gn_flicker reversed = compare(&now, &before);
    assert_near(reversed.flicker, result.flicker, 0, "flicker backwards");
    assert_near(reversed.toggles, result.toggles, 0, "toggles backwards");
}

/* Why squares: an edge that moves by a quarter of a pixel. Sampled hard, a quarter of its pixels
 * toggles; filtered over a pixel, every one changes by a quarter. Same mean absolute change. */
static void a_filtered_edge_flickers_less_than_a_hard_one(void **state)
{
    (void)state;
    static frame hard[2], soft[2];
    double mean_abs_hard = 0, mean_abs_soft = 0;
    for (int n = 0; n < 2; n++) {
        frame_init(&hard[n]);
        frame_init(&soft[n]);
        for (uint32_t y = 0; y < HEIGHT; y++) {
            for (uint32_t x = 0; x < WIDTH; x++) {
                /* The edge is slanted, so that its rows are at all phases, but by whole quarters
                 * between samples. */
                const double edge = 20.125 + 0.25 * y + 0.25 * n;
                const double covered = edge - x; /* of the pixel [x, x + 1] */
                hard[n].visibility[y * WIDTH + x] = x + 0.5 < edge ? 1.0f : 0.0f;
                soft[n].visibility[y * WIDTH + x] = (float)fmin(fmax(covered, 0), 1);
            }
        }
    }
    for (uint32_t i = 0; i < PIXELS; i++) {
        mean_abs_hard += fabs((double)hard[1].visibility[i] - (double)hard[0].visibility[i]);
        mean_abs_soft += fabs((double)soft[1].visibility[i] - (double)soft[0].visibility[i]);
    }
    const gn_flicker h = compare(&hard[0], &hard[1]), s = compare(&soft[0], &soft[1]);
    if (!(fabs(mean_abs_hard / mean_abs_soft - 1) < 0.1))
        fail_msg("mean absolute change: hard %g, soft %g", mean_abs_hard, mean_abs_soft);
    if (!(s.flicker < 0.3 * h.flicker))
        fail_msg("flicker: hard %g, soft %g", h.flicker, s.flicker);
    assert_near(s.toggles, 0, 0, "toggles of the filtered edge");
}

static void other_surfaces_are_left_out(void **state)
{
    (void)state;
    static frame before, now;
    frame_init(&before);
    frame_init(&now);
    for (uint32_t i = 0; i < PIXELS; i++)
        now.visibility[i] = 1.0f;

    now.surface[0] = 2;               /* another object */
    now.surface[1] = GN_NONE;         /* sky */
    before.surface[2] = GN_NONE;      /* was sky */
    now.depth[3] = 10.03f;            /* the same object, but something hid it: 3 widths away */
    now.depth[4] = 9.97f;             /* likewise */
    now.depth[5] = 10.015f;           /* within 2 widths: the same */
    now.motion[0][6] = NAN;           /* no motion known */
    now.motion[0][7] = -7.6f;         /* was outside, to the left */
    now.motion[1][8] = -0.6f;         /* above */
    now.motion[1][9] = (float)HEIGHT; /* below */
    now.motion[0][10] = INFINITY;
    before.surface[11] = now.surface[11] = GN_NONE; /* sky in both */
    const gn_flicker result = compare(&before, &now);
    assert_int_equal(result.pixels, PIXELS - 11);
    assert_near(result.flicker, 1, 0, "flicker");
    assert_near(result.toggles, 1, 0, "toggles");
}

/* The definition, written a second time and in another way: candidates by distance of centres. */
static gn_flicker brute_force(const frame *before, const frame *now)
{
    double sum = 0;
    uint64_t pixels = 0, toggles = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        const double was_x = i % WIDTH + 0.5 + (double)now->motion[0][i];
        const double was_y = i / WIDTH + 0.5 + (double)now->motion[1][i];
        for (uint32_t j = 0; j < PIXELS; j++) {
            const double dx = was_x - (j % WIDTH + 0.5), dy = was_y - (j / WIDTH + 0.5);
            if (fmax(fabs(dx), fabs(dy)) >= 0.5 || now->surface[i] == GN_NONE ||
                before->surface[j] != now->surface[i])
                continue;
            const double then = (double)now->depth[i] + (double)now->motion[2][i];
            if (fabs(then - (double)before->depth[j]) > 2 * (double)now->cone_width[i])
                continue;
            const double change = (double)now->visibility[i] - (double)before->visibility[j];
            pixels++;
            sum += change * change;
            toggles += fabs(change) > 0.5;
        }
    }
    return (gn_flicker){sum / (double)pixels, (double)toggles / (double)pixels, pixels};
}

static void agrees_with_brute_force(void **state)
{
    (void)state;
    static frame before, now;
    for (uint32_t round = 0; round < 4; round++) {
        frame_init(&before);
        frame_init(&now);
        uint32_t seed = 100 + round;
        for (uint32_t i = 0; i < PIXELS; i++) {
            before.surface[i] = next_random(&seed) % 5 ? next_random(&seed) % 2 : GN_NONE;
            now.surface[i] = next_random(&seed) % 5 ? next_random(&seed) % 2 : GN_NONE;
            before.depth[i] = 10.0f + 0.04f * random_unit(&seed);
            now.depth[i] = 10.0f + 0.04f * random_unit(&seed);
            before.visibility[i] = random_unit(&seed);
            now.visibility[i] = random_unit(&seed);
            for (int axis = 0; axis < 2; axis++)
                now.motion[axis][i] = 10.0f * random_unit(&seed) - 5.0f;
            now.motion[2][i] = 0.02f * random_unit(&seed);
        }
        const gn_flicker result = compare(&before, &now), expected = brute_force(&before, &now);
        assert_true(expected.pixels > 200);
        assert_int_equal(result.pixels, expected.pixels);
        assert_near(result.flicker, expected.flicker, 1e-6, "flicker");
        assert_near(result.toggles, expected.toggles, 1e-12, "toggles");
    }
}

static void another_size_starts_anew(void **state)
{
    (void)state;
    static frame f;
    frame_init(&f);
    gn_flicker_state memory = {0};
    gn_measure_flicker(&memory, &f.gbuffer, f.visibility);
    f.gbuffer.height = HEIGHT - 1;
    assert_int_equal(gn_measure_flicker(&memory, &f.gbuffer, f.visibility).pixels, 0);
    assert_int_equal(gn_measure_flicker(&memory, &f.gbuffer, f.visibility).pixels,
                     WIDTH * (HEIGHT - 1));
    gn_flicker_state_free(&memory);
    assert_null(memory.depth);
    assert_int_equal(gn_measure_flicker(&memory, &f.gbuffer, f.visibility).pixels, 0);
    gn_flicker_state_free(&memory);
}

/* After the reference's change is taken off -------------------------------------------------- */

/* The flicker of the second of two frames. references: one a frame. */
static gn_flicker residual(const frame *before, const frame *now, const float *was, const float *is)
{
    gn_flicker_state memory = {0};
    gn_measure_residual_flicker(&memory, &before->gbuffer, before->visibility, was);
    const gn_flicker result =
        gn_measure_residual_flicker(&memory, &now->gbuffer, now->visibility, is);
    gn_flicker_state_free(&memory);
    return result;
}

/* Two frames with random motion, holes and visibility. */
static void shake(frame *before, frame *now, uint32_t seed)
{
    frame_init(before);
    frame_init(now);
    for (uint32_t i = 0; i < PIXELS; i++) {
        before->surface[i] = next_random(&seed) % 5 ? next_random(&seed) % 2 : GN_NONE;
        now->surface[i] = next_random(&seed) % 5 ? next_random(&seed) % 2 : GN_NONE;
        before->visibility[i] = random_unit(&seed);
        now->visibility[i] = random_unit(&seed);
        for (int axis = 0; axis < 2; axis++)
            now->motion[axis][i] = 10.0f * random_unit(&seed) - 5.0f;
    }
}

static void the_reference_itself_has_no_residual(void **state)
{
    (void)state;
    static frame before, now;
    shake(&before, &now, 11);
    assert_true(compare(&before, &now).flicker > 0.1);
    const gn_flicker result = residual(&before, &now, before.visibility, now.visibility);
    assert_near(result.flicker, 0, 0, "flicker of the reference after its own change");
    assert_near(result.toggles, 0, 0, "toggles of the reference after its own change");
    assert_int_equal(result.pixels, compare(&before, &now).pixels);
}

/* What is wrong by the same everywhere and always moves as the reference does. */
static void a_constant_error_has_no_residual(void **state)
{
    (void)state;
    static frame before, now;
    static float was[PIXELS], is[PIXELS];
    shake(&before, &now, 12);
    for (uint32_t i = 0; i < PIXELS; i++) {
        was[i] = before.visibility[i] - 0.25f;
        is[i] = now.visibility[i] - 0.25f;
    }
    assert_near(residual(&before, &now, was, is).flicker, 0, 1e-13, "flicker");
}

static void a_reference_that_stands_still_changes_nothing(void **state)
{
    (void)state;
    static frame before, now;
    static float flat[PIXELS];
    shake(&before, &now, 13);
    const gn_flicker plain = compare(&before, &now);
    gn_flicker result = residual(&before, &now, flat, flat); /* dark */
    assert_near(result.flicker, plain.flicker, 0, "flicker");
    assert_near(result.toggles, plain.toggles, 0, "toggles");
    result = residual(&before, &now, NULL, NULL);
    assert_near(result.flicker, plain.flicker, 0, "flicker without a reference");
}

/* Who is the reference of whom does not matter, nor, on a still G-buffer, which frame came first.
 */
static void residual_is_symmetric(void **state)
{
    (void)state;
    static frame before, now;
    static float was[PIXELS], is[PIXELS];
    shake(&before, &now, 14);
    fill(was, PIXELS, 15);
    fill(is, PIXELS, 16);
    const gn_flicker result = residual(&before, &now, was, is);
    static frame a, b;
    frame_init(&a);
    frame_init(&b);
    memcpy(a.surface, before.surface, sizeof a.surface);
    memcpy(b.surface, now.surface, sizeof b.surface);
    memcpy(b.motion, now.motion, sizeof b.motion);
    memcpy(a.visibility, was, sizeof was);
    memcpy(b.visibility, is, sizeof is);
    const gn_flicker exchanged = residual(&a, &b, before.visibility, now.visibility);
    assert_near(exchanged.flicker, result.flicker, 1e-15, "flicker with the reference exchanged");
    assert_near(exchanged.toggles, result.toggles, 0, "toggles with the reference exchanged");

    frame_init(&a);
    frame_init(&b);
    fill(a.visibility, PIXELS, 17);
    fill(b.visibility, PIXELS, 18);
    assert_near(residual(&b, &a, is, was).flicker, residual(&a, &b, was, is).flicker, 1e-15,
                "flicker backwards");
}

/* The definition once more: the change of the method less that of the reference, each by itself. */
static void residual_agrees_with_brute_force(void **state)
{
    (void)state;
    static frame before, now;
    static float was[PIXELS], is[PIXELS];
    shake(&before, &now, 19);
    fill(was, PIXELS, 20);
    fill(is, PIXELS, 21);
    double sum = 0;
    uint64_t pixels = 0, toggles = 0;
    for (uint32_t i = 0; i < PIXELS; i++)
        for (uint32_t j = 0; j < PIXELS; j++) {
            const double dx = i % WIDTH + (double)now.motion[0][i] - j % WIDTH;
            const double dy = i / WIDTH + (double)now.motion[1][i] - j / WIDTH;
            if (fmax(fabs(dx), fabs(dy)) >= 0.5 || now.surface[i] == GN_NONE ||
                before.surface[j] != now.surface[i])
                continue;
            const double method = (double)now.visibility[i] - (double)before.visibility[j];
            const double reference = (double)is[i] - (double)was[j];
            pixels++;
            sum += (method - reference) * (method - reference);
            toggles += fabs(method - reference) > 0.5;
        }
    const gn_flicker result = residual(&before, &now, was, is);
    assert_true(pixels > 200);
    assert_int_equal(result.pixels, pixels);
    assert_near(result.flicker, sum / (double)pixels, 1e-6, "flicker");
    assert_near(result.toggles, (double)toggles / (double)pixels, 1e-12, "toggles");
}

/* An edge that moves by a quarter of a pixel, hard and filtered, as above: with the filtered one
 * for a reference, what is left is all the hard one's. */
static void real_motion_is_taken_off(void **state)
{
    (void)state;
    static frame hard[2];
    static float soft[2][PIXELS];
    for (int n = 0; n < 2; n++) {
        frame_init(&hard[n]);
        for (uint32_t i = 0; i < PIXELS; i++) {
            const double edge = 20.125 + 0.25 * (i / WIDTH) + 0.25 * n, x = i % WIDTH;
            hard[n].visibility[i] = x + 0.5 < edge ? 1.0f : 0.0f;
            soft[n][i] = (float)fmin(fmax(edge - x, 0), 1);
        }
    }
    /* A quarter of an edge's pixels change by 1, where 1/4 is right: 3/4 too much. The others stay,
     * or 1/4 too little. (A pixel that the filtered edge enters or leaves shares its quarter.) */
    const gn_flicker plain = compare(&hard[0], &hard[1]);
    const gn_flicker left = residual(&hard[0], &hard[1], soft[0], soft[1]);
    if (!(left.flicker > 0.5 * plain.flicker && left.flicker < 0.85 * plain.flicker))
        fail_msg("flicker: plain %g, after the reference's change %g", plain.flicker, left.flicker);
    assert_near(left.toggles, plain.toggles, 0, "toggles");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(identical_images_do_not_differ),
        cmocka_unit_test(difference_is_symmetric),
        cmocka_unit_test(difference_of_known_images),
        cmocka_unit_test(mask_equals_leaving_the_pixels_out),
        cmocka_unit_test(not_a_number_is_wrong),
        cmocka_unit_test(psnr_follows_its_definition),
        cmocka_unit_test(spread_of_known_values),
        cmocka_unit_test(a_still_picture_does_not_flicker),
        cmocka_unit_test(a_translated_pattern_does_not_flicker),
        cmocka_unit_test(random_toggles_are_counted),
        cmocka_unit_test(a_filtered_edge_flickers_less_than_a_hard_one),
        cmocka_unit_test(other_surfaces_are_left_out),
        cmocka_unit_test(agrees_with_brute_force),
        cmocka_unit_test(another_size_starts_anew),
        cmocka_unit_test(the_reference_itself_has_no_residual),
        cmocka_unit_test(a_constant_error_has_no_residual),
        cmocka_unit_test(a_reference_that_stands_still_changes_nothing),
        cmocka_unit_test(residual_is_symmetric),
        cmocka_unit_test(residual_agrees_with_brute_force),
        cmocka_unit_test(real_motion_is_taken_off),
    };
    return cmocka_run_group_tests_name("measure", tests, NULL, NULL);
}
