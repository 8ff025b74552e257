/* The light buffer: a grid over one light's view whose cells list the triangles that overlap them
 * (gnomon/shadow/light_buffer.h has the arithmetic).
 *
 * The grid is made of tiles. A receiver's tile follows from itself alone: its place in the light's
 * view, and the width of its ray cone there, which chooses the size of the tile. So tiles are fine
 * where the camera is near and coarse where it is far, their number depends on the picture and not
 * on the scene, and what a tile holds depends on nothing but the scene and the light. Within a tile
 * the cells are as many as its triangles make worth while.
 *
 * Life of a frame: gn_light_buffer_update(); rays, which note the tiles that they miss;
 * gn_light_buffer_grow(); the rays that missed once more. */
#ifndef GN_CPU_LIGHT_BUFFER_H
#define GN_CPU_LIGHT_BUFFER_H

#include "cpu/kernels.h"
#include "cpu/runs.h"

/* The light's view. A point is axes * (p - origin): (x, y, z). Of a sun x, y are its place and z is
 * its depth. A lamp has six faces, numbered as gn_light_face() does: on face f, with axis k = f /
 * 2, W is z's part along the axis, turned by f % 2, and (X, Y) are coordinates k + 1 and k + 2,
 * cyclic, over W. A sun is face 4, with a W of 1. */
typedef struct gn_light_frame {
    bool central;
    double origin[3], axes[3][3];
    double clip; /* metres around a lamp in which nothing casts a shadow */
} gn_light_frame;

enum { GN_LIGHT_FACES = 6, GN_SUN_FACE = 4 };

/* Runs of triangles and what they cover of a face: x in [low[0], high[0]], y likewise. */
typedef struct gn_light_items {
    uint32_t count, capacity;
    float *low[2], *high[2];
    uint32_t *instance, *run;
} gn_light_items;

/* Where a cell's lists begin in gn_light_lists.data, in floats: rows of `opaque` floats each, then
 * rows of `masked` ones. The rows: x, y (and W of a lamp) of three corners, in the cell's frame;
 * the plane of gn_light_ahead() in four; the least depth, by which the list is sorted; and of
 * masked ones the triangle's number, an integer's bits. */
typedef struct gn_light_cell {
    uint32_t first, opaque, masked;
    float covered; /* what lies deeper is behind an opaque triangle that covers the cell */
} gn_light_cell;

enum { GN_LIGHT_PLANE_ROWS = 4 };

static inline uint32_t gn_light_corner_rows(bool central)
{
    return central ? 9 : 6;
}

static inline uint32_t gn_light_rows(bool central, bool masked)
{
    return gn_light_corner_rows(central) + GN_LIGHT_PLANE_ROWS + 1 + masked;
}

typedef struct gn_light_lists {
    uint32_t cells;      /* a side, a power of two; 0: there is nothing */
    gn_light_cell *cell; /* row by row */
    float *data;         /* loads of GN_PACKET floats may pass its last entry */
    double depth;        /* that depths are relative to */
    double left, bottom; /* of the first cell */
    double size, scale;  /* of a cell, and one over it: powers of two */
    uint64_t entries, triangles;
    size_t bytes;
} gn_light_lists;

/* A square of the view, and its lists: of casters that stand or of those that move. */
typedef struct gn_light_tile {
    uint64_t key;
    uint32_t face;
    double centre[2], half; /* of the square, in the face's plane */
    bool refused, too_long; /* its rays go to the tree; since its lists are too long, or for want of
                               memory */
    gn_light_lists lists;
    /* Only of tiles of casters that stand: */
    _Atomic uint64_t used; /* the frame that last asked for it */
    uint64_t moved;        /* the state of moving casters that `moving` is of; 0: not built */
    struct gn_light_tile *moving; /* around this one, of casters that move; NULL: there are none */
} gn_light_tile;

/* Open addressing. Rays add keys, without tiles, while they are traced; everything else happens
 * between passes. */
typedef struct gn_light_slot {
    _Atomic uint64_t key; /* 0: empty */
    gn_light_tile *tile;  /* NULL: asked for, not there */
} gn_light_slot;

enum { GN_LIGHT_SLOT_BITS = 15, GN_LIGHT_SLOTS = 1 << GN_LIGHT_SLOT_BITS };

/* A tile's key: its face, level (it is 2^level wide), column and row. */
#define GN_LIGHT_COLUMNS 0x1p26
static inline uint64_t gn_light_key(uint32_t face, int32_t level, int32_t column, int32_t row)
{
    return (uint64_t)face << 61 | (uint64_t)(level + 256) << 52 |
           (uint64_t)(column + (1 << 25)) << 26 | (uint64_t)(row + (1 << 25));
}

/* Cells of a tile, a side, at most. */
enum { GN_LIGHT_CELL_BITS = 6, GN_LIGHT_CELLS = 1 << GN_LIGHT_CELL_BITS };

/* A triangle on its way into a tile's lists, relative to the tile's centre. */
typedef struct gn_light_triangle {
    float x[3], y[3], w[3];  /* w: 1 under a sun */
    float least, most;       /* depth (gnomon/shadow/light_buffer.h) */
    double plane[3];         /* depth is plane[0] x + plane[1] y + plane[2] */
    uint8_t low[2], high[2]; /* the first and the last of GN_LIGHT_CELLS columns, and rows */
    bool masked, thin;       /* thin: seen edge on, so that its edges and plane say nothing */
    uint32_t id;
} gn_light_triangle;

#define GN_LIGHT_MASKED 0x80000000u
typedef struct gn_light_pair {
    uint32_t triangle, cell; /* cell: and GN_LIGHT_MASKED of a masked triangle */
    double least;            /* depth in the cell */
} gn_light_pair;

/* A thread's room to build tiles in, kept from frame to frame. */
typedef struct gn_light_scratch {
    gn_light_triangle *triangles;
    gn_sort_item *order, *spare;
    gn_light_pair *pairs, *sorted;
    double *covers;   /* of each cell, the depth behind which nothing counts */
    uint32_t *counts; /* of each cell, opaque and masked */
    uint32_t *starts; /* of each cell, in `sorted` */
    uint64_t
        pairs_at[GN_LIGHT_CELL_BITS + 1]; /* that tiles of 1, 2, 4... cells a side would have */
    uint32_t triangle_count, triangle_capacity, order_capacity, spare_capacity, pair_count,
        pair_capacity, sorted_capacity;
} gn_light_scratch;

typedef struct gn_light_buffer {
    gn_context *context;
    const gn_scene *scene;
    const gn_accel *accel;
    /* What it is of; another light or tree starts it anew. */
    uint64_t scene_number, accel_number, transform_version;
    gn_light_frame frame;
    bool selective; /* gn_light_buffer_update() */

    gn_light_items items[2][GN_LIGHT_FACES]; /* by gn_casters */
    uint32_t *first_masked; /* of each instance: what its masked triangles' numbers begin at */
    gn_light_slot *slots;
    _Atomic uint32_t slots_used;
    gn_light_tile **tiles;
    uint32_t tile_count, tile_capacity;
    /* Moving casters have tiles of their own, made anew when they move: 2^moving_level wide, or as
     * wide as the tiles that they are around. */
    gn_light_tile **moving;
    uint32_t moving_count, moving_capacity;
    int32_t moving_level;
    uint64_t time;              /* frames */
    uint64_t moved;             /* counts the states of moving casters */
    size_t limit;               /* bytes that its tiles may take */
    gn_light_scratch *scratch;  /* one a thread */
    _Atomic uint64_t tree_rays; /* of this call */
    gn_light_buffer_info info;  /* but for tree_rays */
} gn_light_buffer;

gn_result gn_light_buffer_create(gn_context *context, gn_light_buffer **buffer);
void gn_light_buffer_destroy(gn_light_buffer **buffer); /* NULL is fine */
/* Makes ready for the rays of a frame, and clears what info says of a call. selective: leaves the
 * rays of tiles whose lists are long to the tree, which is faster there. limit: bytes. */
gn_result gn_light_buffer_update(gn_light_buffer *buffer, const gn_scene *scene,
                                 const gn_light_frame *frame, bool selective, size_t limit);
/* Builds what rays have missed. On error the buffer is empty. */
gn_result gn_light_buffer_grow(gn_light_buffer *buffer);
/* The slot of a tile's key, made where there is none. NULL: the table is full.
 * Thread-safety: any number of threads, while nothing else is called. */
const gn_light_slot *gn_light_find(gn_light_buffer *buffer, uint64_t key);
/* gn_history_draw_light_buffer(). */
void gn_light_buffer_draw(const gn_light_buffer *buffer, uint32_t face, uint32_t size,
                          float *lengths, float *extent);

/* light_items.c: what the runs of an instance cover, face by face. false: no memory. */
bool gn_light_items_add(gn_light_buffer *buffer, uint32_t instance, gn_light_items *items);
void gn_light_items_free(gn_context *context, gn_light_items *items);
/* axes * world matrix of an instance, and the translation behind it: rows of four. */
void gn_light_matrix(const gn_light_buffer *buffer, uint32_t instance, double rows[3][4]);

#endif
