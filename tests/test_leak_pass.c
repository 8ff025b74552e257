/* The pass of leak tracing against the oracle, bit for bit: walks through a yard, with every
 * switch, kernel, kind of light and place in the mask's texels. */
#include "shadow_map_testing.h"

#include "cpu/leak.h"
#include "leak_oracle.h"

enum { WIDTH = 150, HEIGHT = 83, PIXELS = WIDTH * HEIGHT, FRAMES = 14, CUT = 10 };

typedef enum light_kind { SUN, LAMP, SPOT } light_kind;

typedef struct walk_case {
    const char *method;
    light_kind light;
    gn_leak_kernel kernel;
    bool expand, remove, depth_test, balls;
    uint32_t texel_bytes, slot; /* in the mask */
} walk_case;

/* Planes of a frame. */
typedef struct planes {
    float visibility[PIXELS], test[PIXELS], traced[PIXELS], layer[PIXELS], leak_class[PIXELS];
    float ray[PIXELS], ray_traced[PIXELS];
    bool facing[PIXELS], held[PIXELS], moving[PIXELS];
    float expected[PIXELS], expected_traced[PIXELS], depth_before[PIXELS];
    uint8_t classes[2][PIXELS];
    uint8_t masks[2][PIXELS * 16];
} planes;

typedef struct walk {
    const walk_case *c;
    yard y;
    gn_view *view;
    gn_shadow_map *map;
    gn_visibility_desc desc;
    planes *p;
    gn_leak_counts sums;
    uint64_t rays;
    uint32_t uncertain; /* pixels whose texels cannot be told for sure */
    uint32_t moving;
} walk;

/* A fence with spots in which light is partly held back. */
static void add_fence(gn_scene *scene)
{
    uint8_t rgba[32 * 32 * 4];
    for (uint32_t i = 0; i < 32 * 32; i++) {
        memset(rgba + 4 * i, 128, 3);
        rgba[4 * i + 3] = (uint8_t)(127.5 + 127.0 * sin(0.8 * (i % 32)) * cos(0.5 * (i / 32)));
    }
    gn_texture_desc texture = gn_texture_desc_default();
    texture.width = texture.height = 32;
    texture.rgba = rgba;
    gn_material_desc material = gn_material_desc_default();
    ok(gn_scene_add_texture(scene, &texture, &material.texture));
    material.alpha_mode = GN_ALPHA_MASK;
    material.double_sided = true;
    uint32_t number;
    ok(gn_scene_add_material(scene, &material, &number));
    const vec corners[4] = {v3(-6, 0, 1), v3(6, 0, 3), v3(6, 2, 3), v3(-6, 2, 1)};
    place(scene, add_quad(scene, corners, 3, number), false);
}

static uint32_t light_of(const walk *w)
{
    return w->c->light == SUN ? w->y.sun : w->c->light == LAMP ? w->y.lamp : w->y.spot;
}

static walk begin_walk(const walk_case *c)
{
    walk w = {.c = c, .y = make_yard(c->balls), .p = calloc(1, sizeof *w.p)};
    assert_non_null(w.p);
    add_fence(w.y.scene);
    gn_view_desc view = gn_view_desc_default();
    view.width = WIDTH;
    view.height = HEIGHT;
    ok(gn_view_create(device, &view, &w.view));
    w.desc = gn_visibility_desc_default();
    w.desc.method = gn_method_find(c->method);
    assert_non_null(w.desc.method);
    w.desc.light = light_of(&w);
    w.desc.camera = w.y.camera;
    w.desc.leak.kernel = c->kernel;
    w.desc.leak.expand = c->expand;
    w.desc.leak.remove = c->remove;
    w.desc.leak.depth_test = c->depth_test ? GN_SWITCH_ON : GN_SWITCH_OFF;
    gn_map_desc map = small_desc();
    map.undrawn = c->light == SUN ? 1 : 0;
    map.refresh = 3;
    map.normal_bias = 0; /* is_moving() has none */
    w.map = make_map(&w.desc.method->map, &map);
    return w;
}

static void end_walk(walk *w)
{
    gn_shadow_map_destroy(&w->map);
    gn_view_destroy(&w->view);
    gn_scene_destroy(&w->y.scene);
    free(w->p);
}

/* Stands still, walks by parts of a pixel a frame, turns by many; balls fly. */
static const gn_gbuffer *draw_frame(walk *w, uint32_t n)
{
    const double walked = n < 3 ? 0 : 0.004 * (n - 2), turned = n < 8 ? 0 : 0.11 * (n - 7);
    look(&w->y, v3(2 + walked, 2.2, 9 - walked), v3(2 + 9 * sin(turned), 1, 9 - 9 * cos(turned)));
    for (uint32_t ball = 0; w->c->balls && ball < 2; ball++)
        move_ball(&w->y, ball, v3(2.5 + 0.08 * n - 1.5 * ball, 1.2 + 0.02 * n, 3 + 0.5 * ball));
    ok(gn_scene_commit(w->y.scene));
    ok(gn_view_trace_gbuffer(w->view, w->y.scene, w->y.camera));
    return gn_view_gbuffer(w->view);
}

/* What a ray finds wherever the light reaches a surface's front, by the plain pass for rays. */
static void find_rays(walk *w, const gn_gbuffer *g)
{
    gn_method rays = *gn_method_find("ray");
    rays.alpha = w->desc.method->alpha;
    gn_visibility_desc desc = w->desc;
    desc.method = &rays;
    gn_visibility_stats stats = {.traced = w->p->ray_traced};
    ok(gn_scene_visibility(w->y.scene, g, &desc, w->p->ray, &stats));
    for (size_t i = 0; i < PIXELS; i++)
        w->p->facing[i] = w->p->ray_traced[i] > 0.0f;
}

static void run_pass(walk *w, const gn_gbuffer *g, uint32_t n, gn_leak_job *job)
{
    planes *p = w->p;
    const uint32_t light = light_of(w);
    ok(gn_shadow_map_update(w->map, w->y.scene, light, w->y.camera, (float)WIDTH / HEIGHT, NULL));
    *job = (gn_leak_job){
        .map = {.gbuffer = g,
                .light = w->y.scene->lights[light],
                .frame = n,
                .visibility = p->visibility,
                .layer = p->layer},
        .rays = {.tracer = {.accel = w->y.scene->accel},
                 .gbuffer = g,
                 .light = w->y.scene->lights[light],
                 .visibility = p->visibility},
        .desc = w->desc.leak,
        .mask = {.before = n == 0 || n == CUT ? NULL : p->masks[(n + 1) % 2],
                 .now = p->masks[n % 2],
                 .texel_bytes = w->c->texel_bytes,
                 .first_bit = 3 * w->c->slot,
                 .depth_before = w->c->depth_test && n > 0 && n != CUT ? p->depth_before : NULL},
        .test = p->test,
        .traced = p->traced,
        .leak_class = p->leak_class};
    gn_shadow_map_fill_job(w->map, &job->map);
    ok(gn_cpu_leak(&device->cpu, job, &w->desc));
}

/* Is one of the four depths that are read a moving caster's? -1: the place is too near to where
 * other texels begin to tell. */
static int is_moving(const gn_map_job *job, const gn_gbuffer *g, size_t pixel, float layer_index)
{
    uint32_t l = 0;
    while (l < job->layer_count && (float)job->layers[l].index != layer_index)
        l++;
    if (l == job->layer_count)
        fail_msg("pixel %zu is said to be held by layer %g", pixel, (double)layer_index);
    const gn_map_layer *layer = &job->layers[l];
    if (!layer->depth[1])
        return 0;
    const gn_map_projection *m = &layer->projection;
    double at[3] = {0}; /* right, up, forward */
    for (int axis = 0; axis < 3; axis++) {
        const double d = (double)g->position[axis][pixel] - (double)m->origin[axis];
        at[0] += d * (double)m->right[axis];
        at[1] += d * (double)m->up[axis];
        at[2] += d * (double)m->forward[axis];
    }
    const double scale = 0.5 / ((double)m->extent * (m->perspective ? at[2] : 1.0));
    const double column = (0.5 + at[0] * scale) * m->resolution - 0.5;
    const double row = (0.5 - at[1] * scale) * m->resolution - 0.5;
    if (fabs(column - round(column)) < 2e-3 || fabs(row - round(row)) < 2e-3)
        return -1;
    bool moving = false;
    for (int corner = 0; corner < 4; corner++) {
        const size_t texel = ((size_t)row + (size_t)(corner >> 1)) * m->resolution +
                             (size_t)column + (size_t)(corner & 1);
        moving = moving || layer->depth[1][texel] < layer->depth[0][texel];
    }
    return moving;
}

static void find_moving(walk *w, const gn_map_job *job, const gn_gbuffer *g)
{
    planes *p = w->p;
    for (size_t i = 0; i < PIXELS; i++) {
        p->held[i] = p->layer[i] >= 0.0f;
        const int moving = p->held[i] ? is_moving(job, g, i, p->layer[i]) : 0;
        /* Where it cannot be told the pass has its way. */
        p->moving[i] = moving < 0 ? p->traced[i] > 0.0f : moving;
        w->uncertain += moving < 0;
        w->moving += moving > 0;
    }
}

static leak_oracle ask_oracle(walk *w, const gn_gbuffer *g, uint32_t n)
{
    planes *p = w->p;
    leak_oracle o = {.width = WIDTH,
                     .height = HEIGHT,
                     .masked = w->desc.method->mask,
                     .desc = w->desc.leak,
                     .frame = n,
                     .facing = p->facing,
                     .held = p->held,
                     .moving = p->moving,
                     .test = p->test,
                     .ray = p->ray,
                     .motion = {g->motion[0], g->motion[1], g->motion[2]},
                     .depth = g->depth,
                     .before = n == 0 || n == CUT ? NULL : p->classes[(n + 1) % 2],
                     .depth_before = p->depth_before,
                     .visibility = p->expected,
                     .traced = p->expected_traced,
                     .now = p->classes[n % 2]};
    leak_oracle_frame(&o);
    return o;
}

/* The three bits of a pixel, bit by bit. */
static uint32_t bits_of(const walk_case *c, const uint8_t *mask, size_t pixel)
{
    uint32_t bits = 0;
    for (uint32_t k = 0; k < 3; k++) {
        const uint32_t bit = 3 * c->slot + k;
        bits |= (uint32_t)(mask[pixel * c->texel_bytes + bit / 8] >> bit % 8 & 1) << k;
    }
    return bits;
}

/* Other lights' bits of `now` are as they were. */
static void check_other_bits(const walk_case *c, const uint8_t *mask, uint8_t fill, uint32_t n)
{
    for (size_t i = 0; i < (size_t)PIXELS * c->texel_bytes * 8; i++) {
        const size_t bit = i % (c->texel_bytes * 8);
        if (bit / 3 != c->slot && (mask[i / 8] >> i % 8 & 1) != (fill >> i % 8 & 1))
            fail_msg("frame %u: bit %zu of pixel %zu has changed", n, bit,
                     i / (c->texel_bytes * 8));
    }
}

static void compare(const walk *w, const leak_oracle *o, const gn_leak_job *job, uint32_t n)
{
    const planes *p = w->p;
    for (size_t i = 0; i < PIXELS; i++)
        if (p->visibility[i] != p->expected[i] || p->traced[i] != p->expected_traced[i] ||
            p->leak_class[i] != (float)o->now[i] || bits_of(w->c, p->masks[n % 2], i) != o->now[i])
            fail_msg("%s, frame %u, pixel %zu, %zu, test %a, layer %g: visibility %a, traced %g, "
                     "class %g, mask %u; expected %a, %g, %u",
                     w->c->method, n, i % WIDTH, i / WIDTH, (double)p->test[i], (double)p->layer[i],
                     (double)p->visibility[i], (double)p->traced[i], (double)p->leak_class[i],
                     bits_of(w->c, p->masks[n % 2], i), (double)p->expected[i],
                     (double)p->expected_traced[i], o->now[i]);
    const gn_leak_counts *a = &job->counts, *b = &o->counts;
    if (a->tested != b->tested || a->unsure != b->unsure || a->expanded != b->expanded ||
        a->removed != b->removed || a->lost != b->lost || a->unheld != b->unheld ||
        job->traced_count != o->rays)
        fail_msg("%s, frame %u: tested %zu, unsure %zu, expanded %zu, removed %zu, lost %zu, "
                 "unheld %zu, rays %zu; expected %zu, %zu, %zu, %zu, %zu, %zu, %zu",
                 w->c->method, n, (size_t)a->tested, (size_t)a->unsure, (size_t)a->expanded,
                 (size_t)a->removed, (size_t)a->lost, (size_t)a->unheld, (size_t)job->traced_count,
                 (size_t)b->tested, (size_t)b->unsure, (size_t)b->expanded, (size_t)b->removed,
                 (size_t)b->lost, (size_t)b->unheld, (size_t)o->rays);
}

static void check_walk(const walk_case *c)
{
    walk w = begin_walk(c);
    for (uint32_t n = 0; n < FRAMES; n++) {
        const uint8_t fill = (uint8_t)(0x5a + 37 * n);
        memset(w.p->masks[n % 2], fill, sizeof w.p->masks[0]);
        const gn_gbuffer *g = draw_frame(&w, n);
        find_rays(&w, g);
        gn_leak_job job;
        run_pass(&w, g, n, &job);
        find_moving(&w, &job.map, g);
        const leak_oracle o = ask_oracle(&w, g, n);
        compare(&w, &o, &job, n);
        check_other_bits(c, w.p->masks[n % 2], fill, n);
        memcpy(w.p->depth_before, g->depth, sizeof w.p->depth_before);
        w.sums.unsure += o.counts.unsure;
        w.sums.expanded += o.counts.expanded;
        w.sums.removed += o.counts.removed;
        w.sums.lost += o.counts.lost;
        w.sums.unheld += o.counts.unheld;
        w.rays += o.rays;
    }
    print_message("%-10s light %d, kernel %d: of %d pixels unsure %zu, expanded %zu, removed %zu, "
                  "lost %zu, unheld %zu, moving %u, rays %zu\n",
                  c->method, c->light, c->kernel, FRAMES * PIXELS, (size_t)w.sums.unsure,
                  (size_t)w.sums.expanded, (size_t)w.sums.removed, (size_t)w.sums.lost,
                  (size_t)w.sums.unheld, w.moving, (size_t)w.rays);
    /* The walk has met what it should. */
    const bool masked = w.desc.method->mask;
    assert_true(w.sums.unsure > 100 && w.sums.unheld > 100 && w.rays > 100);
    assert_true((w.sums.expanded > 50) == (masked && c->expand));
    assert_true((w.sums.removed > 10) == (masked && c->remove));
    assert_true((w.sums.lost > 100) == masked);
    assert_true((w.moving > 0) == c->balls);
    assert_true(w.uncertain < FRAMES * PIXELS / 50);
    end_walk(&w);
}

static void test_suns(void **state)
{
    (void)state;
    const walk_case cases[] = {
        {"lt-vsm", SUN, GN_LEAK_GATHER, true, true, false, true, 1, 0},
        {"lt-vsm", SUN, GN_LEAK_FULL, true, true, true, true, 2, 2},
        {"lt-evsm", SUN, GN_LEAK_GATHER, true, true, true, false, 4, 5},
        {"lt-msm", SUN, GN_LEAK_FULL, true, true, true, true, 16, 41},
        {"hybrid-pcf", SUN, GN_LEAK_FULL, true, true, false, true, 1, 0},
        {"ltt-vsm", SUN, GN_LEAK_GATHER, true, true, false, false, 1, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_walk(&cases[i]);
}

static void test_lamps(void **state)
{
    (void)state;
    const walk_case cases[] = {
        {"lt-vsm", LAMP, GN_LEAK_GATHER, true, true, false, true, 8, 20},
        {"lt-esm", LAMP, GN_LEAK_FULL, true, true, true, true, 16, 31},
        {"lt-vsm", SPOT, GN_LEAK_GATHER, true, true, true, true, 2, 4},
        {"lt-nlmsm64", SPOT, GN_LEAK_GATHER, true, true, true, false, 8, 15},
        {"lt-evsm", SPOT, GN_LEAK_FULL, true, true, false, true, 4, 9},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_walk(&cases[i]);
}

static void test_switches(void **state)
{
    (void)state;
    const walk_case cases[] = {
        {"lt-vsm", SUN, GN_LEAK_GATHER, false, true, false, true, 1, 0},
        {"lt-vsm", SUN, GN_LEAK_FULL, true, false, false, true, 1, 1},
        {"lt-evsm", LAMP, GN_LEAK_GATHER, false, false, true, true, 8, 7},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_walk(&cases[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_suns),
        cmocka_unit_test(test_lamps),
        cmocka_unit_test(test_switches),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
