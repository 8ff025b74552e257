/* Visibility behind MASK and BLEND surfaces, against lookups in double by this test in the scene's
 * own mips. */
#include "render_testing.h"

static const gn_alpha_rule rules[] = {GN_ALPHA_RULE_MIP0, GN_ALPHA_RULE_RAW, GN_ALPHA_RULE_TEST,
                                      GN_ALPHA_RULE_SATURATE, GN_ALPHA_RULE_COVERAGE};
#define RULES (sizeof rules / sizeof *rules)

static const gn_method *method_of(gn_alpha_rule rule)
{
    for (const gn_method *const *method = gn_methods; *method; method++)
        if ((*method)->trace == GN_TRACE_ALL && (*method)->alpha == rule)
            return *method;
    fail_msg("no method has the alpha rule %d", (int)rule);
    return NULL;
}

static uint32_t random_state = 1;

static double next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (double)random_state / 2147483648.0 - 1;
}

/* Spots of a few texels with soft and hard borders. */
static uint32_t add_texture(gn_scene *scene, uint32_t width, uint32_t height)
{
    uint8_t *rgba = malloc((size_t)width * height * 4);
    assert_non_null(rgba);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const double wave =
                sin(0.9 * x + 0.2 * y) * cos(0.7 * y - 0.3 * x) + 0.3 * next_random() + 0.1;
            uint8_t *texel = rgba + 4 * ((size_t)y * width + x);
            texel[0] = texel[2] = 60;
            texel[1] = 160;
            texel[3] = (uint8_t)(255 * fmax(0, fmin(1, 0.5 + 1.2 * wave)));
        }
    gn_texture_desc desc = gn_texture_desc_default();
    desc.width = width;
    desc.height = height;
    desc.rgba = rgba;
    uint32_t texture;
    ok(gn_scene_add_texture(scene, &desc, &texture));
    free(rgba);
    return texture;
}

static uint32_t add_masked(gn_scene *scene, uint32_t texture, gn_alpha_mode mode, double cutoff,
                           double alpha, gn_wrap wrap)
{
    gn_material_desc desc = gn_material_desc_default();
    desc.texture = texture;
    desc.alpha_mode = mode;
    desc.alpha_cutoff = (float)cutoff;
    desc.base_color[3] = (float)alpha;
    desc.wrap_u = desc.wrap_v = wrap;
    desc.double_sided = true;
    uint32_t material;
    ok(gn_scene_add_material(scene, &desc, &material));
    return material;
}

/* One card over a floor ---------------------------------------------------------------------- */

/* A parallelogram in the world with texture coordinates from 0 to turns along its sides. */
typedef struct card {
    vec corner, along_u, along_v;
    double turns;
    const gn_material *material;
} card;

static int64_t wrap_index(int64_t i, int64_t n, gn_wrap wrap)
{
    if (wrap == GN_WRAP_CLAMP)
        return i < 0 ? 0 : i >= n ? n - 1 : i;
    const int64_t period = wrap == GN_WRAP_MIRROR ? 2 * n : n;
    i = ((i % period) + period) % period;
    return i < n ? i : 2 * n - 1 - i;
}

/* Bilinear alpha of a level at (u, v), and the length of its gradient per texel. */
static double look_up(const gn_material *material, uint8_t *const *chain, uint32_t level, double u,
                      double v, double *slope)
{
    const int64_t width = gn_level_size(material->alpha.width, level);
    const int64_t height = gn_level_size(material->alpha.height, level);
    const double x = u * (double)width - 0.5, y = v * (double)height - 0.5;
    const double fx = x - floor(x), fy = y - floor(y);
    double a[2][2];
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++)
            a[j][i] =
                chain[level]
                     [wrap_index((int64_t)floor(y) + j, height, material->desc.wrap_v) * width +
                      wrap_index((int64_t)floor(x) + i, width, material->desc.wrap_u)] /
                255.0;
    const double gx = (1 - fy) * (a[0][1] - a[0][0]) + fy * (a[1][1] - a[1][0]);
    const double gy = (1 - fx) * (a[1][0] - a[0][0]) + fx * (a[1][1] - a[0][1]);
    *slope = sqrt(gx * gx + gy * gy);
    return (1 - fy) * ((1 - fx) * a[0][0] + fx * a[0][1]) +
           fy * ((1 - fx) * a[1][0] + fx * a[1][1]);
}

/* How much of a cone that is `width` wide at the card is blocked; -1: too close to a jump. */
static double card_opacity(const card *c, vec from, vec direction, double width_here,
                           double width_loss, gn_alpha_rule rule, bool rescaled)
{
    const vec n = cross(c->along_u, c->along_v);
    const double area = length(n), t = dot(sub(c->corner, from), n) / dot(direction, n);
    if (!(t > 0))
        return 0;
    const vec at = sub(add(from, mul(direction, t)), c->corner);
    const double u = dot(cross(at, c->along_v), n) / (area * area);
    const double v = dot(cross(c->along_u, at), n) / (area * area);
    if (fmin(fmin(u, 1 - u), fmin(v, 1 - v)) < 1e-4)
        return fmin(fmin(u, 1 - u), fmin(v, 1 - v)) < -1e-4 ? 0 : -1;

    const gn_material *m = c->material;
    const gn_alpha_map *map = &m->alpha;
    const double texels = map->width * c->turns * map->height * c->turns;
    const double width = width_here - width_loss * t;
    const bool blend = m->desc.alpha_mode == GN_ALPHA_BLEND;
    const bool coverage = rule == GN_ALPHA_RULE_COVERAGE;
    /* Coverage takes the footprint of equal area, and a mip finer by a third of a level. */
    const double cosine = fabs(dot(direction, n)) / area;
    const double footprint = width * sqrt(texels / area) / (coverage ? sqrt(cosine) : cosine);
    const double level = log2(footprint) + (coverage && !blend ? 0.5 - 1.0 / 3 : 0.5);
    if (rule != GN_ALPHA_RULE_MIP0 &&
        (fabs(level - floor(level + 0.5)) < 1e-3 || fabs(footprint - 1) < 1e-3))
        return -1;
    const double last = map->levels - 1;
    const double mip = rule == GN_ALPHA_RULE_MIP0 ? 0 : fmax(0, fmin(last, floor(level)));
    const bool magnified = coverage && !blend && footprint < 1;
    uint8_t *const *chain = map->rescaled;
    if (blend || magnified || rule == GN_ALPHA_RULE_MIP0 || (!coverage && !rescaled))
        chain = map->averaged;
    else if (coverage)
        chain = map->coverage;
    double slope;
    const double alpha = look_up(m, chain, (uint32_t)mip, u * c->turns, v * c->turns, &slope);
    const double cutoff = (double)m->desc.alpha_cutoff;
    if (blend || rule == GN_ALPHA_RULE_RAW)
        return alpha;
    if (rule == GN_ALPHA_RULE_SATURATE)
        return fmin(alpha / cutoff, 1);
    if (rule != GN_ALPHA_RULE_COVERAGE)
        return fabs(alpha - cutoff) < 1e-3 ? -1 : alpha >= cutoff;
    if (!magnified)
        return alpha;
    /* A steep ramp multiplies the rounding of alpha. */
    if (slope * footprint < 0.1)
        return fabs(alpha - cutoff) < 0.06 ? -1 : alpha >= cutoff;
    return fmax(0, fmin(1, (alpha - cutoff) / (slope * footprint) + 0.5));
}

/* What the cutoff of visibility makes of it. */
static double after_cutoff(double visibility, double cutoff)
{
    return fmax(0, (visibility - cutoff) / (1 - cutoff));
}

static void check_card(const gn_scene *scene, const frame *f, uint32_t light_index, const card *c,
                       const gn_visibility_desc *desc, const char *what)
{
    const gn_light *light = &scene->lights[light_index];
    const bool sun = light->desc.type == GN_LIGHT_DIRECTIONAL;
    size_t undecided = 0, partial = 0;
    for (size_t i = 0; i < f->pixels; i++) {
        if (f->g->surface[i] != 0)
            continue;
        const vec n = normal_at(f->g, i);
        const vec p = add(position_at(f->g, i), mul(n, (double)f->g->origin_error[i]));
        vec direction = v3(-(double)light->direction[0], -(double)light->direction[1],
                           -(double)light->direction[2]);
        double distance = INFINITY;
        if (!sun) {
            direction = sub(v3((double)light->position[0], (double)light->position[1],
                               (double)light->position[2]),
                            p);
            distance = length(direction);
            direction = mul(direction, 1 / distance);
        }
        const double width = (double)f->g->cone_width[i] * dot(n, direction);
        const double opacity = card_opacity(c, p, direction, width, width / distance,
                                            desc->method->alpha, desc->rescale_alpha);
        if (opacity < 0) {
            undecided++;
            continue;
        }
        partial += opacity > 0;
        const double expected = after_cutoff(1 - opacity, (double)desc->cutoff);
        if (fabs(expected - (double)f->visibility[i]) > 3e-3)
            fail_msg("%s, %s%s: pixel (%zu, %zu) is %.6f, expected %.6f", what, desc->method->name,
                     desc->rescale_alpha ? "" : " without rescaling", i % f->g->width,
                     i / f->g->width, (double)f->visibility[i], expected);
    }
    few(undecided, f->pixels, 0.2, "%s, %s: undecided", what, desc->method->name);
    if (partial < f->pixels / 40)
        fail_msg("%s: only %zu pixels see the card's shadow", what, partial);
}

static void check_one_card(uint32_t width, uint32_t height, gn_wrap wrap, gn_alpha_mode mode,
                           bool moving, double turns, const char *what)
{
    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 8, 0, GN_NONE), false);
    const uint32_t material =
        add_masked(scene, add_texture(scene, width, height), mode, 0.4, 0.9, wrap);
    const vec p[4] = {v3(-1.5, 0, 1), v3(1.5, 0.3, 1), v3(1.5, 0.3, -1), v3(-1.5, 0, -1)};
    gn_node_desc node = gn_node_desc_default();
    node.mesh = add_quad(scene, p, turns, material);
    node.translation[1] = 1.5f;
    node.rotation[1] = 0.2f;
    node.scale[0] = 1.25f;
    node.scale[2] = moving ? -0.75f : 1.25f;
    const uint32_t n = place_desc(scene, &node, moving);
    const uint32_t camera = add_camera(scene, v3(0.6, 1.35, 3.4), v3(-0.3, 0, 0), 0.75, 0.1);
    const uint32_t lights[] = {add_sun(scene, v3(0.3, 1, 0.2)), add_lamp(scene, v3(-0.5, 4, 0.5))};
    ok(gn_scene_commit(scene));
    card c = {.turns = turns, .material = &scene->materials[material]};
    const float *m = scene->nodes[n].world;
    c.corner = transform(m, p[0]);
    c.along_u = sub(transform(m, p[1]), c.corner);
    c.along_v = sub(transform(m, p[3]), c.corner);
    for (int light = 0; light < 2; light++)
        for (size_t k = 0; k < 2 * RULES; k++) {
            gn_visibility_desc desc = gn_visibility_desc_default();
            desc.method = method_of(rules[k / 2]);
            desc.rescale_alpha = k % 2 == 0;
            frame f = render_desc(scene, camera, lights[light], &desc, 64, 40);
            picture(&f, what);
            check_card(scene, &f, lights[light], &c, &desc, what);
            end(&f);
        }
    gn_scene_destroy(&scene);
}

static void test_rules(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint32_t width, height;
        gn_wrap wrap;
        double turns;
    } cases[] = {{"magnified", 16, 16, GN_WRAP_REPEAT, 1},
                 {"magnified, mirrored", 11, 7, GN_WRAP_MIRROR, 3},
                 {"magnified, clamped", 12, 20, GN_WRAP_CLAMP, 2},
                 {"near 1", 64, 64, GN_WRAP_REPEAT, 1},
                 {"odd", 61, 47, GN_WRAP_REPEAT, 3},
                 {"odd, mirrored", 45, 83, GN_WRAP_MIRROR, 2.5},
                 {"odd, clamped", 99, 101, GN_WRAP_CLAMP, 1.5},
                 {"thin", 256, 3, GN_WRAP_REPEAT, 2},
                 {"many mips", 128, 128, GN_WRAP_REPEAT, 12}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        for (int moving = 0; moving < 2; moving++) {
            check_one_card(cases[k].width, cases[k].height, cases[k].wrap, GN_ALPHA_MASK, moving,
                           cases[k].turns, cases[k].name);
            check_one_card(cases[k].width, cases[k].height, cases[k].wrap, GN_ALPHA_BLEND, moving,
                           cases[k].turns, cases[k].name);
        }
}

/* The camera sees the card where its alpha, in mip 0 from so near, reaches the cutoff, and the
 * floor through its holes. */
static void test_camera(void **state)
{
    (void)state;
    static const vec corners[4] = {{-1, 1, 1}, {1, 1, 1}, {1, 1.2, -1}, {-1, 1.2, -1}};
    const vec eye = v3(0.2, 3.5, 1);
    for (int k = 0; k < 6; k++) {
        const gn_wrap wrap = (gn_wrap)(k % 3);
        const double turns = 1.7;
        gn_scene *scene = new_scene();
        place(scene, add_floor(scene, 8, 0, GN_NONE), false);
        const uint32_t texture = add_texture(scene, 13, 9);
        const uint32_t material = add_masked(scene, texture, GN_ALPHA_MASK, 0.6, 1, wrap);
        place(scene, add_quad(scene, corners, turns, material), k / 3);
        const uint32_t camera = add_camera(scene, eye, v3(0, 1, 0), 0.9, 0.1);
        const uint32_t sun = add_sun(scene, v3(0.3, 1, 0.2));
        ok(gn_scene_commit(scene));
        frame f = render(scene, camera, sun, 320, 240);
        picture(&f, "camera");
        const card c = {corners[0], sub(corners[1], corners[0]), sub(corners[3], corners[0]), turns,
                        &scene->materials[material]};
        size_t wrong = 0, undecided = 0, seen[2] = {0, 0};
        for (size_t i = 0; i < f.pixels; i++) {
            const vec direction = unit(sub(position_at(f.g, i), eye));
            const double opacity =
                f.g->surface[i] == GN_NONE
                    ? 0
                    : card_opacity(&c, eye, direction, 1e-6, 0, GN_ALPHA_RULE_TEST, false);
            undecided += opacity < 0;
            if (opacity < 0 || f.g->surface[i] == GN_NONE)
                continue;
            seen[opacity > 0]++;
            wrong += (f.g->surface[i] == 1) != (opacity > 0);
        }
        few(wrong, f.pixels, 0, "camera, wrap %d", (int)wrap);
        few(undecided, f.pixels, 0.02, "camera, wrap %d: undecided", (int)wrap);
        assert_true(seen[0] > 1000 && seen[1] > 1000);
        end(&f);
        gn_scene_destroy(&scene);
    }
}

/* Layers, cutoffs, extremes ------------------------------------------------------------------ */

/* A floor under `layers` squares of one material, the camera far to the side; the visibility of
 * the floor's middle. */
static double visibility_under(uint32_t layers, gn_alpha_mode mode, double alpha, double cutoff,
                               const gn_visibility_desc *desc, float *lookups, bool moving)
{
    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 8, 0, GN_NONE), false);
    const uint32_t material = add_masked(scene, GN_NONE, mode, cutoff, alpha, GN_WRAP_REPEAT);
    for (uint32_t i = 0; i < layers; i++)
        place(scene, add_floor(scene, 2, 2 + 0.1 * i, material), moving);
    const uint32_t camera = add_camera(scene, v3(0, 1, 6), v3(0, 0, 0), 0.01, 0.1);
    const uint32_t sun = add_sun(scene, v3(0.3, 1, 0.2));
    ok(gn_scene_commit(scene));
    frame f = render_desc(scene, camera, sun, desc, 8, 8);
    for (size_t i = 1; i < f.pixels; i++)
        assert_true(f.visibility[i] == f.visibility[0]);
    const double seen = (double)f.visibility[0];
    float counts[64];
    gn_visibility_stats stats = {.lookups = counts};
    float again[64];
    ok(gn_scene_visibility(scene, f.g, desc, again, &stats));
    assert_int_equal(stats.rays, 64);
    *lookups = counts[0];
    if (fabs((double)again[0] - seen) > 1e-6)
        fail_msg("visibility %g, with statistics %g", seen, (double)again[0]);
    end(&f);
    gn_scene_destroy(&scene);
    return seen;
}

static void expect(double value, double expected, double tolerance, const char *what,
                   const gn_visibility_desc *desc)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s, %s: %g, expected %g", what, desc->method->name, value, expected);
}

static void test_layers(void **state)
{
    (void)state;
    for (size_t rule = 0; rule < RULES; rule++)
        for (int moving = 0; moving < 2; moving++) {
            gn_visibility_desc desc = gn_visibility_desc_default();
            desc.method = method_of(rules[rule]);
            float lookups;
            const double layer = 1 - 128 / 255.0; /* what 8 bits hold of 0.5 */
            for (uint32_t layers = 1; layers <= 5; layers++) {
                const float cutoffs[] = {0, 0.01f, 0.2f, 0.5f};
                for (int k = 0; k < 4; k++) {
                    desc.cutoff = cutoffs[k];
                    const double seen =
                        visibility_under(layers, GN_ALPHA_BLEND, 0.5, 0.5, &desc, &lookups, moving);
                    expect(seen, after_cutoff(pow(layer, layers), (double)cutoffs[k]), 2e-3,
                           "layers of 1/2", &desc);
                    expect((double)lookups, layers, 0, "lookups", &desc);
                }
            }
            desc.cutoff = 0.01f;
            /* Wholly opaque and wholly transparent, and the ends of the cutoff. */
            const gn_alpha_mode mask = GN_ALPHA_MASK, blend = GN_ALPHA_BLEND;
            expect(visibility_under(1, blend, 1, 0.5, &desc, &lookups, moving), 0, 0, "blend 1",
                   &desc);
            expect(visibility_under(3, blend, 0, 0.5, &desc, &lookups, moving), 1, 0, "blend 0",
                   &desc);
            expect(visibility_under(1, mask, 1, 0.5, &desc, &lookups, moving), 0, 0, "opaque",
                   &desc);
            expect(visibility_under(1, mask, 1, 1, &desc, &lookups, moving), 0, 0, "cutoff 1",
                   &desc);
            expect(visibility_under(3, mask, 0, 0.5, &desc, &lookups, moving), 1, 0, "transparent",
                   &desc);
            expect(visibility_under(1, mask, 0, 0, &desc, &lookups, moving), 0, 0, "cutoff 0",
                   &desc);
            expect(visibility_under(1, mask, 0.3, 0, &desc, &lookups, moving), 0, 0, "cutoff 0",
                   &desc);
        }
}

/* Texels of 255 pass a cutoff of 1 also where others do not. */
static void test_cutoff_one(void **state)
{
    (void)state;
    uint8_t rgba[32 * 32 * 4];
    for (int i = 0; i < 32 * 32; i++) {
        memset(rgba + 4 * i, 255, 4);
        rgba[4 * i + 3] = i % 32 < 16 ? 255 : 254;
    }
    gn_texture_desc texture_desc = gn_texture_desc_default();
    texture_desc.width = texture_desc.height = 32;
    texture_desc.rgba = rgba;
    gn_scene *scene = new_scene();
    uint32_t texture;
    ok(gn_scene_add_texture(scene, &texture_desc, &texture));
    place(scene, add_floor(scene, 4, 0, GN_NONE), false);
    place(scene,
          add_floor(scene, 2, 1, add_masked(scene, texture, GN_ALPHA_MASK, 1, 1, GN_WRAP_CLAMP)),
          false);
    const uint32_t camera = add_camera(scene, v3(0, 0.9, 3), v3(0, 0, 0), 1, 0.1);
    const uint32_t sun = add_sun(scene, v3(0, 1, 0));
    ok(gn_scene_commit(scene));
    for (size_t k = 0; k < 2; k++) {
        gn_visibility_desc desc = gn_visibility_desc_default();
        desc.method = method_of(k ? GN_ALPHA_RULE_TEST : GN_ALPHA_RULE_MIP0);
        frame f = render_desc(scene, camera, sun, &desc, 160, 90);
        size_t wrong = 0, seen = 0;
        for (size_t i = 0; i < f.pixels; i++) {
            const vec p = position_at(f.g, i);
            if (f.g->surface[i] != 0 || fabs(p.x) > 1.95 || fabs(p.z) > 1.95 ||
                fabs(p.x) < (k ? 0.8 : 0.1)) /* mips blur the border */
                continue;
            seen++;
            wrong += f.visibility[i] != (p.x < 0 ? 0 : 1);
        }
        picture(&f, "cutoff 1");
        few(wrong, f.pixels, 0, "cutoff 1, %s", desc.method->name);
        assert_true(seen > 1000);
        end(&f);
    }
    gn_scene_destroy(&scene);
}

/* A lamp in its housing shines only where the housing is clipped away. */
static void test_point_light_clip(void **state)
{
    (void)state;
    for (int spot = 0; spot < 2; spot++) {
        gn_scene *scene = new_scene();
        place(scene, add_floor(scene, 4, 0, GN_NONE), false);
        place(scene, add_box(scene, v3(-0.1, 1.9, -0.1), v3(0.1, 2.1, 0.1), GN_NONE), false);
        place(scene, add_box(scene, v3(-0.5, 0.5, -0.5), v3(0.5, 0.7, 0.5), GN_NONE), false);
        gn_light_desc light = gn_light_desc_default();
        light.type = spot ? GN_LIGHT_SPOT : GN_LIGHT_POINT;
        light.outer_cone_angle = 1.2f;
        const uint32_t lamp = add_light(scene, &light, v3(0, 2, 0), v3(0, 0, 0));
        const uint32_t camera = add_camera(scene, v3(0, 1.4, 4), v3(0, 0, 0), 0.8, 0.1);
        ok(gn_scene_commit(scene));
        const float clips[] = {0, 0.09f, 0.18f, 100};
        for (int k = 0; k < 4; k++) {
            gn_visibility_desc desc = gn_visibility_desc_default();
            desc.point_light_clip = clips[k];
            frame f = render_desc(scene, camera, lamp, &desc, 80, 60);
            size_t wrong = 0, lit = 0;
            for (size_t i = 0; i < f.pixels; i++) {
                const vec p = position_at(f.g, i);
                if (f.g->surface[i] != 0 || length(p) > 2.5)
                    continue;
                const double edge = 2 * 0.5 / 1.3; /* of the second box's shadow */
                const double beyond = fmax(fabs(p.x), fabs(p.z)) - edge;
                if (fabs(beyond) < 0.01)
                    continue;
                const bool expected = k == 2 && beyond > 0;
                lit += expected;
                wrong += f.visibility[i] != expected;
            }
            few(wrong, f.pixels, 0, "clip %g", (double)clips[k]);
            assert_true(lit > 500 || k != 2);
            end(&f);
        }
        gn_scene_destroy(&scene);
    }
}

/* Instances ---------------------------------------------------------------------------------- */

/* A heap of leaves, of one mesh, turned, scaled, some mirrored. */
static gn_scene *make_leaves(bool moving, uint32_t *camera, uint32_t lights[2])
{
    random_state = 1; /* the same leaves each time */
    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 8, 0, GN_NONE), false);
    const uint32_t texture = add_texture(scene, 64, 64);
    const uint32_t material = add_masked(scene, texture, GN_ALPHA_MASK, 0.5, 1, GN_WRAP_REPEAT);
    const vec p[4] = {v3(-0.3, 0, 0.3), v3(0.3, 0, 0.3), v3(0.3, 0, -0.3), v3(-0.3, 0, -0.3)};
    gn_node_desc node = gn_node_desc_default();
    node.mesh = add_quad(scene, p, 1, material);
    for (int i = 0; i < 150; i++) {
        for (int axis = 0; axis < 3; axis++) {
            node.translation[axis] = (float)(1.5 * next_random() + (axis == 1 ? 1.7 : 0));
            node.scale[axis] = (float)(1 + 0.6 * next_random());
        }
        for (int axis = 0; axis < 4; axis++)
            node.rotation[axis] = (float)next_random();
        if (i % 3 == 0)
            node.scale[i % 9 / 3] *= -1;
        place_desc(scene, &node, moving);
    }
    *camera = add_camera(scene, v3(2, 3, 6), v3(0, 0.8, 0), 0.7, 0.1);
    lights[0] = add_sun(scene, v3(0.3, 1, 0.2));
    lights[1] = add_lamp(scene, v3(-0.5, 4, 0.5));
    ok(gn_scene_commit(scene));
    return scene;
}

static void test_instances_agree(void **state)
{
    (void)state;
    uint32_t camera, lights[2];
    gn_scene *flat = make_leaves(false, &camera, lights);
    gn_scene *instances = make_leaves(true, &camera, lights);
    for (int light = 0; light < 2; light++)
        for (size_t rule = 0; rule < RULES; rule++) {
            gn_visibility_desc desc = gn_visibility_desc_default();
            desc.method = method_of(rules[rule]);
            frame a = render_desc(flat, camera, lights[light], &desc, 320, 240);
            frame b = render_desc(instances, camera, lights[light], &desc, 320, 240);
            picture(&a, desc.method->name);
            size_t surfaces = 0;
            for (size_t i = 0; i < a.pixels; i++)
                surfaces += a.g->surface[i] != b.g->surface[i];
            few(surfaces, a.pixels, 1e-4, "other surfaces");
            few(count_different(a.visibility, b.visibility, a.pixels, 0.1f), a.pixels, 1e-4,
                "flat and instances, %s", desc.method->name);
            end(&a);
            end(&b);
        }
    gn_scene_destroy(&flat);
    gn_scene_destroy(&instances);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_camera),           cmocka_unit_test(test_rules),
        cmocka_unit_test(test_layers),           cmocka_unit_test(test_cutoff_one),
        cmocka_unit_test(test_point_light_clip), cmocka_unit_test(test_instances_agree),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
