/* Shadow maps whose layers are drawn in slices: what results, when, and what stays meanwhile. */
#include "shadow_map_testing.h"

#include "render/map_refresh.h"

/* Parts --------------------------------------------------------------------------------------- */

static void check_parts(const gn_scene *scene, uint32_t samples, uint32_t parts,
                        const gn_map_projection *projection)
{
    const size_t count = (size_t)projection->resolution * projection->resolution * samples;
    float *whole = malloc(count * sizeof *whole), *made = malloc(count * sizeof *made);
    assert_true(whole && made);
    for (size_t i = 0; i < count; i++)
        made[i] = -1.0f;
    gn_depth_job job = {
        .scene = scene, .projection = *projection, .samples = samples, .depth = whole};
    ok(gn_cpu_depth(&device->cpu, &job));
    const gn_rect covered = job.covered;
    job.depth = made;
    job.parts = parts;
    for (uint32_t n = parts; n-- > 0;) {
        job.part = n;
        ok(gn_cpu_depth(&device->cpu, &job));
        if (job.covered.x0 < job.covered.x1)
            assert_true(job.covered.x0 >= covered.x0 && job.covered.x1 <= covered.x1 &&
                        job.covered.y0 >= covered.y0 && job.covered.y1 <= covered.y1);
    }
    for (size_t i = 0; i < count; i++)
        if (whole[i] != made[i])
            fail_msg("%u parts, %u samples, depth %zu: %g, at once %g", parts, samples, i,
                     (double)made[i], (double)whole[i]);
    free(whole);
    free(made);
}

static void test_parts_make_the_whole(void **state)
{
    (void)state;
    yard y = make_yard(true);
    gn_map_desc desc = small_desc();
    desc.resolution = 700; /* six tiles a side, the last not full */
    const uint32_t lights[] = {y.sun, y.lamp};
    for (uint32_t i = 0; i < 2; i++) {
        gn_shadow_map *map = make_map(&depth32, &desc);
        update(map, &y, lights[i]);
        const gn_map_projection p = job_of(map).layers[i].projection;
        for (uint32_t parts = 1; parts <= 64; parts = parts * 2 + 1)
            check_parts(y.scene, parts % 4 == 3 ? 4 : 1, parts, &p);
        gn_shadow_map_destroy(&map);
    }
    gn_scene_destroy(&y.scene);
}

/* Slices -------------------------------------------------------------------------------------- */

static void check_slices(const gn_map_format *format, gn_map_desc desc, uint32_t light,
                         const yard *y)
{
    const uint32_t refresh = desc.refresh;
    gn_shadow_map *map = make_map(format, &desc);
    desc.refresh = 1;
    gn_shadow_map *once = make_map(format, &desc);
    const uint32_t layers = update(once, y, light).fitted;
    assert_true(layers > 0);
    for (uint32_t n = 1; n < refresh; n++) {
        const gn_map_update u = update(map, y, light);
        if (u.fitted != (n == 1 ? layers : 0) || u.pending != layers ||
            gn_shadow_map_layer_count(map) != 0)
            fail_msg("update %u of %u: %u layers placed, %u pending, %u in use", n, refresh,
                     u.fitted, u.pending, gn_shadow_map_layer_count(map));
    }
    const gn_map_update last = update(map, y, light);
    assert_int_equal(last.pending, 0);
    char what[60];
    snprintf(what, sizeof what, "light %u in %u slices", light, refresh);
    assert_same(map, once, what);
    assert_as_if_new(map, y, what);
    const gn_map_update after = update(map, y, light);
    assert_int_equal(after.fitted + after.pending + after.filtered, 0);
    gn_shadow_map_destroy(&map);
    gn_shadow_map_destroy(&once);
}

static void test_slices_equal_a_layer_drawn_at_once(void **state)
{
    (void)state;
    yard y = make_yard(true);
    for (uint32_t refresh = 2; refresh <= 17; refresh = 2 * refresh + 1) {
        check_slices(&nlmsm64, sliced_desc(refresh), y.sun, &y);
        check_slices(&depth32, sliced_desc(refresh), y.lamp, &y);
        gn_map_desc desc = sliced_desc(refresh);
        desc.samples = 4;
        desc.mip_maps = true;
        check_slices(&vsm64, desc, y.spot, &y);
    }
    gn_scene_destroy(&y.scene);
}

/* The old layers stay until the new ones are whole, with moving casters as they are now. */
static void check_old_layers(const gn_map_format *format, uint32_t refresh)
{
    yard y = make_yard(true);
    gn_map_desc desc = sliced_desc(refresh);
    desc.resolution = 128;
    gn_shadow_map *map = make_map(format, &desc);
    for (uint32_t n = 0; n < refresh; n++)
        update(map, &y, y.sun);
    const gn_map_projection before = job_of(map).layers[0].projection;
    look(&y, v3(-14, 1.7, -8), v3(-20, 1, -20)); /* a jump */
    for (uint32_t n = 1; n <= refresh + 2; n++) {
        move_ball(&y, 0, v3(2 + 0.3 * n, 1, 2));
        move_ball(&y, 1, v3(-16, 1 + 0.1 * n, -12));
        ok(gn_scene_commit(y.scene));
        const gn_map_update u = update(map, &y, y.sun);
        const gn_map_projection now = job_of(map).layers[0].projection;
        const bool same = memcmp(now.origin, before.origin, sizeof now.origin) == 0;
        if (same != (n < refresh) || (u.pending > 0) != (n < refresh))
            fail_msg("update %u of %u: %s, %u layers pending", n, refresh, same ? "old" : "new",
                     u.pending);
        assert_as_if_new(map, &y, "after a jump");
    }
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

static void test_old_layers_stay_in_use(void **state)
{
    (void)state;
    check_old_layers(&nlmsm64, 8);
    check_old_layers(&vsm64, 3);
    check_old_layers(&depth32, 4);
}

/* Paths --------------------------------------------------------------------------------------- */

/* Slices of the view that their own cascade does not hold. */
static uint32_t count_failing(const gn_shadow_map *map, const yard *y, uint32_t *slices)
{
    const gn_scene *s = y->scene;
    const gn_cascades c =
        gn_cascades_make(&s->cameras[y->camera], 16.0f / 9.0f, s->bounds_min, s->bounds_max, false,
                         s->lights[y->sun].direction, &map->desc, map->margin);
    uint32_t failing = 0;
    bool whole = false;
    for (uint32_t i = 0; i < c.count && !whole; i++) {
        const gn_map_slot *slot = &map->slots[i];
        ++*slices;
        failing += !slot->used || !gn_cascade_serves(&slot->place, &c, i);
        whole = slot->used && slot->place.whole;
    }
    return failing;
}

/* Turning and walking steadily, layers are ready when they are needed: three times the updates that
 * one takes after the start, when it is known how the camera goes. */
static void check_path(const char *name, double degrees, double speed)
{
    yard y = make_yard(false);
    const uint32_t refresh = 8;
    gn_map_desc desc = sliced_desc(refresh);
    desc.filter_width = 1;
    gn_shadow_map *map = make_map(&depth32, &desc);
    uint32_t failing = 0, slices = 0, fitted = 0;
    for (uint32_t n = 0; n < 150; n++) {
        const double turn = degrees * acos(-1.0) / 180 * n / 30;
        const vec eye = v3(1, 1.7, 12 - speed * n / 30);
        look(&y, eye, add(eye, v3(sin(turn), -0.1, -cos(turn))));
        ok(gn_scene_commit(y.scene));
        const gn_map_update u = update(map, &y, y.sun);
        if (n < 3 * refresh)
            continue;
        fitted += u.fitted;
        failing += count_failing(map, &y, &slices);
    }
    print_message("%s: %u layers placed anew, %u of %u slices not held\n", name, fitted, failing,
                  slices);
    assert_true(slices > 0 && (fitted > 0 || degrees + speed == 0));
    assert_int_equal(failing, 0);
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

static void test_layers_are_ready_when_they_are_needed(void **state)
{
    (void)state;
    check_path("standing", 0, 0);
    check_path("a turn of 15 degrees a second", 15, 0);
    check_path("a turn of 40 degrees a second", -40, 0);
    check_path("a walk", 0, 1.4);
    check_path("a walk and a turn", 20, 1.4);
}

/* Light --------------------------------------------------------------------------------------- */

/* Texels by which shadows may be off in a layer of the yard, which is flat: those of the highest
 * caster on the floor. */
static double shift_of(const gn_map_layer *layer, const yard *y)
{
    const gn_map_projection *p = &layer->projection;
    const float *sun = y->scene->lights[y->sun].direction;
    const vec to = v3((double)sun[0], (double)sun[1], (double)sun[2]);
    const vec from = v3((double)p->forward[0], (double)p->forward[1], (double)p->forward[2]);
    const double height = (double)y->scene->bounds_max[1] - (double)y->scene->bounds_min[1];
    return height / -from.y * length(sub(to, from)) / (2 * (double)p->extent / p->resolution);
}

/* As fast as one degree in ten seconds is for a map of 2048: no layer is missing once it is known
 * how the sun turns, none is off by much. */
static void test_a_turning_sun_keeps_its_layers(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = sliced_desc(8);
    gn_shadow_map *map = make_map(&depth32, &desc);
    turn_sun(&y, 30);
    for (uint32_t n = 0; n < 8; n++)
        update(map, &y, y.sun);
    const uint32_t count = gn_shadow_map_layer_count(map);
    uint32_t fitted = 0;
    double worst = 0;
    for (uint32_t n = 1; n <= 120; n++) {
        turn_sun(&y, 30 + 18 * n / 300.0);
        fitted += update(map, &y, y.sun).fitted;
        const gn_map_job job = job_of(map);
        if (job.layer_count != count)
            fail_msg("frame %u: %u layers of %u", n, job.layer_count, count);
        for (uint32_t i = 0; i < count; i++)
            worst = fmax(worst, shift_of(&job.layers[i], &y));
        if (n % 10 == 0)
            assert_as_if_new(map, &y, "while the sun turns");
    }
    print_message("%u layers placed anew; shadows off by at most %.2f texels\n", fitted, worst);
    assert_true(worst > 0 && worst < 1.7);
    /* It stops: soon all layers are right. */
    for (uint32_t n = 0; n < 16; n++)
        update(map, &y, y.sun);
    const gn_map_job job = job_of(map);
    for (uint32_t i = 0; i < count; i++)
        if (!(shift_of(&job.layers[i], &y) < 1e-3))
            fail_msg("at rest: layer %u is off by %g texels", i, shift_of(&job.layers[i], &y));
    assert_int_equal(update(map, &y, y.sun).pending, 0);
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

/* Nothing that was drawn for another light is read. */
static void test_a_light_that_jumps_leaves_no_layer(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = sliced_desc(5);
    for (uint32_t middle = 0; middle < 2; middle++) { /* while some layers are in the making */
        gn_shadow_map *map = make_map(&vsm64, &desc);
        turn_sun(&y, 30);
        for (uint32_t n = 0; n < 7 - 4 * middle; n++)
            update(map, &y, y.sun);
        turn_sun(&y, 75);
        for (uint32_t n = 1; n < 5; n++) {
            update(map, &y, y.sun);
            assert_int_equal(gn_shadow_map_layer_count(map), 0);
        }
        update(map, &y, y.sun);
        assert_true(gn_shadow_map_layer_count(map) > 0);
        const gn_map_job job = job_of(map);
        for (uint32_t i = 0; i < job.layer_count; i++)
            assert_true(shift_of(&job.layers[i], &y) < 1e-3);
        assert_as_if_new(map, &y, "after a jump of the sun");
        gn_shadow_map_destroy(&map);
    }
    gn_shadow_map *map = make_map(&vsm64, &desc);
    for (uint32_t n = 0; n < 5; n++)
        update(map, &y, y.lamp);
    assert_int_equal(gn_shadow_map_layer_count(map), 6);
    const float to[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 4.01f, -2, 1};
    ok(gn_scene_set_node_matrix(y.scene, y.sun_node + 1, to));
    ok(gn_scene_commit(y.scene));
    for (uint32_t n = 1; n <= 5; n++) {
        update(map, &y, y.lamp);
        assert_int_equal(gn_shadow_map_layer_count(map), n < 5 ? 0 : 6);
    }
    assert_as_if_new(map, &y, "a lamp that moved");
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
}

/* Settings ------------------------------------------------------------------------------------ */

static void refused(const gn_map_desc *desc, const char *words)
{
    gn_shadow_map *map = NULL;
    assert_int_equal(gn_shadow_map_create(device, &depth32, desc, &map), GN_ERROR_INVALID_ARGUMENT);
    assert_null(map);
    if (!strstr(gn_device_message(device), words))
        fail_msg("the message is \"%s\", expected \"%s\"", gn_device_message(device), words);
}

static void test_cascades_that_are_not_drawn(void **state)
{
    (void)state;
    yard y = make_yard(true);
    gn_map_desc desc = small_desc();
    gn_shadow_map *all = make_map(&vsm64, &desc);
    update(all, &y, y.sun);
    const gn_map_job job = job_of(all);
    assert_int_equal(job.layer_count, 4);
    for (uint32_t undrawn = 0; undrawn <= 4; undrawn++) {
        desc.undrawn = undrawn;
        gn_shadow_map *map = make_map(&vsm64, &desc);
        const gn_map_update u = update(map, &y, y.sun);
        assert_int_equal(u.fitted, 4 - undrawn);
        assert_int_equal(gn_shadow_map_layer_count(map), 4 - undrawn);
        for (uint32_t i = 0; i < 4 - undrawn; i++)
            assert_int_equal(memcmp(&job_of(map).layers[i].projection, &job.layers[i].projection,
                                    sizeof(gn_map_projection)),
                             0);
        update(map, &y, y.lamp);
        assert_int_equal(gn_shadow_map_layer_count(map), 6);
        gn_shadow_map_destroy(&map);
    }
    gn_shadow_map_destroy(&all);
    gn_scene_destroy(&y.scene);
    desc.undrawn = 5;
    refused(&desc, "5 cascades that are not drawn: the range is 0 to 4");
    desc.undrawn = 0;
    desc.refresh = 65;
    refused(&desc, "a refresh over 65 updates: the range is 1 to 64");
}

/* Texels outside `touched` are those of standing casters alone. Returns how many are inside. */
static uint32_t count_touched(const gn_map_job *job, const gn_map_layer *layer)
{
    const uint32_t words = gn_map_words(&job->format);
    const gn_rect t = layer->touched;
    uint32_t *still = malloc((size_t)RESOLUTION * RESOLUTION * words * sizeof *still), inside = 0;
    assert_non_null(still);
    const gn_filter_job filter = {.format = job->format,
                                  .resolution = RESOLUTION,
                                  .samples = 1,
                                  .width = job->desc.filter_width,
                                  .sigma = job->desc.filter_sigma,
                                  .moment_bias = job->desc.moment_bias,
                                  .depth = layer->depth[0],
                                  .rect = {0, 0, RESOLUTION, RESOLUTION},
                                  .texels = still};
    if (layer->texels)
        ok(gn_cpu_filter(&device->cpu, &filter));
    for (uint32_t i = 0; i < RESOLUTION * RESOLUTION; i++) {
        const uint32_t column = i % RESOLUTION, row = i / RESOLUTION;
        const bool changed = layer->texels
                                 ? memcmp(layer->texels + (size_t)i * words,
                                          still + (size_t)i * words, words * sizeof *still) != 0
                                 : layer->depth[1] && layer->depth[1][i] < layer->depth[0][i];
        const bool touched = column >= t.x0 && column < t.x1 && row >= t.y0 && row < t.y1;
        inside += touched;
        if (changed && !touched)
            fail_msg("map kind %d: column %u, row %u changed outside columns %u to %u",
                     (int)job->format.kind, column, row, t.x0, t.x1);
    }
    free(still);
    return inside;
}

static void test_touched_holds_what_moving_casters_change(void **state)
{
    (void)state;
    yard y = make_yard(true);
    const gn_map_desc desc = small_desc();
    const gn_map_format *formats[] = {&depth32, &vsm64, &nlmsm64};
    const size_t texels = (size_t)RESOLUTION * RESOLUTION;
    for (uint32_t f = 0; f < 3; f++) {
        gn_shadow_map *map = make_map(formats[f], &desc);
        update(map, &y, y.sun);
        const gn_map_job job = job_of(map);
        uint32_t inside = 0;
        for (uint32_t i = 0; i < job.layer_count; i++)
            inside += count_touched(&job, &job.layers[i]);
        assert_true(inside > 0 && inside < texels * job.layer_count / 2);
        gn_shadow_map_destroy(&map);
    }
    gn_scene_destroy(&y.scene);
}

/* Threads ------------------------------------------------------------------------------------- */

static uint64_t hash_words(uint64_t h, const void *data, size_t count)
{
    const uint32_t *words = data;
    for (size_t i = 0; i < count; i++)
        h = (h ^ words[i]) * 1099511628211u;
    return h;
}

/* What a film leaves in a map, update by update, on a device of its own. */
static uint64_t hash_film(uint32_t threads)
{
    gn_device *before = device;
    gn_device_desc of = gn_device_desc_default();
    of.threads = threads;
    ok(gn_device_create(&of, &device));
    yard y = make_yard(true);
    const gn_map_desc desc = sliced_desc(5);
    gn_shadow_map *map = make_map(&nlmsm64, &desc);
    uint64_t h = 14695981039346656037u;
    for (uint32_t n = 0; n < 14; n++) {
        show(&y, n);
        update(map, &y, y.sun);
        const gn_map_job job = job_of(map);
        const size_t texels = (size_t)desc.resolution * desc.resolution;
        for (uint32_t i = 0; i < job.layer_count; i++) {
            h = hash_words(h, job.layers[i].depth[0], texels);
            h = hash_words(h, job.layers[i].texels, 2 * texels);
        }
    }
    assert_true(gn_shadow_map_layer_count(map) > 0);
    gn_shadow_map_destroy(&map);
    gn_scene_destroy(&y.scene);
    gn_device_destroy(&device);
    device = before;
    return h;
}

static void test_threads_do_not_matter(void **state)
{
    (void)state;
    const uint64_t one = hash_film(1);
    for (uint32_t threads = 2; threads <= 5; threads += 3) {
        const uint64_t more = hash_film(threads);
        if (one != more)
            fail_msg("%u threads: %016llx, one: %016llx", threads, (unsigned long long)more,
                     (unsigned long long)one);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_make_the_whole),
        cmocka_unit_test(test_slices_equal_a_layer_drawn_at_once),
        cmocka_unit_test(test_old_layers_stay_in_use),
        cmocka_unit_test(test_layers_are_ready_when_they_are_needed),
        cmocka_unit_test(test_a_turning_sun_keeps_its_layers),
        cmocka_unit_test(test_a_light_that_jumps_leaves_no_layer),
        cmocka_unit_test(test_cascades_that_are_not_drawn),
        cmocka_unit_test(test_touched_holds_what_moving_casters_change),
        cmocka_unit_test(test_threads_do_not_matter)};
    return cmocka_run_group_tests_name("map_refresh", tests, open_device, close_device);
}
