/* Reading shadow maps, against a reading of each pixel in double by this test: own projection, own
 * choice of layer and texels, own inequalities. Layers are synthetic, and lie between pages that
 * must not be touched. */
#include <sys/mman.h>

#include "render_testing.h"

#include "cpu/map.h"
#include "render/device.h"

#include <gnomon/shadow/moments_nonlinear.h>
#include <gnomon/shadow/variance.h>

/* Random numbers, pixels ---------------------------------------------------------------------- */

static uint32_t random_state = 7;

/* [0,1) */
static double next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) / 16777216.0;
}

static vec random_direction(void)
{
    for (;;) {
        const vec v = v3(2 * next_random() - 1, 2 * next_random() - 1, 2 * next_random() - 1);
        if (length(v) < 1 && length(v) > 0.1)
            return unit(v);
    }
}

enum { WIDTH = 70, HEIGHT = 45, PIXELS = WIDTH * HEIGHT };

typedef struct picture_of {
    gn_gbuffer g;
    float position[3][PIXELS], normal[3][PIXELS], error[PIXELS], width[PIXELS];
    uint32_t surface[PIXELS];
    float visibility[PIXELS], layer[PIXELS];
} pixels;

/* Surfaces anywhere in a cube of half a side around the origin, some of them sky. */
static void scatter(pixels *p, double half)
{
    p->g = (gn_gbuffer){.width = WIDTH,
                        .height = HEIGHT,
                        .origin_error = p->error,
                        .cone_width = p->width,
                        .surface = p->surface};
    for (int axis = 0; axis < 3; axis++) {
        p->g.position[axis] = p->position[axis];
        p->g.normal[axis] = p->normal[axis];
    }
    for (uint32_t i = 0; i < PIXELS; i++) {
        const vec n = random_direction();
        const double normal[3] = {n.x, n.y, n.z};
        for (int axis = 0; axis < 3; axis++) {
            p->position[axis][i] = (float)(half * (2 * next_random() - 1));
            p->normal[axis][i] = (float)normal[axis];
        }
        p->error[i] = (float)(1e-4 * half * next_random());
        p->width[i] = (float)(0.02 * half * next_random());
        p->surface[i] = next_random() < 0.05 ? GN_NONE : 1;
    }
}

/* Layers -------------------------------------------------------------------------------------- */

enum { SIZE = 64, TEXELS = SIZE * SIZE, LAYERS = 6 };

/* Memory with pages before and behind that must not be touched. */
typedef struct guarded {
    char *base;
    size_t size;
} guarded;

enum { PAGE = 4096 };

static guarded guard(size_t bytes)
{
    assert_int_equal(bytes % PAGE, 0);
    guarded g = {.size = bytes + 2 * PAGE};
    g.base = mmap(NULL, g.size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(g.base != MAP_FAILED);
    assert_int_equal(mprotect(g.base + PAGE, bytes, PROT_READ | PROT_WRITE), 0);
    return g;
}

static void *memory(guarded g)
{
    return g.base + PAGE;
}

typedef struct layers {
    gn_map_layer layer[LAYERS];
    uint32_t count;
    guarded memory[3 * LAYERS];
    double values[LAYERS][TEXELS][4]; /* what the texels hold, but for their rounding */
} layers;

static void free_layers(layers *l)
{
    for (int i = 0; i < 3 * LAYERS; i++)
        if (l->memory[i].base)
            munmap(l->memory[i].base, l->memory[i].size);
    free(l);
}

static gn_map_projection look(vec from, vec to, double twist)
{
    float m[16];
    aim(from, to, m);
    gn_map_projection p = {.resolution = SIZE};
    for (int axis = 0; axis < 3; axis++) {
        p.origin[axis] = m[12 + axis];
        p.right[axis] = (float)(cos(twist) * (double)m[axis] + sin(twist) * (double)m[4 + axis]);
        p.up[axis] = (float)(cos(twist) * (double)m[4 + axis] - sin(twist) * (double)m[axis]);
        p.forward[axis] = -m[8 + axis];
    }
    return p;
}

/* Nested cascades of a sun that shines along `to`. */
static layers *make_cascades(vec to, uint32_t count)
{
    layers *l = calloc(1, sizeof *l);
    assert_non_null(l);
    l->count = count;
    for (uint32_t i = 0; i < count; i++) {
        const double half = 0.45 * pow(1.7, i);
        gn_map_projection p = look(mul(to, -2), v3(0.05 * i, 0, 0), 0.3 * i);
        p.extent = (float)half;
        p.near = (float)(i == 0 ? 1.2 : 0.2);
        p.far = (float)(i == 0 ? 2.8 : 3.8);
        l->layer[i].projection = p;
    }
    return l;
}

/* The six faces around a point, a little wider than a cube's. */
static layers *make_faces(vec at)
{
    layers *l = calloc(1, sizeof *l);
    assert_non_null(l);
    l->count = 6;
    for (uint32_t i = 0; i < 6; i++) {
        const double sign = i % 2 ? -1 : 1;
        const vec axis = v3(i / 2 == 0 ? sign : 0, i / 2 == 1 ? sign : 0, i / 2 == 2 ? sign : 0);
        gn_map_projection p = look(at, add(at, axis), 0);
        p.perspective = true;
        p.extent = 1.5f;
        p.near = 0.001f;
        p.far = 1;
        l->layer[i].projection = p;
    }
    return l;
}

/* Formats ------------------------------------------------------------------------------------- */

static const gn_map_format formats[] = {
    {.kind = GN_MAP_DEPTH, .bits = 32},
    {.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 2},
    {.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 3},
    {.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 9},
    {.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 17},
    {.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 33},
    {.kind = GN_MAP_VSM, .bits = 32},
    {.kind = GN_MAP_VSM, .bits = 64},
    {.kind = GN_MAP_VSM, .bits = 64, .single_depth = true},
    {.kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 8},
    {.kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 10, .single_depth = true},
    {.kind = GN_MAP_EVSM, .bits = 64, .positive_exponent = 5.5f, .negative_exponent = 4},
    {.kind = GN_MAP_EVSM, .bits = 64, .positive_exponent = 11, .one_sided = true},
    {.kind = GN_MAP_EVSM, .bits = 128, .positive_exponent = 20, .negative_exponent = 5},
    {.kind = GN_MAP_EVSM,
     .bits = 128,
     .positive_exponent = 20,
     .negative_exponent = 5,
     .single_depth = true},
    {.kind = GN_MAP_EVSM,
     .bits = 64,
     .positive_exponent = 20,
     .one_sided = true,
     .single_depth = true},
    {.kind = GN_MAP_MSM, .bits = 64},
    {.kind = GN_MAP_MSM, .bits = 128},
    {.kind = GN_MAP_MSM, .bits = 128, .bound = GN_BOUND_HAUSDORFF},
    {.kind = GN_MAP_MSM, .bits = 128, .single_depth = true},
    {.kind = GN_MAP_NLMSM, .bits = 64},
    {.kind = GN_MAP_NLMSM, .bits = 32},
};
enum { FORMATS = sizeof formats / sizeof *formats };

static const char *name_of(const gn_map_format *f)
{
    static const char *const kinds[] = {"none", "depth", "pcf", "vsm",
                                        "esm",  "evsm",  "msm", "nlmsm"};
    static char text[80];
    snprintf(text, sizeof text, "%s%u%s%s%s", kinds[f->kind],
             f->kind == GN_MAP_PCF ? f->pcf_width : f->bits, f->one_sided ? " one-sided" : "",
             f->single_depth ? " single depth" : "",
             f->bound == GN_BOUND_HAUSDORFF ? " hausdorff" : "");
    return text;
}

/* Texels: each has its own distribution of a few depths. -------------------------------------- */

static void pack_texel(const gn_map_format *f, float bias, const double d[], int count,
                       uint32_t words[4], double values[4])
{
    const double cp = (double)f->positive_exponent, cn = (double)f->negative_exponent;
    double v[4] = {0};
    for (int i = 0; i < count; i++) {
        const double z = 2 * d[i] - 1;
        const double vectors[][4] = {
            [GN_MAP_VSM] = {d[i], d[i] * d[i]},
            [GN_MAP_ESM] = {exp(cp * z)},
            [GN_MAP_EVSM] = {exp(cp * z), exp(2 * cp * z), -exp(-cn * z), exp(-2 * cn * z)},
            [GN_MAP_MSM] = {z, z * z, z * z * z, z * z * z * z}};
        for (int k = 0; k < 4; k++)
            v[k] += vectors[f->kind == GN_MAP_NLMSM ? GN_MAP_MSM : f->kind][k] / count;
    }
    const gn_moments m = {(float)v[0], (float)v[1], (float)v[2], (float)v[3]};
    float real[4];
    for (int k = 0; k < 4; k++)
        words[k] = gn_real_word(real[k] = (float)v[k]);
    if (f->kind == GN_MAP_VSM && f->bits == 32) {
        words[0] = gn_unorm16_pack(real[0], real[1]);
        real[0] = gn_unorm16_low(words[0]);
        real[1] = gn_unorm16_high(words[0]);
    } else if (f->kind == GN_MAP_EVSM && f->bits == 64 && !f->one_sided) {
        for (int k = 0; k < 2; k++) {
            words[k] = gn_half_pack(real[2 * k], real[2 * k + 1]);
            real[2 * k] = gn_half_low(words[k]);
            real[2 * k + 1] = gn_half_high(words[k]);
        }
    } else if (f->kind == GN_MAP_MSM && f->bits == 64) {
        const gn_moments_fixed q = gn_moments_quantize(gn_moments_bias_fixed(m, bias));
        words[0] = gn_unorm16_pack(q.q1, q.q2);
        words[1] = gn_unorm16_pack(q.q3, q.q4);
        const gn_moments read = gn_moments_dequantize(
            (gn_moments_fixed){gn_unorm16_low(words[0]), gn_unorm16_high(words[0]),
                               gn_unorm16_low(words[1]), gn_unorm16_high(words[1])});
        memcpy(real, &read, sizeof real);
    } else if (f->kind == GN_MAP_MSM) {
        const gn_moments biased = gn_moments_bias_float(m, bias);
        memcpy(real, &biased, sizeof real);
        memcpy(words, &biased, sizeof biased);
    } else if (f->kind == GN_MAP_NLMSM) {
        const gn_nonlinear n = gn_nonlinear_of(gn_moments_bias_float(m, bias));
        gn_nonlinear_words two = {gn_nonlinear_pack32(n), 0};
        if (f->bits == 64)
            two = gn_nonlinear_pack64(n);
        words[0] = two.low;
        words[1] = two.high;
        const gn_nonlinear read = f->bits == 64 ? gn_nonlinear_unpack64(two.low, two.high)
                                                : gn_nonlinear_unpack32(two.low);
        memcpy(real, &read, sizeof real);
    }
    for (int k = 0; k < 4; k++)
        values[k] = (double)real[k];
}

static guarded *next_memory(layers *l)
{
    for (int i = 0; i < 3 * LAYERS; i++)
        if (!l->memory[i].base)
            return &l->memory[i];
    fail_msg("no memory left");
    return NULL;
}

/* Depths in blocks of two texels, so that windows see more than noise. */
static float *fill_depth(layers *l)
{
    guarded *m = next_memory(l);
    *m = guard(TEXELS * sizeof(float));
    float *depth = memory(*m);
    double row[SIZE] = {0};
    for (uint32_t i = 0; i < TEXELS; i++) {
        if (i / SIZE % 2 == 0 && i % 2 == 0)
            row[i % SIZE] = row[i % SIZE + 1] = next_random() < 0.2 ? 1 : next_random();
        depth[i] = (float)row[i % SIZE];
    }
    return depth;
}

static void fill(layers *l, const gn_map_format *f, const gn_map_desc *desc, bool moving)
{
    for (uint32_t i = 0; i < l->count; i++) {
        if (!gn_map_has_texels(f)) {
            l->layer[i].depth[0] = fill_depth(l);
            l->layer[i].depth[1] = moving ? fill_depth(l) : NULL;
            continue;
        }
        const uint32_t count = gn_map_words(f);
        guarded *m = next_memory(l);
        *m = guard(TEXELS * count * sizeof(uint32_t));
        l->layer[i].texels = memory(*m);
        for (uint32_t t = 0; t < TEXELS; t++) {
            uint32_t words[4];
            double depths[5];
            for (int k = 0; k < 5; k++)
                depths[k] = next_random();
            pack_texel(f, desc->moment_bias, depths, 2 + (int)(3 * next_random()), words,
                       l->values[i][t]);
            memcpy(l->layer[i].texels + (size_t)t * count, words, count * sizeof *words);
        }
    }
}

/* The same in double --------------------------------------------------------------------------- */

/* Values that a float and a double computation take to different sides of a comparison. */
typedef struct reference {
    double visibility;
    int layer;
    bool unsure;
} reference;

static double chebyshev(double mean, double square, double minimum, double receiver)
{
    const double variance = fmax(square - mean * mean, 0) + minimum, d = receiver - mean;
    return d > 0 ? variance / (variance + d * d) : 1;
}

/* Algorithm 1 of the moment paper. */
static double hamburger(const double b[4], double z)
{
    const double m[3][3] = {{1, b[0], b[1]}, {b[0], b[1], b[2]}, {b[1], b[2], b[3]}};
    double q[3];
    const double right[3] = {1, z, z * z};
#define DET(a, b, c)                                                                               \
    ((a)[0] * ((b)[1] * (c)[2] - (b)[2] * (c)[1]) - (a)[1] * ((b)[0] * (c)[2] - (b)[2] * (c)[0]) + \
     (a)[2] * ((b)[0] * (c)[1] - (b)[1] * (c)[0]))
    const double det = DET(m[0], m[1], m[2]);
    q[0] = DET(right, m[1], m[2]) / det;
    q[1] = DET(m[0], right, m[2]) / det;
    q[2] = DET(m[0], m[1], right) / det;
#undef DET
    const double root = sqrt(fmax(q[1] * q[1] - 4 * q[2] * q[0], 0));
    const double z1 = (-q[1] - root) / (2 * q[2]), z2 = (-q[1] + root) / (2 * q[2]);
    double shadow = 0;
    const double points[3] = {z, z1, z2};
    for (int i = 0; i < 3; i++) {
        const double u = points[(i + 1) % 3], v = points[(i + 2) % 3];
        if (points[i] < z)
            shadow += (b[1] - (u + v) * b[0] + u * v) / ((points[i] - u) * (points[i] - v));
    }
    return 1 - fmin(fmax(shadow, 0), 1);
}

/* What the format makes of a vector. */
static double test_in_double(const gn_map_format *f, const gn_map_desc *desc, const double v[4],
                             double receiver, bool *unsure)
{
    const double z = 2 * receiver - 1, minimum = (double)desc->minimum_variance;
    const double cp = (double)f->positive_exponent, cn = (double)f->negative_exponent;
    switch (f->kind) {
    case GN_MAP_VSM:
        return chebyshev(v[0], v[1], minimum, receiver);
    case GN_MAP_ESM:
        return fmin(v[0] * exp(-cp * z), 1);
    case GN_MAP_EVSM: {
        const double wp = exp(cp * z), wn = -exp(-cn * z), sp = 2 * cp * wp, sn = 2 * cn * wn;
        const double positive = chebyshev(v[0], v[1], minimum * sp * sp, wp);
        return f->one_sided ? positive
                            : fmin(positive, chebyshev(v[2], v[3], minimum * sn * sn, wn));
    }
    case GN_MAP_MSM: {
        double b[4] = {v[0], v[1], v[2], v[3]};
        if (f->single_depth)
            for (int k = 0; k < 4; k++)
                b[k] += (double)desc->moment_bias * ((k % 2 ? 0.375 : 0) - b[k]);
        if (f->bound == GN_BOUND_HAUSDORFF) /* test_moments.c has it in double */
            return (double)gn_hausdorff_visibility(
                (gn_moments){(float)b[0], (float)b[1], (float)b[2], (float)b[3]}, (float)receiver);
        return hamburger(b, z);
    }
    case GN_MAP_NLMSM: {
        double b[4];
        for (int k = 0; k < 4; k++)
            b[k] = (1 - v[2]) * pow(v[0], k + 1) + v[2] * pow(v[1], k + 1);
        b[3] += v[3];
        *unsure |= v[1] - v[0] < 1e-3 || v[2] < 1e-3 || v[2] > 0.999;
        return hamburger(b, z);
    }
    default:
        *unsure |= fabs(v[0] - receiver) < 1e-5;
        return receiver <= v[0];
    }
}

static void vector_of(const gn_map_job *job, const layers *l, int layer, long column, long row,
                      double v[4])
{
    const gn_map_format *f = &job->format;
    assert_true(column >= 0 && row >= 0 && column < SIZE && row < SIZE);
    const long t = row * SIZE + column;
    if (gn_map_has_texels(f)) {
        memcpy(v, l->values[layer][t], 4 * sizeof *v);
        return;
    }
    const gn_map_layer *from = &job->layers[layer];
    const double d =
        fmin((double)from->depth[0][t], from->depth[1] ? (double)from->depth[1][t] : 1);
    const double z = 2 * d - 1, cp = (double)f->positive_exponent,
                 cn = (double)f->negative_exponent;
    const double vectors[][4] = {
        [GN_MAP_DEPTH] = {d},
        [GN_MAP_PCF] = {d},
        [GN_MAP_VSM] = {d, d * d},
        [GN_MAP_ESM] = {exp(cp * z)},
        [GN_MAP_EVSM] = {exp(cp * z), exp(2 * cp * z), -exp(-cn * z), exp(-2 * cn * z)},
        [GN_MAP_MSM] = {z, z * z, z * z * z, z * z * z * z}};
    memcpy(v, vectors[f->kind], 4 * sizeof *v);
}

static double read_texel(const gn_map_job *job, const layers *l, int layer, long column, long row,
                         double receiver, bool *unsure)
{
    const gn_map_format *f = &job->format;
    double v[4], sum = 0, all = 0;
    if (f->kind != GN_MAP_PCF || f->pcf_width == 2) {
        vector_of(job, l, layer, column, row, v);
        return test_in_double(f, &job->desc, v, receiver, unsure);
    }
    const long reach = (long)f->pcf_width / 2;
    for (long y = -reach; y <= reach; y++)
        for (long x = -reach; x <= reach; x++) {
            const double sigma = (double)job->desc.filter_sigma;
            const double weight = exp(-(double)(x * x + y * y) / (2 * sigma * sigma));
            vector_of(job, l, layer, column + x, row + y, v);
            sum += weight * test_in_double(f, &job->desc, v, receiver, unsure);
            all += weight;
        }
    return sum / all;
}

static bool linear(const gn_map_format *f)
{
    return f->kind >= GN_MAP_VSM && f->kind <= GN_MAP_MSM;
}

static double read_bilinear(const gn_map_job *job, const layers *l, int layer, double x, double y,
                            double receiver, bool *unsure)
{
    const long column = (long)floor(x - 0.5), row = (long)floor(y - 0.5);
    const double fx = x - 0.5 - (double)column, fy = y - 0.5 - (double)row;
    double sum[4] = {0}, v[4];
    for (int corner = 0; corner < 4; corner++) {
        const int dx = corner % 2, dy = corner / 2;
        const double weight = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy);
        if (linear(&job->format)) {
            vector_of(job, l, layer, column + dx, row + dy, v);
            for (int k = 0; k < 4; k++)
                sum[k] += weight * v[k];
        } else {
            sum[0] += weight * read_texel(job, l, layer, column + dx, row + dy, receiver, unsure);
        }
    }
    return linear(&job->format) ? test_in_double(&job->format, &job->desc, sum, receiver, unsure)
                                : sum[0];
}

static vec at(const float v[3])
{
    return v3((double)v[0], (double)v[1], (double)v[2]);
}

static bool near(double a, double b, double by)
{
    return fabs(a - b) < by;
}

/* White noise: `given` chooses among the four texels it may have read. */
static reference read_in_double(const gn_map_job *job, const layers *l, uint32_t i, double given)
{
    const gn_gbuffer *g = job->gbuffer;
    reference r = {0, -1, false};
    if (g->surface[i] == GN_NONE)
        return r;
    const vec n = normal_at(g, i),
              from = add(position_at(g, i), mul(n, (double)g->origin_error[i]));
    const gn_light *light = &job->light;
    const bool sun = light->desc.type == GN_LIGHT_DIRECTIONAL;
    const vec to = sun ? mul(at(light->direction), -1) : sub(at(light->position), from);
    const double distance = length(to), cosine = dot(n, to) / distance;
    const double spot = -dot(at(light->direction), to) / distance;
    const double edge = cos((double)light->desc.outer_cone_angle);
    r.unsure = near(cosine, 0, 1e-5);
    if (cosine <= 0)
        return r;
    if (!sun && distance > (double)light->desc.range)
        return r;
    if (light->desc.type == GN_LIGHT_SPOT) {
        r.unsure |= near(spot, edge, 1e-5);
        if (spot <= edge)
            return r;
    }
    const double margin = gn_map_margin(&job->format, &job->desc);
    r.visibility = 1;
    for (uint32_t k = 0; k < job->layer_count; k++) {
        const gn_map_projection *p = &job->layers[k].projection;
        const vec right = at(p->right), up = at(p->up), forward = at(p->forward);
        double w = dot(sub(from, at(p->origin)), forward);
        const double texel = 2 * (double)p->extent * (p->perspective ? w : 1) / SIZE;
        const double range = (double)p->far - (double)p->near,
                     whole = (w - (double)p->near) / range;
        const double sine = sqrt(fmax(0, 1 - dot(n, forward) * dot(n, forward)));
        const vec moved =
            sub(add(from, mul(n, sine * texel * (double)job->desc.normal_bias)), at(p->origin));
        w = dot(moved, forward);
        const double away = p->perspective ? w : 1;
        const double x = (1 + dot(moved, right) / away / (double)p->extent) / 2 * SIZE;
        const double y = (1 - dot(moved, up) / away / (double)p->extent) / 2 * SIZE;
        if (away <= 0)
            continue;
        for (int side = 0; side < 2; side++) {
            const double border = side ? SIZE - margin : margin;
            r.unsure |= near(x, border, 1e-3) || near(y, border, 1e-3) || near(whole, side, 1e-3);
        }
        if (x < margin || x >= SIZE - margin || y < margin || y >= SIZE - margin || whole < 0 ||
            whole > 1)
            continue;
        r.layer = (int)k;
        const double depth =
            fmin(fmax((w - (double)p->near) / range - (double)job->desc.depth_bias, 0), 1);
        double shift[2] = {0};
        const bool four = job->format.kind == GN_MAP_PCF && job->format.pcf_width == 2;
        if (four || job->desc.reading == GN_READING_BILINEAR) {
            r.visibility = read_bilinear(job, l, (int)k, x, y, depth, &r.unsure);
            return r;
        }
        if (job->desc.reading == GN_READING_WHITE_NOISE) {
            double best = 2;
            for (int corner = 0; corner < 4; corner++) {
                const double v = read_texel(job, l, (int)k, (long)floor(x - 0.5) + corner % 2,
                                            (long)floor(y - 0.5) + corner / 2, depth, &r.unsure);
                best = fabs(v - given) < fabs(best - given) ? v : best;
            }
            r.visibility = best;
            return r;
        }
        if (job->desc.reading == GN_READING_BLUE_NOISE) {
            const gn_noise_place place = gn_noise_of_frame(job->desc.seed, job->frame);
            const uint8_t *tile = gn_blue_noise_tile(place.tile);
            const uint32_t column = (i % g->width + place.x) % 64,
                           row = (i / g->width + place.y) % 64;
            for (int axis = 0; axis < 2; axis++)
                shift[axis] = (tile[2 * (row * 64 + column) + (uint32_t)axis] + 0.5) / 256 - 0.5;
        }
        const double tx = x + shift[0], ty = y + shift[1];
        r.unsure |= near(tx, round(tx), 1e-3) || near(ty, round(ty), 1e-3);
        r.visibility =
            read_texel(job, l, (int)k, (long)floor(tx), (long)floor(ty), depth, &r.unsure);
        return r;
    }
    return r;
}

/* Comparing ------------------------------------------------------------------------------------ */

static pixels *shared;

static gn_map_job make_job(const layers *l, const gn_map_format *f, gn_map_reading reading,
                           pixels *p)
{
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = SIZE;
    desc.reading = reading;
    desc.filter_width = 3;
    desc.seed = 3;
    /* Not the format's own: what is read is far from planes, and every term shall be seen. */
    desc.normal_bias = 0.7f;
    desc.depth_bias = 0.01f;
    desc.minimum_variance = 1e-4f;
    desc.moment_bias = 1e-3f;
    return (gn_map_job){.layers = l->layer,
                        .layer_count = l->count,
                        .format = *f,
                        .desc = gn_map_desc_resolve(f, &desc),
                        .gbuffer = &p->g,
                        .frame = 5,
                        .visibility = p->visibility,
                        .layer = p->layer};
}

static gn_light make_sun(vec to)
{
    const vec u = unit(to);
    gn_light light = {.desc = gn_light_desc_default()};
    light.desc.type = GN_LIGHT_DIRECTIONAL;
    light.direction[0] = (float)u.x;
    light.direction[1] = (float)u.y;
    light.direction[2] = (float)u.z;
    return light;
}

static gn_light make_lamp(gn_light_type type, vec from, vec to)
{
    gn_light light = make_sun(sub(to, from));
    light.desc.type = type;
    light.desc.range = 1.4f;
    light.desc.inner_cone_angle = 0.2f;
    light.desc.outer_cone_angle = 0.5f;
    light.position[0] = (float)from.x;
    light.position[1] = (float)from.y;
    light.position[2] = (float)from.z;
    return light;
}

static void read_map(const gn_map_job *job)
{
    ok(gn_cpu_map_visibility(&device->cpu, job));
}

/* Every pixel against the reading in double. Quantities of 1e-4 and more are certain, so that the
 * tolerance is what floats make of an ill-conditioned vector. Returns how many are partly lit. */
static size_t check(const gn_map_job *job, const layers *l, const char *what)
{
    const gn_map_format *f = &job->format;
    const double tolerance = f->kind >= GN_MAP_MSM ? 2e-3 : 5e-4;
    size_t unsure = 0, between = 0;
    read_map(job);
    for (uint32_t i = 0; i < PIXELS; i++) {
        const double given = (double)job->visibility[i];
        const reference r = read_in_double(job, l, i, given);
        if (r.unsure) {
            unsure++;
            assert_true(given >= 0 && given <= 1);
            continue;
        }
        between += given > 0.01 && given < 0.99;
        if ((int)job->layer[i] != r.layer || !near(given, r.visibility, tolerance)) {
            print_error("%s, %s, reading %d, pixel %u: layer %g, %d is right; visibility %.7g, "
                        "%.7g is right\n",
                        what, name_of(f), (int)job->desc.reading, i, (double)job->layer[i], r.layer,
                        given, r.visibility);
            fail();
        }
    }
    /* Of a window of 33^2 depths one is often near the receiver's. */
    few(unsure, PIXELS, f->kind == GN_MAP_PCF ? 0.2 : 0.06, "%s, %s: unsure", what, name_of(f));
    return between;
}

static void check_everywhere(const gn_map_format *f, gn_map_reading reading)
{
    const vec to = unit(v3(0.3, -1, 0.2));
    layers *cascades = make_cascades(to, 3);
    gn_map_job job = make_job(cascades, f, reading, shared);
    fill(cascades, f, &job.desc, true);
    job.light = make_sun(to);
    size_t between = check(&job, cascades, "cascades");
    free_layers(cascades);

    const vec lamp = v3(0.13, 0.21, -0.08);
    layers *faces = make_faces(lamp);
    job = make_job(faces, f, reading, shared);
    fill(faces, f, &job.desc, false);
    job.light = make_lamp(GN_LIGHT_POINT, lamp, v3(0, -1, 0));
    between += check(&job, faces, "faces");
    if (gn_map_margin(f, &job.desc) <= 10) /* 1.5 (1 - 2 * 10 / 64) > 1: no gap between faces */
        for (uint32_t i = 0; i < PIXELS; i++)
            assert_true(shared->layer[i] >= 0 || shared->visibility[i] == 0);
    free_layers(faces);

    const vec eye = v3(0.9, 0.8, 0.7);
    layers *spot = make_faces(eye);
    spot->count = 1;
    spot->layer[0].projection = look(eye, v3(0, 0, 0), 0.4);
    spot->layer[0].projection.perspective = true;
    spot->layer[0].projection.extent = 0.8f;
    spot->layer[0].projection.near = 0.1f;
    spot->layer[0].projection.far = 2;
    job = make_job(spot, f, reading, shared);
    fill(spot, f, &job.desc, true);
    job.light = make_lamp(GN_LIGHT_SPOT, eye, v3(0, 0, 0));
    between += check(&job, spot, "spot");
    free_layers(spot);
    if (f->kind != GN_MAP_DEPTH)
        assert_true(between > 100);
}

static void test_every_format_and_reading(void **state)
{
    (void)state;
    for (int f = 0; f < FORMATS; f++)
        for (int reading = GN_READING_NEAREST; reading <= GN_READING_BILINEAR; reading++)
            check_everywhere(&formats[f], (gn_map_reading)reading);
}

/* Threads and instruction sets: the same bits. */
static void test_devices(void **state)
{
    (void)state;
    static float expected[PIXELS];
    const vec to = unit(v3(0.3, -1, 0.2));
    for (int f = 0; f < FORMATS; f++)
        for (int reading = GN_READING_NEAREST; reading <= GN_READING_BILINEAR; reading++) {
            layers *l = make_cascades(to, 3);
            gn_map_job job = make_job(l, &formats[f], (gn_map_reading)reading, shared);
            job.light = make_sun(to);
            fill(l, &formats[f], &job.desc, true);
            read_map(&job);
            memcpy(expected, shared->visibility, sizeof expected);
            for (int isa = GN_ISA_SCALAR; isa <= GN_ISA_AVX512; isa++) {
                gn_device_desc desc = gn_device_desc_default();
                desc.isa = (gn_isa)isa;
                desc.threads = 1 + (uint32_t)isa;
                gn_device *other = NULL;
                if (gn_device_create(&desc, &other) != GN_OK)
                    continue; /* a processor without it */
                assert_int_equal(gn_cpu_map_visibility(&other->cpu, &job), GN_OK);
                gn_device_destroy(&other);
                for (uint32_t i = 0; i < PIXELS; i++)
                    if (memcmp(&expected[i], &shared->visibility[i], sizeof(float)) != 0)
                        fail_msg("%s, reading %d, instruction set %d, pixel %u: %.9g, was %.9g",
                                 name_of(&formats[f]), reading, isa, i,
                                 (double)shared->visibility[i], (double)expected[i]);
            }
            free_layers(l);
        }
}

/* Where light arrives is what rays say, bit by bit. */
static void test_light_reaches_as_for_rays(void **state)
{
    (void)state;
    gn_scene *scene = new_scene();
    /* Nothing to block the light: one square far below. */
    place(scene, add_floor(scene, 0.01, -50, add_single_sided(scene)), false);
    add_sun(scene, v3(0.4, 1, -0.3));
    for (int type = GN_LIGHT_POINT; type <= GN_LIGHT_SPOT; type++) {
        gn_light_desc desc = gn_light_desc_default();
        desc.type = (gn_light_type)type;
        desc.intensity = 1;
        desc.range = 1.1f;
        desc.inner_cone_angle = 0.3f;
        desc.outer_cone_angle = 0.6f;
        add_light(scene, &desc, v3(0.5, 0.6, 0.4), v3(0, 0, 0));
    }
    ok(gn_scene_commit(scene));
    static float rays[PIXELS];
    for (uint32_t light = 0; light < 3; light++) {
        gn_visibility_desc desc = gn_visibility_desc_default();
        desc.light = light;
        ok(gn_scene_visibility(scene, &shared->g, &desc, rays, NULL));
        gn_map_desc map = gn_map_desc_default();
        map = gn_map_desc_resolve(&formats[0], &map);
        const gn_map_job job = {.format = formats[0],
                                .desc = map,
                                .gbuffer = &shared->g,
                                .light = scene->lights[light],
                                .visibility = shared->visibility,
                                .layer = shared->layer};
        read_map(&job);
        size_t lit = 0;
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (rays[i] != shared->visibility[i])
                fail_msg("light %u, pixel %u: %g by rays, %g by a map without layers", light, i,
                         (double)rays[i], (double)shared->visibility[i]);
            assert_true(shared->layer[i] == -1);
            lit += rays[i] == 1;
        }
        assert_in_range(lit, 20, PIXELS - 20);
    }
    gn_scene_destroy(&scene);
}

/* The nearer caster counts. */
static void test_moving_casters(void **state)
{
    (void)state;
    static float expected[PIXELS], nearer[TEXELS];
    const vec to = unit(v3(-0.2, -1, 0.5));
    for (int f = 0; f < FORMATS; f++) {
        if (gn_map_has_texels(&formats[f]))
            continue;
        layers *l = make_cascades(to, 1);
        gn_map_job job = make_job(l, &formats[f], GN_READING_BILINEAR, shared);
        job.light = make_sun(to);
        fill(l, &formats[f], &job.desc, true);
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        for (int i = 0; i < TEXELS; i++)
            nearer[i] = fminf(l->layer[0].depth[0][i], l->layer[0].depth[1][i]);
        l->layer[0].depth[0] = nearer;
        l->layer[0].depth[1] = NULL;
        read_map(&job);
        assert_memory_equal(expected, shared->visibility, sizeof expected);
        free_layers(l);
    }
}

/* Vectors made of four depths are what texels without a filter blend to. */
static void test_single_depth(void **state)
{
    (void)state;
    static float expected[PIXELS];
    static uint32_t texels[4 * TEXELS];
    const vec to = unit(v3(-0.2, -1, 0.5));
    for (int f = 0; f < FORMATS; f++) {
        if (!formats[f].single_depth)
            continue;
        layers *l = make_cascades(to, 1);
        gn_map_job job = make_job(l, &formats[f], GN_READING_BILINEAR, shared);
        job.light = make_sun(to);
        fill(l, &formats[f], &job.desc, true);
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        job.format.single_depth = false;
        const gn_filter_job filter = {.format = job.format,
                                      .resolution = SIZE,
                                      .samples = 1,
                                      .width = 1,
                                      .sigma = 1,
                                      .moment_bias = job.desc.moment_bias,
                                      .depth = l->layer[0].depth[0],
                                      .dynamic = l->layer[0].depth[1],
                                      .rect = {0, 0, SIZE, SIZE},
                                      .texels = texels};
        ok(gn_cpu_filter(&device->cpu, &filter));
        l->layer[0].texels = texels;
        job.desc.filter_width = 1; /* the same margin */
        read_map(&job);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (!near((double)expected[i], (double)shared->visibility[i], 2e-3))
                fail_msg("%s, pixel %u: %g, from texels %g", name_of(&formats[f]), i,
                         (double)expected[i], (double)shared->visibility[i]);
        free_layers(l);
    }
}

/* The mean over many frames is the bilinear blend of the four tests. */
static void test_noise(void **state)
{
    (void)state;
    enum { FRAMES = 400 };
    static double sums[PIXELS];
    static float expected[PIXELS];
    const vec to = unit(v3(-0.2, -1, 0.5));
    const gn_map_format *f = &formats[0];
    for (int reading = GN_READING_WHITE_NOISE; reading <= GN_READING_BLUE_NOISE; reading++) {
        layers *l = make_cascades(to, 1);
        gn_map_job job = make_job(l, f, GN_READING_BILINEAR, shared);
        job.light = make_sun(to);
        fill(l, f, &job.desc, false);
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        job.desc.reading = (gn_map_reading)reading;
        memset(sums, 0, sizeof sums);
        for (job.frame = 0; job.frame < FRAMES; job.frame++) {
            read_map(&job);
            for (uint32_t i = 0; i < PIXELS; i++)
                sums[i] += (double)shared->visibility[i];
        }
        double worst = 0, square = 0;
        size_t count = 0;
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (expected[i] < 0.02f || expected[i] > 0.98f)
                continue;
            const double error = sums[i] / FRAMES - (double)expected[i];
            worst = fmax(worst, fabs(error));
            square += error * error;
            count++;
        }
        assert_true(count > 100);
        /* Of independent choices: 0.5 / sqrt(400) = 0.025 at most, five times that at worst; blue
         * noise has 256 steps. */
        if (worst > 0.125 || sqrt(square / (double)count) > 0.026)
            fail_msg("reading %d: means are off by %g at worst, %g on the whole", reading, worst,
                     sqrt(square / (double)count));

        /* The seed and the frame matter. */
        job.frame = 1;
        read_map(&job);
        memcpy(expected, shared->visibility, sizeof expected);
        job.frame = 2;
        read_map(&job);
        assert_memory_not_equal(expected, shared->visibility, sizeof expected);
        job.frame = 1;
        job.desc.seed++;
        read_map(&job);
        assert_memory_not_equal(expected, shared->visibility, sizeof expected);
        free_layers(l);
    }
}

/* Each level of a chain of mips has a depth of its own, and the receivers are behind all of them:
 * Markov's bound tells which one was read. */
static void test_mips(void **state)
{
    (void)state;
    const gn_map_format f = {.kind = GN_MAP_ESM, .bits = 32, .positive_exponent = 1};
    const vec to = v3(0, -1, 0);
    layers *l = make_cascades(to, 1);
    static float chain[2 * TEXELS];
    size_t texel = 0;
    for (uint32_t level = 0, size = SIZE; size > 0; level++, size /= 2)
        for (uint32_t i = 0; i < size * size; i++)
            chain[texel++] = expf(2 * 0.02f * (float)level - 1);
    assert_int_equal(texel, gn_map_chain_texels(SIZE, true));
    l->layer[0].texels = (uint32_t *)(void *)chain;
    gn_map_job job = make_job(l, &f, GN_READING_BILINEAR, shared);
    job.desc.mip_maps = true;
    job.light = make_sun(to);
    const double texel_size = 2 * (double)l->layer[0].projection.extent / SIZE;
    size_t levels[7] = {0}, checked = 0;
    for (uint32_t i = 0; i < PIXELS; i++)
        shared->width[i] = (float)(texel_size * exp2(10 * next_random() - 2));
    read_map(&job);
    for (uint32_t i = 0; i < PIXELS; i++) {
        const reference r = read_in_double(&job, l, i, 0); /* only its layer */
        if (r.unsure || r.layer != 0)
            continue;
        const double lod =
            log2((double)shared->width[i] * (double)shared->normal[1][i] / texel_size);
        const int level = (int)fmin(fmax(round(lod), 0), 6);
        if (near(lod, floor(lod) + 0.5, 1e-3))
            continue;
        const vec at_pixel = add(position_at(&shared->g, i),
                                 mul(normal_at(&shared->g, i), (double)shared->error[i]));
        const double sine = sqrt(1 - pow((double)shared->normal[1][i], 2));
        const double w = 2 - at_pixel.y - 0.7 * texel_size * sine * (double)shared->normal[1][i];
        const double depth = (w - 1.2) / 1.6 - 0.01;
        const double expected = fmin(exp(2 * (0.02 * level - fmax(depth, 0))), 1);
        if (!near((double)shared->visibility[i], expected, 1e-4))
            fail_msg("pixel %u, LOD %g: visibility %g, of level %d it is %g", i, lod,
                     (double)shared->visibility[i], level, expected);
        levels[level]++;
        checked++;
    }
    assert_true(checked > 200);
    for (int level = 0; level < 7; level++)
        assert_true(levels[level] > 3);
    free_layers(l);
    scatter(shared, 0.7);
}

/* Settings ------------------------------------------------------------------------------------- */

static void test_resolved_settings(void **state)
{
    (void)state;
    for (int f = 0; f < FORMATS; f++) {
        gn_map_desc desc = gn_map_desc_default();
        gn_map_desc r = gn_map_desc_resolve(&formats[f], &desc);
        assert_int_equal(r.reading, formats[f].kind == GN_MAP_NLMSM   ? GN_READING_BLUE_NOISE
                                    : formats[f].kind == GN_MAP_DEPTH ? GN_READING_NEAREST
                                                                      : GN_READING_BILINEAR);
        assert_true(r.depth_bias >= 0 && r.depth_bias < 1e-3f);
        assert_true(r.normal_bias >= 0 && r.normal_bias <= 16);
        assert_true(r.minimum_variance >= 0 && r.moment_bias >= 0);
        ok(gn_map_desc_check(gn_device_context(device), &formats[f], &r));
        /* What is given stays, and so does what was resolved. */
        desc.depth_bias = 0.01f;
        desc.normal_bias = desc.minimum_variance = desc.moment_bias = 0;
        desc.reading = GN_READING_WHITE_NOISE;
        r = gn_map_desc_resolve(&formats[f], &desc);
        assert_memory_equal(&r, &desc, sizeof r);
    }
}

static void test_margin(void **state)
{
    (void)state;
    gn_map_desc desc = gn_map_desc_default();
    desc.filter_width = 5;
    const struct {
        gn_map_format format;
        gn_map_reading reading;
        uint32_t margin;
    } cases[] = {{{.kind = GN_MAP_DEPTH, .bits = 32}, GN_READING_NEAREST, 0},
                 {{.kind = GN_MAP_DEPTH, .bits = 32}, GN_READING_WHITE_NOISE, 1},
                 {{.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 2}, GN_READING_NEAREST, 1},
                 {{.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 9}, GN_READING_NEAREST, 4},
                 {{.kind = GN_MAP_PCF, .bits = 32, .pcf_width = 9}, GN_READING_BILINEAR, 5},
                 {{.kind = GN_MAP_VSM, .bits = 64}, GN_READING_NEAREST, 2},
                 {{.kind = GN_MAP_VSM, .bits = 64}, GN_READING_BILINEAR, 3},
                 {{.kind = GN_MAP_VSM, .bits = 64, .single_depth = true}, GN_READING_BILINEAR, 1},
                 {{.kind = GN_MAP_NLMSM, .bits = 64}, GN_READING_BLUE_NOISE, 3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        desc.reading = cases[i].reading;
        assert_int_equal(gn_map_margin(&cases[i].format, &desc), cases[i].margin);
    }
}

static void test_empty_layers_are_refused(void **state)
{
    (void)state;
    const vec to = v3(0, -1, 0);
    layers *l = make_cascades(to, 1);
    gn_map_job job = make_job(l, &formats[0], GN_READING_NEAREST, shared);
    job.light = make_sun(to);
    assert_int_equal(gn_cpu_map_visibility(&device->cpu, &job), GN_ERROR_STATE);
    job.layer_count = GN_MAX_CASCADES + 1;
    assert_int_equal(gn_cpu_map_visibility(&device->cpu, &job), GN_ERROR_INVALID_ARGUMENT);
    free_layers(l);
}

/* Biases ----------------------------------------------------------------------------------------
 */

/* The darkest of many receivers on a plane in the light, and the brightest a thousandth of the
 * range behind it, read by a format with its own settings. angle: between the plane's normal and
 * the light, degrees; turn: around it; texel: metres; range: texels. */
typedef struct extremes {
    double darkest, behind;
} extremes;

static extremes look_at_plane(const gn_map_format *f, gn_map_reading reading, double angle,
                              double turn, double texel, double range)
{
    static float depth[TEXELS], visibility[PIXELS], layer[PIXELS];
    static uint32_t texels[4 * TEXELS];
    const double slope = tan(angle * M_PI / 180), sx = slope * cos(turn), sy = slope * sin(turn);
    const double far = range * texel, middle = 0.45 * far;
    gn_map_layer only = {.projection = {.right = {1, 0, 0},
                                        .up = {0, 1, 0},
                                        .forward = {0, 0, 1},
                                        .extent = (float)(texel * SIZE / 2),
                                        .far = (float)far,
                                        .resolution = SIZE},
                         .depth = {depth, NULL},
                         .texels = texels};
    for (int i = 0; i < TEXELS; i++) {
        const double x = (i % SIZE + 0.5 - SIZE / 2) * texel,
                     y = (SIZE / 2 - i / SIZE - 0.5) * texel;
        depth[i] = (float)((middle + sx * x + sy * y) / far);
    }
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = SIZE;
    desc.reading = reading;
    desc = gn_map_desc_resolve(f, &desc);
    if (gn_map_has_texels(f)) {
        const gn_filter_job filter = {.format = *f,
                                      .resolution = SIZE,
                                      .samples = 1,
                                      .width = desc.filter_width,
                                      .sigma = desc.filter_sigma,
                                      .moment_bias = desc.moment_bias,
                                      .depth = depth,
                                      .rect = {0, 0, SIZE, SIZE},
                                      .texels = texels};
        ok(gn_cpu_filter(&device->cpu, &filter));
    }
    const vec n = unit(v3(sx, sy, -1));
    const double normal[3] = {n.x, n.y, n.z};
    gn_map_job job = {.layers = &only,
                      .layer_count = 1,
                      .format = *f,
                      .desc = desc,
                      .gbuffer = &shared->g,
                      .light = make_sun(v3(0, 0, 1)),
                      .visibility = visibility,
                      .layer = layer};
    extremes e = {1, 0};
    for (int behind = 0; behind < 2; behind++) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            /* Away from the border by what the filter and the bias reach. */
            const double x = (next_random() - 0.5) * texel * (SIZE - 24);
            const double y = (next_random() - 0.5) * texel * (SIZE - 24);
            const double p[3] = {x, y, middle + sx * x + sy * y + behind * 0.05 * far};
            for (int axis = 0; axis < 3; axis++) {
                shared->position[axis][i] = (float)p[axis];
                shared->normal[axis][i] = (float)normal[axis];
            }
            shared->surface[i] = 1;
            shared->error[i] = 0;
        }
        read_map(&job);
        for (uint32_t i = 0; i < PIXELS; i++) {
            assert_true(layer[i] == 0);
            if (behind)
                e.behind = fmax(e.behind, (double)visibility[i]);
            else
                e.darkest = fmin(e.darkest, (double)visibility[i]);
        }
    }
    return e;
}

/* Planes in the light have no spots, whatever their slope, and a caster a twentieth of the range
 * away still shadows; a scene of any size gives the same. PCF may see 1 % of its window beyond the
 * bias on either side. */
static void test_biases(void **state)
{
    (void)state;
    for (int f = 0; f < FORMATS; f++) {
        const gn_map_format *format = &formats[f];
        if (format->kind == GN_MAP_PCF && format->pcf_width > 9)
            continue; /* need a larger map */
        for (int reading = GN_READING_NEAREST; reading <= GN_READING_BILINEAR; reading++)
            for (int step = 0; step < 3 && reading != GN_READING_WHITE_NOISE; step++) {
                const double angle = 40 * step, range = 2000, turn = 2 + 1.7 * step;
                for (int scale = step == 1 ? -3 : 0; scale <= (step == 1 ? 3 : 0); scale += 3) {
                    const extremes e = look_at_plane(format, (gn_map_reading)reading, angle, turn,
                                                     0.01 * pow(10, scale), range);
                    const double least = format->pcf_width > 2 ? 0.95 : 0.99;
                    if (e.darkest < least)
                        fail_msg("%s, reading %d, a plane at %g degrees: visibility falls to %g",
                                 name_of(format), reading, angle, e.darkest);
                    /* Bounds that leak much by nature. */
                    const bool leaks = format->kind == GN_MAP_ESM ||
                                       (format->kind == GN_MAP_VSM && format->bits == 32) ||
                                       (format->kind == GN_MAP_EVSM && format->bits == 64) ||
                                       (format->kind == GN_MAP_EVSM && angle > 60);
                    if (!leaks && e.behind > 0.1)
                        fail_msg("%s, reading %d, behind a plane at %g degrees: visibility is %g",
                                 name_of(format), reading, angle, e.behind);
                }
            }
    }
    scatter(shared, 0.7);
}

static int set_up(void **state)
{
    shared = malloc(sizeof *shared);
    if (!shared || open_device(state) != 0)
        return -1;
    scatter(shared, 0.7);
    return 0;
}

static int tear_down(void **state)
{
    free(shared);
    return close_device(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_format_and_reading),
        cmocka_unit_test(test_devices),
        cmocka_unit_test(test_light_reaches_as_for_rays),
        cmocka_unit_test(test_moving_casters),
        cmocka_unit_test(test_single_depth),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_mips),
        cmocka_unit_test(test_resolved_settings),
        cmocka_unit_test(test_margin),
        cmocka_unit_test(test_empty_layers_are_refused),
        cmocka_unit_test(test_biases),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
