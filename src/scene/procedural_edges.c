/* What is hard for leak tracing: a row of things that a map's texels miss.
 *
 * This work is based on: René Kern, Felix Brüll and Thorsten Grosch, "Real-Time Pixel-Perfect Hard
 * Shadows with Leak Tracing", 2024: surfaces nearly parallel to the light and shadow edges near
 * gaps (its Figures 4 and 5: a roller, an ashtray), a thin fence (its Figure 10), and holes of a
 * pixel or two (its section 4.3).
 *
 * Up to scale 1 curves and the sheet are refined; beyond it the row grows longer. */
#include "scene/procedural.h"

#define BAY  14.0f /* metres of the row */
#define BAYS 3     /* up to scale 1 */

/* Elevation 37 degrees. */
static const gn_vec toward_sun = {0.5f, 0.6f, 0.62f};

typedef struct edges {
    uint32_t ground, roller, vane, rack, slats, ashtray, table, sheet, fence, tree;
} edges;

/* Level, at a right angle to the sun. */
static gn_vec beside_sun(void)
{
    return gn_vec_unit((gn_vec){toward_sun.z, 0, -toward_sun.x});
}

/* Towards the sun, but turned to the side: what lies along it faces the sun at that angle. */
static gn_vec nearly_toward_sun(float degrees)
{
    return gn_vec_unit(
        gn_vec_along(gn_vec_unit(toward_sun), tanf(degrees * GN_PI / 180), beside_sun()));
}

/* Parts ------------------------------------------------------------------------------------- */

/* A drum with flanges and two hoops on an axle, around the Z axis: each shadows the drum beneath it
 * over many times its height. */
static uint32_t make_roller(gn_maker *maker, uint32_t material)
{
    const float profile[17][2] = {{0.03f, -2},     {0.03f, -1.1f}, {0.25f, -1.1f}, {0.25f, -1.06f},
                                  {0.22f, -1.06f}, {0.22f, -0.4f}, {0.23f, -0.4f}, {0.23f, -0.37f},
                                  {0.22f, -0.37f}, {0.22f, 0.3f},  {0.23f, 0.3f},  {0.23f, 0.33f},
                                  {0.22f, 0.33f},  {0.22f, 1.06f}, {0.25f, 1.06f}, {0.25f, 1.1f},
                                  {0, 1.1f}};
    gn_shape shape = gn_shape_begin(maker, material);
    gn_shape_lathe(&shape, (gn_vec){0, 0, 0}, profile, 17, gn_refine(maker, 48, 4), 4, 1);
    /* From the Y axis to the Z axis. */
    for (uint32_t i = 0; i < shape.vertex_count; i++) {
        gn_vertex *vertex = &shape.vertices[i];
        gn_vec p = vertex->position, n = vertex->normal;
        vertex->position = (gn_vec){p.x, -p.z, p.y};
        vertex->normal = (gn_vec){n.x, -n.z, n.y};
    }
    return gn_make_mesh(maker, "Roller", &shape, 1);
}

/* A board along Z, 3 mm thick, with pegs that throw their shadows along it. */
static uint32_t make_vane(gn_maker *maker, uint32_t material)
{
    gn_shape shape = gn_shape_begin(maker, material);
    gn_shape_box(&shape, (gn_vec){0, 0, 0}, (gn_vec){0.0015f, 0.3f, 0.5f}, 0, 1);
    for (int i = 0; i < 5; i++)
        gn_shape_box(&shape, (gn_vec){0, -0.24f + 0.12f * (float)i, 0.42f - 0.12f * (float)i},
                     (gn_vec){0.008f, 0.008f, 0.008f}, 0, 1);
    return gn_make_mesh(maker, "Vane", &shape, 1);
}

/* What vanes hang on: two posts and two rods, whose shadows run along the vanes. */
static uint32_t make_rack(gn_maker *maker, uint32_t material)
{
    gn_shape shape = gn_shape_begin(maker, material);
    for (int side = -1; side <= 1; side += 2)
        gn_shape_box(&shape, (gn_vec){1.1f * (float)side, 0.85f, 0}, (gn_vec){0.04f, 0.85f, 0.04f},
                     0, 1);
    const float radii[2] = {0.012f, 0.012f};
    for (int i = 0; i < 2; i++) {
        float height = i == 0 ? 1.5f : 1.65f;
        const gn_vec ends[2] = {{-1.1f, height, 0}, {1.1f, height, 0}};
        gn_shape_tube(&shape, ends, radii, 2, gn_refine(maker, 10, 4), 1);
    }
    return gn_make_mesh(maker, "Rack", &shape, 1);
}

/* Two crossed layers of slats with gaps of a third of their width, over the ground. */
static uint32_t make_slats(gn_maker *maker, uint32_t material)
{
    gn_shape shape = gn_shape_begin(maker, material);
    for (int i = 0; i < 4; i++)
        gn_shape_box(&shape, (gn_vec){i & 1 ? 0.75f : -0.75f, 0.35f, i & 2 ? 0.75f : -0.75f},
                     (gn_vec){0.03f, 0.35f, 0.03f}, 0, 1);
    for (int i = 0; i < 26; i++) {
        float at = -0.75f + 0.06f * (float)i;
        gn_shape_box(&shape, (gn_vec){0, 0.76f, at}, (gn_vec){0.8f, 0.008f, 0.022f}, 0, 1);
        if (i % 3 == 0)
            gn_shape_box(&shape, (gn_vec){at, 0.725f, 0}, (gn_vec){0.022f, 0.025f, 0.8f}, 0, 1);
    }
    return gn_make_mesh(maker, "Slats", &shape, 1);
}

/* A bowl with a thin wall whose rim has notches. */
static uint32_t make_ashtray(gn_maker *maker, uint32_t material)
{
    gn_shape shape = gn_shape_begin(maker, material);
    const float profile[6][2] = {{0.14f, 0},      {0.2f, 0.1f},   {0.196f, 0.1f},
                                 {0.137f, 0.01f}, {0.05f, 0.01f}, {0, 0.01f}};
    gn_shape_lathe(&shape, (gn_vec){0, 0, 0}, profile, 6, gn_refine(maker, 48, 4), 1, 1);
    enum { TEETH = 24 };
    for (int i = 0; i < TEETH; i++) {
        float turn = 2 * GN_PI * (float)i / TEETH;
        gn_shape_box(&shape, (gn_vec){0.198f * sinf(turn), 0.115f, 0.198f * cosf(turn)},
                     (gn_vec){0.02f, 0.015f, 0.002f}, turn, 1);
    }
    return gn_make_mesh(maker, "Ashtray", &shape, 1);
}

static uint32_t make_table(gn_maker *maker, uint32_t material)
{
    gn_shape shape = gn_shape_begin(maker, material);
    gn_shape_box(&shape, (gn_vec){0, 0.73f, 0}, (gn_vec){0.7f, 0.02f, 0.45f}, 0, 1);
    for (int i = 0; i < 4; i++)
        gn_shape_box(&shape, (gn_vec){i & 1 ? 0.64f : -0.64f, 0.355f, i & 2 ? 0.39f : -0.39f},
                     (gn_vec){0.03f, 0.355f, 0.03f}, 0, 1);
    return gn_make_mesh(maker, "Table", &shape, 1);
}

/* A sheet of metal with square holes, in a frame. */
static uint32_t make_sheet(gn_maker *maker, uint32_t sheet, uint32_t frame)
{
    gn_shape shapes[2] = {gn_shape_begin(maker, sheet), gn_shape_begin(maker, frame)};
    const int holes = (int)gn_refine(maker, 30, 4);
    const float side = 1.2f, cell = side / (float)holes, hole = 0.012f;
    const float uv[4] = {0, 0, 1, 1};
    for (int row = 0; row <= holes; row++) {
        /* A strip between two rows of holes, then what is left between the holes. */
        float low = cell * (float)row - cell / 2 + hole / 2, high = low + cell - hole;
        low = fmaxf(low, 0);
        high = fminf(high, side);
        const gn_vec strip[4] = {{-side / 2, 0.3f + low, 0},
                                 {side / 2, 0.3f + low, 0},
                                 {side / 2, 0.3f + high, 0},
                                 {-side / 2, 0.3f + high, 0}};
        gn_shape_quad(&shapes[0], strip, uv);
        for (int column = 0; column <= holes && row < holes; column++) {
            float left = cell * (float)column - cell / 2 + hole / 2, right = left + cell - hole;
            left = fmaxf(left, 0) - side / 2;
            right = fminf(right, side) - side / 2;
            const gn_vec bridge[4] = {{left, 0.3f + high, 0},
                                      {right, 0.3f + high, 0},
                                      {right, 0.3f + high + hole, 0},
                                      {left, 0.3f + high + hole, 0}};
            gn_shape_quad(&shapes[0], bridge, uv);
        }
    }
    for (int edge = -1; edge <= 1; edge += 2) {
        gn_shape_box(&shapes[1], (gn_vec){0.62f * (float)edge, 0.77f, 0},
                     (gn_vec){0.02f, 0.77f, 0.02f}, 0, 1);
        gn_shape_box(&shapes[1], (gn_vec){0, 0.9f + 0.62f * (float)edge, 0},
                     (gn_vec){0.6f, 0.02f, 0.02f}, 0, 1);
    }
    return gn_make_mesh(maker, "Sheet", shapes, 2);
}

/* Thin planks on two rails between posts, wires above them, and a sign that hangs on the wires. */
static uint32_t make_fence(gn_maker *maker, uint32_t wood, uint32_t iron)
{
    gn_shape shapes[2] = {gn_shape_begin(maker, wood), gn_shape_begin(maker, iron)};
    for (int i = 0; i < 7; i++)
        gn_shape_box(&shapes[0], (gn_vec){-BAY / 2 + 2 * (float)i, 0.9f, 0},
                     (gn_vec){0.04f, 0.9f, 0.04f}, 0, 1);
    for (int i = 0; i < 87; i++)
        gn_shape_box(&shapes[0], (gn_vec){-BAY / 2 + 0.16f * (float)(i + 1), 0.6f, 0.03f},
                     (gn_vec){0.013f, 0.5f, 0.006f}, 0, 1);
    const float rails[2] = {0.25f, 0.95f}, wires[3] = {1.2f, 1.45f, 1.7f};
    for (int i = 0; i < 2; i++)
        gn_shape_box(&shapes[0], (gn_vec){0, rails[i], 0}, (gn_vec){BAY / 2, 0.02f, 0.015f}, 0, 1);
    const float radii[2] = {0.005f, 0.005f};
    for (int i = 0; i < 3; i++) {
        const gn_vec ends[2] = {{-BAY / 2, wires[i], 0}, {BAY / 2, wires[i], 0}};
        gn_shape_tube(&shapes[1], ends, radii, 2, gn_refine(maker, 8, 4), 1);
    }
    gn_shape_box(&shapes[1], (gn_vec){1, 1.33f, 0.008f}, (gn_vec){0.12f, 0.07f, 0.002f}, 0, 1);
    return gn_make_mesh(maker, "Fence", shapes, 2);
}

static uint32_t make_tree(gn_maker *maker)
{
    gn_shape shapes[2] = {
        gn_shape_begin(maker,
                       gn_make_material(maker, "bark", GN_SURFACE_SOLID,
                                        gn_make_texture_kind(maker, GN_TEXTURE_BARK), 0xffffff)),
        gn_shape_begin(maker,
                       gn_make_material(maker, "leaves", GN_SURFACE_CUTOUT,
                                        gn_make_texture_kind(maker, GN_TEXTURE_LIME), 0xffffff))};
    const gn_tree tree = {6, 0.16f, 0.25f, 2, 0.45f, 0.3f, 0.9f, 0.1f, 15, 8, 0.9f, 0.8f};
    gn_random random = gn_random_make(maker->seed, 2);
    gn_grow_tree(&shapes[0], &shapes[1], &tree, &random);
    return gn_make_mesh(maker, "Tree", shapes, 2);
}

/* Placing ----------------------------------------------------------------------------------- */

static void put(gn_maker *maker, uint32_t parent, const char *name, uint32_t mesh, gn_vec position,
                float yaw)
{
    gn_make_node(maker, name, parent, mesh, (gn_place){position, yaw, 1});
}

/* One of each around x; shift turns and moves them a little. */
static void put_bay(gn_maker *maker, const edges *part, float x, float shift)
{
    put(maker, GN_NONE, "Ground", part->ground, (gn_vec){x, 0, 0}, 0);
    put(maker, GN_NONE, "Tree", part->tree, (gn_vec){x, 0, -34}, shift);
    put(maker, GN_NONE, "Fence", part->fence, (gn_vec){x, 0, -3.5f}, 0);

    gn_vec at = {x - 4.6f, 1.15f, 0.2f};
    gn_make_node_facing(maker, "Roller", part->roller, at, nearly_toward_sun(1.5f + shift), 1);
    enum { VANES = 6 };
    for (int i = 0; i < VANES; i++)
        gn_make_node_facing(maker, "Vane", part->vane,
                            (gn_vec){x - 2.3f + 0.32f * (float)i, 1.15f, 0},
                            nearly_toward_sun(0.5f + 0.7f * (float)i + shift), 1);
    put(maker, GN_NONE, "Rack", part->rack, (gn_vec){x - 1.2f, 0, 0.37f}, 0);

    put(maker, GN_NONE, "Slats", part->slats, (gn_vec){x + 1.1f, 0, 0}, 0.2f + shift);
    at = (gn_vec){x + 3, 0, 0.2f};
    put(maker, GN_NONE, "Table", part->table, at, 0);
    for (int i = 0; i < 3; i++)
        put(maker, GN_NONE, "Ashtray", part->ashtray,
            (gn_vec){at.x - 0.45f + 0.45f * (float)i, 0.75f, at.z + (i == 1 ? 0.2f : -0.1f)},
            shift + (float)i);
    put(maker, GN_NONE, "Sheet", part->sheet, (gn_vec){x + 5.2f, 0, 0}, 0.3f + shift);
}

/* Ten seconds from one place to another along a line. */
static void make_slide(gn_maker *maker, const char *name, gn_vec eye, gn_vec target, gn_vec along,
                       float degrees)
{
    const gn_vec eyes[2] = {eye, gn_vec_add(eye, along)},
                 targets[2] = {target, gn_vec_add(target, along)};
    gn_make_moving_camera(maker, name, eyes, targets, 2, 10, degrees);
}

static void make_cameras(gn_maker *maker)
{
    gn_make_camera(maker, "CamEdges", (gn_vec){-4.5f, 2.1f, 3.5f}, (gn_vec){-3.2f, 0.95f, 0}, 45);
    gn_make_camera(maker, "CamGaps", (gn_vec){2.3f, 2.1f, 2.6f}, (gn_vec){2.1f, 0.6f, 0}, 50);
    gn_make_camera(maker, "CamFence", (gn_vec){2, 2.1f, -8.2f}, (gn_vec){0.3f, 0.3f, -4}, 45);
    make_slide(maker, "CamHoles", (gn_vec){3.4f, 2, -3.2f}, (gn_vec){4.8f, 0.3f, -0.6f},
               (gn_vec){3, 0, 0}, 45);
    make_slide(maker, "CamTree", (gn_vec){-2.5f, 2, -12}, (gn_vec){-1.2f, 1.4f, -34},
               (gn_vec){0, 0, -6}, 40);
    make_slide(maker, "CamWalk", (gn_vec){-8, 1.9f, 3.8f}, (gn_vec){-6.8f, 0.8f, 0},
               (gn_vec){14, 0, 0}, 55);
}

void gn_make_edges(gn_maker *maker)
{
    uint32_t paving = gn_make_material(maker, "paving", GN_SURFACE_SOLID,
                                       gn_make_texture_kind(maker, GN_TEXTURE_PAVING), 0xffffff);
    uint32_t wood = gn_make_material(maker, "planks", GN_SURFACE_SOLID,
                                     gn_make_texture_kind(maker, GN_TEXTURE_PLANKS), 0xffffff);
    uint32_t paint = gn_make_material(maker, "paint", GN_SURFACE_SOLID, GN_NONE, 0xd8d2c4);
    uint32_t metal = gn_make_material(maker, "metal", GN_SURFACE_SHEET, GN_NONE, 0xb4b8bc);
    uint32_t iron = gn_make_material(maker, "iron", GN_SURFACE_SOLID, GN_NONE, 0x4a4c50);

    gn_shape shape = gn_shape_begin(maker, paving);
    gn_shape_box(&shape, (gn_vec){0, -0.25f, -10}, (gn_vec){BAY / 2, 0.25f, 30}, 0, 2);
    const edges part = {gn_make_mesh(maker, "Ground", &shape, 1),
                        make_roller(maker, paint),
                        make_vane(maker, paint),
                        make_rack(maker, iron),
                        make_slats(maker, wood),
                        make_ashtray(maker, paint),
                        make_table(maker, wood),
                        make_sheet(maker, metal, iron),
                        make_fence(maker, wood, iron),
                        make_tree(maker)};

    /* From the middle to both sides; the one in the middle is the same for all seeds. */
    gn_random random = gn_random_make(maker->seed, 1);
    int bays = (int)(BAYS * fmax(maker->scale, 1));
    for (int i = 0; i < bays && maker->result == GN_OK; i++)
        put_bay(maker, &part, BAY * (float)(i % 2 ? (i + 1) / 2 : -(i / 2)),
                i > 0 ? gn_random_range(&random, -0.3f, 0.3f) : 0);

    gn_make_sun(maker, toward_sun, 3);
    gn_make_lamp(maker, (gn_vec){0.5f, 3.2f, 2}, 0xffd9a0, 20, 30, false);
    make_cameras(maker);
}
