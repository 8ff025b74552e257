/* Leak tracing while things change: a moving caster, a turning sun, cuts, sizes, lights of all
 * kinds, many of them; the same in any unit, for any number of threads and instruction set. Counts
 * are of pixels whose visibility is off by more than a half. */
#include "leak_testing.h"

#define WIDTH  320
#define HEIGHT 180
#define PIXELS (WIDTH * HEIGHT)

static stage court(void)
{
    return new_stage(built_in("court", 0.3, 1), "CamCourt", WIDTH, HEIGHT, 512);
}

/* Moving casters ------------------------------------------------------------------------------ */

/* The siege tower rolls through the picture: where its shadow was in the last frames, or is now,
 * nothing stays behind and nothing is missing. */
static void test_moving_caster(void **state)
{
    (void)state;
    enum { WARM = 4, FRAMES = 12, AGE = 8 };
    static const char *const names[] = {"lt-vsm", "lt-evsm"};
    stage s = court();
    s.map.refresh = 1;
    run runs[2];
    tally tallies[2] = {{0}}, moved[2] = {{0}};
    uint8_t *age = calloc(PIXELS, 1); /* frames for which a change is remembered */
    assert_non_null(age);
    for (int k = 0; k < 2; k++)
        runs[k] = new_run(&s, names[k]);
    size_t pixels = 0;
    for (s.frame = 0; s.frame < WARM + FRAMES; s.frame++) {
        show(&s, 4 + s.frame / 30.0);
        pixels = 0;
        for (size_t i = 0; i < PIXELS; i++) {
            const bool changed = s.frame > 0 && fabsf(s.truth[i] - s.before[i]) > 0.5f;
            age[i] = changed ? AGE : (uint8_t)(age[i] > 0 ? age[i] - 1 : 0);
            pixels += age[i] > 0;
        }
        for (int k = 0; k < 2; k++) {
            step(&s, &runs[k]);
            if (s.frame < WARM)
                continue;
            count(&tallies[k], &runs[k]);
            run part = runs[k];
            part.wrong = 0;
            for (size_t i = 0; i < PIXELS; i++)
                part.wrong += age[i] > 0 && is_wrong(&s, &runs[k], i);
            count(&moved[k], &part);
        }
    }
    print_message("%zu pixels have changed in the last %d frames\n", pixels, AGE);
    for (int k = 0; k < 2; k++) {
        print_tally(&tallies[k], &s, "court", names[k]);
        print_message("of them where the shadow moved: %zu to %zu\n", moved[k].least,
                      moved[k].most);
        leak_picture(&s, &runs[k], "court");
        few(tallies[k].most, PIXELS, 8e-4, "court, %s", names[k]);
        few(moved[k].most, pixels, 0.015, "where the shadow moved, %s", names[k]);
        end_run(&runs[k]);
    }
    assert_true(pixels > 1000);
    free(age);
    end_stage(&s);
}

/* Does a moving caster take part in what the map says of a pixel? -1 where rounding decides which
 * texels are read. */
static int reads_moving(const stage *s, const run *r, size_t pixel)
{
    const gn_map_layer_info info =
        gn_shadow_map_layer(gn_history_map(r->history, s->light), (uint32_t)r->layer[pixel]);
    if (!info.dynamic_depth)
        return 0;
    const vec p = position_at(s->g, pixel);
    double place[2] = {0, 0};
    for (int i = 0; i < 3; i++) {
        const double d = (i == 0 ? p.x : i == 1 ? p.y : p.z) - (double)info.origin[i];
        place[0] += d * (double)info.right[i];
        place[1] -= d * (double)info.up[i];
    }
    bool moving = false;
    size_t first[2];
    for (int i = 0; i < 2; i++) {
        const double at = (place[i] / (double)info.extent + 1) / 2 * info.resolution - 0.5;
        if (at < 0 || at >= info.resolution - 1 || fabs(at - round(at)) < 1e-3)
            return -1;
        first[i] = (size_t)at;
    }
    for (size_t i = 0; i < 4; i++) {
        const size_t texel = (first[1] + i / 2) * info.resolution + first[0] + i % 2;
        moving |= info.dynamic_depth[texel] < info.depth[texel];
    }
    return moving;
}

/* Rays are taken away where only what stands still is read (section 3.1.2). */
static void test_no_removal_where_moving(void **state)
{
    (void)state;
    stage s = court();
    s.map.normal_bias = 0;
    s.map.refresh = 1;
    run r = new_run(&s, "lt-evsm");
    size_t kept = 0, removed = 0;
    for (s.frame = 0; s.frame < 6; s.frame++) {
        show(&s, 4 + s.frame / 30.0);
        step(&s, &r);
        for (size_t i = 0; s.frame >= 2 && i < PIXELS; i++) {
            if (r.layer[i] < 0 || r.test[i] <= 0.01f || r.test[i] >= 0.99f)
                continue;
            const int moving = reads_moving(&s, &r, i);
            if (moving > 0 && r.traced[i] == 0.0f)
                fail_msg("frame %u: no ray at pixel %zu, which sees a moving caster, test %g",
                         s.frame, i, (double)r.test[i]);
            kept += moving > 0;
            removed += moving == 0 && r.traced[i] == 0.0f;
        }
    }
    print_message("unsure pixels: %zu with a moving caster, all traced; %zu without one, removed\n",
                  kept, removed);
    assert_true(kept > 100 && removed > 100);
    end_run(&r);
    end_stage(&s);
}

/* Sun ----------------------------------------------------------------------------------------- */

static void turn_sun(stage *s, uint32_t node, double degrees)
{
    const double turn = degrees * atan(1) / 45;
    float matrix[16];
    aim(v3(46 * cos(turn) - 68 * sin(turn), 57, 68 * cos(turn) + 46 * sin(turn)), v3(0, 0, 0),
        matrix);
    ok(gn_scene_set_node_matrix(s->scene, node, matrix));
}

/* One degree in ten seconds, then 25 degrees at once. */
static void test_sun(void **state)
{
    (void)state;
    enum { WARM = 9, FRAMES = 12, JUMPED = 12 };
    static const struct {
        const char *method;
        int fps;
    } cases[] = {{"lt-vsm", 30}, {"lt-evsm", 60}};
    stage s = court();
    s.light = add_sun(s.scene, v3(0.46, 0.57, 0.68));
    const uint32_t node = s.scene->node_count - 1;
    for (int k = 0; k < 2; k++) {
        run r = new_run(&s, cases[k].method);
        tally slow = {0}, jump = {0};
        for (s.frame = 0; s.frame < WARM + FRAMES + JUMPED; s.frame++) {
            const bool jumped = s.frame >= WARM + FRAMES;
            turn_sun(&s, node, 0.1 * s.frame / cases[k].fps + (jumped ? 25 : 0));
            show(&s, 0);
            step(&s, &r);
            if (s.frame >= WARM)
                count(jumped ? &jump : &slow, &r);
        }
        print_tally(&slow, &s, "court, turning sun", r.name);
        print_tally(&jump, &s, "court, after a jump", r.name);
        few(slow.most, PIXELS, 3e-4, "turning sun, %s", r.name);
        few(jump.most, PIXELS, 3e-4, "after a jump, %s", r.name);
        end_run(&r);
    }
    end_stage(&s);
}

/* Cuts ---------------------------------------------------------------------------------------- */

/* No pixel is left to a mask that does not know it. */
static void all_traced(const run *r, const char *when)
{
    if (r->rays != r->counts.tested + r->counts.unheld || r->wrong > 0)
        fail_msg("%s: %zu rays, %zu pixels with light to find; %zu are wrong", when,
                 (size_t)r->rays, (size_t)(r->counts.tested + r->counts.unheld), r->wrong);
}

static void test_cuts(void **state)
{
    (void)state;
    stage s = court();
    run r = new_run(&s, "lt-vsm");
    for (s.frame = 0; s.frame < 30; s.frame++) {
        const bool cut = s.frame == 12, camera = s.frame == 14;
        if (cut)
            gn_history_cut(r.history);
        if (camera)
            s.camera = gn_scene_find_camera(s.scene, "CamTop");
        show(&s, 0);
        step(&s, &r);
        if (s.frame == 0 || cut || camera)
            all_traced(&r, s.frame == 0 ? "first frame" : cut ? "cut" : "another camera");
        else if (s.frame == 11 || s.frame == 13 || s.frame == 29)
            few((size_t)r.rays, PIXELS, 0.25, "rays in frame %u", s.frame);
        few(r.wrong, PIXELS, 1e-4, "frame %u", s.frame);
    }
    /* Another size. */
    stage small = new_stage(s.scene, "CamTop", WIDTH / 2, HEIGHT / 2, 512);
    small.frame = s.frame;
    show(&small, 0);
    step(&small, &r);
    all_traced(&r, "another size");
    small.scene = built_in("leafbox", 0.01, 1); /* so that each stage ends its own */
    end_stage(&small);
    end_run(&r);
    end_stage(&s);
}

/* Lights -------------------------------------------------------------------------------------- */

static void test_lamps(void **state)
{
    (void)state;
    enum { WARM = 2, FRAMES = 5 };
    for (int spot = 0; spot < 2; spot++) {
        stage s = new_stage(built_in("leafbox", 0.3, 1), "CamOrbit", WIDTH, HEIGHT, 512);
        s.map.refresh = 1;
        if (spot) {
            gn_light_desc desc = gn_light_desc_default();
            desc.type = GN_LIGHT_SPOT;
            desc.outer_cone_angle = 0.6f;
            s.light = add_light(s.scene, &desc, v3(0.9, 4.6, 0.9), v3(-0.3, 0, -0.3));
        }
        run test = new_run(&s, "ltt-vsm"), mask = new_run(&s, "lt-vsm");
        tally tallies[2] = {{0}};
        for (s.frame = 0; s.frame < WARM + FRAMES; s.frame++) {
            show(&s, s.frame / 60.0);
            step(&s, &test);
            step(&s, &mask);
            if (s.frame >= WARM) {
                count(&tallies[0], &test);
                count(&tallies[1], &mask);
            }
        }
        const char *name = spot ? "spot light" : "point light";
        print_tally(&tallies[0], &s, name, test.name);
        print_tally(&tallies[1], &s, name, mask.name);
        leak_picture(&s, &mask, name);
        few(tallies[1].most, PIXELS, 2e-3, "%s", name);
        assert_true(tallies[1].sum < tallies[0].sum);
        end_run(&test);
        end_run(&mask);
        end_stage(&s);
    }
}

/* The masks of many lights lie in one texel: each light sees the picture that it sees alone. */
static void test_many_lights(void **state)
{
    (void)state;
    enum { MOST = 42, SMALL = 96 * 54 };
    static const uint32_t counts[] = {1, 4, 16, MOST};
    stage s = new_stage(built_in("edges", 0.05, 1), "CamWalk", 96, 54, 64);
    s.map.cascades = 2;
    for (uint32_t i = 2; i < MOST; i++)
        add_sun(s.scene, v3(cos(i), 0.8 + 0.01 * i, sin(i)));
    for (size_t c = 0; c < 4; c++) {
        const uint32_t lights = counts[c], last = lights - 1;
        run many = new_run(&s, "lt-vsm"), alone = new_run(&s, "lt-vsm");
        uint64_t rays = 0;
        for (s.frame = 0; s.frame < 2; s.frame++) {
            show(&s, s.frame / 30.0);
            for (s.light = 0; s.light < lights; s.light++) {
                gn_visibility_desc desc = stage_desc(&s, many.method);
                desc.history = many.history;
                ok(gn_scene_visibility(s.scene, s.g, &desc, many.visibility, NULL));
            }
            s.light = last;
            gn_visibility_desc desc = stage_desc(&s, alone.method);
            desc.history = alone.history;
            gn_visibility_stats stats = {.traced = NULL};
            ok(gn_scene_visibility(s.scene, s.g, &desc, alone.visibility, &stats));
            rays = stats.rays;
            assert_memory_equal(many.visibility, alone.visibility, SMALL * sizeof(float));
        }
        const size_t bytes = gn_history_mask_bytes(many.history) / SMALL / 2;
        print_message("%u lights: %zu bytes of mask a pixel; the last has %zu rays\n", lights,
                      bytes, (size_t)rays);
        assert_true(8 * bytes >= 3 * lights && (bytes == 1 || 8 * bytes < 6 * lights));
        end_run(&many);
        end_run(&alone);
    }
    end_stage(&s);
}

/* Units and machines -------------------------------------------------------------------------- */

/* Units that are powers of two change no bit. Others only round otherwise: a few pixels in
 * thousands are decided another way. */
static void test_units(void **state)
{
    (void)state;
    static const double units[] = {1, 0x1p-10, 1e-3, 1e3};
    enum { WARM = 3, FRAMES = 4 };
    tally tallies[4][2] = {{{0}}};
    for (int u = 0; u < 4; u++) {
        stage s = new_stage(built_in("edges", 0.3, units[u]), "CamWalk", WIDTH, HEIGHT, 512);
        s.map.refresh = 1;
        run runs[2] = {new_run(&s, "ltt-vsm"), new_run(&s, "lt-vsm")};
        for (s.frame = 0; s.frame < WARM + FRAMES; s.frame++) {
            show(&s, 3 + s.frame / 60.0);
            for (int k = 0; k < 2; k++) {
                step(&s, &runs[k]);
                if (s.frame >= WARM)
                    count(&tallies[u][k], &runs[k]);
            }
        }
        for (int k = 0; k < 2; k++) {
            char name[32];
            snprintf(name, sizeof name, "edges * %g", units[u]);
            print_tally(&tallies[u][k], &s, name, runs[k].name);
            const tally *one = &tallies[0][k];
            if (u == 1) {
                assert_int_equal(tallies[u][k].sum, one->sum);
                assert_int_equal(tallies[u][k].rays, one->rays);
            }
            few((size_t)fabs(mean(&tallies[u][k]) - mean(one)), 1, 1 + 0.01 * mean(one), "%s, %s",
                name, runs[k].name);
            end_run(&runs[k]);
        }
        end_stage(&s);
    }
}

/* Single depths are read four by four, whatever reading is asked for, and the layers' margins are
 * those of four. */
static void test_readings(void **state)
{
    (void)state;
    gn_method depth = *gn_method_find("lt-vsm");
    depth.map = gn_method_find("sm")->map;
    static const gn_map_reading readings[] = {GN_READING_BILINEAR, GN_READING_AUTO,
                                              GN_READING_NEAREST, GN_READING_BLUE_NOISE};
    enum { READINGS = sizeof readings / sizeof *readings };
    for (int kind = 0; kind < 2; kind++) {
        stage s = court();
        s.map.refresh = 1;
        run runs[READINGS];
        for (int k = 0; k < READINGS; k++) {
            runs[k] = new_run(&s, "lt-vsm");
            if (kind > 0)
                runs[k].method = &depth;
        }
        for (s.frame = 0; s.frame < 3; s.frame++) {
            show(&s, s.frame / 10.0);
            for (int k = 0; k < READINGS; k++) {
                s.map.reading = readings[k];
                step(&s, &runs[k]);
                const run *one = &runs[0], *other = &runs[k];
                const size_t layers = count_different(one->layer, other->layer, PIXELS, 0.0f);
                const size_t tests = count_different(one->test, other->test, PIXELS, 0.0f);
                if (layers + tests > 0)
                    fail_msg("%s, reading %d, frame %u: %zu layers and %zu tests differ",
                             kind > 0 ? "depth" : "vsm", (int)readings[k], s.frame, layers, tests);
                assert_true(other->counts.tested > PIXELS / 4);
            }
        }
        for (int k = 0; k < READINGS; k++)
            end_run(&runs[k]);
        end_stage(&s);
    }
}

/* Visibility and classes of a few frames, one after the other. */
static float *sequence(uint32_t threads, gn_isa isa, const char *method)
{
    enum { FRAMES = 4, SMALL = 160 * 90 };
    gn_device *shared = device;
    gn_device_desc desc = gn_device_desc_default();
    desc.threads = threads;
    desc.isa = isa;
    if (gn_device_create(&desc, &device) != GN_OK) {
        device = shared;
        return NULL;
    }
    float *planes = new_plane((size_t)FRAMES * 2 * SMALL);
    stage s = new_stage(built_in("court", 0.1, 1), "CamWalk", 160, 90, 256);
    run r = new_run(&s, method);
    for (s.frame = 0; s.frame < FRAMES; s.frame++) {
        show(&s, s.frame / 10.0);
        step(&s, &r);
        float *at = planes + (size_t)s.frame * 2 * SMALL;
        memcpy(at, r.visibility, SMALL * sizeof *at);
        memcpy(at + SMALL, r.leak_class, SMALL * sizeof *at);
    }
    end_run(&r);
    end_stage(&s);
    gn_device_destroy(&device);
    device = shared;
    return planes;
}

static void test_machines(void **state)
{
    (void)state;
    static const char *const methods[] = {"lt-vsm", "hybrid-pcf"};
    enum { VALUES = 4 * 2 * 160 * 90 };
    for (size_t m = 0; m < 2; m++) {
        float *one = sequence(1, GN_ISA_AUTO, methods[m]);
        assert_non_null(one);
        for (uint32_t threads = 2; threads <= 3; threads++) {
            float *more = sequence(threads, GN_ISA_AUTO, methods[m]);
            assert_non_null(more);
            assert_memory_equal(one, more, VALUES * sizeof *one);
            free(more);
        }
        static const gn_isa sets[] = {GN_ISA_SCALAR, GN_ISA_AVX2, GN_ISA_AVX512};
        for (int i = 0; i < 3; i++) {
            float *other = sequence(0, sets[i], methods[m]);
            if (!other)
                continue;
            const size_t different = count_different(one, other, VALUES, 0.0f);
            print_message("%s, instruction set %d: %zu of %d values differ\n", methods[m], i,
                          different, (int)VALUES);
            few(different, VALUES, 1e-5, "%s, instruction set %d", methods[m], i);
            free(other);
        }
        free(one);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_moving_caster), cmocka_unit_test(test_no_removal_where_moving),
        cmocka_unit_test(test_sun),           cmocka_unit_test(test_cuts),
        cmocka_unit_test(test_lamps),         cmocka_unit_test(test_many_lights),
        cmocka_unit_test(test_units),         cmocka_unit_test(test_readings),
        cmocka_unit_test(test_machines),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
