/* A court of columns, arches, stairs and walls, with a siege tower that rolls around it.
 *
 * Up to scale 1 curves are refined; beyond it the court is repeated around itself. */
#include "scene/procedural.h"

#define SIDE 44.0f /* metres from the middle of a court to the next one's */

static const gn_vec toward_sun = {0.46f, 0.574f, 0.677f}; /* elevation 35 degrees */

typedef struct stones {
    uint32_t masonry, paving, marble, planks, shingles, iron;
} stones;

typedef struct court {
    uint32_t ground, wall, tower, column, beam, arch, stairs, railing, podium, obelisk;
} court;

/* The shaft of a fluted column, u around, v up. */
static gn_vec shaft_surface(float u, float v, const void *user)
{
    (void)user;
    float turn = -2 * GN_PI * (u == 1 ? 0 : u);
    float swell = 0.34f - 0.06f * v * v + 0.01f * sinf(GN_PI * v);
    float radius = swell - 0.022f * fabsf(sinf(10 * turn));
    return (gn_vec){radius * cosf(turn), 0.45f + 3.7f * v, radius * sinf(turn)};
}

static uint32_t make_column(gn_maker *maker, const stones *stone)
{
    gn_shape shape = gn_shape_begin(maker, stone->marble);
    uint32_t sides = gn_refine(maker, 32, 4);
    gn_shape_box(&shape, (gn_vec){0, 0.09f, 0}, (gn_vec){0.5f, 0.09f, 0.5f}, 0, 1);
    const float base[7][2] = {{0.46f, 0.18f}, {0.48f, 0.23f}, {0.46f, 0.28f}, {0.39f, 0.31f},
                              {0.42f, 0.36f}, {0.41f, 0.41f}, {0.33f, 0.45f}};
    const float top[5][2] = {
        {0.27f, 4.15f}, {0.32f, 4.2f}, {0.32f, 4.24f}, {0.44f, 4.4f}, {0.44f, 4.42f}};
    gn_shape_lathe(&shape, (gn_vec){0, 0, 0}, base, 7, sides, 2, 1);
    gn_shape_surface(&shape, gn_refine(maker, 80, 4), gn_refine(maker, 6, 4), shaft_surface, NULL,
                     2, 4);
    gn_shape_lathe(&shape, (gn_vec){0, 0, 0}, top, 5, sides, 2, 1);
    gn_shape_box(&shape, (gn_vec){0, 4.5f, 0}, (gn_vec){0.48f, 0.08f, 0.48f}, 0, 1);
    return gn_make_mesh(maker, "Column", &shape, 1);
}

/* The inner side of a round arch, u along the depth, v around. */
static gn_vec vault_surface(float u, float v, const void *user)
{
    const float *arch = user; /* radius, height of its middle */
    float turn = GN_PI * v;
    return (gn_vec){-arch[0] * cosf(turn), arch[1] + arch[0] * sinf(turn), 0.8f * (1 - 2 * u)};
}

/* A gate with a round arch: two piers, the vault, and the wall above it on both sides. */
static uint32_t make_arch(gn_maker *maker, const stones *stone)
{
    gn_shape shape = gn_shape_begin(maker, stone->masonry);
    const float radius = 1.6f, pier = 2.8f, depth = 0.8f, height = 6.2f, width = 3.1f;
    for (int side = -1; side <= 1; side += 2) {
        float s = (float)side, middle = s * 0.5f * (radius + width);
        gn_shape_box(&shape, (gn_vec){middle, pier / 2, 0},
                     (gn_vec){0.5f * (width - radius), pier / 2, depth}, 0, 2);
        gn_shape_box(&shape, (gn_vec){middle, pier + 0.06f, 0},
                     (gn_vec){0.5f * (width - radius) + 0.08f, 0.06f, depth + 0.08f}, 0, 2);
    }
    uint32_t steps = gn_refine(maker, 32, 4);
    gn_shape_surface(&shape, 2, steps, vault_surface, (const float[]){radius, pier}, 1, 3);
    /* The spandrels: strips from the arch up to the top. */
    for (int side = -1; side <= 1; side += 2) {
        float z = depth * (float)side;
        for (uint32_t i = 0; i < steps; i++) {
            gn_vec ends[2];
            for (uint32_t k = 0; k < 2; k++) {
                float turn = GN_PI * (float)(i + k) / (float)steps;
                ends[k] = (gn_vec){-radius * cosf(turn), pier + radius * sinf(turn), z};
            }
            if (side < 0) {
                gn_vec swap = ends[0];
                ends[0] = ends[1];
                ends[1] = swap;
            }
            const gn_vec strip[4] = {
                ends[0], ends[1], {ends[1].x, height, z}, {ends[0].x, height, z}};
            const float uv[4] = {ends[0].x / 2, 0, ends[1].x / 2, 1};
            gn_shape_quad(&shape, strip, uv);
        }
        float x = 0.5f * (float)side * (radius + width);
        gn_shape_box(&shape, (gn_vec){x, 0.5f * (pier + height), 0},
                     (gn_vec){0.5f * (width - radius), 0.5f * (height - pier), depth}, 0, 2);
    }
    gn_shape_box(&shape, (gn_vec){0, height + 0.15f, 0},
                 (gn_vec){width + 0.2f, 0.15f, depth + 0.2f}, 0, 2);
    gn_shape_box(&shape, (gn_vec){0, height + 0.75f, 0}, (gn_vec){width, 0.45f, depth}, 0, 2);
    return gn_make_mesh(maker, "Arch", &shape, 1);
}

/* A wall along X with a crenellated top, 4 m long. */
static uint32_t make_wall(gn_maker *maker, const stones *stone)
{
    gn_shape shape = gn_shape_begin(maker, stone->masonry);
    gn_shape_box(&shape, (gn_vec){0, 2.2f, 0}, (gn_vec){2, 2.2f, 0.5f}, 0, 2);
    gn_shape_box(&shape, (gn_vec){0, 4.45f, 0}, (gn_vec){2, 0.08f, 0.6f}, 0, 2);
    for (int i = 0; i < 3; i++)
        gn_shape_box(&shape, (gn_vec){-1.33f + 1.33f * (float)i, 4.93f, 0.35f},
                     (gn_vec){0.38f, 0.4f, 0.15f}, 0, 1);
    return gn_make_mesh(maker, "Wall", &shape, 1);
}

static uint32_t make_tower(gn_maker *maker, const stones *stone)
{
    gn_shape shapes[2] = {gn_shape_begin(maker, stone->masonry),
                          gn_shape_begin(maker, stone->shingles)};
    uint32_t sides = gn_refine(maker, 40, 4);
    const float body[6][2] = {{2.1f, 0},    {1.9f, 1.2f}, {1.85f, 6.2f},
                              {2.2f, 6.8f}, {2.2f, 7.6f}, {0, 7.6f}};
    const float roof[3][2] = {{2.5f, 7.4f}, {1.2f, 9}, {0, 11}};
    gn_shape_lathe(&shapes[0], (gn_vec){0, 0, 0}, body, 6, sides, 6, 2);
    gn_shape_lathe(&shapes[1], (gn_vec){0, 0, 0}, roof, 3, sides, 6, 2);
    return gn_make_mesh(maker, "Tower", shapes, 2);
}

static uint32_t make_stairs(gn_maker *maker, const stones *stone)
{
    gn_shape shape = gn_shape_begin(maker, stone->paving);
    for (int i = 0; i < 8; i++) {
        float rise = 0.16f * (float)(i + 1), depth = 0.36f * (float)(8 - i);
        gn_shape_box(&shape, (gn_vec){0, rise / 2, -depth / 2}, (gn_vec){2.4f, rise / 2, depth / 2},
                     0, 2);
    }
    return gn_make_mesh(maker, "Stairs", &shape, 1);
}

/* A stone balustrade along X, 2 m long. */
static uint32_t make_railing(gn_maker *maker, const stones *stone)
{
    gn_shape shape = gn_shape_begin(maker, stone->marble);
    const float baluster[8][2] = {{0.07f, 0.12f}, {0.05f, 0.17f}, {0.085f, 0.32f}, {0.08f, 0.42f},
                                  {0.04f, 0.6f},  {0.04f, 0.68f}, {0.065f, 0.73f}, {0.065f, 0.78f}};
    gn_shape_box(&shape, (gn_vec){0, 0.06f, 0}, (gn_vec){1, 0.06f, 0.14f}, 0, 1);
    gn_shape_box(&shape, (gn_vec){0, 0.84f, 0}, (gn_vec){1, 0.06f, 0.13f}, 0, 1);
    for (int i = 0; i < 7; i++)
        gn_shape_lathe(&shape, (gn_vec){-0.858f + 0.286f * (float)i, 0, 0}, baluster, 8,
                       gn_refine(maker, 12, 4), 1, 1);
    return gn_make_mesh(maker, "Balustrade", &shape, 1);
}

static uint32_t make_boxes(gn_maker *maker, const char *name, uint32_t material, gn_vec center,
                           gn_vec half, float tile)
{
    gn_shape shape = gn_shape_begin(maker, material);
    gn_shape_box(&shape, center, half, 0, tile);
    return gn_make_mesh(maker, name, &shape, 1);
}

/* A pointed stone pillar on steps. */
static uint32_t make_obelisk(gn_maker *maker, const stones *stone)
{
    gn_shape shape = gn_shape_begin(maker, stone->marble);
    const float needle[4][2] = {{0.55f, 0.92f}, {0.36f, 5.8f}, {0.3f, 6.0f}, {0, 6.6f}};
    gn_shape_box(&shape, (gn_vec){0, 0.12f, 0}, (gn_vec){1.5f, 0.12f, 1.5f}, 0, 2);
    gn_shape_box(&shape, (gn_vec){0, 0.36f, 0}, (gn_vec){1.1f, 0.12f, 1.1f}, 0, 2);
    gn_shape_box(&shape, (gn_vec){0, 0.7f, 0}, (gn_vec){0.7f, 0.22f, 0.7f}, 0, 2);
    for (int k = 0; k < 3; k++) {
        float low = needle[k][0], high = needle[k + 1][0], y0 = needle[k][1], y1 = needle[k + 1][1];
        const float uv[4] = {0, 0, 1, 1};
        for (int i = 0; i < 4; i++) {
            float c = i == 0 ? 1 : i == 2 ? -1 : 0, s = i == 1 ? 1 : i == 3 ? -1 : 0;
            /* The side that faces (s, c), from its left to its right. */
            const gn_vec side[4] = {{low * (s - c), y0, low * (c + s)},
                                    {low * (s + c), y0, low * (c - s)},
                                    {high * (s + c), y1, high * (c - s)},
                                    {high * (s - c), y1, high * (c + s)}};
            gn_shape_quad(&shape, side, uv);
        }
    }
    return gn_make_mesh(maker, "Obelisk", &shape, 1);
}

/* A wooden tower on wheels; its front is +Z. */
static uint32_t make_siege_tower(gn_maker *maker, const stones *stone)
{
    gn_shape shapes[2] = {gn_shape_begin(maker, stone->planks), gn_shape_begin(maker, stone->iron)};
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? 1 : -1, z = i & 2 ? 1 : -1;
        gn_shape_beam(&shapes[0], (gn_vec){1.15f * x, 0.4f, 1.25f * z},
                      (gn_vec){0.85f * x, 5.4f, 0.95f * z}, 0.16f, 0.16f, 1);
        const gn_vec axle[2] = {{1.1f * x, 0.42f, 0.9f * z}, {1.45f * x, 0.42f, 0.9f * z}};
        const float wheel[2] = {0.42f, 0.42f}, hub[2] = {0.08f, 0.08f};
        gn_shape_tube(&shapes[0], axle, wheel, 2, gn_refine(maker, 20, 4), 1);
        gn_shape_tube(&shapes[1], axle, hub, 2, gn_refine(maker, 8, 4), 1);
        for (int k = 0; k < 3; k++) {
            gn_vec spoke = {0, 0.41f * cosf(1.05f * (float)k), 0.41f * sinf(1.05f * (float)k)};
            gn_vec middle = gn_vec_along(axle[0], 0.5f, gn_vec_sub(axle[1], axle[0]));
            gn_shape_beam(&shapes[0], gn_vec_sub(middle, spoke), gn_vec_add(middle, spoke), 0.07f,
                          0.07f, 1);
        }
    }
    for (int floor = 0; floor < 3; floor++) {
        float y = 0.75f + 2.0f * (float)floor, half = 1.2f - 0.1f * (float)floor;
        gn_shape_box(&shapes[0], (gn_vec){0, y, 0}, (gn_vec){half, 0.07f, half + 0.1f}, 0, 1);
        for (int k = 0; k < 5 && floor < 2; k++)
            for (int side = -1; side <= 1; side += 2)
                gn_shape_box(&shapes[0],
                             (gn_vec){(float)side * (half - 0.06f), y + 0.3f + 0.34f * (float)k, 0},
                             (gn_vec){0.03f, 0.11f, half}, 0, 1);
        if (floor < 2)
            gn_shape_beam(&shapes[0], (gn_vec){-half, y, half}, (gn_vec){half, y + 1.9f, half},
                          0.1f, 0.1f, 1);
    }
    for (int i = 0; i < 14; i++)
        gn_shape_box(&shapes[0], (gn_vec){0, 0.9f + 0.3f * (float)i, -1.12f},
                     (gn_vec){0.3f, 0.03f, 0.04f}, 0, 1);
    gn_shape_box(&shapes[0], (gn_vec){0, 5.3f, 0.98f}, (gn_vec){0.9f, 0.5f, 0.05f}, 0, 1);
    return gn_make_mesh(maker, "Siege tower", shapes, 2);
}

/* Placing ----------------------------------------------------------------------------------- */

static void put(gn_maker *maker, uint32_t parent, const char *name, uint32_t mesh, float x, float y,
                float z, float yaw)
{
    gn_make_node(maker, name, parent, mesh, (gn_place){{x, y, z}, yaw, 1});
}

/* One court around a node of its own. */
static void put_court(gn_maker *maker, const court *part, gn_vec middle)
{
    uint32_t node = gn_make_node(maker, "Court", GN_NONE, GN_NONE, (gn_place){middle, 0, 1});
    put(maker, node, "Ground", part->ground, 0, 0, 0, 0);
    put(maker, node, "Obelisk", part->obelisk, 4, 0, 2, 0.3f);
    put(maker, node, "Arch", part->arch, 0, 0, 17, 0);
    put(maker, node, "Podium", part->podium, 0, 0, -14, 0);
    put(maker, node, "Stairs", part->stairs, 0, 0, -9, GN_PI);
    for (int side = -1; side <= 1; side += 2) {
        float s = (float)side;
        /* Walls around, towers in the corners. */
        for (int i = 0; i < 8; i++) {
            float along = -14 + 4 * (float)i;
            put(maker, node, "Wall", part->wall, s * 18.5f, 0, along, s * GN_PI / 2);
            if (side < 0)
                put(maker, node, "Wall", part->wall, along, 0, -18.5f, GN_PI);
            else if (i != 3 && i != 4)
                put(maker, node, "Wall", part->wall, along < 0 ? along - 1 : along + 1, 0, 17, 0);
        }
        put(maker, node, "Tower", part->tower, s * 18.5f, 0, -18.5f, 0);
        put(maker, node, "Tower", part->tower, s * 18.5f, 0, 17.5f, 0);
        /* A colonnade along both sides, and the temple front on the podium. */
        for (int i = 0; i < 9; i++)
            put(maker, node, "Column", part->column, s * 13, 0, -8 + 2.6f * (float)i, 0);
        put(maker, node, "Beam", part->beam, s * 13, 4.58f, 2.4f, 0);
        for (int i = 0; i < 4; i++)
            put(maker, node, "Column", part->column, s * (1.4f + 2.3f * (float)i), 1.28f, -9.8f, 0);
        for (int i = 0; i < 3; i++)
            put(maker, node, "Balustrade", part->railing, s * (3.5f + 2.02f * (float)i), 1.28f,
                -9.2f, 0);
    }
    put(maker, node, "Beam", part->beam, 0, 5.86f, -9.8f, GN_PI / 2);
}

/* The place of court number i on a square spiral around the middle. */
static gn_vec spiral(int i)
{
    int x = 0, z = 0, dx = 1, dz = 0, run = 1, left = 1, turns = 0;
    while (i-- > 0) {
        x += dx;
        z += dz;
        if (--left == 0) {
            int swap = dx;
            dx = -dz;
            dz = swap;
            run += ++turns % 2 == 0;
            left = run;
        }
    }
    return (gn_vec){SIDE * (float)x, 0, SIDE * (float)z};
}

static void make_cameras(gn_maker *maker)
{
    gn_make_camera(maker, "CamCourt", (gn_vec){-7.5f, 1.7f, 13}, (gn_vec){1.5f, 2.2f, -4}, 60);
    gn_make_camera(maker, "CamColonnade", (gn_vec){-16.4f, 1.7f, 14.2f}, (gn_vec){-14.6f, 1.4f, 0},
                   60);
    gn_make_camera(maker, "CamTop", (gn_vec){-17, 13, 19}, (gn_vec){2, 0, -2}, 60);
    enum { KEYS = 41 };
    gn_vec eyes[KEYS], targets[KEYS];
    for (int i = 0; i < KEYS; i++) {
        float z = 12 - 14 * (float)i / (KEYS - 1);
        eyes[i] = (gn_vec){-16, 1.7f, z};
        targets[i] = (gn_vec){-14.8f, 1.1f, z - 6};
    }
    gn_make_moving_camera(maker, "CamWalk", eyes, targets, KEYS, 10, 60);
}

void gn_make_court(gn_maker *maker)
{
    const stones stone = {
        gn_make_material(maker, "masonry", GN_SURFACE_SOLID,
                         gn_make_texture_kind(maker, GN_TEXTURE_MASONRY), 0xffffff),
        gn_make_material(maker, "paving", GN_SURFACE_SOLID,
                         gn_make_texture_kind(maker, GN_TEXTURE_PAVING), 0xffffff),
        gn_make_material(maker, "marble", GN_SURFACE_SOLID, GN_NONE, 0xe2dccd),
        gn_make_material(maker, "planks", GN_SURFACE_SHEET,
                         gn_make_texture_kind(maker, GN_TEXTURE_PLANKS), 0xffffff),
        gn_make_material(maker, "shingles", GN_SURFACE_SHEET,
                         gn_make_texture_kind(maker, GN_TEXTURE_SHINGLES), 0xffffff),
        gn_make_material(maker, "iron", GN_SURFACE_SHEET, GN_NONE, 0x4a4c50)};
    const gn_vec whole = {SIDE / 2, 0.5f, SIDE / 2};
    const court part = {
        .ground = make_boxes(maker, "Ground", stone.paving, (gn_vec){0, -0.5f, 0}, whole, 3),
        .wall = make_wall(maker, &stone),
        .tower = make_tower(maker, &stone),
        .column = make_column(maker, &stone),
        .beam = make_boxes(maker, "Beam", stone.marble, (gn_vec){0, 0.3f, 0},
                           (gn_vec){0.45f, 0.3f, 11}, 2),
        .arch = make_arch(maker, &stone),
        .stairs = make_stairs(maker, &stone),
        .railing = make_railing(maker, &stone),
        .podium = make_boxes(maker, "Podium", stone.masonry, (gn_vec){0, 0.64f, 0},
                             (gn_vec){10.5f, 0.64f, 5}, 2),
        .obelisk = make_obelisk(maker, &stone)};

    int courts = (int)(fmax(maker->scale, 1) + 0.5);
    for (int i = 0; i < courts && maker->result == GN_OK; i++)
        put_court(maker, &part, spiral(i));

    /* Around the obelisk in 20 s; the seed says where it starts. */
    enum { STOPS = 12 };
    gn_vec stops[STOPS];
    gn_random random = gn_random_make(maker->seed, 1);
    float start = gn_random_range(&random, -0.1f, 0.1f);
    for (int i = 0; i < STOPS; i++) {
        float turn = start + 2 * GN_PI * (float)i / STOPS;
        stops[i] = (gn_vec){4 - 5.5f * cosf(turn), 0, 2 + 5.5f * sinf(turn)};
    }
    uint32_t tower = gn_make_node(maker, "Siege tower", GN_NONE, make_siege_tower(maker, &stone),
                                  (gn_place){stops[0], 0, 1});
    gn_make_loop(maker, tower, stops, STOPS, 20);

    gn_make_sun(maker, toward_sun, 3);
    gn_make_lamp(maker, (gn_vec){0, 3.2f, 17}, 0xffd9a0, 50, 40, false);
    make_cameras(maker);
}
