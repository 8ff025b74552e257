/* Two settings that are hard for filtered shadow maps.
 *
 * This work is based on: Christoph Peters, "Non-linearly Quantized Moment Shadow Maps", 2017: its
 * Figure 1 (a railing shadows a banner, the banner the ground, both over a short range) and its
 * Figure 9 (umbrella, roof and railing, one behind the other, shadow one line on the ground). */
#include "scene/procedural.h"

#define BAY  4.0f /* metres of railing from pillar to pillar */
#define BAYS 11.0 /* up to scale 1 */

/* From behind the railing, 43 degrees high. */
static const gn_vec toward_sun = {0.32f, 0.682f, 0.657f};

typedef struct parts {
    uint32_t bay, banner, ground;
} parts;

/* A cloth drawn from the middle of the railing down to the ground in front; u across, v up. */
static gn_vec banner_surface(float u, float v, const void *user)
{
    (void)user;
    float fall = 1 - v, wave = 0.025f * sinf(11 * u + 2 * v) + 0.012f * sinf(27 * u + 1);
    float sag = 0.28f * fall * v;
    return (gn_vec){2.8f * (0.5f - u), 0.07f + 0.57f * v - 0.35f * sag + wave * (0.3f + fall),
                    -0.06f - 1.05f * fall + 0.5f * wave * fall};
}

static gn_vec umbrella_surface(float u, float v, const void *user)
{
    const float *radius = user;
    float turn = -2 * GN_PI * (u == 1 ? 0 : u), away = v == 1 ? 0 : *radius * (1 - v);
    float rib = 1 - 0.05f * (1 - v) * (1 - cosf(8 * turn)) * 0.5f;
    float height = 0.62f * (1 - powf(1 - v, 1.7f));
    return (gn_vec){away * rib * cosf(turn), height * rib, away * rib * sinf(turn)};
}

/* One bay along X: two pillars' worth of masonry, bars, and rails above and below. */
static uint32_t make_bay(gn_maker *maker, uint32_t masonry, uint32_t iron)
{
    gn_shape shapes[2] = {gn_shape_begin(maker, masonry), gn_shape_begin(maker, iron)};
    float x = -BAY / 2;
    gn_shape_box(&shapes[0], (gn_vec){x, 0.62f, 0}, (gn_vec){0.2f, 0.62f, 0.2f}, 0, 1);
    gn_shape_box(&shapes[0], (gn_vec){x, 1.28f, 0}, (gn_vec){0.25f, 0.05f, 0.25f}, 0, 1);
    gn_shape_box(&shapes[0], (gn_vec){0, 0.07f, 0}, (gn_vec){BAY / 2 - 0.2f, 0.07f, 0.12f}, 0, 1);
    const float rails[2] = {0.24f, 1.06f};
    for (unsigned i = 0; i < 2; i++) {
        const gn_vec ends[2] = {{x, rails[i], 0}, {-x, rails[i], 0}};
        const float radius[2] = {0.024f, 0.024f};
        gn_shape_tube(&shapes[1], ends, radius, 2, gn_refine(maker, 10, 3), 1);
    }
    for (int i = 0; i < 28; i++) {
        /* Bars with a knob, every other one higher. */
        float at = x + 0.27f + 0.1283f * (float)i, knob = i % 2 ? 0.55f : 0.72f;
        const float profile[6][2] = {{0.011f, 0.13f},         {0.011f, knob - 0.05f},
                                     {0.028f, knob - 0.015f}, {0.028f, knob + 0.015f},
                                     {0.011f, knob + 0.05f},  {0.011f, 1.07f}};
        gn_shape_lathe(&shapes[1], (gn_vec){at, 0, 0}, profile, 6, gn_refine(maker, 8, 3), 1, 1);
    }
    return gn_make_mesh(maker, "Railing", shapes, 2);
}

static uint32_t make_banner(gn_maker *maker, uint32_t cloth, uint32_t wood)
{
    gn_shape shapes[2] = {gn_shape_begin(maker, cloth), gn_shape_begin(maker, wood)};
    uint32_t cells = gn_refine(maker, 28, 3);
    gn_shape_surface(&shapes[0], cells, cells, banner_surface, NULL, 1, 1);
    gn_shape_beam(&shapes[1], (gn_vec){-1.46f, 0.63f, -0.05f}, (gn_vec){1.46f, 0.63f, -0.05f},
                  0.035f, 0.035f, 1);
    /* Pegs that hold its lower corners. */
    for (int side = -1; side <= 1; side += 2)
        gn_shape_beam(&shapes[1], (gn_vec){1.4f * (float)side, 0, -1.13f},
                      (gn_vec){1.4f * (float)side, 0.22f, -1.1f}, 0.03f, 0.03f, 1);
    return gn_make_mesh(maker, "Banner", shapes, 2);
}

/* Umbrella, roof and railing, each where the ray from the line's middle to the sun passes it. */
static void make_terrace(gn_maker *maker, uint32_t bay, uint32_t wood, uint32_t masonry)
{
    const gn_vec line = {12.5f, 0, -2.2f};
    uint32_t canvas = gn_make_material(maker, "umbrella", GN_SURFACE_SHEET, GN_NONE, 0xe6dcc4);
    uint32_t tiles = gn_make_material(maker, "shingles", GN_SURFACE_SOLID,
                                      gn_make_texture_kind(maker, GN_TEXTURE_SHINGLES), 0xffffff);
    uint32_t paint = gn_make_material(maker, "line", GN_SURFACE_SOLID, GN_NONE, 0xf2f0e6);

    /* The line lies 4 mm high: one side of it is what shadows must not leak onto. */
    gn_shape shape = gn_shape_begin(maker, paint);
    gn_shape_box(&shape, (gn_vec){0, 0.002f, 0}, (gn_vec){2.6f, 0.002f, 0.06f}, 0, 1);
    uint32_t mesh = gn_make_mesh(maker, "Line", &shape, 1);
    gn_make_node(maker, "Line", GN_NONE, mesh, (gn_place){line, 0, 1});

    gn_vec at = gn_vec_along(line, 0.85f / toward_sun.y, toward_sun);
    gn_make_node(maker, "Terrace railing", GN_NONE, bay, (gn_place){{at.x, 0, at.z}, 0, 1});

    at = gn_vec_along(line, 2.5f / toward_sun.y, toward_sun);
    const float radius = 1.5f, thin[2] = {0.022f, 0.018f};
    const gn_vec pole[2] = {{0, -2.4f, 0}, {0, 0.62f, 0}};
    gn_shape shapes[2] = {gn_shape_begin(maker, canvas), gn_shape_begin(maker, wood)};
    gn_shape_surface(&shapes[0], 2 * gn_refine(maker, 24, 3), gn_refine(maker, 10, 3),
                     umbrella_surface, &radius, 1, 1);
    gn_shape_tube(&shapes[1], pole, thin, 2, gn_refine(maker, 10, 3), 1);
    gn_shape_box(&shapes[1], (gn_vec){0, -2.36f, 0}, (gn_vec){0.25f, 0.04f, 0.25f}, 0, 1);
    mesh = gn_make_mesh(maker, "Umbrella", shapes, 2);
    gn_make_node(maker, "Umbrella", GN_NONE, mesh, (gn_place){{at.x, 2.4f, at.z}, 0, 1});

    /* A roof on four posts, open towards the railing. */
    at = gn_vec_along(line, 4.2f / toward_sun.y, toward_sun);
    gn_shape roof[3] = {gn_shape_begin(maker, tiles), gn_shape_begin(maker, wood),
                        gn_shape_begin(maker, masonry)};
    const float x = 2.3f, z = 1.3f, low = 3.95f, high = 4.45f;
    const gn_vec top[4] = {{x, high, -z}, {-x, high, -z}, {-x, low, z}, {x, low, z}};
    const gn_vec under[4] = {
        {-x, high - 0.1f, -z}, {x, high - 0.1f, -z}, {x, low - 0.1f, z}, {-x, low - 0.1f, z}};
    const float uv[4] = {0, 0, 3, 1.5f};
    gn_shape_quad(&roof[0], top, uv);
    gn_shape_quad(&roof[1], under, uv);
    for (int i = 0; i < 4; i++) {
        float px = i & 1 ? x - 0.2f : 0.2f - x, pz = i & 2 ? z - 0.2f : 0.2f - z;
        float height = pz > 0 ? low : high - 0.2f;
        gn_shape_box(&roof[1], (gn_vec){px, height / 2, pz}, (gn_vec){0.07f, height / 2, 0.07f}, 0,
                     1);
        gn_shape_box(&roof[2], (gn_vec){px, 0.15f, pz}, (gn_vec){0.16f, 0.15f, 0.16f}, 0, 1);
    }
    for (int side = -1; side <= 1; side += 2) {
        float edge = x * (float)side;
        gn_shape_beam(&roof[1], (gn_vec){edge, high - 0.05f, -z}, (gn_vec){edge, low - 0.05f, z},
                      0.08f, 0.1f, 1);
    }
    mesh = gn_make_mesh(maker, "Roof", roof, 3);
    gn_make_node(maker, "Roof", GN_NONE, mesh, (gn_place){{at.x, 0, at.z}, 0, 1});
}

void gn_make_railing(gn_maker *maker)
{
    uint32_t paving = gn_make_material(maker, "paving", GN_SURFACE_SOLID,
                                       gn_make_texture_kind(maker, GN_TEXTURE_PAVING), 0xffffff);
    uint32_t masonry = gn_make_material(maker, "masonry", GN_SURFACE_SOLID,
                                        gn_make_texture_kind(maker, GN_TEXTURE_MASONRY), 0xffffff);
    uint32_t wood = gn_make_material(maker, "planks", GN_SURFACE_SOLID,
                                     gn_make_texture_kind(maker, GN_TEXTURE_PLANKS), 0xffffff);
    uint32_t cloth = gn_make_material(maker, "cloth", GN_SURFACE_SHEET,
                                      gn_make_texture_kind(maker, GN_TEXTURE_CLOTH), 0xffffff);
    uint32_t iron = gn_make_material(maker, "iron", GN_SURFACE_SOLID, GN_NONE, 0x4a4c50);

    gn_shape shape = gn_shape_begin(maker, paving);
    gn_shape_box(&shape, (gn_vec){0, -0.25f, 0}, (gn_vec){BAY / 2, 0.25f, 30}, 0, 2);
    parts part = {make_bay(maker, masonry, iron), make_banner(maker, cloth, wood),
                  gn_make_mesh(maker, "Ground", &shape, 1)};

    /* From the middle to both sides; each bay with a banner behind it, in its own turn. */
    /* From the middle to both sides; each bay with a banner, a little to the left or right. */
    gn_random random = gn_random_make(maker->seed, 1);
    int bays = (int)(BAYS * fmax(maker->scale, 1));
    for (int i = 0; i < bays; i++) {
        float x = BAY * (float)(i % 2 ? (i + 1) / 2 : -(i / 2));
        float shift = i > 0 ? gn_random_range(&random, -0.4f, 0.4f) : 0;
        gn_make_node(maker, "Ground", GN_NONE, part.ground, (gn_place){{x, 0, 0}, 0, 1});
        /* The terrace has the place of two bays. */
        if (x > 10 && x < 18)
            continue;
        gn_make_node(maker, "Railing", GN_NONE, part.bay, (gn_place){{x, 0, 0}, 0, 1});
        gn_make_node(maker, "Banner", GN_NONE, part.banner, (gn_place){{x + shift, 0, 0}, 0, 1});
    }
    make_terrace(maker, part.bay, wood, masonry);

    gn_make_sun(maker, toward_sun, 3);
    gn_make_lamp(maker, (gn_vec){0.8f, 2.6f, 1.4f}, 0xffd9a0, 12, 30, false);
    gn_make_camera(maker, "CamRailing", (gn_vec){-1.9f, 1.5f, -3.1f}, (gn_vec){0.15f, 0.3f, -0.4f},
                   50);
    gn_make_camera(maker, "CamUmbrella", (gn_vec){9.8f, 1.8f, -6.6f}, (gn_vec){12.9f, 1.1f, 0}, 60);
    gn_make_camera(maker, "CamTop", (gn_vec){5, 9, -9}, (gn_vec){6.5f, 0, 0}, 60);
    enum { KEYS = 41 };
    gn_vec eyes[KEYS], targets[KEYS];
    for (int i = 0; i < KEYS; i++) {
        float x = -8 + 14 * (float)i / (KEYS - 1);
        eyes[i] = (gn_vec){x, 1.7f, -4.3f};
        targets[i] = (gn_vec){x + 2.4f, 0.35f, -0.9f};
    }
    gn_make_moving_camera(maker, "CamWalk", eyes, targets, KEYS, 10, 60);
}
