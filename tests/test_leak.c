/* Leak tracing's test and mask against the paper's long forms and its Table 1,
 * over all inputs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/shadow/bilinear.h>
#include <gnomon/shadow/leak.h>

#include "distribution_testing.h"
#include "leak_oracle.h"

static const gn_leak_class classes[] = {GN_LEAK_BLACK,  GN_LEAK_RED,     GN_LEAK_GREEN,
                                        GN_LEAK_YELLOW, GN_LEAK_NOTHING, GN_LEAK_PURPLE,
                                        GN_LEAK_WHITE};
#define CLASSES (sizeof classes / sizeof *classes)

/* Table 1: colour, LTT, ST, RS; RS is not known without a ray. */
static void test_classes(void **state)
{
    (void)state;
    const struct {
        int ray, shadow, hit;
        gn_leak_class class;
    } table[] = {
        {0, 0, 0, GN_LEAK_BLACK}, {0, 0, 1, GN_LEAK_BLACK},  {0, 1, 0, GN_LEAK_GREEN},
        {0, 1, 1, GN_LEAK_GREEN}, {1, 1, 1, GN_LEAK_WHITE},  {1, 0, 1, GN_LEAK_PURPLE},
        {1, 0, 0, GN_LEAK_RED},   {1, 1, 0, GN_LEAK_YELLOW},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        const int32_t bits = gn_leak_state(table[i].ray, table[i].shadow, table[i].hit);
        if (bits != (int32_t)table[i].class)
            fail_msg("LTT %d, ST %d, RS %d is %d, expected %d", table[i].ray, table[i].shadow,
                     table[i].hit, bits, (int)table[i].class);
    }
    assert_int_equal(GN_LEAK_HIT, GN_LEAK_NOTHING);
}

/* Equations 6 and 8 for one neighbour: Equation 5 with the change of ST, and
 * Equation 7. */
static void test_long_forms(void **state)
{
    (void)state;
    for (size_t i = 0; i < CLASSES; i++)
        for (int shadow = 0; shadow < 2; shadow++) {
            const int expands = gn_leak_expands((int32_t)classes[i], shadow),
                      confirms = gn_leak_confirms((int32_t)classes[i], shadow);
            if (expands != leak_long_expands(classes[i], shadow) ||
                confirms != leak_long_confirms(classes[i], shadow))
                fail_msg("neighbour %d, ST %d: expands %d, confirms %d; expected %d, %d",
                         (int)classes[i], shadow, expands, confirms,
                         leak_long_expands(classes[i], shadow),
                         leak_long_confirms(classes[i], shadow));
        }
}

/* What sections 3.1.1 and 3.1.2 say in words, by colours. */
static bool any_asks(const gn_leak_class neighbours[4], bool shadow)
{
    for (int i = 0; i < 4; i++)
        switch (neighbours[i]) {
        case GN_LEAK_PURPLE: /* ST there is lit */
        case GN_LEAK_YELLOW: /* ST there is shadow */
            return true;     /* a correction of this very answer, or another answer */
        case GN_LEAK_BLACK:
        case GN_LEAK_RED:
            if (shadow)
                return true;
            break;
        case GN_LEAK_GREEN:
        case GN_LEAK_WHITE:
            if (!shadow)
                return true;
            break;
        case GN_LEAK_NOTHING:
            break;
        }
    return false;
}

/* Of every gather of four neighbours: any expands exactly where the words say
 * so, and all confirm exactly where none expands, so that what is removed does
 * not come back by expansion. */
static void test_all_gathers(void **state)
{
    (void)state;
    size_t expanding = 0, confirming = 0, count = 0;
    for (size_t code = 0; code < CLASSES * CLASSES * CLASSES * CLASSES; code++)
        for (int shadow = 0; shadow < 2; shadow++) {
            gn_leak_class neighbours[4];
            int any = 0, all = 1;
            size_t rest = code;
            for (int i = 0; i < 4; i++, rest /= CLASSES) {
                neighbours[i] = classes[rest % CLASSES];
                any |= gn_leak_expands((int32_t)neighbours[i], shadow);
                all &= gn_leak_confirms((int32_t)neighbours[i], shadow);
            }
            if (any != any_asks(neighbours, shadow) || all == any)
                fail_msg("%d %d %d %d, ST %d: any expands %d, all confirm %d", (int)neighbours[0],
                         (int)neighbours[1], (int)neighbours[2], (int)neighbours[3], shadow, any,
                         all);
            expanding += (size_t)any;
            confirming += (size_t)all;
            count++;
        }
    /* Of either answer, three classes of seven confirm: two, and nothing. */
    assert_int_equal(confirming, 2 * 3 * 3 * 3 * 3);
    assert_int_equal(expanding, count - confirming);
}

/* Nothing is neutral: a gather with nothing in it says what it says without. */
static void test_nothing(void **state)
{
    (void)state;
    for (int shadow = 0; shadow < 2; shadow++) {
        assert_false(gn_leak_expands(GN_LEAK_NOTHING, shadow));
        assert_true(gn_leak_confirms(GN_LEAK_NOTHING, shadow));
        /* Black is not: it expands what is in shadow. */
        assert_int_equal(gn_leak_expands(GN_LEAK_BLACK, shadow), shadow);
    }
}

static void check_unsure(float visibility, float epsilon, int expected)
{
    if (gn_leak_unsure(visibility, epsilon) != expected)
        fail_msg("%a with epsilon %a is %s", (double)visibility, (double)epsilon,
                 expected ? "sure" : "unsure");
}

/* Equation 3 leaves its ends out; where there is no number there is doubt. */
static void test_unsure(void **state)
{
    (void)state;
    const float epsilons[] = {0.0f, 0x1p-20f, 0.01f, 0.25f, 0.49f};
    for (size_t i = 0; i < sizeof epsilons / sizeof *epsilons; i++) {
        const float low = epsilons[i], high = 1.0f - low;
        check_unsure(low, low, 0);
        check_unsure(nextafterf(low, 1.0f), low, 1);
        check_unsure(nextafterf(low, -1.0f), low, 0);
        check_unsure(high, low, 0);
        check_unsure(nextafterf(high, 0.0f), low, 1);
        check_unsure(nextafterf(high, 2.0f), low, 0);
        check_unsure(0.5f, low, 1);
        check_unsure(0.0f, low, 0);
        check_unsure(-0.0f, low, 0);
        check_unsure(1.0f, low, 0);
        check_unsure(-INFINITY, low, 0);
        check_unsure(INFINITY, low, 0);
        check_unsure(NAN, low, 1);
        check_unsure(-NAN, low, 1);
    }
    assert_true(gn_leak_shadowed(nextafterf(0.5f, 0.0f)));
    assert_false(gn_leak_shadowed(0.5f));
    assert_true(gn_leak_shadowed(0.0f));
    assert_false(gn_leak_shadowed(1.0f));
    assert_false(gn_leak_shadowed(NAN));
}

/* Columns that are asked around a place, as bits: bit k is the column left + k.
 */
static uint32_t asked(float place, float jitter, int32_t left)
{
    const int32_t base = gn_to_int(gn_bilinear_base(place + jitter));
    if (base < left || base + 1 > left + 4)
        fail_msg("%.9g asks column %d", (double)place, base);
    return 3u << (base - left);
}

/* Nothing moves: in any four consecutive frames, all nine, and no others. */
static void test_gather_at_rest(void **state)
{
    (void)state;
    const uint32_t starts[] = {0, 1, 2, 3, 1000003, 0xfffffffe, 0xffffffff};
    for (size_t s = 0; s < sizeof starts / sizeof *starts; s++)
        for (int32_t pixel = 0; pixel < 16384; pixel++) {
            const float place = (float)pixel + 0.5f;
            uint32_t rows[3] = {0}; /* columns that were asked in each row */
            for (uint32_t k = 0; k < 4; k++) {
                const uint32_t frame = starts[s] + k;
                const uint32_t across = asked(place, gn_leak_jitter_x(frame), pixel - 1);
                const uint32_t down = asked(place, gn_leak_jitter_y(frame), pixel - 1);
                for (int row = 0; row < 3; row++)
                    rows[row] |= down >> row & 1u ? across : 0;
                if (!(across & 2u) || !(down & 2u) || across > 7u || down > 7u)
                    fail_msg("frame %u, pixel %d: columns %x, rows %x", frame, pixel, across, down);
            }
            if (rows[0] != 7u || rows[1] != 7u || rows[2] != 7u)
                fail_msg("from frame %u, pixel %d: %x %x %x", starts[s], pixel, rows[0], rows[1],
                         rows[2]);
        }
}

/* Places between centres: what leak.h says of distances, in four frames, and
 * nothing that the full kernel would not ask. Steps of 1/1024 are exact. */
static void test_gather_between(void **state)
{
    (void)state;
    for (int step = 0; step < 64 * 1024; step++) {
        const float place = (float)step / 1024.0f;
        const int32_t pixel = (int32_t)place, left = pixel - 2;
        for (int vertical = 0; vertical < 2; vertical++) {
            int times[5] = {0};
            for (uint32_t frame = 0; frame < 4; frame++) {
                const float jitter = vertical ? gn_leak_jitter_y(frame) : gn_leak_jitter_x(frame);
                const uint32_t columns = asked(place, jitter, left);
                if (columns & 17u || !(columns & 4u))
                    fail_msg("%.9g, frame %u: %x", (double)place, frame, columns);
                for (int k = 0; k < 5; k++)
                    times[k] += (int)(columns >> k & 1u);
            }
            for (int k = 0; k < 5; k++) {
                const double distance = fabs((double)(left + k) + 0.5 - (double)place);
                if ((distance < 0.75 && times[k] != 4) ||
                    (distance > 0.75 && distance < 1.25 && times[k] != 2) ||
                    (distance > 1.25 && times[k] != 0))
                    fail_msg("%.9g: column %d is asked %d times of 4", (double)place, left + k,
                             times[k]);
            }
        }
    }
}

/* Any motion by less than a pixel, its roundings included: never beside the
 * full kernel's pixels, and always the pixel that the place lies in. */
static void test_gather_in_motion(void **state)
{
    (void)state;
    uint32_t seed = 7;
    for (uint32_t frame = 0; frame < 2000000; frame++) {
        const int32_t from = (int32_t)(random_unit(&seed) * (frame % 2 ? 8.0 : 16384.0));
        const float motion = (float)((random_unit(&seed) - 0.5) * 2.0);
        const float place = (float)from + 0.5f + motion;
        const int32_t left = (int32_t)floorf(place) - 2;
        const uint32_t across = asked(place, gn_leak_jitter_x(frame), left);
        const uint32_t down = asked(place, gn_leak_jitter_y(frame), left);
        if ((across | down) & 17u || !(across & down & 4u))
            fail_msg("%.9g, frame %u: columns %x, rows %x", (double)place, frame, across, down);
    }
}

/* Pictures
 * --------------------------------------------------------------------------------------*/

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

/* A picture at rest, its two masks, and what the frame's oracle made of it. */
typedef struct picture {
    leak_oracle oracle;
    bool facing[PIXELS], held[PIXELS];
    float test[PIXELS], ray[PIXELS], zero[PIXELS], visibility[PIXELS], traced[PIXELS];
    uint8_t masks[2][PIXELS];
} picture;

/* Unsure, and lit by test and ray everywhere. */
static void picture_make(picture *p, gn_leak_kernel kernel)
{
    memset(p, 0, sizeof *p);
    for (int i = 0; i < PIXELS; i++) {
        p->facing[i] = p->held[i] = true;
        p->test[i] = 0.75f;
        p->ray[i] = 1.0f;
    }
    p->oracle = (leak_oracle){.width = WIDTH,
                              .height = HEIGHT,
                              .masked = true,
                              .desc = {.epsilon = 0.01f,
                                       .kernel = kernel,
                                       .expand = true,
                                       .remove = true,
                                       .depth_test = GN_SWITCH_OFF},
                              .facing = p->facing,
                              .held = p->held,
                              .test = p->test,
                              .ray = p->ray,
                              .motion = {p->zero, p->zero, p->zero},
                              .depth = p->zero,
                              .visibility = p->visibility,
                              .traced = p->traced,
                              .now = p->masks[0]};
}

/* The next frame: of the oracle, and its decisions by leak.h once more. */
static void picture_frame(picture *p)
{
    leak_oracle *o = &p->oracle;
    leak_oracle_frame(o);
    for (int32_t i = 0; o->before && i < PIXELS; i++) {
        const int32_t x = i % WIDTH, y = i / WIDTH;
        const bool full = o->desc.kernel == GN_LEAK_FULL;
        const int32_t left =
            full ? x - 1
                 : gn_to_int(gn_bilinear_base((float)x + 0.5f + gn_leak_jitter_x(o->frame)));
        const int32_t top =
            full ? y - 1
                 : gn_to_int(gn_bilinear_base((float)y + 0.5f + gn_leak_jitter_y(o->frame)));
        const int shadow = gn_leak_shadowed(p->test[i]);
        /* Rays are added by the kernel, and taken away by all nine. */
        int any = 0, all = 1;
        for (int32_t row = y - 1; row <= y + 1; row++)
            for (int32_t column = x - 1; column <= x + 1; column++)
                if (row >= 0 && row < HEIGHT && column >= 0 && column < WIDTH) {
                    const int32_t neighbour = o->before[row * WIDTH + column];
                    const int asked = row >= top && row < top + 2 + full && column >= left &&
                                      column < left + 2 + full;
                    any |= asked && gn_leak_expands(neighbour, shadow);
                    all &= gn_leak_confirms(neighbour, shadow);
                }
        const int ray = gn_leak_unsure(p->test[i], o->desc.epsilon)
                            ? !(o->desc.remove && all && gn_leak_removable(p->test[i]))
                            : o->desc.expand && any;
        const int32_t class = p->facing[i] && o->before[i] != GN_LEAK_NOTHING
                                  ? gn_leak_state(ray, shadow, gn_leak_blocked(p->ray[i], shadow))
                                  : o->now[i];
        if (class != o->now[i])
            fail_msg("frame %u, pixel %d, %d: class %d, of the oracle %d", o->frame, x, y, class,
                     o->now[i]);
    }
    o->before = o->now;
    o->now = p->masks[o->now == p->masks[0]];
    o->frame++;
}

/* Where rays agree with one answer everywhere, the first frame's are the last.
 */
static void test_agreement(void **state)
{
    (void)state;
    picture p;
    for (int kernel = GN_LEAK_GATHER; kernel <= GN_LEAK_FULL; kernel++)
        for (int shadow = 0; shadow < 2; shadow++) {
            picture_make(&p, (gn_leak_kernel)kernel);
            for (int i = 0; i < PIXELS; i++) {
                p.test[i] = shadow ? 0.2f : 0.8f;
                p.ray[i] = shadow ? 0.0f : 1.0f;
                p.facing[i] = i % 7 != 0; /* what faces away does not disturb that */
            }
            picture_frame(&p);
            uint64_t facing = 0;
            for (int i = 0; i < PIXELS; i++)
                facing += p.facing[i];
            assert_int_equal(p.oracle.rays, facing);
            assert_int_equal(p.oracle.counts.lost, facing);
            for (int frame = 1; frame < 8; frame++) {
                picture_frame(&p);
                assert_int_equal(p.oracle.rays, 0);
                assert_int_equal(p.oracle.counts.removed, facing);
                for (int i = 0; i < PIXELS; i++)
                    assert_true(p.visibility[i] == (p.facing[i] && !shadow ? 1.0f : 0.0f));
            }
        }
}

/* A shadow's edge at rest, known to a map that is often unsure, but right. When the mask has
 * settled, rays remain exactly where a neighbour has the other answer: in every frame with the full
 * kernel, with the gather at least once in four. */
static void test_silhouettes(void **state)
{
    (void)state;
    uint32_t seed = 3;
    picture p;
    for (int kernel = GN_LEAK_GATHER; kernel <= GN_LEAK_FULL; kernel++)
        for (int trial = 0; trial < 50; trial++) {
            picture_make(&p, (gn_leak_kernel)kernel);
            const double edge = random_unit(&seed) * WIDTH, slope = random_unit(&seed) - 0.5;
            for (int i = 0; i < PIXELS; i++) {
                const double side = (double)(i % WIDTH) - edge + slope * (double)(i / WIDTH);
                const bool unsure = random_unit(&seed) < 0.3;
                p.test[i] = side < 0.0 ? (unsure ? 0.2f : 0.0f) : (unsure ? 0.8f : 1.0f);
                p.ray[i] = side < 0.0 ? 0.0f : 1.0f;
            }
            for (int frame = 0; frame < 8; frame++)
                picture_frame(&p);
            uint32_t traced[PIXELS] = {0};
            for (int frame = 0; frame < 4; frame++) {
                picture_frame(&p);
                for (int i = 0; i < PIXELS; i++) {
                    traced[i] += p.traced[i] > 0.0f;
                    assert_true(p.visibility[i] == p.ray[i]);
                }
            }
            for (int i = 0; i < PIXELS; i++) {
                bool edge_here = false;
                for (int k = 0; k < 9; k++) {
                    const int x = i % WIDTH + k % 3 - 1, y = i / WIDTH + k / 3 - 1;
                    edge_here = edge_here || (x >= 0 && x < WIDTH && y >= 0 && y < HEIGHT &&
                                              p.ray[y * WIDTH + x] != p.ray[i]);
                }
                const uint32_t expected = edge_here ? 4 : 0;
                if (kernel == GN_LEAK_FULL ? traced[i] != expected : (traced[i] > 0) != edge_here)
                    fail_msg("trial %d, kernel %d, pixel %d, %d: %u rays in 4 frames, edge %d",
                             trial, kernel, i % WIDTH, i / WIDTH, traced[i], edge_here);
            }
        }
}

/* A map that is sure and wrong (Figure 4): of a wire's shadow it only suspects one end. That is
 * removed at first, since the frame before saw light all around (section 4.3). Without removal rays
 * follow the wire: by a pixel a frame with the full kernel, by one in four at least with the
 * gather, and what they have found they keep. */
static void test_expansion(void **state)
{
    (void)state;
    picture p;
    for (int kernel = GN_LEAK_GATHER; kernel <= GN_LEAK_FULL; kernel++) {
        picture_make(&p, (gn_leak_kernel)kernel);
        const int left = 4, right = 15, row = 7; /* a wire in shadow that the map does not know */
        for (int i = 0; i < PIXELS; i++)
            p.test[i] = 1.0f;
        picture_frame(&p); /* all get a ray in the first frame: nothing is in shadow */
        for (int x = left; x <= right; x++)
            p.ray[row * WIDTH + x] = 0.0f;
        p.test[row * WIDTH + left] = 0.8f; /* unsure */
        picture_frame(&p);                 /* but removed: rays agreed all around */
        assert_int_equal(p.oracle.rays, 0);
        p.oracle.desc.remove = false;
        int last = left - 1;
        for (int frame = 0; frame <= 4 * (right - left); frame++) {
            const int before = last;
            picture_frame(&p);
            for (last = left - 1; p.visibility[row * WIDTH + last + 1] == 0.0f;)
                last++;
            const int least = kernel == GN_LEAK_FULL ? left + frame : left + frame / 4;
            if (last < before || last < (least < right ? least : right))
                fail_msg("kernel %d, frame %d: shadow up to %d, before %d, expected %d", kernel,
                         frame, last, before, least);
        }
        assert_int_equal(last, right);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_classes),        cmocka_unit_test(test_long_forms),
        cmocka_unit_test(test_all_gathers),    cmocka_unit_test(test_nothing),
        cmocka_unit_test(test_unsure),         cmocka_unit_test(test_gather_at_rest),
        cmocka_unit_test(test_gather_between), cmocka_unit_test(test_gather_in_motion),
        cmocka_unit_test(test_agreement),      cmocka_unit_test(test_silhouettes),
        cmocka_unit_test(test_expansion),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
