/* What tests of the light buffer in scenes share: it and the tree, asked for the same rays. */
#ifndef LIGHT_BUFFER_TESTING_H
#define LIGHT_BUFFER_TESTING_H

#include "render_testing.h"

static const char *const ray_methods[] = {"ray-mip0", "ray-raw", "ray-test", "ray-saturate",
                                          "ray-coverage"};

/* Rays that may differ by more than a half, of so many: those at the edge of a triangle or a texel,
 * where rounding decides; with a binary test also those whose alpha is its cutoff. */
static inline double allowed(const gn_method *method, uint64_t rays)
{
    const bool binary = method->alpha == GN_ALPHA_RULE_MIP0 || method->alpha == GN_ALPHA_RULE_TEST;
    return fmax(1.0, (binary ? 1e-4 : 1e-5) * (double)rays);
}

static inline gn_visibility_desc ray_desc(const char *method, uint32_t light, gn_tracer_kind tracer)
{
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = gn_method_find(method);
    assert_non_null(desc.method);
    desc.light = light;
    desc.tracer = tracer;
    return desc;
}

/* Sums over comparisons. */
typedef struct tally {
    uint64_t rays, different, tree_rays;
    uint32_t refused;
} tally;

static inline void print_tally(const char *name, const tally *t)
{
    print_message("%-28s %8zu rays, %zu differ (%.1e); the tree traced %.2f %%\n", name,
                  (size_t)t->rays, (size_t)t->different,
                  (double)t->different / fmax((double)t->rays, 1),
                  100 * (double)t->tree_rays / fmax((double)t->rays, 1));
}

/* Asks both for the visibility of a picture. desc: its tracer is not looked at. found: what the
 * light buffer finds, one a pixel, or NULL. */
static inline gn_visibility_stats compare_tracers(const gn_scene *scene, const gn_gbuffer *g,
                                                  const gn_visibility_desc *desc, float *found,
                                                  tally *sum, const char *what)
{
    const size_t pixels = (size_t)g->width * g->height;
    float *tree = calloc(pixels * 2, sizeof *tree), *grid = found ? found : tree + pixels;
    assert_non_null(tree);
    gn_visibility_desc d = *desc;
    gn_visibility_stats expected = {0}, stats = {0};
    d.tracer = GN_TRACER_BVH;
    ok(gn_scene_visibility(scene, g, &d, tree, &expected));
    assert_int_equal(expected.tracer, GN_TRACER_BVH);
    d.tracer = GN_TRACER_LIGHT_BUFFER;
    ok(gn_scene_visibility(scene, g, &d, grid, &stats));
    assert_int_equal(stats.tracer, GN_TRACER_LIGHT_BUFFER);
    assert_int_equal(stats.rays, expected.rays);
    const size_t different = count_different(tree, grid, pixels, 0.5f);
    if ((double)different > allowed(d.method, stats.rays))
        fail_msg("%s, light %u, %s: %zu of %zu rays differ, at most %g are allowed", what, d.light,
                 d.method->name, different, (size_t)stats.rays, allowed(d.method, stats.rays));
    sum->rays += stats.rays;
    sum->different += different;
    sum->tree_rays += stats.light_buffer.tree_rays;
    sum->refused += stats.light_buffer.refused;
    free(tree);
    return stats;
}

/* Receivers of one's own making, anywhere: a picture of one row. */
typedef struct cloud {
    gn_gbuffer g;
    float *memory;
} cloud;

static inline cloud new_cloud(uint32_t count)
{
    cloud c = {.g = {.width = count, .height = 1}, .memory = calloc((size_t)count * 8, 4)};
    c.g.surface = calloc(count, sizeof *c.g.surface);
    assert_true(c.memory && c.g.surface);
    for (int i = 0; i < 3; i++) {
        c.g.position[i] = c.memory + (size_t)i * count;
        c.g.normal[i] = c.memory + (size_t)(3 + i) * count;
    }
    c.g.origin_error = c.memory + (size_t)6 * count;
    c.g.cone_width = c.memory + (size_t)7 * count;
    return c;
}

static inline void end_cloud(cloud *c)
{
    free(c->g.surface);
    free(c->memory);
}

/* One that faces the light; error: how far its ray starts along the normal. */
static inline void put_receiver(cloud *c, uint32_t i, vec position, vec normal, double error,
                                double width)
{
    const double p[3] = {position.x, position.y, position.z}, n[3] = {normal.x, normal.y, normal.z};
    for (int k = 0; k < 3; k++) {
        c->g.position[k][i] = (float)p[k];
        c->g.normal[k][i] = (float)n[k];
    }
    c->g.origin_error[i] = (float)error;
    c->g.cone_width[i] = (float)width;
}

/* The direction to a light. */
static inline vec towards_light(const gn_scene *scene, uint32_t light, vec p)
{
    const gn_light *l = &scene->lights[light];
    if (l->desc.type == GN_LIGHT_DIRECTIONAL)
        return v3(-(double)l->direction[0], -(double)l->direction[1], -(double)l->direction[2]);
    return unit(sub(v3((double)l->position[0], (double)l->position[1], (double)l->position[2]), p));
}

static inline uint32_t add_spot(gn_scene *scene, vec from, vec to, double half_angle)
{
    gn_light_desc desc = gn_light_desc_default();
    desc.type = GN_LIGHT_SPOT;
    desc.outer_cone_angle = (float)half_angle;
    return add_light(scene, &desc, from, to);
}

static inline gn_scene *built_in(const char *name, double scale, double unit)
{
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = scale;
    desc.unit = unit;
    gn_scene *scene;
    ok(gn_scene_create_procedural(device, name, &desc, &scene));
    return scene;
}

static inline gn_view *new_view(uint32_t width, uint32_t height)
{
    gn_view_desc desc = gn_view_desc_default();
    desc.width = width;
    desc.height = height;
    gn_view *view;
    ok(gn_view_create(device, &desc, &view));
    return view;
}

/* The picture of a scene at a time. */
static inline const gn_gbuffer *look(gn_view *view, gn_scene *scene, uint32_t camera,
                                     double seconds)
{
    ok(gn_scene_set_time(scene, seconds));
    ok(gn_scene_commit(scene));
    ok(gn_view_trace_gbuffer(view, scene, camera));
    return gn_view_gbuffer(view);
}

#endif
