/* The light buffer from frame to frame: what a history keeps makes no difference, to the bit, while
 * casters, cameras and lights move and nodes are added; and it goes on finding what the tree finds.
 */
#include "light_buffer_testing.h"

#define WIDTH  112
#define HEIGHT 63
#define PIXELS (WIDTH * HEIGHT)

typedef struct film {
    gn_scene *scene;
    gn_view *view;
    gn_history *history;
    uint32_t camera, first_light, lights;
    const char *method;
    float *kept, *fresh, *kept_entries, *fresh_entries;
    tally sum;
    uint64_t built; /* tiles, static casters */
    size_t changed; /* pixels of the last light, since the frame before */
} film;

static film new_film(gn_scene *scene, const char *method)
{
    film f = {.scene = scene, .view = new_view(WIDTH, HEIGHT), .method = method};
    ok(gn_history_create(device, &f.history));
    f.kept = calloc((size_t)PIXELS * 4, sizeof *f.kept);
    assert_non_null(f.kept);
    f.fresh = f.kept + PIXELS;
    f.kept_entries = f.fresh + PIXELS;
    f.fresh_entries = f.kept_entries + PIXELS;
    f.lights = scene->light_count;
    return f;
}

static void end_film(film *f)
{
    gn_history_destroy(&f->history);
    gn_view_destroy(&f->view);
    gn_scene_destroy(&f->scene);
    free(f->kept);
}

/* One frame by the history, by none, and by the tree. */
static void shoot(film *f, double seconds, const char *what)
{
    const gn_gbuffer *g = look(f->view, f->scene, f->camera, seconds);
    for (uint32_t light = f->first_light; light < f->first_light + f->lights; light++) {
        gn_visibility_desc desc = ray_desc(f->method, light, GN_TRACER_LIGHT_BUFFER);
        desc.camera = f->camera;
        gn_visibility_stats stats = {.entries = f->fresh_entries};
        ok(gn_scene_visibility(f->scene, g, &desc, f->fresh, &stats));
        desc.history = f->history;
        gn_visibility_stats kept = {.entries = f->kept_entries};
        f->changed = count_different(f->kept, f->fresh, PIXELS, 0.5f);
        ok(gn_scene_visibility(f->scene, g, &desc, f->kept, &kept));
        const size_t different = count_different(f->kept, f->fresh, PIXELS, 0);
        if (memcmp(f->kept, f->fresh, PIXELS * sizeof *f->kept) != 0)
            fail_msg("%s, light %u: %zu pixels are not what they are without a history", what,
                     light, different);
        assert_memory_equal(f->kept_entries, f->fresh_entries, PIXELS * sizeof *f->kept);
        assert_int_equal(kept.rays, stats.rays);
        f->built += kept.light_buffer.built;
        compare_tracers(f->scene, g, &desc, NULL, &f->sum, what);
    }
}

/* Tiles that a frame built. */
static uint64_t built_by(film *f, double seconds, const char *what)
{
    const uint64_t before = f->built;
    shoot(f, seconds, what);
    return f->built - before;
}

static vec middle(const gn_scene *scene)
{
    const float *low = scene->bounds_min, *high = scene->bounds_max;
    return v3(0.5 * ((double)low[0] + (double)high[0]), (double)low[1],
              0.5 * ((double)low[2] + (double)high[2]));
}

static void move_node(gn_scene *scene, uint32_t node, vec from, vec to, double scale)
{
    float matrix[16];
    aim(from, to, matrix);
    for (int i = 0; i < 12; i++)
        matrix[i] *= (float)scale;
    ok(gn_scene_set_node_matrix(scene, node, matrix));
}

/* Lights turn and move. What stands still, lights and casters, is kept. */
static void test_lights_move(void **state)
{
    (void)state;
    gn_scene *scene = built_in("court", 0.03, 1);
    film f = new_film(scene, "ray");
    const vec at = middle(scene);
    f.first_light = add_sun(scene, v3(0.4, 1, 0.3));
    const uint32_t sun = scene->node_count - 1;
    add_lamp(scene, add(at, v3(3, 6, 2)));
    const uint32_t lamp = scene->node_count - 1;
    add_spot(scene, add(at, v3(-4, 9, 3)), at, 0.8);
    const uint32_t spot = scene->node_count - 1;
    f.lights = 3;
    assert_true(built_by(&f, 0, "first frame") > 0);
    assert_int_equal(built_by(&f, 0, "the same once more"), 0);
    for (int k = 1; k < 3; k++) {
        move_node(scene, sun, v3(0.4 + 0.01 * k, 1, 0.3), v3(0, 0, 0), 1);
        assert_true(built_by(&f, 0, "sun turned") > 0);
        move_node(scene, lamp, add(at, v3(3 + 0.1 * k, 6, 2)), at, 1);
        assert_true(built_by(&f, 0, "lamp moved") > 0);
        move_node(scene, spot, add(at, v3(-4, 9, 3)), add(at, v3(0.1 * k, 0, 0)), 1);
        assert_true(built_by(&f, 0, "spot light turned") > 0);
        assert_int_equal(built_by(&f, 0, "nothing moved"), 0);
    }
    print_tally("lights move", &f.sum);
    end_film(&f);
}

/* The camera walks, jumps and is another; back where it was, all tiles are there. */
static void test_camera_moves(void **state)
{
    (void)state;
    gn_scene *scene = built_in("court", 0.03, 1);
    add_lamp(scene, add(middle(scene), v3(3, 6, 2)));
    film f = new_film(scene, "ray");
    f.camera = gn_scene_find_camera(scene, "CamWalk");
    assert_true(f.camera != GN_NONE);
    for (int k = 0; k < 4; k++)
        shoot(&f, k / 30.0, "walk");
    shoot(&f, 3, "jump");
    f.camera = 0;
    const uint64_t there = built_by(&f, 0, "another camera");
    f.camera = gn_scene_find_camera(scene, "CamWalk");
    shoot(&f, 3, "and back");
    f.camera = 0;
    const uint64_t again = built_by(&f, 0, "another camera again");
    print_message("another camera built %zu tiles, again %zu\n", (size_t)there, (size_t)again);
    assert_int_equal(again, 0);
    print_tally("camera moves", &f.sum);
    end_film(&f);
}

/* Casters move, opaque and masked, turned, stretched and mirrored, far and near; static tiles
 * stay. */
static void test_casters_move(void **state)
{
    (void)state;
    static const struct {
        const char *scene, *method;
    } cases[] = {{"leafbox", "ray-saturate"}, {"railing", "ray-mip0"}}; /* a lamp, a sun */
    for (size_t m = 0; m < 2; m++) {
        gn_scene *scene = built_in(cases[m].scene, 0.1, 1);
        const vec at = middle(scene);
        uint32_t nodes[3];
        gn_node_desc desc = gn_node_desc_default();
        for (uint32_t i = 0; i < 3; i++) {
            desc.mesh = i % scene->mesh_count;
            desc.scale[0] = i == 1 ? -0.5f : 0.3f;
            desc.scale[2] = i == 2 ? -0.7f : 0.4f;
            ok(gn_scene_add_node(scene, &desc, &nodes[i]));
        }
        ok(gn_scene_commit(scene));
        film f = new_film(scene, cases[m].method);
        f.lights = 1;
        shoot(&f, 0, "first frame");
        uint64_t built = 0;
        size_t changed = 0;
        for (int k = 0; k < 5; k++) {
            const double turn = 0.3 * k;
            for (uint32_t i = 0; i < 3; i++) {
                const vec place =
                    add(at, v3(0.8 * cos(turn + 2 * i), 0.5 + 0.3 * i, 0.8 * sin(turn + 2 * i)));
                move_node(scene, nodes[i], place, add(place, v3(cos(turn), 0.1 * i, sin(turn))),
                          k == 3 ? 20 : 0.25);
            }
            built += built_by(&f, 0, "casters move");
            changed += f.changed;
        }
        /* A node scaled to nothing, and back. */
        for (uint32_t i = 0; i < 3; i++)
            move_node(scene, nodes[i], at, add(at, v3(1, 0, 0)), 0);
        shoot(&f, 0, "casters vanish");
        for (uint32_t i = 0; i < 3; i++)
            move_node(scene, nodes[i], add(at, v3(0, 1, 0)), add(at, v3(1, 1, 0)), 0.3);
        shoot(&f, 0, "casters come back");
        print_message("%zu static tiles built while casters moved, %zu pixels changed\n",
                      (size_t)built, changed);
        assert_true(changed > 300);
        print_tally(cases[m].scene, &f.sum);
        end_film(&f);
    }
}

/* Nodes and meshes are added between frames. */
static void test_nodes_added(void **state)
{
    (void)state;
    gn_scene *scene = built_in("edges", 0.05, 1);
    const vec at = middle(scene);
    add_lamp(scene, add(at, v3(1, 5, 1)));
    film f = new_film(scene, "ray");
    shoot(&f, 0, "first frame");
    for (int k = 0; k < 3; k++) {
        gn_node_desc desc = gn_node_desc_default();
        desc.mesh = k == 0 ? add_box(scene, v3(-1, 0, -1), v3(1, 1, 1), GN_NONE) : 0;
        desc.translation[0] = (float)at.x + (float)k;
        desc.translation[1] = (float)at.y + 2;
        desc.translation[2] = (float)at.z;
        place_desc(scene, &desc, k == 2);
        shoot(&f, 0, "a node is added");
    }
    gn_history_cut(f.history);
    shoot(&f, 0, "after a cut");
    gn_history_reset(f.history);
    shoot(&f, 0, "after a reset");
    print_tally("nodes added", &f.sum);
    end_film(&f);
}

/* Leak tracing: its rays by either tracer, frame after frame. */
static void test_leak_tracing(void **state)
{
    (void)state;
    static const char *const methods[] = {"lt-vsm", "hybrid-pcf"};
    for (size_t m = 0; m < 2; m++) {
        gn_scene *scene = built_in("leafbox", 0.2, 1);
        add_sun(scene, v3(0.3, 1, 0.5));
        film f = new_film(scene, methods[m]);
        gn_history *tree;
        ok(gn_history_create(device, &tree));
        size_t different = 0, pixels = 0;
        for (uint32_t k = 0; k < 4; k++) {
            const gn_gbuffer *g = look(f.view, scene, 0, k / 30.0);
            for (uint32_t light = 0; light < scene->light_count; light++) {
                gn_visibility_desc desc = ray_desc(f.method, light, GN_TRACER_LIGHT_BUFFER);
                desc.map.resolution = 256;
                desc.frame = k;
                desc.history = f.history;
                gn_visibility_stats stats = {0};
                ok(gn_scene_visibility(scene, g, &desc, f.kept, &stats));
                assert_int_equal(stats.tracer, GN_TRACER_LIGHT_BUFFER);
                assert_true(k < 2 || stats.light_buffer.tree_rays < stats.rays / 4 + 16);
                desc.tracer = GN_TRACER_BVH;
                desc.history = tree;
                ok(gn_scene_visibility(scene, g, &desc, f.fresh, NULL));
                different += count_different(f.kept, f.fresh, PIXELS, 0.5f);
                pixels += PIXELS;
            }
        }
        print_message("%s: %zu of %zu pixels differ\n", f.method, different, pixels);
        few(different, pixels, 1e-4, "%s", f.method);
        gn_history_destroy(&tree);
        end_film(&f);
    }
}

/* Casters and cameras move while memory is short: tiles make room for others, and some are left to
 * the tree. */
static void test_short_of_memory(void **state)
{
    (void)state;
    gn_scene *scene = built_in("court", 0.1, 1);
    gn_view *view = new_view(WIDTH, HEIGHT);
    const uint32_t cameras[2] = {0, gn_scene_find_camera(scene, "CamWalk")};
    bool full = false;
    for (size_t limit = 50000; limit < 50000000; limit *= 2) {
        gn_history *history;
        ok(gn_history_create(device, &history));
        tally sum = {0};
        size_t most = 0;
        for (uint32_t k = 0; k < 8; k++) {
            const gn_gbuffer *g = look(view, scene, cameras[k / 2 % 2], k);
            gn_visibility_desc desc = ray_desc("ray", 0, GN_TRACER_LIGHT_BUFFER);
            desc.history = history;
            desc.light_buffer_limit = limit;
            const gn_visibility_stats stats =
                compare_tracers(scene, g, &desc, NULL, &sum, "short of memory");
            assert_true(stats.light_buffer.bytes <= limit);
            most = stats.light_buffer.bytes > most ? stats.light_buffer.bytes : most;
        }
        print_message("limit %zu: at most %zu bytes, %zu of %zu rays by the tree\n", limit, most,
                      (size_t)sum.tree_rays, (size_t)sum.rays);
        assert_true(limit > 50000 || sum.tree_rays > 0);
        full |= sum.tree_rays == 0;
        gn_history_destroy(&history);
    }
    assert_true(full);
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
}

/* What the automatic choice takes for pictures of a size. */
static gn_tracer_kind choice(gn_scene *scene, const char *method, uint32_t width, uint32_t height)
{
    gn_view *view = new_view(width, height);
    gn_history *history;
    ok(gn_history_create(device, &history));
    const gn_gbuffer *g = look(view, scene, 0, 0);
    gn_visibility_desc desc = ray_desc(method, 0, GN_TRACER_AUTO);
    float *visibility = calloc((size_t)width * height, sizeof *visibility);
    assert_non_null(visibility);
    gn_visibility_stats stats = {0};
    ok(gn_scene_visibility(scene, g, &desc, visibility, &stats));
    assert_int_equal(stats.tracer, GN_TRACER_BVH); /* no history keeps a light buffer */
    desc.history = history;
    stats = (gn_visibility_stats){0};
    ok(gn_scene_visibility(scene, g, &desc, visibility, &stats));
    free(visibility);
    gn_history_destroy(&history);
    gn_view_destroy(&view);
    return stats.tracer;
}

/* Moving casters are worth their lists where pictures are large enough. */
static void test_choice(void **state)
{
    (void)state;
    gn_scene *court = built_in("court", 1, 1), *box = built_in("leafbox", 0.5, 1);
    assert_int_equal(choice(court, "ray", 96, 54), GN_TRACER_BVH);
    assert_int_equal(choice(court, "ray", 640, 360), GN_TRACER_LIGHT_BUFFER);
    assert_int_equal(choice(court, "lt-vsm", 640, 360), GN_TRACER_BVH);
    /* Nothing moves there. */
    assert_int_equal(choice(box, "ray", 96, 54), GN_TRACER_LIGHT_BUFFER);
    gn_scene_destroy(&court);
    gn_scene_destroy(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lights_move),  cmocka_unit_test(test_camera_moves),
        cmocka_unit_test(test_casters_move), cmocka_unit_test(test_nodes_added),
        cmocka_unit_test(test_leak_tracing), cmocka_unit_test(test_short_of_memory),
        cmocka_unit_test(test_choice)};
    return cmocka_run_group_tests(tests, open_device, close_device);
}
