/* Leak tracing where its test fails: the paper's Figures 4, 5, 9 and 10, and small holes. Counts
 * are of pixels whose visibility is off by more than a half. */
#include "leak_testing.h"

#define WIDTH  320
#define HEIGHT 180
#define PIXELS (WIDTH * HEIGHT)

/* Layers are drawn at once, so that frames before they are whole need not be waited for. */
static stage edges_of_size(const char *camera, uint32_t width, uint32_t height, uint32_t resolution)
{
    stage s = new_stage(built_in("edges", 1, 1), camera, width, height, resolution);
    s.map.refresh = 1;
    return s;
}

static stage edges(const char *camera, uint32_t resolution)
{
    return edges_of_size(camera, WIDTH, HEIGHT, resolution);
}

/* Figures 4 and 5, a camera at rest. The test alone errs in every frame; with the mask nothing is
 * wrong, since the first frame traces all, and what it found wrong stays traced. */
static void test_at_rest(void **state)
{
    (void)state;
    static const char *const methods[] = {"ltt-vsm", "ltt-evsm", "lt-vsm", "lt-evsm"};
    static const char *const cameras[] = {"CamEdges", "CamGaps"};
    static const size_t least[] = {60, 50}; /* wrong pixels of the test alone */
    for (size_t v = 0; v < 2; v++) {
        stage s = edges(cameras[v], 512);
        show(&s, 0);
        for (int k = 0; k < 4; k++) {
            run r = new_run(&s, methods[k]);
            tally t = {0};
            for (s.frame = 0; s.frame < (k < 2 ? 1 : 9); s.frame++) {
                step(&s, &r);
                count(&t, &r);
            }
            print_tally(&t, &s, cameras[v], r.name);
            leak_picture(&s, &r, cameras[v]);
            if (k >= 2)
                few(t.most, PIXELS, 2e-5, "%s on %s", r.name, cameras[v]);
            else if (t.least < least[v])
                fail_msg("%s does not fail on %s any more: %zu wrong pixels, %zu are expected",
                         r.name, cameras[v], t.least, least[v]);
            end_run(&r);
        }
        end_stage(&s);
    }
}

/* Errors that are not known at first: rays spread over them from their neighbours, with either
 * kernel, until nothing changes. What touches no shadow that is known is never found. */
static void test_repair(void **state)
{
    (void)state;
    static const char *const cameras[] = {"CamEdges", "CamGaps"};
    for (size_t v = 0; v < 2; v++) {
        enum { FRAMES = 12 };
        stage s = edges(cameras[v], 512);
        run runs[2];
        show(&s, 0);
        for (int k = 0; k < 2; k++) {
            runs[k] = new_run(&s, "lt-evsm");
            runs[k].leak.kernel = k == 0 ? GN_LEAK_GATHER : GN_LEAK_FULL;
            s.frame = 0;
            forget_errors(&s, &runs[k]);
            const size_t first = runs[k].wrong;
            print_message("%s, %s: wrong pixels %zu;", cameras[v], k == 0 ? "gather" : "full",
                          first);
            size_t before = first;
            for (int i = 1; i <= FRAMES; i++, s.frame++) {
                step(&s, &runs[k]);
                print_message(" %zu", runs[k].wrong);
                if (runs[k].wrong > before)
                    fail_msg("%zu pixels are wrong after %zu", runs[k].wrong, before);
                before = runs[k].wrong;
                if (i == 8)
                    few(runs[k].wrong, first, 0.65, "%s after 8 frames", cameras[v]);
            }
            print_message("\n");
            assert_true(first > 60);
        }
        few(count_different(runs[0].visibility, runs[1].visibility, PIXELS, 0.5f), PIXELS, 2e-4,
            "%s: gather and full kernel", cameras[v]);
        for (int k = 0; k < 2; k++)
            end_run(&runs[k]);
        end_stage(&s);
    }
}

/* Means over frames of a camera that moves, of the test alone and with the mask. */
static void walk(stage *s, const char *view, double start, double least, double share, double most)
{
    enum { RUNS = 4, WARM = 4, FRAMES = 12 };
    static const char *const names[RUNS] = {"ltt-vsm", "ltt-evsm", "lt-vsm", "lt-evsm"};
    run runs[RUNS];
    tally tallies[RUNS] = {{0}};
    for (int k = 0; k < RUNS; k++)
        runs[k] = new_run(s, names[k]);
    for (s->frame = 0; s->frame < WARM + FRAMES; s->frame++) {
        show(s, start + s->frame / 60.0);
        for (int k = 0; k < RUNS; k++) {
            step(s, &runs[k]);
            if (s->frame >= WARM)
                count(&tallies[k], &runs[k]);
        }
    }
    for (int k = 0; k < RUNS; k++) {
        print_tally(&tallies[k], s, view, names[k]);
        leak_picture(s, &runs[k], view);
        end_run(&runs[k]);
    }
    for (int k = 0; k < 2; k++) {
        const double alone = mean(&tallies[k]), masked = mean(&tallies[k + 2]);
        if (alone < least)
            fail_msg("%s: %s has %g wrong pixels, %g are expected", view, names[k], alone, least);
        if (masked > share * alone)
            fail_msg("%s: %s has %g wrong pixels, more than %g of the %g of %s", view, names[k + 2],
                     masked, share, alone, names[k]);
        few(tallies[k + 2].most, s->pixels, most, "%s, %s", view, names[k + 2]);
    }
}

static void test_walk(void **state)
{
    (void)state;
    stage s = edges("CamWalk", 512);
    walk(&s, "CamWalk", 3, 100, 0.45, 0.0025);
    end_stage(&s);
}

/* Figure 9: a small map, a tree far away, a low sun. */
static void test_far_tree(void **state)
{
    (void)state;
    stage s = edges("CamTree", 512);
    ok(gn_scene_add_sun(s.scene, 5, 12, &s.light));
    walk(&s, "CamTree", 0, 50, 0.15, 0.0004);
    end_stage(&s);
}

/* Section 4.3: holes that are one or two pixels in the picture. */
static void test_small_holes(void **state)
{
    (void)state;
    stage s = edges_of_size("CamHoles", 480, 270, 512);
    walk(&s, "CamHoles", 0, 100, 0.8, 0.0025);
    end_stage(&s);
}

/* Figure 10: a map of 64 x 64 misses most of a fence. From a mask that does not know of it, rays
 * close it slowly, and never where planks are too far apart; after a first frame that traced all of
 * it, it is whole. */
static void test_fence(void **state)
{
    (void)state;
    stage s = edges("CamFence", 64);
    s.map.cascades = 1;
    s.map.distance = 15;
    show(&s, 0);
    for (int k = 0; k < 3; k++) {
        static const char *const names[] = {"gather", "full", "gather, first frame traced"};
        run mask = new_run(&s, "lt-evsm");
        mask.leak.kernel = k == 1 ? GN_LEAK_FULL : GN_LEAK_GATHER;
        s.frame = 0;
        if (k < 2)
            forget_errors(&s, &mask);
        const size_t first = mask.wrong;
        print_message("fence, %s: wrong pixels %zu", names[k], first);
        for (int i = 1; i <= 40; i++, s.frame++) {
            step(&s, &mask);
            if (i % 8 == 0)
                print_message(", after %d frames %zu", i, mask.wrong);
            if (k == 2)
                assert_int_equal(mask.wrong, 0);
        }
        print_message("\n");
        leak_picture(&s, &mask, "fence");
        if (k < 2) {
            assert_true(first > PIXELS / 100);
            few(mask.wrong, first, k == 0 ? 0.65 : 0.55, "fence, %s, after 40 frames", names[k]);
        }
        end_run(&mask);
    }
    end_stage(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_at_rest),     cmocka_unit_test(test_repair),
        cmocka_unit_test(test_walk),        cmocka_unit_test(test_far_tree),
        cmocka_unit_test(test_small_holes), cmocka_unit_test(test_fence),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
