/* What tests of the reading of maps share: scattered pixels, synthetic layers between pages that
 * must not be touched, every format, jobs. */
#ifndef MAP_READING_TESTING_H
#define MAP_READING_TESTING_H

#include <sys/mman.h>

#include "render_testing.h"

#include "cpu/map.h"
#include "render/device.h"

#include <gnomon/shadow/moments_nonlinear.h>
#include <gnomon/shadow/variance.h>

/* Random numbers, pixels ---------------------------------------------------------------------- */

static uint32_t random_state = 7;

/* [0,1) */
static inline double next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) / 16777216.0;
}

static inline vec random_direction(void)
{
    for (;;) {
        const double x = 2 * next_random() - 1, y = 2 * next_random() - 1;
        const vec v = v3(x, y, 2 * next_random() - 1);
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
static inline void scatter(pixels *p, double half)
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

static inline guarded guard(size_t bytes)
{
    assert_int_equal(bytes % PAGE, 0);
    guarded g = {.size = bytes + 2 * PAGE};
    g.base = mmap(NULL, g.size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(g.base != MAP_FAILED);
    assert_int_equal(mprotect(g.base + PAGE, bytes, PROT_READ | PROT_WRITE), 0);
    return g;
}

static inline void *memory(guarded g)
{
    return g.base + PAGE;
}

typedef struct layers {
    gn_map_layer layer[LAYERS];
    uint32_t count;
    guarded memory[3 * LAYERS];
    double values[LAYERS][TEXELS][4]; /* what the texels hold, but for their rounding */
} layers;

static inline void free_layers(layers *l)
{
    for (int i = 0; i < 3 * LAYERS; i++)
        if (l->memory[i].base)
            munmap(l->memory[i].base, l->memory[i].size);
    free(l);
}

static inline gn_map_projection look(vec from, vec to, double twist)
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
static inline layers *make_cascades(vec to, uint32_t count)
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
        l->layer[i].index = i;
    }
    return l;
}

/* The six faces around a point, a little wider than a cube's. */
static inline layers *make_faces(vec at)
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
        l->layer[i].index = i;
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

static inline const char *name_of(const gn_map_format *f)
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

static inline void pack_texel(const gn_map_format *f, float bias, const double d[], int count,
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

static inline guarded *next_memory(layers *l)
{
    for (int i = 0; i < 3 * LAYERS; i++)
        if (!l->memory[i].base)
            return &l->memory[i];
    fail_msg("no memory left");
    return NULL;
}

/* Depths in blocks of two texels, so that windows see more than noise. */
static inline float *fill_depth(layers *l)
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

static inline void fill(layers *l, const gn_map_format *f, const gn_map_desc *desc, bool moving)
{
    for (uint32_t i = 0; i < l->count; i++) {
        if (!gn_map_has_texels(f)) {
            l->layer[i].depth[0] = fill_depth(l);
            l->layer[i].depth[1] = moving ? fill_depth(l) : NULL;
            l->layer[i].touched = (gn_rect){0, 0, SIZE, SIZE};
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

static inline vec at(const float v[3])
{
    return v3((double)v[0], (double)v[1], (double)v[2]);
}

static inline bool near(double a, double b, double by)
{
    return fabs(a - b) < by;
}

/* Jobs ------------------------------------------------------------------------------------------
 */

static pixels *shared;

static inline gn_map_job make_job(const layers *l, const gn_map_format *f, gn_map_reading reading,
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

static inline gn_light make_sun(vec to)
{
    const vec u = unit(to);
    gn_light light = {.desc = gn_light_desc_default()};
    light.desc.type = GN_LIGHT_DIRECTIONAL;
    light.direction[0] = (float)u.x;
    light.direction[1] = (float)u.y;
    light.direction[2] = (float)u.z;
    return light;
}

static inline gn_light make_lamp(gn_light_type type, vec from, vec to)
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

static inline void read_map(const gn_map_job *job)
{
    ok(gn_cpu_map_visibility(&device->cpu, job));
}

static inline int set_up(void **state)
{
    shared = malloc(sizeof *shared);
    if (!shared || open_device(state) != 0)
        return -1;
    scatter(shared, 0.7);
    return 0;
}

static inline int tear_down(void **state)
{
    free(shared);
    return close_device(state);
}

#endif
