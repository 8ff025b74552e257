/* Trees and bushes: wood as tubes, leaves as cards that hold whole twigs. */
#include "scene/procedural.h"

enum { TRUNK_POINTS = 7, BRANCH_POINTS = 3 };

/* The trunk at a share of the tree's height. */
static gn_vec trunk_point(const gn_vec trunk[TRUNK_POINTS], float share)
{
    float k = gn_clamp(share, 0, 0.9999f) * (TRUNK_POINTS - 1);
    int i = (int)k;
    return gn_vec_along(trunk[i], k - (float)i, gn_vec_sub(trunk[i + 1], trunk[i]));
}

/* How far the crown reaches at a share of its own height, [0,1]. */
static float crown_reach(const gn_tree *tree, float share)
{
    float t = share < tree->crown_peak ? 1 - share / tree->crown_peak
                                       : (share - tree->crown_peak) / (1 - tree->crown_peak);
    return sqrtf(gn_clamp(1 - t * t, 0.06f, 1));
}

/* One twig card near the outer end of a branch. */
static void add_card(gn_shape *leaves, const gn_tree *tree, gn_random *random, gn_vec base,
                     gn_vec direction, gn_vec crown_center)
{
    gn_vec along = gn_vec_unit(gn_vec_along(direction, 0.75f, gn_random_direction(random)));
    along.y -= tree->bend < 0 ? 0.25f : -0.1f;
    along = gn_vec_unit(along);
    gn_vec beside = gn_vec_beside(along), third = gn_vec_cross(along, beside);
    float roll = gn_random_range(random, 0, GN_PI), size = gn_random_range(random, 0.8f, 1.15f);
    gn_vec across = gn_vec_along(gn_vec_scale(beside, cosf(roll)), sinf(roll), third);
    gn_vec tip = gn_vec_along(base, size * tree->card_length, along);
    gn_shape_card(leaves, base, gn_vec_scale(along, size * tree->card_length),
                  gn_vec_scale(across, size * tree->card_width), gn_vec_sub(tip, crown_center));
}

static void grow_branch(gn_shape *wood, gn_shape *leaves, const gn_tree *tree, gn_random *random,
                        const gn_vec trunk[TRUNK_POINTS], uint32_t number)
{
    float share = ((float)number + gn_random_range(random, 0.2f, 0.8f)) / (float)tree->branches;
    float height = tree->clear + (0.97f - tree->clear) * share;
    float turn = 2.39996f * (float)number + gn_random_range(random, -0.4f, 0.4f);
    float rise = gn_mix(tree->rise_low, tree->rise_high, share);
    rise += gn_random_range(random, -0.12f, 0.12f);
    float reach = tree->crown_radius * crown_reach(tree, share);
    /* The card at its tip belongs to the reach. */
    float length = fmaxf(reach - 0.6f * tree->card_length, 0.15f * tree->crown_radius);
    length *= gn_random_range(random, 0.85f, 1.1f);

    gn_vec points[BRANCH_POINTS] = {trunk_point(trunk, height)};
    float radii[BRANCH_POINTS], thick = 0.42f * tree->trunk_radius * (1.05f - height);
    for (int i = 0; i < BRANCH_POINTS; i++) {
        float t = (float)i / (BRANCH_POINTS - 1), slope = rise + tree->bend * t;
        gn_vec direction = {cosf(turn) * cosf(slope), sinf(slope), sinf(turn) * cosf(slope)};
        radii[i] = fmaxf(thick * (1 - 0.8f * t), 0.012f);
        if (i + 1 < BRANCH_POINTS)
            points[i + 1] = gn_vec_along(points[i], length / (BRANCH_POINTS - 1), direction);
        turn += gn_random_range(random, -0.2f, 0.2f);
    }
    gn_shape_tube(wood, points, radii, BRANCH_POINTS, 3, 0.7f);

    gn_vec center = {0, tree->height * (tree->clear + 0.4f * (1 - tree->clear)), 0};
    for (uint32_t i = 0; i < tree->cards; i++) {
        float at = 1 - 0.75f * gn_random_range(random, 0, 1) * ((float)i / (float)tree->cards);
        float k = gn_clamp(at, 0, 0.9999f) * (BRANCH_POINTS - 1);
        int s = (int)k;
        gn_vec step = gn_vec_sub(points[s + 1], points[s]);
        add_card(leaves, tree, random, gn_vec_along(points[s], k - (float)s, step),
                 gn_vec_unit(step), center);
    }
}

void gn_grow_tree(gn_shape *wood, gn_shape *leaves, const gn_tree *tree, gn_random *random)
{
    gn_vec trunk[TRUNK_POINTS];
    float radii[TRUNK_POINTS], sway_x = 0, sway_z = 0;
    for (int i = 0; i < TRUNK_POINTS; i++) {
        float t = (float)i / (TRUNK_POINTS - 1);
        trunk[i] = (gn_vec){sway_x, tree->height * 0.97f * t - (i == 0 ? 0.4f : 0), sway_z};
        radii[i] = tree->trunk_radius * (i == 0 ? 1.5f : 1.06f - t) + 0.01f;
        sway_x += gn_random_range(random, -0.018f, 0.018f) * tree->height;
        sway_z += gn_random_range(random, -0.018f, 0.018f) * tree->height;
    }
    gn_shape_tube(wood, trunk, radii, TRUNK_POINTS, 7, 1.4f);
    for (uint32_t i = 0; i < tree->branches; i++)
        grow_branch(wood, leaves, tree, random, trunk, i);
    /* The top of the crown. */
    gn_vec center = {0, tree->height * (tree->clear + 0.4f * (1 - tree->clear)), 0};
    for (uint32_t i = 0; i < tree->cards; i++)
        add_card(leaves, tree, random, trunk_point(trunk, gn_random_range(random, 0.88f, 1)),
                 (gn_vec){0, 1, 0}, center);
}

void gn_grow_bush(gn_shape *leaves, float radius, float height, uint32_t cards, gn_random *random)
{
    for (uint32_t i = 0; i < cards; i++) {
        float turn = gn_random_range(random, 0, 2 * GN_PI);
        float away = radius * sqrtf(gn_random_range(random, 0, 1));
        gn_vec base = {0.55f * away * cosf(turn), gn_random_range(random, -0.05f, 0.45f) * height,
                       0.55f * away * sinf(turn)};
        gn_vec along = {cosf(turn) * away / radius, gn_random_range(random, 0.35f, 1.1f),
                        sinf(turn) * away / radius};
        along = gn_vec_unit(gn_vec_along(along, 0.35f, gn_random_direction(random)));
        gn_vec beside = gn_vec_beside(along), third = gn_vec_cross(along, beside);
        float roll = gn_random_range(random, 0, GN_PI);
        gn_vec across = gn_vec_along(gn_vec_scale(beside, cosf(roll)), sinf(roll), third);
        float size = height * gn_random_range(random, 0.5f, 0.7f);
        gn_shape_card(leaves, base, gn_vec_scale(along, size), gn_vec_scale(across, size),
                      gn_vec_along((gn_vec){0, 0.3f, 0}, 1, along));
    }
}
