/* Ray cones through the whole library: the level of detail that a rendered pixel's shadow ray has
 * read is the one that geometry foretells (ray_cone_testing.h). */
#include "ray_cone_testing.h"

/* Where a footprint of these levels lies between two mips; far enough from the half for the 0.05
 * that cones may be off. */
static const double offsets[] = {-0.42, 0.0, 0.42};

/* How the occluder stands in the scene. A child is scaled and turned about the occluder's normal
 * within its parent, which faces the occluder's normal. */
typedef struct placement {
    const char *name;
    double parent_scale[3], scale[3], turn;
    bool moving;
} placement;

static const placement placements[] = {
    {"flat", {1, 1, 1}, {1, 1, 1}, 0, false},
    {"flat, scaled", {1, 1, 1}, {7, 7, 7}, 0, false},
    {"moving", {1, 1, 1}, {1, 1, 1}, 0, true},
    {"moving, small", {1, 1, 1}, {0.01, 0.01, 0.01}, 20, true},
    {"moving, large", {4, 4, 4}, {10, 10, 10}, 20, true},
    {"flat, stretched", {1, 1, 1}, {0.4, 3, 1.7}, 0, false},
    {"moving, stretched", {1, 1, 1}, {0.4, 3, 1.7}, 0, true},
    {"moving, flattened", {1, 1, 1}, {2, 2, 0.02}, 0, true},
    {"moving, mirrored", {1, 1, 1}, {-2, 2, 2}, 0, true},
    {"moving, sheared", {3, 0.5, 1}, {1, 1, 1}, 35, true},
};

/* A MASK material of width x height texels whose every triangle has both kinds of texels. */
static uint32_t add_masked(gn_scene *scene, uint32_t width, uint32_t height)
{
    uint8_t *rgba = malloc((size_t)width * height * 4);
    assert_non_null(rgba);
    for (uint32_t i = 0; i < width * height; i++) {
        rgba[4 * i] = rgba[4 * i + 1] = rgba[4 * i + 2] = 255;
        rgba[4 * i + 3] = (i % width * 5 + i / width * 3) % 7 < 2 ? 255 : 20;
    }
    gn_texture_desc texture = gn_texture_desc_default();
    texture.width = width;
    texture.height = height;
    texture.rgba = rgba;
    gn_material_desc material = gn_material_desc_default();
    ok(gn_scene_add_texture(scene, &texture, &material.texture));
    material.alpha_mode = GN_ALPHA_MASK;
    material.double_sided = true;
    uint32_t index;
    ok(gn_scene_add_material(scene, &material, &index));
    free(rgba);
    return index;
}

static uint32_t add_square(gn_scene *scene, double half_x, double half_y, double turns,
                           uint32_t material)
{
    const vec p[4] = {v3(-half_x, -half_y, 0), v3(half_x, -half_y, 0), v3(half_x, half_y, 0),
                      v3(-half_x, half_y, 0)};
    return add_quad(scene, p, turns, material);
}

/* A node at p whose +Z is n, scaled. */
static uint32_t add_frame(gn_scene *scene, vec p, vec n, const double scale[3])
{
    gn_node_desc desc = gn_node_desc_default();
    desc.use_matrix = true;
    aim(p, sub(p, n), desc.matrix);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 3; i++)
            desc.matrix[4 * c + i] *= (float)scale[c];
    uint32_t node;
    ok(gn_scene_add_node(scene, &desc, &node));
    return node;
}

static const double one[3] = {1, 1, 1};

#define TEXTURE_WIDTH  256u
#define TEXTURE_HEIGHT 64u

/* The occluder: a quad around its point, at most as large as leaves the camera's ray free, with as
 * many turns of the texture as give it texels of `texel_area` square metres in the world. */
static uint32_t add_occluder(gn_scene *scene, const setup *s, const placement *place,
                             double texel_area)
{
    const double half =
        0.3 * fmin(s->occluder_distance * sin(fabs(s->tilt + s->light_tilt)), s->distance);
    double object[2], world_area = 1;
    for (int i = 0; i < 2; i++) {
        const double scale = place->parent_scale[i] * place->scale[i];
        object[i] = half / fabs(scale);
        world_area *= 2 * half;
    }
    const double turns = sqrt(world_area / texel_area / (TEXTURE_WIDTH * TEXTURE_HEIGHT));
    const uint32_t parent =
        add_frame(scene, occluder_point(s), occluder_normal(s), place->parent_scale);
    gn_node_desc desc = gn_node_desc_default();
    desc.parent = parent;
    for (int i = 0; i < 3; i++)
        desc.scale[i] = (float)place->scale[i];
    desc.rotation[2] = (float)sin(0.5 * place->turn * degrees);
    desc.rotation[3] = (float)cos(0.5 * place->turn * degrees);
    desc.mesh = add_square(scene, object[0], object[1], turns,
                           add_masked(scene, TEXTURE_WIDTH, TEXTURE_HEIGHT));
    return place_desc(scene, &desc, place->moving);
}

static uint32_t add_setup_light(gn_scene *scene, const setup *s, gn_light_type type)
{
    gn_light_desc desc = gn_light_desc_default();
    desc.type = type;
    desc.outer_cone_angle = 0.1f;
    const double distance = isinf(s->light_distance) ? 1 : s->light_distance;
    const vec receiver = receiver_point(s);
    return add_light(scene, &desc, add(receiver, mul(to_light(s), distance)), receiver);
}

/* Camera, receiver and light; the occluder is the caller's. */
static gn_scene *make_setup(const setup *s, gn_light_type type)
{
    gn_scene *scene = new_scene();
    const double half = 0.2 * s->distance;
    gn_node_desc desc = gn_node_desc_default();
    desc.parent = add_frame(scene, receiver_point(s), receiver_normal(s), one);
    desc.mesh = add_square(scene, half, half, 1, GN_NONE);
    ok(gn_scene_add_node(scene, &desc, NULL));
    add_camera(scene, v3(0, 0, 0), v3(0, 0, -1), 2 * atan(s->tan_half_fov), 0.01);
    add_setup_light(scene, s, type);
    return scene;
}

/* Level and lookups at the centre of the image. */
typedef struct reading {
    float lod, lookups;
} reading;

static reading read_centre(const gn_scene *scene, const setup *s, const char *method)
{
    const uint32_t width = 8, height = (uint32_t)s->height;
    const size_t pixels = (size_t)width * height, centre = (size_t)(height / 2) * width + width / 2;
    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = width;
    view_desc.height = height;
    gn_view *view;
    ok(gn_view_create(device, &view_desc, &view));
    ok(gn_view_trace_gbuffer(view, scene, 0));

    float *planes = malloc(3 * pixels * sizeof *planes);
    assert_non_null(planes);
    gn_visibility_stats stats = {.lod = planes + pixels, .lookups = planes + 2 * pixels};
    gn_visibility_desc desc = gn_visibility_desc_default();
    desc.method = gn_method_find(method);
    ok(gn_scene_visibility(scene, gn_view_gbuffer(view), &desc, planes, &stats));
    const reading r = {stats.lod[centre], stats.lookups[centre]};
    free(planes);
    gn_view_destroy(&view);
    return r;
}

static void check_mip(const gn_scene *scene, const setup *s, const char *method, double level,
                      const char *what)
{
    const reading r = read_centre(scene, s, method);
    const double mip = fmax(floor(level + 0.5), 0);
    if (!(r.lookups >= 1.0f) || (double)r.lod != mip)
        fail_msg("%s, %s: mip %g in %g lookups, the footprint has level %.3f; fov tan %g height %g "
                 "distance %g tilt %.3f light %.3f at %g occluder %.3f at %g",
                 what, method, (double)r.lod, (double)r.lookups, level, s->tan_half_fov, s->height,
                 s->distance, s->tilt, s->light_tilt, s->light_distance, s->occluder_tilt,
                 s->occluder_distance);
}

static double texel_area(const setup *s, double level)
{
    const double texel = carry_pixel(s).extent / exp2(level);
    return texel * texel;
}

/* Cameras, and where the light's side of the scene is. */
static const setup setups[] = {
    {.tan_half_fov = 0.5, .height = 240, .distance = 5, .tilt = 0.5, .light_tilt = 0.5},
    {.tan_half_fov = 0.18, .height = 480, .distance = 60, .tilt = 0.0, .light_tilt = 0.9},
    {.tan_half_fov = 1.19, .height = 1080, .distance = 0.7, .tilt = 1.1, .light_tilt = 0.2},
    {.tan_half_fov = 0.41, .height = 2160, .distance = 400, .tilt = 0.2, .light_tilt = 0.9},
    {.tan_half_fov = 0.7,
     .height = 720,
     .distance = 8,
     .tilt = 0.4,
     .light_tilt = 0.4,
     .occluder_tilt = 1.0},
};
#define SETUPS (sizeof setups / sizeof *setups)

static setup lit_setup(size_t i, gn_light_type type)
{
    setup s = setups[i];
    s.light_distance = type == GN_LIGHT_DIRECTIONAL ? INFINITY : s.distance * (0.5 + (double)i);
    s.occluder_distance = type == GN_LIGHT_DIRECTIONAL ? 0.8 * s.distance : 0.6 * s.light_distance;
    assert_true(is_small(&s));
    return s;
}

static void check_placement(const placement *place, gn_light_type type)
{
    static const double levels[] = {-2, 0, 1, 3, 5};
    for (size_t i = 0; i < SETUPS; i++) {
        const setup s = lit_setup(i, type);
        const double level = levels[(i + (size_t)type) % 5] + offsets[(i + (size_t)type) % 3];
        gn_scene *scene = make_setup(&s, type);
        add_occluder(scene, &s, place, texel_area(&s, level));
        ok(gn_scene_commit(scene));
        check_mip(scene, &s, "ray-raw", level, place->name);
        gn_scene_destroy(&scene);
    }
}

static void test_sun(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof placements / sizeof *placements; i++)
        check_placement(&placements[i], GN_LIGHT_DIRECTIONAL);
}

static void test_point_light(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof placements / sizeof *placements; i++)
        check_placement(&placements[i], GN_LIGHT_POINT);
}

static void test_spot_light(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof placements / sizeof *placements; i++)
        check_placement(&placements[i], GN_LIGHT_SPOT);
}

/* The paper's rules read the same level, mip 0 reads mip 0. */
static void test_rules(void **state)
{
    (void)state;
    for (int type = 0; type < 3; type++) {
        const setup s = lit_setup(0, (gn_light_type)type);
        gn_scene *scene = make_setup(&s, (gn_light_type)type);
        add_occluder(scene, &s, &placements[4], texel_area(&s, 3.2));
        ok(gn_scene_commit(scene));
        for (const gn_method *const *method = gn_methods; *method; method++)
            if ((*method)->map.kind == GN_MAP_NONE && (*method)->alpha != GN_ALPHA_RULE_COVERAGE)
                check_mip(scene, &s, (*method)->name,
                          (*method)->alpha == GN_ALPHA_RULE_MIP0 ? 0 : 3.2, "rule");
        gn_scene_destroy(&scene);
    }
}

/* Coverage, our own, goes by the footprint's area and reads a third of a level finer. Where the
 * light mirrors the camera, cones know the area. */
static void test_coverage(void **state)
{
    (void)state;
    static const size_t mirrored[] = {0,
                                      4}; /* an occluder that faces the light, and a tilted one */
    for (size_t i = 0; i < sizeof placements / sizeof *placements; i++)
        for (int type = 0; type < 3; type++) {
            const setup s = lit_setup(mirrored[i % 2], (gn_light_type)type);
            const double level = 1 + (double)(i % 4) + offsets[(i + (size_t)type) % 3];
            gn_scene *scene = make_setup(&s, (gn_light_type)type);
            add_occluder(scene, &s, &placements[i],
                         carry_pixel(&s).area / exp2(2 * (level + 1.0 / 3)));
            ok(gn_scene_commit(scene));
            check_mip(scene, &s, "ray-coverage", level, placements[i].name);
            gn_scene_destroy(&scene);
        }
}

/* An occluder that grows by its animation: twice the size, one level less, and back. */
static void test_growing(void **state)
{
    (void)state;
    for (int type = 0; type < 3; type++) {
        const setup s = lit_setup(0, (gn_light_type)type);
        gn_scene *scene = make_setup(&s, (gn_light_type)type);
        const placement still = {"growing", {1, 1, 1}, {1, 1, 1}, 0, false};
        gn_channel_desc channel = gn_channel_desc_default();
        channel.node = add_occluder(scene, &s, &still, texel_area(&s, 4.2));
        channel.path = GN_PATH_SCALE;
        channel.key_count = 2;
        channel.times = (const float[]){0, 3};
        channel.values = (const float[]){1, 1, 1, 4, 4, 4};
        ok(gn_scene_add_channel(scene, &channel));
        ok(gn_scene_commit(scene));
        static const double times[] = {0, 1, 3, 1, 0}; /* scales 1, 2, 4 */
        static const double levels[] = {4.2, 3.2, 2.2, 3.2, 4.2};
        for (int i = 0; i < 5; i++) {
            ok(gn_scene_set_time(scene, times[i]));
            ok(gn_scene_commit(scene));
            check_mip(scene, &s, "ray-raw", levels[i], "growing");
        }
        gn_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sun),        cmocka_unit_test(test_point_light),
        cmocka_unit_test(test_spot_light), cmocka_unit_test(test_rules),
        cmocka_unit_test(test_coverage),   cmocka_unit_test(test_growing),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
