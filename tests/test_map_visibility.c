/* Reading shadow maps, against a reading of each pixel in double by this test: own projection, own
 * choice of layer and texels, own inequalities. */
#include "map_reading_testing.h"

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

/* Every pixel against the reading in double. Quantities of 1e-4 and more are certain, so that the
 * tolerance is what floats make of an ill-conditioned vector. Returns how many are partly lit. */
static size_t check(const gn_map_job *job, const layers *l, const char *what)
{
    const gn_map_format *f = &job->format;
    const double tolerance = f->kind >= GN_MAP_EVSM ? 2e-3 : 5e-4;
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_format_and_reading),
        cmocka_unit_test(test_devices),
        cmocka_unit_test(test_mips),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
