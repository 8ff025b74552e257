/* The light buffer finds the visibility that the tree finds: in all scenes, for lights of all kinds
 * and all alpha rules; in any unit, for any number of threads and any instruction set the same
 * bits; within any limit of memory. */
#include "light_buffer_testing.h"

#define WIDTH  192
#define HEIGHT 108
#define PIXELS (WIDTH * HEIGHT)

/* A sun, a lamp and a spot light besides the scene's own, over the middle of what it holds. */
static void add_lights(gn_scene *scene)
{
    const float *low = scene->bounds_min, *high = scene->bounds_max;
    const vec size = v3((double)high[0] - (double)low[0], (double)high[1] - (double)low[1],
                        (double)high[2] - (double)low[2]);
    const vec floor =
        v3((double)low[0] + 0.5 * size.x, (double)low[1], (double)low[2] + 0.5 * size.z);
    add_sun(scene, v3(0.3, 1, -0.4));
    add_lamp(scene, add(floor, v3(0.11 * size.x, 0.8 * size.y, -0.07 * size.z)));
    add_spot(scene, add(floor, v3(-0.2 * size.x, 1.1 * size.y, 0.1 * size.z)), floor, 0.7);
    ok(gn_scene_commit(scene));
}

/* All lights and rules of one view. */
static void check_view(gn_scene *scene, const gn_gbuffer *g, uint32_t camera, const char *name)
{
    tally sum = {0};
    for (uint32_t light = 0; light < scene->light_count; light++) {
        gn_history *history;
        ok(gn_history_create(device, &history));
        for (size_t m = 0; m < sizeof ray_methods / sizeof *ray_methods; m++) {
            gn_visibility_desc desc = ray_desc(ray_methods[m], light, GN_TRACER_AUTO);
            desc.camera = camera;
            desc.history = history;
            compare_tracers(scene, g, &desc, NULL, &sum, name);
        }
        gn_history_destroy(&history);
    }
    print_tally(name, &sum);
    assert_true(sum.rays > PIXELS && sum.tree_rays < sum.rays / 20 && sum.refused == 0);
}

static void test_scenes(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double scale, unit;
    } cases[] = {{"grove", 0.02, 1},  {"court", 0.1, 1}, {"leafbox", 0.2, 1},
                 {"railing", 0.3, 1}, {"edges", 0.3, 1}, {"leafbox", 0.1, 1e-3},
                 {"court", 0.05, 1e3}};
    gn_view *view = new_view(WIDTH, HEIGHT);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        gn_scene *scene = built_in(cases[k].name, cases[k].scale, cases[k].unit);
        add_lights(scene);
        char name[64];
        snprintf(name, sizeof name, "%s * %g", cases[k].name, cases[k].unit);
        const uint32_t camera = scene->camera_count - 1;
        check_view(scene, look(view, scene, camera, 1), camera, name);
        gn_scene_destroy(&scene);
    }
    gn_view_destroy(&view);
}

/* The scenes of GNOMON_SCENES, every camera. */
static void test_real_scenes(void **state)
{
    (void)state;
    const char *folder = getenv("GNOMON_SCENES");
    if (!folder)
        skip();
    static const char *const names[] = {"grove", "court", "leafbox"};
    gn_view *view = new_view(WIDTH, HEIGHT);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s.glb", folder, names[k]);
        gn_scene *scene;
        ok(gn_scene_load(device, path, &scene));
        ok(gn_scene_commit(scene));
        for (uint32_t camera = 0; camera < scene->camera_count; camera++) {
            char name[64];
            snprintf(name, sizeof name, "%s, camera %u", names[k], camera);
            check_view(scene, look(view, scene, camera, 1), camera, name);
        }
        gn_scene_destroy(&scene);
    }
    gn_view_destroy(&view);
}

/* Lights --------------------------------------------------------------------------------------- */

/* A box, a sphere and a wall on a floor, and what the camera sees of them. */
typedef struct yard {
    gn_scene *scene;
    gn_view *view;
    uint32_t camera;
} yard;

static yard new_yard(double size)
{
    yard y = {.scene = new_scene()};
    place(y.scene, add_floor(y.scene, 10 * size, 0, GN_NONE), false);
    place(y.scene,
          add_box(y.scene, v3(-2 * size, 0, -1 * size), v3(-1 * size, 2 * size, size), GN_NONE),
          false);
    place(y.scene, add_sphere(y.scene, v3(size, 1.5 * size, 0), size, 12, GN_NONE), false);
    const vec wall[4] = {v3(-3 * size, 0, -3 * size), v3(3 * size, 0, -3 * size),
                         v3(3 * size, 3 * size, -3 * size), v3(-3 * size, 3 * size, -3 * size)};
    place(y.scene, add_quad(y.scene, wall, 1, GN_NONE), false);
    y.camera =
        add_camera(y.scene, v3(5 * size, 6 * size, 9 * size), v3(0, size, 0), 0.9, 0.1 * size);
    y.view = new_view(WIDTH, HEIGHT);
    return y;
}

static void end_yard(yard *y)
{
    gn_view_destroy(&y->view);
    gn_scene_destroy(&y->scene);
}

/* Suns straight above and along axes, where faces of the light's view are seen edge-on; lamps close
 * to things and among them; spot lights from narrow to almost half of space. */
static void test_lights(void **state)
{
    (void)state;
    static const double sizes[] = {1, 1e-3, 1e3};
    static const vec suns[] = {{0, 1, 0}, {1, 0, 0},     {0, 0, 1},   {-1, 1, 0},
                               {1, 1, 1}, {0, 1, 0.001}, {1, 0.01, 0}};
    static const vec lamps[] = {{0, 5, 0}, {-0.9, 0.5, 0.3}, {0.2, 1, 2}, {0, 0.01, 1}};
    tally sum = {0};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        const double size = sizes[k];
        yard y = new_yard(size);
        for (size_t i = 0; i < sizeof suns / sizeof *suns; i++)
            add_sun(y.scene, suns[i]);
        for (size_t i = 0; i < sizeof lamps / sizeof *lamps; i++)
            add_lamp(y.scene, mul(lamps[i], size));
        for (int degrees = 20; degrees <= 170; degrees += 30)
            add_spot(y.scene, mul(v3(1, 5, 3), size), v3(0, 0, 0), degrees * atan(1) / 90);
        add_spot(y.scene, mul(v3(0, 4, 0), size), v3(0, 0, 0), 0.9);
        const gn_gbuffer *g = look(y.view, y.scene, y.camera, 0);
        for (uint32_t light = 0; light < y.scene->light_count; light++) {
            const gn_visibility_desc desc = ray_desc("ray", light, GN_TRACER_AUTO);
            compare_tracers(y.scene, g, &desc, NULL, &sum, "yard");
        }
        end_yard(&y);
    }
    print_tally("suns, lamps, spot lights", &sum);
    assert_true(sum.rays > 10 * PIXELS && sum.tree_rays < sum.rays / 20);
}

/* A lamp in a box: dark, but where the box is nearer to it than the clip distance. */
static void test_clip(void **state)
{
    (void)state;
    yard y = new_yard(1);
    place(y.scene, add_box(y.scene, v3(-0.1, 4.9, -0.1), v3(0.1, 5.1, 0.1), GN_NONE), false);
    const uint32_t lamp = add_lamp(y.scene, v3(0.01, 5.02, 0.03));
    const gn_gbuffer *g = look(y.view, y.scene, y.camera, 0);
    static const float clips[] = {0, 0.05f, 0.11f, 0.14f, 0.3f, 2, 100};
    float *visibility = calloc(PIXELS, sizeof *visibility);
    assert_non_null(visibility);
    tally sum = {0};
    for (size_t i = 0; i < sizeof clips / sizeof *clips; i++) {
        gn_visibility_desc desc = ray_desc("ray", lamp, GN_TRACER_AUTO);
        desc.point_light_clip = clips[i];
        compare_tracers(y.scene, g, &desc, visibility, &sum, "clip");
        size_t lit = 0;
        for (size_t p = 0; p < PIXELS; p++)
            lit += visibility[p] > 0;
        print_message("clip %g m: %zu pixels lit\n", (double)clips[i], lit);
        assert_true(clips[i] < 0.07f || clips[i] > 10 ? lit == 0 : true);
        assert_true(clips[i] >= 0.3f && clips[i] < 10 ? lit > PIXELS / 10 : true);
    }
    free(visibility);
    end_yard(&y);
}

/* Memory --------------------------------------------------------------------------------------- */

static void test_limit(void **state)
{
    (void)state;
    gn_scene *scene = built_in("leafbox", 0.5, 1);
    gn_view *view = new_view(WIDTH, HEIGHT);
    const gn_gbuffer *g = look(view, scene, 0, 0);
    static const size_t limits[] = {0, 100000, 1000000, (size_t)512 << 20};
    uint64_t before = UINT64_MAX;
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        tally sum = {0};
        gn_visibility_desc desc = ray_desc("ray", 0, GN_TRACER_AUTO);
        desc.light_buffer_limit = limits[i];
        const gn_visibility_stats stats =
            compare_tracers(scene, g, &desc, NULL, &sum, "limit of memory");
        const gn_light_buffer_info *info = &stats.light_buffer;
        print_message(
            "limit %zu: %zu bytes, %u tiles, %u refused, the tree traced %zu of %zu rays\n",
            limits[i], info->bytes, info->tiles, info->refused, (size_t)info->tree_rays,
            (size_t)stats.rays);
        assert_true(info->bytes <= limits[i] && info->tree_rays <= before);
        assert_true((info->refused > 0) == (limits[i] < 10000000));
        assert_true((info->tree_rays > 0) == (info->refused > 0));
        before = info->tree_rays;
    }
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
}

/* The picture of list lengths has the tiles, and as many triangles as are asked. */
static void test_draw(void **state)
{
    (void)state;
    enum { SIZE = 128 };
    yard y = new_yard(1);
    const uint32_t sun = add_sun(y.scene, v3(0.4, 1, 0.3)), lamp = add_lamp(y.scene, v3(0, 5, 1));
    const gn_gbuffer *g = look(y.view, y.scene, y.camera, 0);
    gn_history *history;
    ok(gn_history_create(device, &history));
    float *visibility = calloc(PIXELS * 2, sizeof *visibility), *entries = visibility + PIXELS;
    float *lengths = calloc((size_t)SIZE * SIZE, sizeof *lengths), extent = -1;
    assert_true(visibility && lengths);
    assert_int_equal(gn_history_draw_light_buffer(history, sun, 0, SIZE, lengths, &extent),
                     GN_ERROR_INVALID_ARGUMENT);
    for (uint32_t light = sun; light <= lamp; light++) {
        gn_visibility_desc desc = ray_desc("ray", light, GN_TRACER_LIGHT_BUFFER);
        desc.history = history;
        gn_visibility_stats stats = {.entries = entries};
        ok(gn_scene_visibility(y.scene, g, &desc, visibility, &stats));
        float most_asked = 0, most = -1;
        for (size_t p = 0; p < PIXELS; p++)
            most_asked = fmaxf(most_asked, entries[p]);
        size_t there = 0;
        for (uint32_t face = 0; face < (light == sun ? 1u : 6u); face++) {
            extent = -1;
            ok(gn_history_draw_light_buffer(history, light, face, SIZE, lengths, &extent));
            assert_true(light == sun ? extent > 1 && extent < 100 : extent == 2);
            for (size_t p = 0; p < (size_t)SIZE * SIZE; p++) {
                assert_true(lengths[p] >= -1);
                there += lengths[p] >= 0;
                most = fmaxf(most, lengths[p]);
            }
        }
        print_message("light %u: %zu cells drawn, up to %g triangles; a ray asks up to %g\n", light,
                      there, (double)most, (double)most_asked);
        assert_true(there > 0 && most > 0 && most_asked > 0);
    }
    gn_history_destroy(&history);
    free(visibility);
    free(lengths);
    end_yard(&y);
}

/* Machines ------------------------------------------------------------------------------------- */

enum { VALUES = 2 * 3 * 2 * 160 * 90 };

/* Visibility and list lengths of two frames, three lights; NULL where the machine cannot. */
static float *sequence(uint32_t threads, gn_isa isa, gn_light_buffer_info *info)
{
    enum { SMALL = 160 * 90 };
    gn_device *shared = device;
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = threads;
    desc.isa = isa;
    if (gn_device_create(&desc, &device) != GN_OK) {
        device = shared;
        return NULL;
    }
    float *planes = calloc(VALUES, sizeof *planes), *at = planes;
    assert_non_null(planes);
    gn_scene *scene = built_in("court", 0.1, 1);
    add_lights(scene);
    gn_view *view = new_view(160, 90);
    gn_history *history;
    ok(gn_history_create(device, &history));
    for (int k = 0; k < 2; k++) {
        const gn_gbuffer *g = look(view, scene, 0, 4 + k / 10.0);
        for (uint32_t light = 0; light < 3; light++) {
            gn_visibility_desc d =
                ray_desc("ray", scene->light_count - 3 + light, GN_TRACER_LIGHT_BUFFER);
            d.history = history;
            gn_visibility_stats stats = {.entries = at + SMALL};
            ok(gn_scene_visibility(scene, g, &d, at, &stats));
            at += 2 * SMALL;
            *info = stats.light_buffer;
        }
    }
    info->build_ms = 0;
    gn_history_destroy(&history);
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
    gn_device_destroy(&device);
    device = shared;
    return planes;
}

static void test_machines(void **state)
{
    (void)state;
    gn_light_buffer_info info, other_info;
    float *one = sequence(1, GN_ISA_AUTO, &info);
    assert_non_null(one);
    static const struct {
        uint32_t threads;
        gn_isa isa;
    } others[] = {{2, GN_ISA_AUTO},
                  {3, GN_ISA_AUTO},
                  {2, GN_ISA_SCALAR},
                  {2, GN_ISA_AVX2},
                  {2, GN_ISA_AVX512}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        float *other = sequence(others[i].threads, others[i].isa, &other_info);
        if (!other)
            continue;
        const size_t different = count_different(one, other, VALUES, 0.0f);
        print_message("%u threads, instruction set %d: %zu of %d values differ\n",
                      others[i].threads, (int)others[i].isa, different, (int)VALUES);
        assert_memory_equal(one, other, VALUES * sizeof *one);
        assert_int_equal(info.tiles, other_info.tiles);
        assert_int_equal(info.entries, other_info.entries);
        assert_int_equal(info.bytes, other_info.bytes);
        free(other);
    }
    free(one);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes),  cmocka_unit_test(test_real_scenes),
        cmocka_unit_test(test_lights),  cmocka_unit_test(test_clip),
        cmocka_unit_test(test_limit),   cmocka_unit_test(test_draw),
        cmocka_unit_test(test_machines)};
    return cmocka_run_group_tests(tests, open_device, close_device);
}
