/* A Cornell box, open in front, with a tree and a point light. */
#include "scene/procedural.h"

#define HALF     2.5f  /* metres: the box is a cube */
#define CLUSTERS 150.0 /* at scale 1 */

/* A face of the box that looks inward. */
static void add_wall(gn_maker *maker, const char *name, uint32_t color, gn_vec center, gn_vec right,
                     gn_vec up)
{
    gn_shape shape =
        gn_shape_begin(maker, gn_make_material(maker, name, GN_SURFACE_SOLID, GN_NONE, color));
    const gn_vec corners[4] = {
        gn_vec_sub(gn_vec_sub(center, right), up), gn_vec_sub(gn_vec_add(center, right), up),
        gn_vec_add(gn_vec_add(center, right), up), gn_vec_add(gn_vec_sub(center, right), up)};
    const float uv[4] = {0, 0, 1, 1};
    gn_shape_quad(&shape, corners, uv);
    uint32_t mesh = gn_make_mesh(maker, name, &shape, 1);
    gn_make_node(maker, name, GN_NONE, mesh, (gn_place){{0, 0, 0}, 0, 1});
}

static void make_box(gn_maker *maker)
{
    const float h = HALF;
    const gn_vec x = {h, 0, 0}, y = {0, h, 0}, z = {0, 0, h};
    const gn_vec back = {0, 0, -h};
    add_wall(maker, "Floor", 0xd8d4c8, (gn_vec){0, 0, 0}, x, back);
    add_wall(maker, "Ceiling", 0xd8d4c8, (gn_vec){0, 2 * h, 0}, x, z);
    add_wall(maker, "Back", 0xd8d4c8, (gn_vec){0, h, -h}, x, y);
    add_wall(maker, "Left", 0xb03a2c, (gn_vec){-h, h, 0}, back, y);
    add_wall(maker, "Right", 0x4f8a3a, (gn_vec){h, h, 0}, z, y);
}

/* A ball of twigs around the origin, one metre wide. */
static uint32_t make_cluster(gn_maker *maker, uint32_t leaves, uint64_t stream)
{
    gn_random random = gn_random_make(maker->seed, stream);
    gn_shape shape = gn_shape_begin(maker, leaves);
    for (int i = 0; i < 36; i++) {
        gn_vec out = gn_random_direction(&random);
        gn_vec beside = gn_vec_beside(out), third = gn_vec_cross(out, beside);
        float roll = gn_random_range(&random, 0, GN_PI);
        gn_vec across = gn_vec_along(gn_vec_scale(beside, cosf(roll)), sinf(roll), third);
        gn_vec along = gn_vec_unit(gn_vec_along(out, 0.5f, gn_random_direction(&random)));
        across = gn_vec_unit(gn_vec_along(across, -gn_vec_dot(across, along), along));
        float size = gn_random_range(&random, 0.38f, 0.52f);
        gn_shape_card(&shape, gn_vec_scale(out, gn_random_range(&random, 0, 0.12f)),
                      gn_vec_scale(along, size), gn_vec_scale(across, 0.9f * size), out);
    }
    return gn_make_mesh(maker, "Twigs", &shape, 1);
}

/* A trunk and bare branches; the clusters hide where they end. */
static uint32_t make_wood(gn_maker *maker, const gn_vec tips[], int count)
{
    uint32_t bark = gn_make_material(maker, "bark", GN_SURFACE_SOLID,
                                     gn_make_texture_kind(maker, GN_TEXTURE_BARK), 0xffffff);
    gn_shape shape = gn_shape_begin(maker, bark);
    const gn_vec trunk[5] = {{0, -0.02f, 0},
                             {0.03f, 0.5f, 0.02f},
                             {-0.02f, 1.1f, 0},
                             {0.04f, 1.8f, -0.03f},
                             {0, 2.9f, 0}};
    const float thick[5] = {0.17f, 0.11f, 0.095f, 0.075f, 0.02f};
    gn_shape_tube(&shape, trunk, thick, 5, 12, 0.6f);
    for (int i = 0; i < count; i++) {
        float low = 1.0f + 1.3f * (float)i / (float)count;
        gn_vec foot = {0.01f, low, 0}, middle = gn_vec_along(foot, 0.5f, gn_vec_sub(tips[i], foot));
        middle.y -= 0.08f;
        const gn_vec branch[3] = {foot, middle, tips[i]};
        const float radii[3] = {0.045f, 0.03f, 0.008f};
        gn_shape_tube(&shape, branch, radii, 3, 6, 0.4f);
    }
    return gn_make_mesh(maker, "Wood", &shape, 1);
}

void gn_make_leafbox(gn_maker *maker)
{
    make_box(maker);
    enum { TIPS = 14 };
    gn_random random = gn_random_make(maker->seed, 1);
    gn_vec tips[TIPS];
    for (int i = 0; i < TIPS; i++) {
        float turn = 2.39996f * (float)i, t = (float)i / (TIPS - 1);
        float away = gn_mix(1.15f, 0.45f, t * t) * gn_random_range(&random, 0.85f, 1.1f);
        tips[i] = (gn_vec){away * cosf(turn), gn_mix(1.75f, 3.1f, t), away * sinf(turn)};
    }
    gn_vec foot = {-0.35f, 0, -0.35f};
    uint32_t wood = make_wood(maker, tips, TIPS);
    uint32_t tree = gn_make_node(maker, "Tree", GN_NONE, wood, (gn_place){foot, 0.6f, 1});

    /* More clusters are smaller ones: the crown keeps its area of leaves. */
    uint32_t leaves = gn_make_material(maker, "leaves", GN_SURFACE_CUTOUT,
                                       gn_make_texture_kind(maker, GN_TEXTURE_BIRCH), 0xffffff);
    const uint32_t clusters[2] = {make_cluster(maker, leaves, 2), make_cluster(maker, leaves, 3)};
    uint32_t count = (uint32_t)(CLUSTERS * maker->scale + 0.5);
    count = count > 0 ? count : 1;
    float size = 0.46f / (float)sqrt(fmax(maker->scale, 0.3));
    for (uint32_t i = 0; i < count; i++) {
        gn_vec tip = tips[i % TIPS];
        float spread = i < TIPS ? 0.05f : 0.42f;
        gn_vec at = gn_vec_along(tip, spread * cbrtf(gn_random_range(&random, 0, 1)),
                                 gn_random_direction(&random));
        gn_make_node(maker, "Twigs", tree, clusters[i % 2],
                     (gn_place){at, gn_random_range(&random, 0, 2 * GN_PI),
                                size * gn_random_range(&random, 0.85f, 1.15f)});
    }

    gn_make_lamp(maker, (gn_vec){0.9f, 4.2f, 0.9f}, 0xffe9c8, 20, 30, true);
    gn_make_camera(maker, "CamFront", (gn_vec){0, 2.5f, 8.2f}, (gn_vec){0, 2.4f, 0}, 40);
    gn_make_camera(maker, "CamUnder", (gn_vec){0.9f, 0.35f, 1.9f}, (gn_vec){-0.3f, 2.2f, -0.4f},
                   70);
    gn_make_camera(maker, "CamFloor", (gn_vec){1.6f, 4.2f, 2.3f}, (gn_vec){-0.4f, 0.3f, -0.4f}, 60);
    /* Orbits within the open front; closed. */
    enum { KEYS = 61 };
    gn_vec eyes[KEYS], targets[KEYS];
    for (int i = 0; i < KEYS; i++) {
        float turn = 2 * GN_PI * (float)(i % (KEYS - 1)) / (KEYS - 1);
        eyes[i] = (gn_vec){1.7f * sinf(turn), 2.2f + 0.8f * cosf(turn), 4.6f};
        targets[i] = (gn_vec){-0.2f, 1.9f, -0.4f};
    }
    gn_make_moving_camera(maker, "CamOrbit", eyes, targets, KEYS, 10, 55);
}
