/* The grove: a road between trees, a house, fences, a glade with standing stones.
 *
 * The scene is planted from the middle outwards until it has the triangles asked for, and what
 * stands in a cell depends on the cell and the seed alone: the surroundings of the cameras look
 * the same at every size. */
#include "scene/procedural.h"

#include <stdlib.h>

#define TRIANGLES 350000.0 /* at scale 1, with instancing */
#define TILE      64.0f    /* metres: the ground repeats */
#define CELL      6.0f     /* metres: one tree at most */

static const gn_vec toward_sun = {-0.328f, 0.574f, 0.751f}; /* elevation 35 degrees */
static const gn_vec house = {-6, 0, -11.5f};
static const gn_vec glade = {14, 0, -15};

enum {
    OAK,
    OAK_SMALL,
    LIME,
    BIRCH,
    BIRCH_SMALL,
    ASH,
    FIR,
    TREES,
    BUSH = TREES,
    BUSH_WIDE,
    GRASS,
    GRASS_LOW,
    FLOWERS,
    ROCK,
    STONE,
    RAILS,
    NETTING,
    GROUND,
    ROAD,
    HOUSE,
    MESHES
};

typedef struct planting {
    gn_maker *maker;
    uint32_t mesh[MESHES];
    double budget; /* triangles */
} planting;

/* Ground ------------------------------------------------------------------------------------ */

/* Metres; periodic with TILE in both directions. */
static float ground_height(float x, float z)
{
    const float f = 2 * GN_PI / TILE;
    float height = 0.45f * sinf(f * (x + 2 * z)) + 0.35f * sinf(f * (2 * x - z) + 1);
    height += 0.18f * sinf(f * 5 * x + 2) * sinf(f * 4 * z);
    height += 0.06f * sinf(f * (9 * x + 7 * z)) + 0.05f * sinf(f * (11 * z - 6 * x) + 4);
    return height;
}

/* The middle of the road; 0 at both ends of the tile. */
static float road_middle(float x)
{
    const float f = 2 * GN_PI / TILE;
    return 1.6f * sinf(f * x) + 0.7f * sinf(f * 3 * x);
}

static gn_vec on_ground(float x, float z)
{
    return (gn_vec){x, ground_height(x, z), z};
}

/* A strip of the ground tile, between two lines that may follow the road. */
typedef struct strip {
    float low, high; /* metres from the middle of the road, or of the tile */
    bool bent;       /* follows the road where it is near */
} strip;

static gn_vec ground_surface(float u, float v, const void *user)
{
    const strip *part = user;
    /* v grows towards -Z, so that the front looks up; the far edges take the height of the near
     * ones exactly, for tiles to meet without gaps. */
    float x = (u - 0.5f) * TILE, away = gn_mix(part->high, part->low, v);
    float z = away;
    if (part->bent)
        z += road_middle(x) * gn_clamp(1 - fabsf(away) / (0.5f * TILE), 0, 1);
    float ex = u == 1 ? -0.5f * TILE : x, ez = z == 0.5f * TILE ? -0.5f * TILE : z;
    return (gn_vec){x, ground_height(ex, ez), z};
}

static void make_ground(planting *grove)
{
    gn_maker *maker = grove->maker;
    uint32_t meadow = gn_make_material(maker, "meadow", GN_SURFACE_SOLID,
                                       gn_make_texture_kind(maker, GN_TEXTURE_MEADOW), 0xffffff);
    uint32_t gravel = gn_make_material(maker, "gravel", GN_SURFACE_SOLID,
                                       gn_make_texture_kind(maker, GN_TEXTURE_GRAVEL), 0xffffff);
    const float half = 0.5f * TILE, side = 1.7f;
    const strip plain = {-half, half, false}, north = {-half, -side, true};
    const strip road = {-side, side, true}, south = {side, half, true};
    gn_shape shapes[2] = {gn_shape_begin(maker, meadow), gn_shape_begin(maker, gravel)};
    gn_shape_surface(&shapes[0], 24, 24, ground_surface, &plain, 24, 24);
    grove->mesh[GROUND] = gn_make_mesh(maker, "Ground", shapes, 1);
    gn_shape_surface(&shapes[0], 24, 11, ground_surface, &north, 24, 11.4f);
    gn_shape_surface(&shapes[0], 24, 11, ground_surface, &south, 24, 11.4f);
    gn_shape_surface(&shapes[1], 24, 2, ground_surface, &road, 40, 2.1f);
    grove->mesh[ROAD] = gn_make_mesh(maker, "Road", shapes, 2);
}

/* Plants ------------------------------------------------------------------------------------ */

static const struct {
    const char *name;
    gn_texture_kind leaves;
    bool birch;
    gn_tree tree;
} kinds[TREES] = {
    [OAK] = {"Oak",
             GN_TEXTURE_OAK,
             false,
             {11, 0.42f, 0.2f, 4.8f, 0.42f, 0.15f, 1.0f, 0.25f, 26, 12, 1.5f, 1.35f}},
    [OAK_SMALL] = {"Young oak",
                   GN_TEXTURE_OAK,
                   false,
                   {7, 0.2f, 0.22f, 2.7f, 0.4f, 0.3f, 1.1f, 0.2f, 17, 10, 1.2f, 1.1f}},
    [LIME] = {"Lime",
              GN_TEXTURE_LIME,
              false,
              {12, 0.36f, 0.2f, 3.7f, 0.35f, 0.35f, 1.2f, 0.15f, 26, 12, 1.4f, 1.3f}},
    [BIRCH] = {"Birch",
               GN_TEXTURE_BIRCH,
               true,
               {12, 0.17f, 0.28f, 2.5f, 0.3f, 0.6f, 1.1f, -0.7f, 22, 9, 1.3f, 1.1f}},
    [BIRCH_SMALL] = {"Young birch",
                     GN_TEXTURE_BIRCH,
                     true,
                     {7.5f, 0.1f, 0.25f, 1.7f, 0.3f, 0.6f, 1.1f, -0.6f, 15, 8, 1.05f, 0.9f}},
    [ASH] = {"Ash",
             GN_TEXTURE_ASH,
             false,
             {9.5f, 0.22f, 0.28f, 3.2f, 0.45f, 0.45f, 1.2f, 0.1f, 19, 9, 1.3f, 1.2f}},
    [FIR] = {"Fir",
             GN_TEXTURE_FIR,
             false,
             {13, 0.26f, 0.07f, 2.9f, 0.04f, -0.15f, 0.45f, 0.1f, 40, 8, 1.3f, 1.0f}},
};

static void make_plants(planting *grove)
{
    gn_maker *maker = grove->maker;
    uint32_t bark = gn_make_material(maker, "bark", GN_SURFACE_SOLID,
                                     gn_make_texture_kind(maker, GN_TEXTURE_BARK), 0xffffff);
    uint32_t white = gn_make_material(maker, "birch bark", GN_SURFACE_SOLID,
                                      gn_make_texture_kind(maker, GN_TEXTURE_BIRCH_BARK), 0xffffff);
    uint32_t twigs[GN_TEXTURE_BUSH + 1];
    for (uint32_t i = 0; i < TREES; i++) {
        if (i == 0 || kinds[i].leaves != kinds[i - 1].leaves)
            twigs[kinds[i].leaves] =
                gn_make_material(maker, kinds[i].name, GN_SURFACE_CUTOUT,
                                 gn_make_texture_kind(maker, kinds[i].leaves), 0xffffff);
        gn_random random = gn_random_make(maker->seed, 100 + i);
        gn_shape shapes[2] = {gn_shape_begin(maker, kinds[i].birch ? white : bark),
                              gn_shape_begin(maker, twigs[kinds[i].leaves])};
        gn_grow_tree(&shapes[0], &shapes[1], &kinds[i].tree, &random);
        grove->mesh[i] = gn_make_mesh(maker, kinds[i].name, shapes, 2);
    }

    gn_random random = gn_random_make(maker->seed, 120);
    gn_shape shape = gn_shape_begin(
        maker, gn_make_material(maker, "bush", GN_SURFACE_CUTOUT,
                                gn_make_texture_kind(maker, GN_TEXTURE_BUSH), 0xffffff));
    gn_grow_bush(&shape, 0.9f, 1.3f, 60, &random);
    grove->mesh[BUSH] = gn_make_mesh(maker, "Bush", &shape, 1);
    gn_grow_bush(&shape, 1.5f, 1.1f, 90, &random);
    grove->mesh[BUSH_WIDE] = gn_make_mesh(maker, "Wide bush", &shape, 1);

    /* Tufts: upright cards around a middle, in three kinds. */
    uint32_t grass = gn_make_material(maker, "grass", GN_SURFACE_CUTOUT,
                                      gn_make_texture_kind(maker, GN_TEXTURE_GRASS), 0xffffff);
    uint32_t flowers = gn_make_material(maker, "flowers", GN_SURFACE_CUTOUT,
                                        gn_make_texture_kind(maker, GN_TEXTURE_FLOWER), 0xffffff);
    for (uint32_t kind = GRASS; kind <= FLOWERS; kind++) {
        float height = kind == GRASS ? 0.55f : kind == FLOWERS ? 0.5f : 0.32f;
        shape = gn_shape_begin(maker, kind == FLOWERS ? flowers : grass);
        for (uint32_t i = 0; i < 9; i++) {
            float turn = gn_random_range(&random, 0, 2 * GN_PI), away = 0.14f * (float)(i % 5);
            float spot = 2.4f * (float)i, size = height * gn_random_range(&random, 0.75f, 1.2f);
            gn_vec base = {away * cosf(spot), -0.03f, away * sinf(spot)};
            gn_shape_card(&shape, base, (gn_vec){0.1f * cosf(spot), size, 0.1f * sinf(spot)},
                          (gn_vec){1.2f * size * cosf(turn), 0, 1.2f * size * sinf(turn)},
                          (gn_vec){0, 1, 0});
        }
        grove->mesh[kind] = gn_make_mesh(maker,
                                         kind == GRASS     ? "Grass"
                                         : kind == FLOWERS ? "Flowers"
                                                           : "Low grass",
                                         &shape, 1);
    }
}

/* Things ------------------------------------------------------------------------------------ */

static gn_vec rock_surface(float u, float v, const void *user)
{
    const float *size = user;
    float turn = -2 * GN_PI * (u == 1 ? 0 : u), rise = GN_PI * (v - 0.5f);
    float c = cosf(rise), x = c * cosf(turn), y = sinf(rise), z = c * sinf(turn);
    if (v == 0 || v == 1)
        x = z = 0;
    float bump = 1 + 0.16f * sinf(3 * x + 2 * y + 1) + 0.12f * sinf(5 * z - 3 * y) +
                 0.06f * sinf(9 * x - 7 * z + 2 * y);
    return (gn_vec){size[0] * bump * x, size[1] * bump * y, size[2] * bump * z};
}

static void make_rocks(planting *grove)
{
    gn_maker *maker = grove->maker;
    uint32_t stone = gn_make_material(maker, "stone", GN_SURFACE_SOLID,
                                      gn_make_texture_kind(maker, GN_TEXTURE_STONE), 0xffffff);
    static const float flat[3] = {0.7f, 0.4f, 0.55f}, tall[3] = {0.5f, 1.5f, 0.32f};
    gn_shape shape = gn_shape_begin(maker, stone);
    gn_shape_surface(&shape, 12, 7, rock_surface, flat, 2, 1);
    grove->mesh[ROCK] = gn_make_mesh(maker, "Rock", &shape, 1);
    gn_shape_surface(&shape, 12, 10, rock_surface, tall, 2, 2);
    grove->mesh[STONE] = gn_make_mesh(maker, "Standing stone", &shape, 1);
}

/* Fence sections, 2.5 m along +Z from the post at the origin. */
static void make_fences(planting *grove, uint32_t wood)
{
    gn_maker *maker = grove->maker;
    gn_shape shapes[2] = {gn_shape_begin(maker, wood)};
    gn_shape_box(&shapes[0], (gn_vec){0, 0.35f, 0}, (gn_vec){0.06f, 0.75f, 0.06f}, 0, 0.5f);
    for (int i = 0; i < 3; i++) {
        float y = 0.3f + 0.34f * (float)i;
        gn_shape_beam(&shapes[0], (gn_vec){0.08f, y, -0.15f}, (gn_vec){0.08f, y + 0.04f, 2.65f},
                      0.05f, 0.1f, 0.6f);
    }
    grove->mesh[RAILS] = gn_make_mesh(maker, "Rail fence", shapes, 1);

    shapes[1] = gn_shape_begin(maker, gn_make_material(maker, "wire netting", GN_SURFACE_NETTING,
                                                       gn_make_texture_kind(maker, GN_TEXTURE_WIRE),
                                                       0xffffff));
    gn_shape_box(&shapes[0], (gn_vec){0, 0.5f, 0}, (gn_vec){0.05f, 0.95f, 0.05f}, 0, 0.5f);
    gn_shape_beam(&shapes[0], (gn_vec){0, 1.38f, 0}, (gn_vec){0, 1.38f, 2.5f}, 0.04f, 0.04f, 0.6f);
    const gn_vec corners[4] = {{0, 0, 2.5f}, {0, 0, 0}, {0, 1.38f, 0}, {0, 1.38f, 2.5f}};
    const float uv[4] = {0, 0, 8, 4.4f};
    gn_shape_quad(&shapes[1], corners, uv);
    grove->mesh[NETTING] = gn_make_mesh(maker, "Netting", shapes, 2);
}

/* Walls 8 m by 5 m, a gable roof with eaves, a door and shutters on the side of the road. */
static void make_house(planting *grove, uint32_t wood)
{
    gn_maker *maker = grove->maker;
    gn_shape shapes[3] = {
        gn_shape_begin(maker,
                       gn_make_material(maker, "masonry", GN_SURFACE_SOLID,
                                        gn_make_texture_kind(maker, GN_TEXTURE_MASONRY), 0xffffff)),
        gn_shape_begin(maker, gn_make_material(maker, "shingles", GN_SURFACE_SOLID,
                                               gn_make_texture_kind(maker, GN_TEXTURE_SHINGLES),
                                               0xffffff)),
        gn_shape_begin(maker, wood)};
    const float x = 4, z = 2.5f, wall = 3.2f, ridge = 5.4f;
    gn_shape_box(&shapes[0], (gn_vec){0, wall / 2 - 0.5f, 0}, (gn_vec){x, wall / 2 + 0.5f, z}, 0,
                 2);
    gn_shape_box(&shapes[0], (gn_vec){2.4f, 4.9f, -0.9f}, (gn_vec){0.35f, 1.3f, 0.35f}, 0, 2);
    for (int side = -1; side <= 1; side += 2) {
        float s = (float)side;
        /* A gable, as a quad whose upper edge is short. */
        const gn_vec gable[4] = {{s * x, wall, s * z},
                                 {s * x, wall, -s * z},
                                 {s * x, ridge - 0.06f, -s * 0.01f},
                                 {s * x, ridge - 0.06f, s * 0.01f}};
        const float gable_uv[4] = {0, 0, 2.5f, 1.1f};
        gn_shape_quad(&shapes[0], gable, gable_uv);
        /* Roof slabs with a front on both sides. */
        float eave = z + 0.5f, drop = ridge - (ridge - wall) * eave / z;
        const gn_vec roof[4] = {{-s * (x + 0.5f), drop, s * eave},
                                {s * (x + 0.5f), drop, s * eave},
                                {s * (x + 0.5f), ridge, 0},
                                {-s * (x + 0.5f), ridge, 0}};
        const gn_vec below[4] = {{s * (x + 0.5f), drop - 0.1f, s * eave},
                                 {-s * (x + 0.5f), drop - 0.1f, s * eave},
                                 {-s * (x + 0.5f), ridge - 0.1f, 0},
                                 {s * (x + 0.5f), ridge - 0.1f, 0}};
        const float roof_uv[4] = {0, 0, 4.5f, 2};
        gn_shape_quad(&shapes[1], roof, roof_uv);
        gn_shape_quad(&shapes[2], below, roof_uv);
        gn_shape_beam(&shapes[2], (gn_vec){-x - 0.5f, drop - 0.05f, s * eave},
                      (gn_vec){x + 0.5f, drop - 0.05f, s * eave}, 0.1f, 0.12f, 1);
        gn_shape_box(&shapes[2], (gn_vec){s * 2.2f + 0.7f, 1.7f, z}, (gn_vec){0.5f, 0.55f, 0.05f},
                     0, 0.8f);
    }
    gn_shape_box(&shapes[2], (gn_vec){-0.4f, 0.8f, z}, (gn_vec){0.55f, 1.3f, 0.06f}, 0, 1);
    grove->mesh[HOUSE] = gn_make_mesh(maker, "House", shapes, 3);
}

/* Planting ---------------------------------------------------------------------------------- */

static bool may_grow(const planting *grove)
{
    return grove->maker->result == GN_OK && (double)grove->maker->triangles < grove->budget;
}

static void plant(planting *grove, uint32_t which, const char *name, float x, float z, float yaw,
                  float size)
{
    if (may_grow(grove))
        gn_make_node(grove->maker, name, GN_NONE, grove->mesh[which],
                     (gn_place){on_ground(x, z), yaw, size});
}

static void plant_fence(planting *grove, uint32_t which, float x0, float z0, float x1, float z1,
                        bool follow)
{
    float dx = x1 - x0, dz = z1 - z0;
    int count = (int)(sqrtf(dx * dx + dz * dz) / 2.5f + 0.5f);
    for (int i = 0; i < count && may_grow(grove); i++) {
        gn_vec ends[2];
        for (int k = 0; k < 2; k++) {
            float t = (float)(i + k) / (float)count, x = x0 + t * dx, z = z0 + t * dz;
            ends[k] = on_ground(x, follow ? z + road_middle(x) : z);
        }
        gn_make_node_facing(grove->maker, which == RAILS ? "Rail fence" : "Netting",
                            grove->mesh[which], ends[0], gn_vec_sub(ends[1], ends[0]), 1);
    }
}

/* Things that stand where the cameras look, the most telling ones first. */
static void plant_middle(planting *grove)
{
    gn_vec at = on_ground(house.x, house.z);
    gn_make_node(grove->maker, "House", GN_NONE, grove->mesh[HOUSE], (gn_place){at, 0, 1});
    static const struct {
        uint32_t kind;
        float x, z, yaw, size;
    } trees[] = {
        {BIRCH, -7.2f, -5.6f, 0.4f, 0.75f}, {ASH, -3.5f, 5.2f, 2.1f, 1.1f},
        {OAK, -14, 5.5f, 1.3f, 1},          {BIRCH, 5.5f, 5.6f, 5.1f, 1},
        {LIME, 13, 6.0f, 0.7f, 1},          {ASH, 9.0f, -9.5f, 0.3f, 1},
        {OAK, 20, -9.5f, 4.2f, 1},          {OAK_SMALL, 0.5f, -5.5f, 3.3f, 0.9f},
        {BIRCH_SMALL, -20, -4.8f, 2.2f, 1}, {BIRCH, -22, 6.0f, 5.5f, 0.95f},
        {LIME, -14.5f, -7.5f, 1.1f, 0.9f},  {BIRCH, 23, 6.5f, 1.9f, 1},
    };
    for (size_t i = 0; i < sizeof trees / sizeof *trees; i++)
        plant(grove, trees[i].kind, kinds[trees[i].kind].name, trees[i].x, trees[i].z, trees[i].yaw,
              trees[i].size);
    plant_fence(grove, RAILS, -22, 2.9f, 22, 2.9f, true);
    plant_fence(grove, NETTING, 2.5f, -3.4f, 22.5f, -3.4f, true);
    for (int i = 0; i < 7; i++) {
        float turn = 0.5f + 0.8f * (float)i;
        plant(grove, STONE, "Standing stone", glade.x + 4.2f * cosf(turn),
              glade.z + 4.2f * sinf(turn), turn + 1, 0.75f + 0.06f * (float)(i % 4));
    }
}

/* Whether something of a radius may stand at a place: not on the road, in the house or on the
 * open part of the glade. */
static bool is_free(float x, float z, float radius)
{
    bool on_road = fabsf(z - road_middle(x)) < 2.0f + radius;
    bool in_house = fabsf(x - house.x) < 4.2f + radius && fabsf(z - house.z) < 2.8f + radius;
    float gx = x - glade.x, gz = z - glade.z, open = 3.0f + 2.5f * radius;
    return !on_road && !in_house && gx * gx + gz * gz > open * open;
}

static void plant_cell(planting *grove, int column, int row)
{
    gn_random random = gn_random_make(grove->maker->seed,
                                      1000 + ((uint64_t)(uint32_t)column << 32 | (uint32_t)row));
    float left = CELL * ((float)column - 0.5f), top = CELL * ((float)row - 0.5f);

    /* Woods are mixed in patches: what grows depends on the place, too. */
    float x = left + CELL * gn_random_range(&random, 0.1f, 0.9f);
    float z = top + CELL * gn_random_range(&random, 0.1f, 0.9f);
    float yaw = gn_random_range(&random, 0, 2 * GN_PI), size = gn_random_range(&random, 0.8f, 1.2f);
    float patch = gn_noise(0.04f * x + 1000, 0.04f * z + 1000, 4096, grove->maker->seed);
    float pick = gn_clamp(patch * 1.6f - 0.3f + gn_random_range(&random, -0.25f, 0.25f), 0, 0.999f);
    static const uint8_t mix[] = {FIR, BIRCH, BIRCH_SMALL, LIME, OAK, OAK_SMALL, ASH, BIRCH, LIME};
    static const uint8_t airy[] = {BIRCH, ASH, BIRCH_SMALL};
    /* On the sunny side of the road trees are few and thin, so that light comes through. */
    bool sunny = fabsf(x) < 32 && z > 0 && z < 22;
    uint32_t tree =
        sunny ? airy[(size_t)(pick * (float)sizeof airy)] : mix[(size_t)(pick * (float)sizeof mix)];
    bool wanted = gn_random_range(&random, 0, 1) < (sunny ? 0.4f : 0.72f);
    /* The planted middle has its own trees. */
    bool middle = fabsf(x) < 26 && z > -10 && z < 9;
    if (wanted && !middle && is_free(x, z, 1.6f))
        plant(grove, tree, kinds[tree].name, x, z, yaw, size);

    for (int i = 0; i < 9; i++) {
        x = left + CELL * gn_random_range(&random, 0, 1);
        z = top + CELL * gn_random_range(&random, 0, 1);
        yaw = gn_random_range(&random, 0, 2 * GN_PI);
        size = gn_random_range(&random, 0.75f, 1.3f);
        float chance = gn_random_range(&random, 0, 1);
        /* More undergrowth far out: it closes the horizon. */
        float bushy = fmaxf(fabsf(x), fabsf(z)) > 30 ? 0.14f : 0.05f;
        if (chance < bushy && is_free(x, z, 0.8f) && !(middle && z < 1.5f))
            plant(grove, chance < 0.5f * bushy ? BUSH : BUSH_WIDE, "Bush", x, z, yaw, size);
        else if (chance < 0.08f && is_free(x, z, 0))
            plant(grove, ROCK, "Rock", x, z, yaw, 0.6f * size);
        else if (chance < 0.13f && is_free(x, z, -0.2f))
            plant(grove, FLOWERS, "Flowers", x, z, yaw, size);
        else if (is_free(x, z, -0.35f))
            plant(grove, chance < 0.5f ? GRASS : GRASS_LOW, "Grass", x, z, yaw, size);
    }
}

/* Puts the ground tiles of one square ring. */
static void lay_ring(planting *grove, int ring)
{
    for (int row = -ring; row <= ring; row++)
        for (int column = -ring; column <= ring; column++)
            if (ring == (abs(row) > abs(column) ? abs(row) : abs(column)))
                gn_make_node(grove->maker, row == 0 ? "Road" : "Ground", GN_NONE,
                             grove->mesh[row == 0 ? ROAD : GROUND],
                             (gn_place){{TILE * (float)column, 0, TILE * (float)row}, 0, 1});
}

static void make_cameras(gn_maker *maker)
{
    gn_vec eye = on_ground(-24, road_middle(-24) + 0.5f), target = {0, 1.6f, 0.2f};
    eye.y += 1.7f;
    gn_make_camera(maker, "CamRoad", eye, target, 55);
    eye = on_ground(glade.x - 1.0f, glade.z + 9.2f);
    eye.y += 1.7f;
    target = on_ground(glade.x, glade.z);
    target.y += 1;
    gn_make_camera(maker, "CamGlade", eye, target, 55);
    eye = on_ground(-1.0f, -0.9f);
    eye.y += 1.7f;
    gn_make_camera(maker, "CamWall", eye, (gn_vec){-6.5f, 1.9f, -9}, 55);

    /* 14 m along the road. */
    enum { KEYS = 41 };
    gn_vec eyes[KEYS], targets[KEYS];
    for (int i = 0; i < KEYS; i++) {
        float x = -12 + 14 * (float)i / (KEYS - 1);
        eyes[i] = on_ground(x, road_middle(x) + 0.3f);
        targets[i] = on_ground(x + 7, road_middle(x + 7) - 0.5f);
        eyes[i].y += 1.7f;
        targets[i].y += 0.7f;
    }
    gn_make_moving_camera(maker, "CamWalk", eyes, targets, KEYS, 10, 60);
}

void gn_make_grove(gn_maker *maker)
{
    planting grove = {.maker = maker, .budget = TRIANGLES * maker->scale};
    make_ground(&grove);
    make_plants(&grove);
    make_rocks(&grove);
    uint32_t wood = gn_make_material(maker, "planks", GN_SURFACE_SOLID,
                                     gn_make_texture_kind(maker, GN_TEXTURE_PLANKS), 0xffffff);
    make_fences(&grove, wood);
    make_house(&grove, wood);

    gn_make_sun(maker, toward_sun, 3);
    gn_vec lamp = on_ground(glade.x + 4.5f, glade.z + 4.5f);
    lamp.y += 2.1f;
    gn_make_lamp(maker, lamp, 0xffd9a0, 60, 40, false);
    make_cameras(maker);

    lay_ring(&grove, 0);
    plant_middle(&grove);
    int tiles = 0;
    for (int ring = 0; may_grow(&grove); ring++) {
        if (CELL * ((float)ring + 0.5f) > TILE * ((float)tiles + 0.5f))
            lay_ring(&grove, ++tiles);
        for (int row = -ring; row <= ring; row++)
            for (int column = -ring; column <= ring; column += abs(row) == ring ? 1 : 2 * ring)
                plant_cell(&grove, column, row);
    }
}
