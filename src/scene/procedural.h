/* The workshop of the procedural scenes: random numbers, mesh and texture building, and a maker
 * that hands what was built to the scene.
 *
 * Recipes are written in metres; the maker multiplies every length by the unit asked for. After
 * the first error a maker does nothing more, so that recipes need no error paths. */
#ifndef GN_SCENE_PROCEDURAL_H
#define GN_SCENE_PROCEDURAL_H

#include <math.h>
#include <gnomon/procedural.h>

#include "base/base.h"

#define GN_PI 3.14159265f

/* Vectors ----------------------------------------------------------------------------------- */

typedef struct gn_vec {
    float x, y, z;
} gn_vec;

static inline gn_vec gn_vec_add(gn_vec a, gn_vec b)
{
    return (gn_vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline gn_vec gn_vec_sub(gn_vec a, gn_vec b)
{
    return (gn_vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline gn_vec gn_vec_scale(gn_vec a, float s)
{
    return (gn_vec){a.x * s, a.y * s, a.z * s};
}

/* a + s b */
static inline gn_vec gn_vec_along(gn_vec a, float s, gn_vec b)
{
    return (gn_vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline float gn_vec_dot(gn_vec a, gn_vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline gn_vec gn_vec_cross(gn_vec a, gn_vec b)
{
    return (gn_vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline float gn_vec_length(gn_vec a)
{
    return sqrtf(gn_vec_dot(a, a));
}

/* The zero vector stays as it is. */
static inline gn_vec gn_vec_unit(gn_vec a)
{
    float length = gn_vec_length(a);
    return length > 0 ? gn_vec_scale(a, 1 / length) : a;
}

/* A unit vector at a right angle to the unit vector a. */
gn_vec gn_vec_beside(gn_vec a);

static inline float gn_mix(float a, float b, float t)
{
    return a + (b - a) * t;
}

static inline float gn_clamp(float value, float low, float high)
{
    return value < low ? low : value > high ? high : value;
}

/* 0 below a, 1 above b, smooth between. */
static inline float gn_smooth(float a, float b, float value)
{
    float t = gn_clamp((value - a) / (b - a), 0, 1);
    return t * t * (3 - 2 * t);
}

/* Random numbers ---------------------------------------------------------------------------- */

typedef struct gn_random {
    uint64_t state, increment;
} gn_random;

/* Streams with different numbers are independent of each other. */
gn_random gn_random_make(uint64_t seed, uint64_t stream);
uint32_t gn_random_bits(gn_random *random);
float gn_random_range(gn_random *random, float low, float high); /* [low, high) */
gn_vec gn_random_direction(gn_random *random);                   /* on the unit sphere */

/* Maker ------------------------------------------------------------------------------------- */

#define GN_MAKER_MESHES 64u

typedef struct gn_maker {
    gn_context *context;
    gn_scene *scene;
    gn_result result; /* the first error */
    float unit;
    double scale;
    uint32_t seed;
    uint64_t triangles; /* with instancing, so far */
    uint32_t mesh_triangles[GN_MAKER_MESHES];
} gn_maker;

/* Where a node stands: turned by yaw (radians, from +Z towards +X), then scaled. */
typedef struct gn_place {
    gn_vec position;
    float yaw, scale;
} gn_place;

typedef enum gn_surface_kind {
    GN_SURFACE_SOLID,  /* opaque, single sided */
    GN_SURFACE_SHEET,  /* opaque, double sided */
    GN_SURFACE_CUTOUT, /* MASK, double sided, clamped */
    GN_SURFACE_NETTING /* MASK, double sided, repeated */
} gn_surface_kind;

/* How finely to divide what has so many cells at scale 1: fewer below it, not under least. */
uint32_t gn_refine(const gn_maker *maker, uint32_t cells, uint32_t least);

/* color: 0xRRGGBB in sRGB, multiplies the texture; texture may be GN_NONE. */
uint32_t gn_make_material(gn_maker *maker, const char *name, gn_surface_kind kind, uint32_t texture,
                          uint32_t color);
uint32_t gn_make_node(gn_maker *maker, const char *name, uint32_t parent, uint32_t mesh,
                      gn_place place);
/* The node's +Z looks along forward, its +Y is as near to up as it can be. */
uint32_t gn_make_node_facing(gn_maker *maker, const char *name, uint32_t mesh, gn_vec position,
                             gn_vec forward, float scale);
/* toward: from the ground to the sun. */
void gn_make_sun(gn_maker *maker, gn_vec toward, float intensity);
void gn_make_lamp(gn_maker *maker, gn_vec position, uint32_t color, float intensity, float range,
                  bool on);
void gn_make_camera(gn_maker *maker, const char *name, gn_vec eye, gn_vec target, float degrees);
/* A camera that passes eyes[0 .. count - 1] at equal steps of time. */
void gn_make_moving_camera(gn_maker *maker, const char *name, const gn_vec *eyes,
                           const gn_vec *targets, uint32_t count, float seconds, float degrees);
/* Moves a node around a closed smooth curve through positions, its +Z ahead. */
void gn_make_loop(gn_maker *maker, uint32_t node, const gn_vec *positions, uint32_t count,
                  float seconds);

/* Shapes ------------------------------------------------------------------------------------ */

typedef struct gn_vertex {
    gn_vec position, normal;
    float u, v;
} gn_vertex;

/* Triangles of one material while they are collected. */
typedef struct gn_shape {
    gn_maker *maker;
    uint32_t material;
    gn_vertex *vertices;
    uint32_t *indices;
    uint32_t vertex_count, vertex_capacity, index_count, index_capacity;
} gn_shape;

gn_shape gn_shape_begin(gn_maker *maker, uint32_t material);
/* Adds the shapes as one mesh and frees them; empty ones are left out. */
uint32_t gn_make_mesh(gn_maker *maker, const char *name, gn_shape *shapes, uint32_t count);

/* Four corners, counter-clockwise seen from the front; texture coordinates run from (u0,v1) at a
 * to (u1,v0) at c. */
void gn_shape_quad(gn_shape *shape, const gn_vec corners[4], const float uv[4]);
/* An upright box turned by yaw; textured with tiles metres a repeat. */
void gn_shape_box(gn_shape *shape, gn_vec center, gn_vec half, float yaw, float tile);
/* A beam with a rectangular section between two points. */
void gn_shape_beam(gn_shape *shape, gn_vec from, gn_vec to, float width, float height, float tile);
/* A round bar through points, open at the ends; textured once around and a repeat a tile. */
void gn_shape_tube(gn_shape *shape, const gn_vec *points, const float *radii, uint32_t count,
                   uint32_t sides, float tile);
/* A rectangle from its base along a direction; its normals lean by half towards outward. */
void gn_shape_card(gn_shape *shape, gn_vec base, gn_vec along, gn_vec across, gn_vec outward);

/* A curved surface over [0,1]^2, in columns * rows cells; its front is where u cross v points. */
typedef gn_vec (*gn_surface)(float u, float v, const void *user);
void gn_shape_surface(gn_shape *shape, uint32_t columns, uint32_t rows, gn_surface surface,
                      const void *user, float u_tiles, float v_tiles);
/* A body turned around the Y axis: profile of (radius, height) from bottom to top, y up. */
void gn_shape_lathe(gn_shape *shape, gn_vec foot, const float (*profile)[2], uint32_t count,
                    uint32_t sides, float u_tiles, float tile);

/* Textures ---------------------------------------------------------------------------------- */

typedef struct gn_canvas {
    gn_maker *maker;
    uint32_t size; /* texels, square */
    uint8_t *rgba;
} gn_canvas;

typedef enum gn_leaf {
    GN_LEAF_OVATE,  /* birch, beech */
    GN_LEAF_LOBED,  /* oak */
    GN_LEAF_NARROW, /* ash, willow */
    GN_LEAF_BROAD   /* lime, maple */
} gn_leaf;

/* Filled with one colour (0xRRGGBB) and alpha 0. */
gn_canvas gn_canvas_begin(gn_maker *maker, uint32_t size, uint32_t color);
uint32_t gn_make_texture(gn_maker *maker, const char *name, gn_canvas *canvas);
/* A stroke with round ends; coordinates and radii in [0,1] of the canvas, (0,0) upper left. */
void gn_canvas_stroke(gn_canvas *canvas, float x0, float y0, float r0, float x1, float y1, float r1,
                      uint32_t color);
/* One leaf from its stalk at (x, y); angle: 0 is right, positive is down. */
void gn_canvas_leaf(gn_canvas *canvas, gn_leaf kind, float x, float y, float angle, float length,
                    uint32_t color);
/* Value noise in [0,1] at x, y >= 0 with the given period in cells, a power of two. */
float gn_noise(float x, float y, uint32_t period, uint32_t seed);
/* Octaves of it, each twice as fine and half as strong; [0,1]. */
float gn_noise_octaves(float u, float v, uint32_t period, uint32_t octaves, uint32_t seed);
uint32_t gn_color_mix(uint32_t a, uint32_t b, float t);
/* color times factor, in sRGB, saturating. */
uint32_t gn_color_shade(uint32_t color, float factor);

typedef enum gn_texture_kind {
    GN_TEXTURE_OAK, /* MASK twigs: the stalk enters at the middle of the lower edge */
    GN_TEXTURE_LIME,
    GN_TEXTURE_BIRCH,
    GN_TEXTURE_ASH,
    GN_TEXTURE_FIR,
    GN_TEXTURE_BUSH,
    GN_TEXTURE_GRASS, /* MASK, stands on the lower edge */
    GN_TEXTURE_FLOWER,
    GN_TEXTURE_WIRE, /* MASK, repeats */
    GN_TEXTURE_BARK, /* opaque, repeat */
    GN_TEXTURE_BIRCH_BARK,
    GN_TEXTURE_MEADOW,
    GN_TEXTURE_GRAVEL,
    GN_TEXTURE_STONE,
    GN_TEXTURE_MASONRY,
    GN_TEXTURE_PLANKS,
    GN_TEXTURE_SHINGLES,
    GN_TEXTURE_PAVING,
    GN_TEXTURE_CLOTH
} gn_texture_kind;

uint32_t gn_make_texture_kind(gn_maker *maker, gn_texture_kind kind);

/* Trees ------------------------------------------------------------------------------------- */

typedef struct gn_tree {
    float height, trunk_radius; /* metres */
    float clear;                /* share of the height without branches */
    float crown_radius;         /* metres */
    float crown_peak;           /* height of the widest place, as a share of the crown */
    float rise_low, rise_high;  /* slope of the lowest and highest branches, radians above level */
    float bend;                 /* how much branches turn up (positive) or hang (negative) */
    uint32_t branches;
    uint32_t cards;                /* a branch */
    float card_length, card_width; /* metres */
} gn_tree;

/* A tree that stands on the origin: wood into one shape, leaf cards into the other. */
void gn_grow_tree(gn_shape *wood, gn_shape *leaves, const gn_tree *tree, gn_random *random);
/* A bush: cards that rise from the ground around the origin. */
void gn_grow_bush(gn_shape *leaves, float radius, float height, uint32_t cards, gn_random *random);

/* Scenes ------------------------------------------------------------------------------------ */

void gn_make_grove(gn_maker *maker);
void gn_make_railing(gn_maker *maker);
void gn_make_leafbox(gn_maker *maker);
void gn_make_court(gn_maker *maker);
void gn_make_edges(gn_maker *maker);

#endif
