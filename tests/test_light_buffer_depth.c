/* The light buffer's depths, weights, faces and levels against double precision. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/shadow/light_buffer.h>

#include "distribution_testing.h"

#ifdef __SANITIZE_ADDRESS__
#define COUNT 50000
#else
#define COUNT 500000
#endif

#define U 5.9604644775390625e-8 /* half a unit in the last place of 1 */

static uint32_t seed = 1;

static double in(double low, double high)
{
    return low + (high - low) * random_unit(&seed);
}

static int whole(int low, int high) /* both included */
{
    return low + (int)(random_unit(&seed) * (high - low + 1));
}

/* From low to high, evenly in the logarithm. */
static double size_in(double low, double high)
{
    return low * pow(high / low, random_unit(&seed));
}

/* One triangle and one ray, as the functions get them and in double. */
typedef struct meeting {
    bool central;
    float corner[3][3], ray[3]; /* x, y, depth; W under a lamp */
    gn_light_corner relative[3];
    gn_light_weights w;
    double weight[3], bound[3]; /* and how far the rounded one may be off */
    double area, depth;         /* on the ray */
} meeting;

/* What the functions say, and what is true of the same floats. A rounded difference x - r w is off
 * by U (|x| + 2 |r w|) at most, a product of two by 3 U times their bounds, and the difference of
 * two products by 4 U times their sum; the rest is terms in U^2. */
static void meet(meeting *m)
{
    double at[3][2], most[3][2];
    for (int i = 0; i < 3; i++) {
        const float *p = m->corner[i], *r = m->ray;
        m->relative[i] = m->central ? gn_light_corner_central(p[0], p[1], p[2], r[0], r[1])
                                    : gn_light_corner_parallel(p[0], p[1], r[0], r[1]);
        for (int k = 0; k < 2; k++) {
            const double moved = (double)r[k] * (m->central ? (double)p[2] : 1.0);
            at[i][k] = (double)p[k] - moved;
            most[i][k] = m->central ? fabs((double)p[k]) + 2 * fabs(moved) : fabs(at[i][k]);
        }
    }
    m->w = gn_light_weigh(m->relative[0], m->relative[1], m->relative[2]);
    m->area = m->depth = 0;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        m->weight[i] = at[j][0] * at[k][1] - at[j][1] * at[k][0];
        m->bound[i] = 4.001 * U * (most[j][0] * most[k][1] + most[j][1] * most[k][0]);
        m->area += m->weight[i];
        m->depth += m->weight[i] * (double)m->corner[i][2];
    }
    m->depth /= m->area;
}

/* Anything from slivers to triangles far larger than the cell, around the ray or beside it; those
 * of a lamp may stand across its plane W = 0 or behind it. */
static meeting random_meeting(void)
{
    meeting m = {.central = whole(0, 1)};
    const double size = size_in(1e-4, 1e4), away = size * size_in(0.1, 100),
                 thin = whole(0, 1) ? 1 : size_in(1e-6, 1), most = m.central ? 0.7 : 0.7 * away;
    m.ray[2] = (float)(m.central ? away : in(-1, 1) * away);
    const double x = in(-most, most), y = in(-most, most);
    m.ray[0] = (float)x;
    m.ray[1] = (float)y;
    for (int i = 0; i < 3; i++) {
        const double angle = 8 * atan(1) * (i + in(0, 0.9)) / 3, radius = size * size_in(0.01, 1),
                     depth = (double)m.ray[2] + size * in(-1, 1), beside = whole(0, 3) ? 0 : size;
        m.corner[i][0] = (float)(x * (m.central ? depth : 1) + radius * cos(angle) + beside);
        m.corner[i][1] = (float)(y * (m.central ? depth : 1) + radius * sin(angle) * thin);
        m.corner[i][2] = (float)depth;
    }
    return m;
}

static void test_covers(void **state)
{
    (void)state;
    double worst = 0;
    size_t covered = 0, decided = 0, across = 0, behind = 0;
    for (int n = 0; n < COUNT; n++) {
        meeting m = random_meeting();
        meet(&m);
        const float weight[3] = {m.w.a, m.w.b, m.w.c};
        int sure[3];
        for (int i = 0; i < 3; i++) {
            const double error = fabs((double)weight[i] - m.weight[i]);
            worst = fmax(worst, error / m.bound[i]);
            if (error > m.bound[i])
                fail_msg("weight %g, exactly %g, bound %g", (double)weight[i], m.weight[i],
                         m.bound[i]);
            sure[i] = fabs(m.weight[i]) > m.bound[i] ? (m.weight[i] > 0 ? 1 : -1) : 0;
        }
        if (sure[0] == 0 || sure[1] == 0 || sure[2] == 0)
            continue;
        decided++;
        const bool truth = sure[0] == sure[1] && sure[1] == sure[2];
        const bool covers = gn_light_covers(m.relative[0], m.relative[1], m.relative[2], m.w) != 0;
        if (covers != truth)
            fail_msg("weights %g %g %g: covered %d", m.weight[0], m.weight[1], m.weight[2], covers);
        if (!covers)
            continue;
        covered++;
        if ((gn_light_area(m.w) > 0.0f) != (m.area > 0))
            fail_msg("area %g, exactly %g", (double)gn_light_area(m.w), m.area);
        across += m.central &&
                  (m.corner[0][2] < 0.0f) + (m.corner[1][2] < 0.0f) + (m.corner[2][2] < 0.0f) == 1;
        behind += m.central && m.depth < 0;
    }
    print_message(
        "%zu of %d decided, %zu covered; %zu with a corner behind the lamp, %zu met there; "
        "worst error of a weight %.2f of its bound\n",
        decided, COUNT, covered, across, behind, worst);
    assert_true(decided > COUNT / 2 && covered > COUNT / 4 && across > COUNT / 100 &&
                behind > COUNT / 100);
    assert_true(worst > 0.3); /* the bound means something */
}

/* Barycentric weights: the point that they blend the corners to lies on the ray. */
static void test_barycentric(void **state)
{
    (void)state;
    double worst = 0;
    for (int n = 0; n < COUNT / 10; n++) {
        meeting m = random_meeting();
        meet(&m);
        if (!gn_light_covers(m.relative[0], m.relative[1], m.relative[2], m.w))
            continue;
        const double weight[3] = {(double)m.w.a, (double)m.w.b, (double)m.w.c};
        double x = 0, y = 0, most = 0;
        for (int i = 0; i < 3; i++) {
            const double px = (double)m.relative[i].x, py = (double)m.relative[i].y;
            x += weight[i] * px;
            y += weight[i] * py;
            most = fmax(most, fmax(fabs(px), fabs(py)));
        }
        const double off = fmax(fabs(x), fabs(y)), allowed = 8 * U * most * most * most;
        worst = fmax(worst, off / allowed);
        if (off > allowed)
            fail_msg("off the ray by %g, bound %g", off, allowed);
    }
    print_message("off the ray by %.2f of the bound\n", worst);
    assert_true(worst > 0.1);
}

/* Depth ---------------------------------------------------------------------------------------- */

/* A plane's depth over a cell. */
typedef struct plane {
    double depth, slope_x, slope_y; /* at the cell's centre */
    double half;                    /* of the cell's side */
} plane;

static double rounding_of(const plane *p)
{
    return 0x1p-22 * (fabs(p->slope_x) + fabs(p->slope_y)) * p->half;
}

static float ahead(const plane *p, double depth, float x, float y, double receiver)
{
    const float high = (float)depth, ray_high = (float)receiver;
    return gn_light_ahead(high, (float)(depth - (double)high), (float)p->slope_x, (float)p->slope_y,
                          x, y, ray_high, (float)(receiver - (double)ray_high));
}

static double exact_depth(const plane *p, float x, float y)
{
    return p->depth + p->slope_x * (double)x + p->slope_y * (double)y;
}

/* Flat and steep planes, near and far; receivers in them, close to them and anywhere. */
static void test_ahead(void **state)
{
    (void)state;
    double worst = 0;
    size_t own = 0, before = 0, behind = 0;
    for (int n = 0; n < COUNT; n++) {
        const plane p = {.depth = in(-1, 1) * size_in(1e-3, 1e6),
                         .slope_x = in(-1, 1) * size_in(1e-6, 1e6),
                         .slope_y = in(-1, 1) * size_in(1e-6, 1e6),
                         .half = size_in(1e-4, 1e2)};
        const float x = (float)(in(-1, 1) * p.half), y = (float)(in(-1, 1) * p.half);
        const double depth = exact_depth(&p, x, y),
                     scale =
                         fabs(p.depth) + fabs(p.slope_x * (double)x) + fabs(p.slope_y * (double)y);
        const int kind = whole(0, 2);
        const double receiver = kind == 0 ? depth : depth + in(-1, 1) * scale * size_in(1e-12, 1);
        const double truth = depth - receiver,
                     error = fabs((double)ahead(&p, p.depth, x, y, receiver) - truth);
        /* The slopes' share, the result's own rounding, and the parts that are split off. */
        const double allowed = rounding_of(&p) + 2 * U * fabs(truth) + 4 * U * U * scale;
        worst = fmax(worst, error / allowed);
        if (error > allowed)
            fail_msg("depth %.17g, receiver %.17g, slopes %g %g, half %g: off by %g, bound %g",
                     depth, receiver, p.slope_x, p.slope_y, p.half, error, allowed);
        /* Raised by the bound, no plane hides what lies in it; what lies clearly behind is hidden.
         */
        const double raised = p.depth + rounding_of(&p), slack = 4 * U * U * scale;
        const double result = (double)ahead(&p, raised, x, y, receiver);
        own += kind == 0;
        before += truth > slack;
        if (truth >= 0 && result < -slack)
            fail_msg("a receiver %g before a plane is hidden by it", truth);
        if (truth < -2 * allowed) {
            behind++;
            if (!(result < 0))
                fail_msg("a receiver %g behind a plane is not hidden, bound %g", -truth, allowed);
        }
    }
    print_message(
        "%zu receivers in the plane, %zu before it, %zu behind it; worst error %.2f of the "
        "bound\n",
        own, before, behind, worst);
    assert_true(own > COUNT / 4 && before > COUNT / 5 && behind > COUNT / 8 && worst > 0.4);
}

/* Whole numbers: no rounding. What lies in the plane is not hidden, a unit behind it is. */
static void test_equal_depth(void **state)
{
    (void)state;
    for (int n = 0; n < COUNT / 10; n++) {
        const plane p = {whole(-1000, 1000), whole(-9, 9), whole(-9, 9), 16};
        const float x = (float)whole(-16, 16), y = (float)whole(-16, 16);
        const double depth = exact_depth(&p, x, y);
        assert_true(ahead(&p, p.depth, x, y, depth) == 0.0f);
        assert_true(ahead(&p, p.depth, x, y, depth + 1) == -1.0f);
        assert_true(ahead(&p, p.depth, x, y, depth - 1) == 1.0f);
    }
}

/* A lamp: by -1 / W a plane is linear over the face, and it hides a receiver where the lamp's ray
 * meets it between the two, not behind the lamp. */
static void test_central_depth(void **state)
{
    (void)state;
    size_t between = 0, beyond = 0, behind = 0;
    for (int n = 0; n < COUNT / 2; n++) {
        meeting m = random_meeting();
        m.central = true;
        m.ray[0] = (float)in(-1, 1);
        m.ray[1] = (float)in(-1, 1);
        m.ray[2] = fabsf(m.ray[2]);
        meet(&m);
        double edge[2][3], normal[3], d = 0;
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 2; i++)
                edge[i][k] = (double)m.corner[i + 1][k] - (double)m.corner[0][k];
        for (int k = 0; k < 3; k++) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            normal[k] = edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i];
            d += normal[k] * (double)m.corner[0][k];
        }
        const double half = size_in(1e-3, 1);
        const double cx = (double)m.ray[0] - in(-1, 1) * half,
                     cy = (double)m.ray[1] - in(-1, 1) * half;
        const plane p = {.depth = -(normal[2] + normal[0] * cx + normal[1] * cy) / d,
                         .slope_x = -normal[0] / d,
                         .slope_y = -normal[1] / d,
                         .half = half};
        const float x = (float)((double)m.ray[0] - cx), y = (float)((double)m.ray[1] - cy);
        const double receiver = -1 / (double)m.ray[2];
        /* By the weights, which know nothing of the plane. */
        const double w = m.depth;
        const double margin =
            2 * rounding_of(&p) +
            8 * U * (fabs(receiver) + fabs(p.depth) + (fabs(p.slope_x) + fabs(p.slope_y)) * half);
        if (!(fabs(-1 / w - receiver) > margin) ||
            !(fabs(m.area) > m.bound[0] + m.bound[1] + m.bound[2]))
            continue;
        const bool truth = w > 0 && w < (double)m.ray[2];
        between += truth;
        behind += w < 0;
        beyond += w > (double)m.ray[2];
        if ((ahead(&p, p.depth, x, y, receiver) < 0.0f) != truth)
            fail_msg("W %g, the receiver's %g: hidden %d", w, (double)m.ray[2], !truth);
    }
    print_message("%zu planes between lamp and receiver, %zu beyond it, %zu behind the lamp\n",
                  between, beyond, behind);
    assert_true(between > COUNT / 20 && beyond > COUNT / 20 && behind > COUNT / 20);
}

/* Faces and levels ------------------------------------------------------------------------------
 */

/* The face is the first of the six along which the point lies farthest. */
static void test_face(void **state)
{
    (void)state;
    static const float special[] = {0.0f,  -0.0f,   1.0f,   -1.0f,  2.0f,
                                    -2.0f, FLT_MAX, 1e-40f, -1e-40f};
    size_t seen[6] = {0};
    for (int n = 0; n < COUNT / 5; n++) {
        float p[3];
        for (int i = 0; i < 3; i++)
            p[i] = whole(0, 1) ? special[whole(0, 8)] : (float)in(-2, 2);
        int best = 0;
        for (int face = 1; face < 6; face++) {
            const float along = face % 2 ? -p[face / 2] : p[face / 2];
            if (along > (best % 2 ? -p[best / 2] : p[best / 2]))
                best = face;
        }
        const int face = gn_light_face(p[0], p[1], p[2]);
        /* Of equal coordinates of both signs the first axis counts, not the first face. */
        const float most = best % 2 ? -p[best / 2] : p[best / 2];
        for (int axis = 2; axis >= 0; axis--)
            if (fabsf(p[axis]) == most)
                best = 2 * axis + (p[axis] < 0.0f);
        if (face != best)
            fail_msg("(%g, %g, %g) is in face %d, expected %d", (double)p[0], (double)p[1],
                     (double)p[2], face, best);
        seen[face]++;
    }
    for (int face = 0; face < 6; face++)
        assert_true(seen[face] > COUNT / 100);
}

/* A tile is a power of two, of 2^GN_LIGHT_TILE_BITS footprints down to a sixteenth. */
static void test_level(void **state)
{
    (void)state;
    const double most = ldexp(1.0, GN_LIGHT_TILE_BITS);
    for (int n = 0; n < COUNT / 10; n++) {
        const float width =
            (float)(whole(0, 3) ? size_in(1e-30, 1e30) : ldexp(1.0, whole(-99, 99)));
        const double footprints = ldexp(1.0, gn_light_level(width)) / (double)width;
        if (!(footprints > most / 16 && footprints <= most))
            fail_msg("width %g: %g footprints", (double)width, footprints);
    }
    assert_int_equal(gn_light_level(1.0f), GN_LIGHT_TILE_BITS);
    assert_int_equal(gn_light_level(nextafterf(16.0f, 0.0f)), GN_LIGHT_TILE_BITS);
    assert_int_equal(gn_light_level(16.0f), GN_LIGHT_TILE_BITS + 4);
    assert_int_equal(gn_light_level(nextafterf(1.0f, 0.0f)), GN_LIGHT_TILE_BITS - 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_covers),        cmocka_unit_test(test_barycentric),
        cmocka_unit_test(test_ahead),         cmocka_unit_test(test_equal_depth),
        cmocka_unit_test(test_central_depth), cmocka_unit_test(test_face),
        cmocka_unit_test(test_level)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
