/* What tests of shadow maps share: formats, a yard with casters that move, and a check that a map
 * is what a new one would be. */
#ifndef SHADOW_MAP_TESTING_H
#define SHADOW_MAP_TESTING_H

#include "render_testing.h"

#include "cpu/cpu.h"
#include "render/device.h"
#include "render/shadow_map.h"

#define RESOLUTION 256u /* of small_desc() */

static const gn_map_format depth32 = {.kind = GN_MAP_DEPTH, .bits = 32};
static const gn_map_format vsm64 = {.kind = GN_MAP_VSM, .bits = 64};
static const gn_map_format msm64 = {.kind = GN_MAP_MSM, .bits = 64};
static const gn_map_format nlmsm64 = {.kind = GN_MAP_NLMSM, .bits = 64};

static inline gn_map_desc small_desc(void)
{
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = RESOLUTION;
    return desc;
}

static inline gn_shadow_map *make_map(const gn_map_format *format, const gn_map_desc *desc)
{
    gn_shadow_map *map = NULL;
    ok(gn_shadow_map_create(device, format, desc, &map));
    return map;
}

/* A yard: floor, pillars that stand, two balls that move. */
typedef struct yard {
    gn_scene *scene;
    uint32_t balls[2], sun_node, camera_node, pillar; /* nodes */
    uint32_t camera, sun, lamp, spot;
} yard;

static inline void look(yard *y, vec eye, vec target)
{
    float m[16];
    aim(eye, target, m);
    ok(gn_scene_set_node_matrix(y->scene, y->camera_node, m));
}

static inline void move_ball(yard *y, uint32_t ball, vec to)
{
    const float m[16] = {1, 0, 0, 0, 0,           1,           0,           0,
                         0, 0, 1, 0, (float)to.x, (float)to.y, (float)to.z, 1};
    ok(gn_scene_set_node_matrix(y->scene, y->balls[ball], m));
}

static inline yard make_yard(bool balls)
{
    yard y = {.scene = new_scene()};
    place(y.scene, add_floor(y.scene, 30, 0, GN_NONE), false);
    const uint32_t pillar = add_box(y.scene, v3(-0.3, 0, -0.3), v3(0.3, 3, 0.3), GN_NONE);
    for (int i = 0; i < 25; i++) {
        gn_node_desc node = gn_node_desc_default();
        node.mesh = pillar;
        node.translation[0] = (float)(10 * (i % 5) - 20);
        node.translation[2] = (float)(10 * (i / 5) - 20);
        ok(gn_scene_add_node(y.scene, &node, &y.pillar));
    }
    const uint32_t ball = add_sphere(y.scene, v3(0, 0, 0), 0.7, 6, GN_NONE);
    for (int i = 0; balls && i < 2; i++) {
        gn_node_desc node = gn_node_desc_default();
        node.mesh = ball;
        ok(gn_scene_add_node(y.scene, &node, &y.balls[i]));
        move_ball(&y, (uint32_t)i, v3(3 + i, 1, 2));
    }
    y.sun = add_sun(y.scene, v3(0.4, 1, 0.3));
    y.sun_node = y.scene->node_count - 1;
    y.lamp = add_lamp(y.scene, v3(1, 4, -2));
    gn_light_desc desc = gn_light_desc_default();
    desc.type = GN_LIGHT_SPOT;
    desc.outer_cone_angle = 0.6f;
    y.spot = add_light(y.scene, &desc, v3(-4, 6, 3), v3(1, 0, 1));
    y.camera = add_camera(y.scene, v3(2, 1.7, 10), v3(2, 1, 0), 0.9, 0.1);
    y.camera_node = y.scene->node_count - 1;
    ok(gn_scene_commit(y.scene));
    return y;
}

static inline gn_map_update update(gn_shadow_map *map, const yard *y, uint32_t light)
{
    gn_map_update u;
    ok(gn_shadow_map_update(map, y->scene, light, y->camera, 16.0f / 9.0f, &u));
    return u;
}

/* Draws and filters every layer of a map from nothing, with its own projections, and compares bit
 * by bit. */
static inline void assert_as_if_new(const gn_shadow_map *map, const yard *y, const char *what)
{
    gn_map_job job = {.layers = NULL};
    gn_shadow_map_fill_job(map, &job);
    const gn_cpu *cpu = &device->cpu;
    const uint32_t resolution = job.desc.resolution;
    const size_t count = (size_t)resolution * resolution * job.desc.samples;
    const size_t words =
        gn_map_chain_texels(resolution, job.desc.mip_maps) * gn_map_words(&job.format);
    float *depth[2] = {malloc(count * sizeof(float)), malloc(count * sizeof(float))};
    uint32_t *texels = malloc(words * sizeof *texels);
    assert_true(depth[0] && depth[1] && texels);
    for (uint32_t i = 0; i < job.layer_count; i++) {
        const gn_map_layer *layer = &job.layers[i];
        gn_depth_job draw = {.scene = y->scene,
                             .projection = layer->projection,
                             .alpha = job.desc.alpha,
                             .samples = job.desc.samples};
        for (int casters = 0; casters < 2; casters++) {
            draw.casters = (gn_casters)casters;
            draw.depth = depth[casters];
            ok(gn_cpu_depth(cpu, &draw));
        }
        for (size_t k = 0; k < count; k++) {
            const float moving = layer->depth[1] ? layer->depth[1][k] : 1.0f;
            if (layer->depth[0][k] != depth[0][k] || moving != depth[1][k])
                fail_msg("%s: layer %u, depth %zu: %g and %g, drawn anew %g and %g", what, i, k,
                         (double)layer->depth[0][k], (double)moving, (double)depth[0][k],
                         (double)depth[1][k]);
        }
        if (!gn_map_has_texels(&job.format))
            continue;
        const gn_filter_job filter = {.format = job.format,
                                      .resolution = resolution,
                                      .samples = job.desc.samples,
                                      .width = job.desc.filter_width,
                                      .sigma = job.desc.filter_sigma,
                                      .moment_bias = job.desc.moment_bias,
                                      .depth = depth[0],
                                      .dynamic = depth[1],
                                      .rect = {0, 0, resolution, resolution},
                                      .texels = texels};
        ok(gn_cpu_filter(cpu, &filter));
        if (job.desc.mip_maps)
            gn_cpu_map_mips(cpu, &job.format, resolution, texels);
        for (size_t k = 0; k < words; k++)
            if (texels[k] != layer->texels[k])
                fail_msg("%s: layer %u, word %zu: %08x, made anew %08x", what, i, k,
                         layer->texels[k], texels[k]);
    }
    free(depth[0]);
    free(depth[1]);
    free(texels);
}

/* In slices ----------------------------------------------------------------------------------- */

static inline gn_map_desc sliced_desc(uint32_t refresh)
{
    gn_map_desc desc = small_desc();
    desc.refresh = refresh;
    return desc;
}

static inline gn_map_job job_of(const gn_shadow_map *map)
{
    gn_map_job job = {.layers = NULL};
    gn_shadow_map_fill_job(map, &job);
    return job;
}

/* Both hold the same layers, to the bit. */
static inline void assert_same(const gn_shadow_map *a, const gn_shadow_map *b, const char *what)
{
    const gn_map_job of[2] = {job_of(a), job_of(b)};
    const size_t depths = (size_t)of[0].desc.resolution * of[0].desc.resolution;
    const size_t words = gn_map_chain_texels(of[0].desc.resolution, of[0].desc.mip_maps) *
                         gn_map_words(&of[0].format);
    if (of[0].layer_count != of[1].layer_count)
        fail_msg("%s: %u layers and %u", what, of[0].layer_count, of[1].layer_count);
    for (uint32_t i = 0; i < of[0].layer_count; i++) {
        const gn_map_layer *l[2] = {&of[0].layers[i], &of[1].layers[i]};
        const gn_map_projection *p[2] = {&l[0]->projection, &l[1]->projection};
        if (l[0]->index != l[1]->index || memcmp(p[0]->origin, p[1]->origin, 12) != 0 ||
            memcmp(p[0]->right, p[1]->right, 12) != 0 || p[0]->extent != p[1]->extent ||
            p[0]->near != p[1]->near || p[0]->far != p[1]->far)
            fail_msg("%s: layer %u is cascade %u of extent %g, and %u of %g", what, i, l[0]->index,
                     (double)p[0]->extent, l[1]->index, (double)p[1]->extent);
        for (int casters = 0; casters < 2; casters++) {
            const float *d[2] = {l[0]->depth[casters], l[1]->depth[casters]};
            if (!d[0] != !d[1] || (d[0] && memcmp(d[0], d[1], depths * sizeof(float)) != 0))
                fail_msg("%s: depth %d of layer %u differs", what, casters, i);
        }
        if (memcmp(&l[0]->touched, &l[1]->touched, sizeof(gn_rect)) != 0)
            fail_msg("%s: layer %u is touched in columns %u to %u, and %u to %u", what, i,
                     l[0]->touched.x0, l[0]->touched.x1, l[1]->touched.x0, l[1]->touched.x1);
        if (!l[0]->texels != !l[1]->texels ||
            (l[0]->texels && memcmp(l[0]->texels, l[1]->texels, words * sizeof(uint32_t)) != 0))
            fail_msg("%s: texels of layer %u differ", what, i);
    }
}

static inline void turn_sun(yard *y, double degrees)
{
    float m[16];
    const double a = degrees * acos(-1.0) / 180;
    aim(v3(0.5 * cos(a), 1, 0.5 * sin(a)), v3(0, 0, 0), m);
    ok(gn_scene_set_node_matrix(y->scene, y->sun_node, m));
    ok(gn_scene_commit(y->scene));
}

/* Camera, balls and sun at a frame of a small film. */
static inline void show(yard *y, uint32_t n)
{
    const double t = n / 10.0;
    look(y, v3(0.5 * t, 1.7, 10 - 0.6 * t), v3(4 * sin(0.4 * t), 1, -3));
    move_ball(y, 0, v3(3 * sin(1.1 * t), 1 + sin(t), 4 * cos(0.9 * t)));
    move_ball(y, 1, v3(2 + 0.2 * t, 1, 4));
    turn_sun(y, 30 + 0.02 * n);
}

#endif
