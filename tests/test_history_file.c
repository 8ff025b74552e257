/* Histories in files: a history that was saved and loaded goes on with the same bits; a file that
 * is damaged is refused, or is another history. */
#include <unistd.h>

#include "shadow_map_testing.h"

#include "history_testing.h"
#include "render/history_file.h"
#include "render/stream.h"

static char folder[] = "/tmp/gnomon-history-XXXXXX";
static char one[64], two[64];

static int open_all(void **state)
{
    if (!mkdtemp(folder))
        return 1;
    snprintf(one, sizeof one, "%s/one", folder);
    snprintf(two, sizeof two, "%s/two", folder);
    return open_device(state);
}

static int close_all(void **state)
{
    unlink(one);
    unlink(two);
    if (rmdir(folder) != 0) /* what else is there was left by a save */
        return 1;
    return close_device(state);
}

typedef struct content {
    uint8_t *data;
    size_t size;
} content;

static content read_all(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    content c = {.size = (size_t)ftell(file)};
    rewind(file);
    c.data = malloc(c.size + 1);
    assert_non_null(c.data);
    assert_int_equal(fread(c.data, 1, c.size, file), c.size);
    fclose(file);
    return c;
}

static void write_all(const char *path, const uint8_t *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Saves and loads; what is loaded writes the same file again. */
static gn_history *reload(const gn_history *history, const gn_scene *scene)
{
    gn_history *loaded = NULL;
    ok(gn_history_save(history, one));
    ok(gn_history_load(scene, one, &loaded));
    ok(gn_history_save(loaded, two));
    const content a = read_all(one), b = read_all(two);
    assert_int_equal(a.size, b.size);
    for (size_t i = 0; i < a.size; i++)
        if (a.data[i] != b.data[i])
            fail_msg("byte %zu of %zu: %02x, saved again %02x", i, a.size, a.data[i], b.data[i]);
    free(a.data);
    free(b.data);
    return loaded;
}

/* Masks --------------------------------------------------------------------------------------- */

enum { WIDTH = 37, HEIGHT = 29, PIXELS = WIDTH * HEIGHT };

/* Asks both for a light, and writes the same states into both. */
static void step_both(gn_history *const histories[2], const gn_scene *scene, uint32_t light,
                      const gn_gbuffer *g, bool keep, uint64_t *random, const char *what)
{
    gn_leak_mask masks[2];
    for (int k = 0; k < 2; k++)
        masks[k] = begin(histories[k], scene, light, g, keep);
    const gn_leak_mask *a = &masks[0], *b = &masks[1];
    if (!a->before != !b->before || !a->depth_before != !b->depth_before)
        fail_msg("%s, light %u: %s mask, %s depth; loaded %s mask, %s depth", what, light,
                 a->before ? "a" : "no", a->depth_before ? "a" : "no", b->before ? "a" : "no",
                 b->depth_before ? "a" : "no");
    for (size_t p = 0; p < PIXELS; p++) {
        if (a->before && get_state(a->before, a, p) != get_state(b->before, b, p))
            fail_msg("%s, light %u, pixel %zu: %u, loaded %u", what, light, p,
                     get_state(a->before, a, p), get_state(b->before, b, p));
        if (a->depth_before && a->depth_before[p] != b->depth_before[p])
            fail_msg("%s, light %u, pixel %zu: depth %g, loaded %g", what, light, p,
                     (double)a->depth_before[p], (double)b->depth_before[p]);
        const uint32_t made = random_below(random, 8);
        set_state(a, p, made);
        set_state(b, p, made);
    }
}

/* Saved after any number of lights of a frame, and gone on with for two frames. */
static void test_masks_go_on(void **state)
{
    (void)state;
    static float plane[PIXELS];
    const gn_gbuffer g = {.width = WIDTH, .height = HEIGHT, .depth = plane};
    gn_scene *scene = many_lights(12);
    gn_history *histories[2] = {new_history(device), NULL};
    uint64_t random = 1;
    uint32_t kept = 0;
    for (uint32_t n = 0; n < 40; n++) {
        const uint32_t lights = 1 + random_below(&random, 12), saved = random_below(&random, 13);
        const bool keep = random_below(&random, 3) > 0;
        for (size_t p = 0; p < PIXELS; p++)
            plane[p] = (float)random_below(&random, 1000);
        for (uint32_t i = 0; i < lights; i++) {
            if (i == saved || n == 0) {
                gn_history_destroy(&histories[1]);
                if (n > 0 || i > 0)
                    histories[1] = reload(histories[0], scene);
                else
                    histories[1] = new_history(device);
                kept += i == saved;
            }
            char what[40];
            snprintf(what, sizeof what, "frame %u", n);
            step_both(histories, scene, i, &g, keep && i % 2 == 0, &random, what);
        }
    }
    assert_true(kept > 10);
    assert_int_equal(histories[0]->texel_bytes, histories[1]->texel_bytes);
    gn_history_destroy(&histories[0]);
    gn_history_destroy(&histories[1]);
    gn_scene_destroy(&scene);
}

/* Sequences ----------------------------------------------------------------------------------- */

enum { FRAMES = 9, ACROSS = 96, DOWN = 54 };

/* Camera, balls and sun at a frame. */
static void pose(yard *y, uint32_t n)
{
    const double t = n / 6.0;
    look(y, v3(2 + 2 * t, 1.7, 10 - t), v3(2 + sin(t), 1, 0));
    move_ball(y, 0, v3(3 + sin(3 * t), 1, 3));
    move_ball(y, 1, v3(1 - t, 1.5, 4));
    float m[16];
    aim(v3(0.4 + 0.01 * t, 1, 0.3), v3(0, 0, 0), m);
    ok(gn_scene_set_node_matrix(y->scene, y->sun_node, m));
    ok(gn_scene_commit(y->scene));
}

static gn_view *new_view(uint32_t width, uint32_t height)
{
    gn_view_desc desc = gn_view_desc_default();
    desc.width = width;
    desc.height = height;
    gn_view *view = NULL;
    ok(gn_view_create(device, &desc, &view));
    return view;
}

/* Renders a frame and keeps its visibility and motion: 4 planes a light. */
static void render_frame(gn_view *view, yard *y, const gn_visibility_desc *desc, uint32_t n,
                         float *planes)
{
    const uint32_t lights[] = {y->sun, y->lamp, y->spot};
    gn_visibility_desc own = *desc;
    own.frame = n;
    pose(y, n);
    ok(gn_view_render(view, y->scene, y->camera, &own, lights, 3));
    for (uint32_t i = 0; i < 3; i++) {
        const size_t bytes = ACROSS * DOWN * sizeof(float);
        memcpy(planes + 2 * i * ACROSS * DOWN, gn_view_visibility(view, i), bytes);
        memcpy(planes + (2 * i + 1) * ACROSS * DOWN, gn_view_gbuffer(view)->motion[i], bytes);
    }
}

static void check_sequence(const char *method, const gn_map_desc *map)
{
    const size_t size = (size_t)6 * ACROSS * DOWN;
    float *planes = malloc(FRAMES * size * sizeof *planes), *again = malloc(size * sizeof *again);
    assert_true(planes && again);
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = gn_method_find(method);
    assert_non_null(desc.method);
    desc.map = *map;
    gn_device *const first = device;
    yard y = make_yard(true);
    gn_view *view = new_view(ACROSS, DOWN);
    char paths[FRAMES][80];
    for (uint32_t n = 0; n < FRAMES; n++) {
        render_frame(view, &y, &desc, n, planes + n * size);
        snprintf(paths[n], sizeof paths[n], "%s/%u", folder, n);
        ok(gn_view_save_history(view, paths[n]));
    }
    gn_view_destroy(&view);
    gn_scene_destroy(&y.scene);

    /* Each goes on in another device with as many threads as it likes, from another time. */
    gn_device_desc device_desc = gn_device_desc_default();
    device_desc.threads = 3;
    ok(gn_device_create(&device_desc, &device));
    for (uint32_t from = 0; from < FRAMES - 1; from++) {
        y = make_yard(true);
        pose(&y, 0);
        view = new_view(ACROSS, DOWN);
        ok(gn_view_load_history(view, y.scene, paths[from]));
        for (uint32_t n = from + 1; n < FRAMES && n < from + 4; n++) {
            render_frame(view, &y, &desc, n, again);
            if (memcmp(again, planes + n * size, size * sizeof *again) == 0)
                continue;
            size_t wrong = 0, where = 0;
            for (size_t i = 0; i < size; i++)
                if (memcmp(again + i, planes + n * size + i, sizeof *again) != 0) {
                    wrong++;
                    where = i;
                }
            fail_msg("%s, saved after frame %u, frame %u: %zu of %zu values differ, %g and %g",
                     method, from, n, wrong, size, (double)planes[n * size + where],
                     (double)again[where]);
        }
        gn_view_destroy(&view);
        gn_scene_destroy(&y.scene);
    }
    gn_device_destroy(&device);
    device = first;
    for (uint32_t n = 0; n < FRAMES; n++)
        unlink(paths[n]);
    free(planes);
    free(again);
}

static void test_sequences_go_on(void **state)
{
    (void)state;
    gn_map_desc map = small_desc();
    map.resolution = 128;
    check_sequence("lt-vsm", &map);
    check_sequence("lt-esm", &map);
    check_sequence("hybrid-pcf", &map);
    check_sequence("nlmsm64", &map);
    check_sequence("ray", &map);
    map.refresh = 3;
    map.cascades = 2;
    check_sequence("lt-evsm", &map);
    check_sequence("lt-nlmsm32", &map);
}

/* Refusals ------------------------------------------------------------------------------------ */

static void assert_refused(gn_result result, gn_result expected, const char *words)
{
    const char *message = gn_device_message(device);
    if (result != expected || !strstr(message, words))
        fail_msg("%s: \"%s\"; expected %s with \"%s\"", gn_result_string(result), message,
                 gn_result_string(expected), words);
}

static void refuse(const gn_scene *scene, const char *path, gn_result expected, const char *words)
{
    gn_history *history = (gn_history *)scene; /* to be overwritten */
    const size_t held = gn_device_bytes(device);
    assert_refused(gn_history_load(scene, path, &history), expected, words);
    if (path && *path && !strstr(gn_device_message(device), path))
        fail_msg("\"%s\" does not name %s", gn_device_message(device), path);
    assert_null(history);
    assert_int_equal(gn_device_bytes(device), held);
}

static void test_refusals(void **state)
{
    (void)state;
    const gn_gbuffer g = {.width = 5, .height = 4};
    gn_scene *scene = many_lights(2);
    gn_history *history = new_history(device);
    unlink(one);
    assert_refused(gn_history_save(history, one), GN_ERROR_STATE, "the history is empty");
    assert_int_not_equal(access(one, F_OK), 0);
    begin(history, scene, 0, &g, false);
    assert_refused(gn_history_save(history, ""), GN_ERROR_INVALID_ARGUMENT, "empty");
    assert_refused(gn_history_save(history, folder), GN_ERROR_IO, folder);
    assert_refused(gn_history_save(history, "/nowhere/at/all"), GN_ERROR_IO, "/nowhere/at/all");
    assert_refused(gn_history_save(history, "/dev/full"), GN_ERROR_IO, "/dev/full");
    ok(gn_history_save(history, one));

    refuse(scene, "/nowhere/at/all", GN_ERROR_IO, "No such file");
    refuse(scene, folder, GN_ERROR_IO, "not a regular file");
    refuse(scene, "", GN_ERROR_INVALID_ARGUMENT, "empty");
    refuse(scene, NULL, GN_ERROR_INVALID_ARGUMENT, "empty");
    write_all(two, (const uint8_t *)"GNHISTORY of the world, in 12 volumes", 36);
    refuse(scene, two, GN_ERROR_UNSUPPORTED, "version");
    write_all(two, (const uint8_t *)"\x89PNG\r\n and so on and so on", 27);
    refuse(scene, two, GN_ERROR_FORMAT, "no history");

    /* Other scenes. */
    gn_scene *other = many_lights(3);
    refuse(other, one, GN_ERROR_INVALID_ARGUMENT, "of 6 nodes; this one has 7");
    gn_scene_destroy(&other);
    other = new_scene();
    place(other, add_floor(other, 3, 0, GN_NONE), false);
    place(other, add_box(other, v3(-1, 0.5, -1), v3(1, 1, 1.5), GN_NONE), false);
    add_sun(other, v3(1, 2, 0.3));
    add_sun(other, v3(1, 2, 0.3));
    add_camera(other, v3(2, 3, 5), v3(0, 0, 0), 0.7, 0.1);
    add_camera(other, v3(2, 3, 5), v3(0, 0, 0), 0.7, 0.1);
    refuse(other, one, GN_ERROR_STATE, "not committed");
    ok(gn_scene_commit(other));
    refuse(other, one, GN_ERROR_INVALID_ARGUMENT, "whose meshes");
    gn_scene_destroy(&other);

    /* Views. */
    gn_view *view = new_view(5, 4), *wide = new_view(6, 4);
    assert_refused(gn_view_load_history(view, scene, one), GN_ERROR_FORMAT, "frame before");
    assert_refused(gn_view_save_history(view, two), GN_ERROR_STATE, "no frame");
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = gn_method_find("lt-vsm");
    desc.map = tiny_map();
    ok(gn_view_render(view, scene, 0, &desc, (const uint32_t[]){0, 1}, 2));
    ok(gn_view_render(wide, scene, 0, &desc, (const uint32_t[]){0, 1}, 2));
    ok(gn_view_save_history(wide, two));
    assert_refused(gn_view_load_history(view, scene, two), GN_ERROR_INVALID_ARGUMENT,
                   "6 x 4 pixels; this one has 5 x 4");
    gn_visibility_stats stats[2] = {{.lod = NULL}};
    gn_view_set_stats(view, stats);
    ok(gn_view_render(view, scene, 0, &desc, (const uint32_t[]){0, 1}, 2));
    assert_true(stats[0].leak.tested > 0 && stats[0].leak.lost == 0); /* it is unchanged */
    gn_view_set_stats(view, NULL);
    gn_history *loaded;
    ok(gn_history_load(scene, two, &loaded)); /* a view's file is a history's too */
    gn_history_destroy(&loaded);
    gn_view_destroy(&view);
    gn_view_destroy(&wide);
    gn_history_destroy(&history);
    gn_scene_destroy(&scene);
}

/* Damage -------------------------------------------------------------------------------------- */

/* Refuses what no small picture needs: a file may ask for much. */
static int allocations_left;

static void *modest_alloc(size_t size, void *user)
{
    (void)user;
    if (size > (size_t)1 << 22 || __atomic_sub_fetch(&allocations_left, 1, __ATOMIC_SEQ_CST) < 0)
        return NULL;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void modest_free(void *pointer, size_t size, void *user)
{
    (void)size;
    (void)user;
    free(pointer);
}

static gn_device *modest_device(void)
{
    gn_device *const plenty = device;
    gn_device_desc desc = gn_device_desc_default();
    desc.allocator = (gn_allocator){modest_alloc, modest_free, NULL};
    desc.threads = 1;
    allocations_left = INT32_MAX;
    ok(gn_device_create(&desc, &device));
    return plenty;
}

static gn_visibility_desc small_leak(void)
{
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = gn_method_find("lt-esm"); /* it keeps depth */
    desc.map.resolution = 32;
    desc.map.cascades = 2;
    desc.map.distance = 6; /* so that no layer holds the scene */
    desc.map.enlarge = 0;
    desc.map.refresh = 3;
    return desc;
}

/* Some frames of a view of 5 x 4 pixels, with two lights; the last camera asks for new layers, of
 * which a part is drawn. */
static content small_file(gn_view *view, const gn_scene *scene)
{
    const gn_visibility_desc desc = small_leak();
    for (uint32_t n = 0; n < 4; n++)
        ok(gn_view_render(view, scene, n / 3, &desc, (const uint32_t[]){0, 1}, 2));
    gn_map_state map;
    gn_shadow_map_save_state(gn_history_map(gn_view_history(view), 0), &map);
    assert_true(map.layers[0].used && map.layers[0].parts > 0);
    ok(gn_view_save_history(view, one));
    return read_all(one);
}

static void test_cut_short(void **state)
{
    (void)state;
    gn_scene *scene = many_lights(2);
    gn_view *view = new_view(5, 4);
    content c = small_file(view, scene);
    print_message("%zu bytes\n", c.size);
    const size_t held = gn_device_bytes(device);
    for (size_t size = 0; size <= c.size + 1; size++) {
        gn_history *history;
        gn_last_frame last = {.width = 5, .height = 4};
        uint8_t *exact = malloc(size + 1); /* so that AddressSanitizer sees its end */
        assert_non_null(exact);
        memcpy(exact, c.data, size < c.size ? size : c.size);
        const gn_result result =
            gn_history_read_memory(scene, "a file", exact, size, &history, &last);
        if ((result == GN_OK) != (size == c.size))
            fail_msg("%zu of %zu bytes: %s", size, c.size, gn_result_string(result));
        if (result != GN_OK)
            assert_true(!history && !last.world && strstr(gn_device_message(device), "a file"));
        if (size > 20 && size != c.size)
            assert_refused(result, GN_ERROR_FORMAT, "checksum");
        /* The same with a checksum that is right. */
        if (size > 20 && size < c.size) {
            const uint64_t sum = gn_checksum(GN_CHECKSUM_START, exact, size - 8);
            for (int k = 0; k < 8; k++)
                exact[size - 8 + (size_t)k] = (uint8_t)(sum >> 8 * k);
            const gn_result short_result =
                gn_history_read_memory(scene, "a file", exact, size, &history, &last);
            assert_int_equal(short_result, GN_ERROR_FORMAT);
            assert_true(!history && !last.world);
        }
        gn_free(scene->context, last.world);
        gn_history_destroy(&history);
        free(exact);
        assert_int_equal(gn_device_bytes(device), held);
    }
    free(c.data);
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
}

/* A note goes along, and one that is too long does not. */
static void test_notes(void **state)
{
    (void)state;
    gn_scene *scene = many_lights(2);
    gn_view *view = new_view(5, 4);
    const gn_visibility_desc desc = small_leak();
    ok(gn_view_render(view, scene, 0, &desc, (const uint32_t[]){0, 1}, 2));
    gn_history *history = gn_view_history(view), *loaded;
    char *longest = malloc(GN_MAX_NOTE + 2);
    memset(longest, 'x', GN_MAX_NOTE + 1);
    longest[GN_MAX_NOTE + 1] = '\0';
    assert_int_equal(gn_history_set_note(history, longest), GN_ERROR_INVALID_ARGUMENT);
    assert_string_equal(gn_history_note(history), "");
    longest[GN_MAX_NOTE] = '\0';
    const char *const notes[] = {"frame 7\nof a walk", longest, NULL};
    for (size_t i = 0; i < sizeof notes / sizeof *notes; i++) {
        ok(gn_history_set_note(history, notes[i]));
        loaded = reload(history, scene);
        assert_string_equal(gn_history_note(loaded), notes[i] ? notes[i] : "");
        gn_history_destroy(&loaded);
    }
    ok(gn_history_set_note(history, "frame 8"));
    ok(gn_view_save_history(view, one));
    ok(gn_history_set_note(history, "another"));
    ok(gn_view_load_history(view, scene, one));
    assert_string_equal(gn_history_note(gn_view_history(view)), "frame 8");
    free(longest);
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
}

/* Random bits of a byte. With its own checksum a file is always refused; with the right one it
 * is refused or gives a history with which a frame can be rendered. */
static void test_damage(void **state)
{
    (void)state;
    gn_device *const plenty = modest_device();
    gn_scene *scene = many_lights(2);
    gn_view *view = new_view(5, 4);
    content c = small_file(view, scene);
    const gn_visibility_desc desc = small_leak();
    uint64_t random = 3;
    uint32_t refused = 0, taken = 0, failed = 0;
    for (size_t at = 0; at < c.size; at += 1 + random_below(&random, 3)) {
        const uint8_t was = c.data[at];
        c.data[at] ^= (uint8_t)(1 + random_below(&random, 255));
        gn_history *history;
        assert_refused(gn_history_read_memory(scene, one, c.data, c.size, &history, NULL),
                       at >= 8 && at < 12 ? GN_ERROR_UNSUPPORTED : GN_ERROR_FORMAT, one);
        if (at < c.size - 8) {
            uint8_t *end = c.data + c.size - 8, sums[8];
            memcpy(sums, end, sizeof sums);
            const uint64_t sum = gn_checksum(GN_CHECKSUM_START, c.data, c.size - 8);
            for (int k = 0; k < 8; k++)
                end[k] = (uint8_t)(sum >> 8 * k);
            write_all(one, c.data, c.size);
            if (gn_view_load_history(view, scene, one) != GN_OK) {
                assert_true(strstr(gn_device_message(device), one) != NULL);
                refused++;
            } else if (gn_view_render(view, scene, 1, &desc, (const uint32_t[]){0, 1}, 2) !=
                       GN_OK) {
                failed++;
            } else {
                taken++;
            }
            memcpy(end, sums, sizeof sums);
        }
        c.data[at] = was;
    }
    print_message("%u refused, %u taken, %u of them without the next frame\n", refused,
                  taken + failed, failed);
    assert_true(refused > 100 && taken > 100);
    free(c.data);
    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
    gn_device_destroy(&device);
    device = plenty;
}

/* Wherever memory ends: an error, nothing lost, and it goes on. */
static void test_lack_of_memory(void **state)
{
    (void)state;
    gn_device *const plenty = modest_device();
    gn_scene *scene = many_lights(4);
    const gn_visibility_desc desc = small_leak();
    const uint32_t lights[] = {0, 1, 2, 3};
    uint32_t failures = 0;
    gn_result result = GN_ERROR_OUT_OF_MEMORY;
    gn_view *first = new_view(5, 4);
    ok(gn_view_render(first, scene, 0, &desc, lights, 4)); /* what the scene keeps, it has now */
    gn_view_destroy(&first);
    for (int allowed = 0; result != GN_OK && allowed < 1000; allowed++) {
        const size_t held = gn_device_bytes(device);
        gn_view *view = new_view(5, 4), *next = new_view(5, 4);
        ok(gn_view_render(view, scene, 0, &desc, lights, 1));
        allocations_left = allowed;
        result = gn_view_render(view, scene, 0, &desc, lights, 4);
        if (result == GN_OK)
            result = gn_view_save_history(view, one);
        if (result == GN_OK)
            result = gn_view_load_history(next, scene, one);
        allocations_left = INT32_MAX;
        failures += result != GN_OK;
        if (result != GN_OK && !strstr(gn_device_message(device), "memory"))
            fail_msg("with %d allocations: %s", allowed, gn_device_message(device));
        ok(gn_view_render(view, scene, 0, &desc, lights, 4));
        ok(gn_view_render(next, scene, 0, &desc, lights, 4));
        assert_memory_equal(gn_view_visibility(view, 3), gn_view_visibility(next, 3),
                            20 * sizeof(float));
        gn_view_destroy(&view);
        gn_view_destroy(&next);
        assert_int_equal(gn_device_bytes(device), held);
    }
    print_message("%u allocations failed\n", failures);
    assert_true(failures > 30 && result == GN_OK);
    gn_scene_destroy(&scene);
    gn_device_destroy(&device);
    device = plenty;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_masks_go_on), cmocka_unit_test(test_sequences_go_on),
        cmocka_unit_test(test_refusals),    cmocka_unit_test(test_cut_short),
        cmocka_unit_test(test_damage),      cmocka_unit_test(test_lack_of_memory),
        cmocka_unit_test(test_notes)};
    return cmocka_run_group_tests_name("history_file", tests, open_all, close_all);
}
