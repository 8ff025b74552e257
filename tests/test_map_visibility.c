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
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
