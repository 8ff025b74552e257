/* The light buffer's arithmetic: edges that belong to one side, covers without cracks, depth, faces
 * and levels, against exact sums and double precision. */
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

#include "bits_testing.h"
#include "distribution_testing.h"

#ifdef __SANITIZE_ADDRESS__
#define RAYS 100000
#else
#define RAYS 1000000
#endif

#define U    5.9604644775390625e-8 /* half a unit in the last place of 1 */
#define MOST 192                   /* triangles, or points, of a mesh */

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

/* Meshes in the frame of a cell ---------------------------------------------------------------- */

typedef struct point {
    float x, y, depth;
} point;

typedef struct mesh {
    bool central;
    int points, triangles;
    point point[MOST];
    int corner[MOST][3];
    /* The border, counter-clockwise where the mesh is; none of a closed mesh. */
    int edges;
    int border[MOST][2];
} mesh;

typedef struct ray {
    float x, y, depth;
} ray;

static void add_triangle(mesh *m, int a, int b, int c)
{
    assert_true(m->triangles < MOST);
    int *corner = m->corner[m->triangles++];
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}

static void add_border(mesh *m, int a, int b)
{
    assert_true(m->edges < MOST);
    m->border[m->edges][0] = a;
    m->border[m->edges++][1] = b;
}

/* Where x and y are seen; in a central frame, at W = depth. */
static int add_point(mesh *m, double x, double y, double depth)
{
    assert_true(m->points < MOST);
    const double w = m->central ? depth : 1.0;
    m->point[m->points] = (point){(float)(x * w), (float)(y * w), (float)depth};
    return m->points++;
}

static gn_light_corner corner_of(const mesh *m, int i, ray r)
{
    const point p = m->point[i];
    return m->central ? gn_light_corner_central(p.x, p.y, p.depth, r.x, r.y)
                      : gn_light_corner_parallel(p.x, p.y, r.x, r.y);
}

/* How often a ray is covered by triangles of each orientation. */
typedef struct cover {
    int positive, negative;
    int nearer; /* than the receiver */
} cover;

static cover cover_of(const mesh *m, ray r)
{
    gn_light_corner at[MOST];
    for (int i = 0; i < m->points; i++)
        at[i] = corner_of(m, i, r);
    cover n = {0, 0, 0};
    for (int t = 0; t < m->triangles; t++) {
        const gn_light_corner a = at[m->corner[t][0]], b = at[m->corner[t][1]],
                              c = at[m->corner[t][2]];
        const gn_light_weights w = gn_light_weigh(a, b, c);
        const float area = gn_light_area(w);
        if (gn_light_inside(w))
            assert_true(gn_light_covers(a, b, c, w));
        else if (!gn_light_on_edge(w))
            assert_false(gn_light_covers(a, b, c, w));
        if (!gn_light_covers(a, b, c, w))
            continue;
        n.positive += area > 0.0f;
        n.negative += area < 0.0f;
        const point *p = m->point;
        const double scaled = (double)w.a * (double)p[m->corner[t][0]].depth +
                              (double)w.b * (double)p[m->corner[t][1]].depth +
                              (double)w.c * (double)p[m->corner[t][2]].depth;
        n.nearer += scaled / (double)area < (double)r.depth;
    }
    return n;
}

/* Twice the area of (0, a, b), exact but for one rounding in double: of the right sign. */
static double exact_weight(gn_light_corner a, gn_light_corner b)
{
    return (double)a.x * (double)b.y - (double)a.y * (double)b.x;
}

/* How often the border winds around the ray, of corners as the ray sees them: edges that cross the
 * axis y = 0 at x > 0. -100 where the ray meets the border. */
static int winding_of(const mesh *m, ray r)
{
    int winding = 0;
    for (int i = 0; i < m->edges; i++) {
        const gn_light_corner a = corner_of(m, m->border[i][0], r),
                              b = corner_of(m, m->border[i][1], r);
        if (gn_light_weigh(a, a, b).a == 0.0f)
            return -100;
        if (a.y <= 0.0f && b.y > 0.0f)
            winding += exact_weight(a, b) > 0.0;
        else if (b.y <= 0.0f && a.y > 0.0f)
            winding -= exact_weight(a, b) < 0.0;
    }
    return winding;
}

/* Does rounding take the ray for one on an edge's line that it is not on? */
static bool doubtful(const mesh *m, ray r)
{
    for (int t = 0; t < m->triangles; t++)
        for (int i = 0; i < 3; i++) {
            const gn_light_corner a = corner_of(m, m->corner[t][i], r),
                                  b = corner_of(m, m->corner[t][(i + 1) % 3], r);
            if (gn_light_weigh(a, a, b).a == 0.0f && exact_weight(a, b) != 0.0)
                return true;
        }
    return false;
}

/* Is a triangle turned over, or to a line, by the rounding of its corners? */
static bool folded(const mesh *m, ray r)
{
    for (int t = 0; t < m->triangles; t++) {
        gn_light_corner at[3];
        for (int i = 0; i < 3; i++)
            at[i] = corner_of(m, m->corner[t][i], r);
        const double x1 = (double)at[1].x - (double)at[0].x, y1 = (double)at[1].y - (double)at[0].y,
                     x2 = (double)at[2].x - (double)at[0].x, y2 = (double)at[2].y - (double)at[0].y;
        if (!(x1 * y2 - y1 * x2 > 0.0))
            return true;
    }
    return false;
}

/* Rays through points, along edges, near them, and anywhere. */
static ray ray_at(const mesh *m, double spread)
{
    const int t = whole(0, m->triangles - 1);
    const point p = m->point[m->corner[t][0]], q = m->point[m->corner[t][1]];
    const double pw = m->central ? (double)p.depth : 1.0, qw = m->central ? (double)q.depth : 1.0;
    double x = (double)p.x / pw, y = (double)p.y / pw;
    const int kind = whole(0, 3);
    if (kind > 0) {
        const double share = kind == 1 ? in(0, 1) : size_in(1e-8, 1);
        x += share * ((double)q.x / qw - x);
        y += share * ((double)q.y / qw - y);
    }
    if (kind == 3) {
        x += spread * in(-1, 1);
        y += spread * in(-1, 1);
    }
    return (ray){(float)x, (float)y, m->central ? (float)size_in(0.01, 100) : (float)in(-1, 1)};
}

/* Edges ---------------------------------------------------------------------------------------- */

static void check_edge(gn_light_corner a, gn_light_corner b, float forward, float back)
{
    const int one = gn_light_side(forward, a, b), other = gn_light_side(back, b, a);
    const bool together = a.x == b.x && a.y == b.y;
    if (one + other != (together ? 0 : 1))
        fail_msg("(%a, %a) to (%a, %a), weights %a and %a: sides %d and %d", (double)a.x,
                 (double)a.y, (double)b.x, (double)b.y, (double)forward, (double)back, one, other);
}

static float coordinate(void)
{
    static const float special[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-40f, -1e-40f, 0x1p-126f, 1e5f};
    switch (whole(0, 3)) {
    case 0:
        return special[whole(0, 7)];
    case 1:
        return (float)whole(-3, 3);
    case 2:
        return (float)(size_in(1e-30, 1e15) * (whole(0, 1) ? 1 : -1));
    default:
        return (float)in(-1, 1);
    }
}

/* The edge function turns its sign with the edge, to the bit, and one direction alone holds. */
static void test_edges(void **state)
{
    (void)state;
    size_t met = 0;
    for (int i = 0; i < RAYS; i++) {
        const gn_light_corner a = {coordinate(), coordinate()},
                              b = {whole(0, 9) ? coordinate() : a.x, coordinate()};
        const gn_light_weights there = gn_light_weigh(a, a, b), back = gn_light_weigh(a, b, a);
        if (there.a != 0.0f ? to_bits(there.a) != to_bits(-back.a) : back.a != 0.0f)
            fail_msg("(%a, %a) to (%a, %a) weighs %a, back %a", (double)a.x, (double)a.y,
                     (double)b.x, (double)b.y, (double)there.a, (double)back.a);
        check_edge(a, b, there.a, back.a);
        check_edge(a, b, 0.0f, -0.0f);
        check_edge(a, b, -0.0f, 0.0f);
        met += there.a == 0.0f;
    }
    print_message("%zu of %d rays meet their edge\n", met, RAYS);
    assert_true(met > RAYS / 20);
}

/* The three weights are the three edge functions of their opposite edges. */
static void test_weights(void **state)
{
    (void)state;
    for (int i = 0; i < RAYS / 10; i++) {
        gn_light_corner at[3];
        for (int k = 0; k < 3; k++)
            at[k] = (gn_light_corner){coordinate(), coordinate()};
        const gn_light_weights w = gn_light_weigh(at[0], at[1], at[2]);
        const float weight[3] = {w.a, w.b, w.c};
        for (int k = 0; k < 3; k++) {
            const float edge = gn_light_weigh(at[0], at[(k + 1) % 3], at[(k + 2) % 3]).a;
            assert_int_equal(to_bits(weight[k]), to_bits(edge));
            const double exact = exact_weight(at[(k + 1) % 3], at[(k + 2) % 3]);
            if (weight[k] != 0.0f && (weight[k] > 0.0f) != (exact > 0.0))
                fail_msg("weight %a, exactly %a", (double)weight[k], exact);
        }
        /* Of no area: points, and corners that fall together. */
        assert_false(gn_light_covers(at[0], at[0], at[1], gn_light_weigh(at[0], at[0], at[1])));
        assert_false(gn_light_covers(at[0], at[1], at[0], gn_light_weigh(at[0], at[1], at[0])));
        assert_false(gn_light_covers(at[0], at[0], at[0], gn_light_weigh(at[0], at[0], at[0])));
    }
}

/* Planes --------------------------------------------------------------------------------------- */

/* Small whole numbers times a power of two, so that nothing is rounded: rays through all points,
 * along all edges. In a central frame the plane is tilted, and may pass behind the light. */
static void test_grid(void **state)
{
    (void)state;
    enum { SIDE = 6, STEP = 4 };
    size_t rays = 0, behind = 0;
    while (rays < RAYS) {
        mesh m = {.central = whole(0, 1)};
        int at[SIDE][SIDE][3];
        const int u[3] = {whole(3, 4), whole(-1, 1), whole(-1, 1)},
                  v[3] = {whole(-1, 1), whole(3, 4), whole(-1, 1)};
        const int up = whole(3, 9); /* the plane does not pass through the light */
        const float unit = ldexpf(1.0f, whole(-20, 10));
        for (int j = 0; j < SIDE; j++)
            for (int i = 0; i < SIDE; i++) {
                const int a = i * STEP + whole(-1, 1), b = j * STEP + whole(-1, 1);
                for (int k = 0; k < 3; k++)
                    at[j][i][k] = (a - 10) * u[k] + (b - 10) * v[k] + (k == 2 ? up : 0);
                m.point[m.points++] = (point){unit * (float)at[j][i][0], unit * (float)at[j][i][1],
                                              unit * (float)at[j][i][2]};
            }
        for (int j = 0; j < SIDE - 1; j++)
            for (int i = 0; i < SIDE - 1; i++) {
                const int a = j * SIDE + i, b = a + 1, c = b + SIDE, d = a + SIDE,
                          cut = whole(0, 1);
                add_triangle(&m, a, b, cut ? c : d);
                add_triangle(&m, cut ? a : b, c, d);
            }
        for (int n = 0; n < 64; n++) {
            const int i = whole(1, SIDE - 2), j = whole(1, SIDE - 2), k = whole(1, SIDE - 2),
                      l = whole(1, SIDE - 2);
            ray r;
            if (m.central) {
                /* Towards a corner whose depth is a power of two, of which the quotients are exact;
                 * by a sum with another's multiple, towards a point of the plane between them. */
                const int *p = at[j][i], w = abs(p[2]);
                if (w == 0 || (w & (w - 1)) != 0)
                    continue;
                r = (ray){(float)p[0] / (float)p[2], (float)p[1] / (float)p[2], unit};
                behind += p[2] < 0;
            } else {
                r = (ray){unit * 0.5f * (float)(at[j][i][0] + at[l][k][0]),
                          unit * 0.5f * (float)(at[j][i][1] + at[l][k][1]), 0.0f};
            }
            const cover n_of = cover_of(&m, r);
            rays++;
            if (n_of.positive + n_of.negative != 1)
                fail_msg("%s, ray (%a, %a): covered %d + %d times",
                         m.central ? "central" : "parallel", (double)r.x, (double)r.y,
                         n_of.positive, n_of.negative);
        }
    }
    print_message("%zu rays, %zu of them behind a light\n", rays, behind);
    assert_true(behind > 1000);
}

typedef enum shape { FAN, STRIP, LATTICE, SHAPES } shape;

static void add_fan(mesh *m, double x, double y, double size, double thin, double turn)
{
    const int n = whole(3, 12);
    const double first = in(0, 7), step = 8 * atan(1) / n;
    for (int i = 0; i < n; i++) {
        const double angle = first + step * (i + in(-0.4, 0.4)), radius = size * size_in(0.01, 1);
        const double a = radius * cos(angle), b = radius * sin(angle) * thin;
        add_point(m, x + a * cos(turn) - b * sin(turn), y + a * sin(turn) + b * cos(turn),
                  in(1, 3));
    }
    add_point(m, x, y, in(1, 3));
    for (int i = 0; i < n; i++) {
        add_triangle(m, n, i, (i + 1) % n);
        add_border(m, i, (i + 1) % n);
    }
}

/* columns * rows quads, each cut in two. */
static void add_lattice(mesh *m, int columns, int rows, double x, double y, double size,
                        double thin, double turn)
{
    for (int j = 0; j <= rows; j++)
        for (int i = 0; i <= columns; i++) {
            const double a = size * (i + in(-0.2, 0.2)), b = size * thin * (j + in(-0.2, 0.2));
            add_point(m, x + a * cos(turn) - b * sin(turn), y + a * sin(turn) + b * cos(turn),
                      in(1, 3));
        }
    const int across = columns + 1;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns; i++) {
            const int a = j * across + i, b = a + 1, c = b + across, d = a + across,
                      cut = whole(0, 1);
            add_triangle(m, a, b, cut ? c : d);
            add_triangle(m, cut ? a : b, c, d);
        }
    for (int i = 0; i < columns; i++) {
        add_border(m, i, i + 1);
        add_border(m, rows * across + i + 1, rows * across + i);
    }
    for (int j = 0; j < rows; j++) {
        add_border(m, (j + 1) * across, j * across);
        add_border(m, j * across + columns, (j + 1) * across + columns);
    }
}

/* Triangles of all sizes, thin ones, far from the cell's centre: with rounding. A ray is covered as
 * often as the border winds around it, and once where rounding turns no triangle over. */
static void test_planes(void **state)
{
    (void)state;
    size_t rays = 0, once = 0, never = 0, turned = 0;
    for (int k = 0; rays < RAYS; k++) {
        mesh m = {.central = k & 1};
        const double size = size_in(1e-6, 1e5), thin = whole(0, 2) ? 1 : size_in(1e-6, 1),
                     turn = in(0, 7), away = size * (whole(0, 1) ? 4 : 1000);
        const double x = in(-1, 1) * away, y = in(-1, 1) * away;
        switch (whole(0, SHAPES - 1)) {
        case FAN:
            add_fan(&m, x, y, size, thin, turn);
            break;
        case STRIP:
            add_lattice(&m, whole(1, 20), 1, x, y, size, thin, turn);
            break;
        default:
            add_lattice(&m, whole(2, 4), whole(2, 4), x, y, size, thin, turn);
        }
        for (int i = 0; i < 20; i++) {
            const ray r = ray_at(&m, 0.1 * size);
            const int winding = winding_of(&m, r);
            if (winding == -100)
                continue;
            const cover n = cover_of(&m, r);
            rays++;
            once += n.positive == 1;
            never += n.positive == 0;
            const bool good = n.positive - n.negative == winding;
            const bool plain = n.positive + n.negative <= 1;
            turned += !plain;
            if (!good || (!plain && !folded(&m, r)))
                fail_msg("mesh %d, size %g, thin %g, ray (%a, %a): covered %d - %d times, the "
                         "border winds %d times around it",
                         k, size, thin, (double)r.x, (double)r.y, n.positive, n.negative, winding);
        }
    }
    print_message("%zu rays: covered once %zu, never %zu; %zu by a triangle turned over\n", rays,
                  once, never, turned);
    assert_true(once > rays / 3 && never > rays / 20);
    assert_true(turned < rays / 20);
}

/* Closed meshes -------------------------------------------------------------------------------- */

/* A point of the mesh's own space on its way to the light's view. */
typedef struct placing {
    double m[3][3], at[3], size, thin[3];
} placing;

static placing random_placing(double away)
{
    placing t = {.size = size_in(1e-6, 1e5)};
    /* Three rotations. */
    double c[3], s[3];
    for (int i = 0; i < 3; i++) {
        const double angle = whole(0, 5) ? in(0, 7) : whole(0, 4) * 2 * atan(1);
        c[i] = cos(angle);
        s[i] = sin(angle);
    }
    const double m[3][3] = {
        {c[0] * c[1], c[0] * s[1] * s[2] - s[0] * c[2], c[0] * s[1] * c[2] + s[0] * s[2]},
        {s[0] * c[1], s[0] * s[1] * s[2] + c[0] * c[2], s[0] * s[1] * c[2] - c[0] * s[2]},
        {-s[1], c[1] * s[2], c[1] * c[2]}};
    memcpy(t.m, m, sizeof m);
    for (int i = 0; i < 3; i++) {
        t.thin[i] = whole(0, 3) ? 1 : size_in(1e-6, 1);
    }
    t.at[2] = away * t.size;
    t.at[0] = in(-0.6, 0.6) * t.at[2];
    t.at[1] = in(-0.6, 0.6) * t.at[2];
    return t;
}

static void add_turned(mesh *m, const placing *t, double x, double y, double z)
{
    const double p[3] = {x * t->thin[0], y * t->thin[1], z * t->thin[2]};
    float out[3];
    for (int i = 0; i < 3; i++)
        out[i] = (float)(t->at[i] +
                         t->size * (t->m[i][0] * p[0] + t->m[i][1] * p[1] + t->m[i][2] * p[2]));
    assert_true(m->points < MOST);
    m->point[m->points++] = (point){out[0], out[1], out[2]};
}

static void add_tetrahedron(mesh *m, const placing *t)
{
    for (int i = 0; i < 4; i++)
        add_turned(m, t, i == 0 || i == 1 ? 1 : -1, i == 0 || i == 2 ? 1 : -1,
                   i == 0 || i == 3 ? 1 : -1);
    add_triangle(m, 0, 1, 2);
    add_triangle(m, 0, 2, 3);
    add_triangle(m, 0, 3, 1);
    add_triangle(m, 1, 3, 2);
}

static void add_box(mesh *m, const placing *t)
{
    static const int sides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int i = 0; i < 8; i++)
        add_turned(m, t, i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    for (int i = 0; i < 6; i++) {
        const int *s = sides[i], cut = whole(0, 1);
        add_triangle(m, s[0], s[1], cut ? s[2] : s[3]);
        add_triangle(m, cut ? s[0] : s[1], s[2], s[3]);
    }
}

/* A sphere whose radius varies by a share: a star, which the light may see many times. */
static void add_star(mesh *m, const placing *t, double share)
{
    enum { BELTS = 6, AROUND = 12 };
    const double pi = 4 * atan(1);
    add_turned(m, t, 0, 0, 1);
    add_turned(m, t, 0, 0, -1);
    for (int i = 1; i < BELTS; i++)
        for (int j = 0; j < AROUND; j++) {
            const double polar = pi * i / BELTS, angle = 2 * pi * j / AROUND,
                         radius = 1 - share * in(0, 1);
            add_turned(m, t, radius * sin(polar) * cos(angle), radius * sin(polar) * sin(angle),
                       radius * cos(polar));
        }
    for (int j = 0; j < AROUND; j++) {
        const int k = (j + 1) % AROUND, last = 2 + (BELTS - 2) * AROUND;
        add_triangle(m, 0, 2 + j, 2 + k);
        add_triangle(m, 1, last + k, last + j);
        for (int i = 0; i < BELTS - 2; i++) {
            const int a = 2 + i * AROUND + j, b = 2 + i * AROUND + k;
            add_triangle(m, a, a + AROUND, b + AROUND);
            add_triangle(m, a, b + AROUND, b);
        }
    }
}

/* Seen from a light, what enters a closed mesh comes out, and rays to a point inside are stopped.
 * Half of the rays go through corners or along edges, of meshes down to a millionth as thin as wide
 * or seen exactly edge-on: there a triangle may be a line but for rounding, and a ray along it, on
 * the border of the mesh, be taken for one beside it. */
static void test_closed(void **state)
{
    (void)state;
    size_t rays = 0, inside = 0, most = 0, odd = 0;
    for (int k = 0; rays < RAYS; k++) {
        mesh m = {.central = k & 1};
        const placing t = random_placing(size_in(4, 1000));
        const int kind = whole(0, 2);
        if (kind == 0)
            add_tetrahedron(&m, &t);
        else if (kind == 1)
            add_box(&m, &t);
        else
            add_star(&m, &t, in(0, 0.9));
        for (int i = 0; i < (kind == 2 ? 40 : 10); i++) {
            ray r = ray_at(&m, 0.1 * t.size / (m.central ? t.at[2] : 1));
            r.depth = (float)(t.at[2] * in(0.5, 1.5));
            if (m.central && r.depth <= 0.0f)
                continue;
            const cover n = cover_of(&m, r);
            rays++;
            most =
                (size_t)(n.positive + n.negative) > most ? (size_t)(n.positive + n.negative) : most;
            odd += n.positive != n.negative;
            if (n.positive != n.negative && !doubtful(&m, r))
                fail_msg("closed mesh %d of kind %d, size %g, ray (%a, %a): covered %d and %d "
                         "times",
                         k, kind, t.size, (double)r.x, (double)r.y, n.positive, n.negative);
        }
        /* All hold their middle; of those that are not too thin for floats. */
        if (t.thin[0] < 1e-3 || t.thin[1] < 1e-3 || t.thin[2] < 1e-3)
            continue;
        const double w = m.central ? t.at[2] : 1;
        const ray r = {(float)(t.at[0] / w), (float)(t.at[1] / w), (float)t.at[2]};
        const cover n = cover_of(&m, r);
        inside++;
        if (n.nearer % 2 != 1 || (n.positive + n.negative - n.nearer) % 2 != 1)
            fail_msg("closed mesh %d of kind %d, size %g, at (%g, %g, %g): %d triangles before its "
                     "middle, %d in all",
                     k, kind, t.size, t.at[0], t.at[1], t.at[2], n.nearer, n.positive + n.negative);
    }
    print_message("%zu rays, %zu from inside; up to %zu triangles cover one; %zu enter without an "
                  "exit\n",
                  rays, inside, most, odd);
    assert_true(inside > rays / 100 && most >= 4 && (double)odd < 5e-5 * (double)rays);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_edges), cmocka_unit_test(test_weights),
                                       cmocka_unit_test(test_grid), cmocka_unit_test(test_planes),
                                       cmocka_unit_test(test_closed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
