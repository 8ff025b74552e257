/* Pictures of a light buffer: how long its lists are, over the light's view. */
#include <math.h>

#include "cpu/light_buffer.h"

/* What the lists of the cell hold that a point lies in. */
static float length_at(const gn_light_tile *tile, const double place[2])
{
    const gn_light_lists *lists = &tile->lists;
    if (lists->cells == 0)
        return 0.0f;
    uint32_t cell[2];
    for (int k = 0; k < 2; k++) {
        const double part = (place[k] - tile->centre[k] + tile->half) / (2.0 * tile->half);
        cell[k] = (uint32_t)(part * lists->cells);
        cell[k] = cell[k] < lists->cells ? cell[k] : lists->cells - 1;
    }
    const gn_light_cell *there = &lists->cell[cell[1] * lists->cells + cell[0]];
    return (float)(there->opaque + there->masked);
}

/* What a picture shows; rows run downwards. */
typedef struct square {
    double left, top, side;
} square;

/* The first pixel whose centre does not lie before `place`. */
static uint32_t first_pixel(double place, uint32_t size)
{
    return (uint32_t)fmin(fmax(ceil(place - 0.5), 0.0), size);
}

static void draw_tile(const gn_light_tile *tile, const gn_light_tile *moving, const square *shown,
                      uint32_t size, float *lengths)
{
    const double pixels = size / shown->side;
    const double x0 = (tile->centre[0] - tile->half - shown->left) * pixels;
    const double y0 = (shown->top - tile->centre[1] - tile->half) * pixels;
    const double span = 2.0 * tile->half * pixels;
    const uint32_t left = first_pixel(x0, size), right = first_pixel(x0 + span, size);
    const uint32_t top = first_pixel(y0, size), bottom = first_pixel(y0 + span, size);
    for (uint32_t y = top; y < bottom; y++)
        for (uint32_t x = left; x < right; x++) {
            const double place[2] = {shown->left + (x + 0.5) / pixels,
                                     shown->top - (y + 0.5) / pixels};
            lengths[(size_t)y * size + x] =
                length_at(tile, place) + (moving ? length_at(moving, place) : 0.0f);
        }
}

static void draw_tiles(const gn_light_buffer *buffer, uint32_t face, const square *shown,
                       uint32_t size, float *lengths)
{
    double finest = INFINITY, coarsest = 0.0;
    for (uint32_t i = 0; i < buffer->tile_count; i++)
        if (buffer->tiles[i]->face == face) {
            finest = fmin(finest, buffer->tiles[i]->half);
            coarsest = fmax(coarsest, buffer->tiles[i]->half);
        }
    for (size_t i = 0; i < (size_t)size * size; i++)
        lengths[i] = -1.0f;
    double half = 2.0 * coarsest;
    while (half > finest) {
        half *= 0.5;
        for (uint32_t i = 0; i < buffer->tile_count; i++) {
            const gn_light_tile *tile = buffer->tiles[i];
            if (tile->face == face && tile->half == half && !tile->refused)
                draw_tile(tile, tile->moved == buffer->moved ? tile->moving : NULL, shown, size,
                          lengths);
        }
    }
}

/* All tiles of a face. */
static square around_tiles(const gn_light_buffer *buffer, uint32_t face)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (uint32_t i = 0; i < buffer->tile_count; i++) {
        const gn_light_tile *tile = buffer->tiles[i];
        for (int k = 0; k < 2 && tile->face == face; k++) {
            low[k] = fmin(low[k], tile->centre[k] - tile->half);
            high[k] = fmax(high[k], tile->centre[k] + tile->half);
        }
    }
    const double side = fmax(fmax(high[0] - low[0], high[1] - low[1]), 0.0);
    return (square){0.5 * (low[0] + high[0] - side), 0.5 * (low[1] + high[1] + side), side};
}

/* Tiles reach to the horizon, where nothing casts a shadow. Narrows a square to the pixels of it
 * that have lists; false: they fill most of it, or there are none. */
static bool narrow(const float *lengths, uint32_t size, square *shown)
{
    uint32_t low[2] = {size, size}, high[2] = {0, 0};
    for (uint32_t y = 0; y < size; y++)
        for (uint32_t x = 0; x < size; x++)
            if (lengths[(size_t)y * size + x] > 0.0f) {
                low[0] = x < low[0] ? x : low[0];
                high[0] = x >= high[0] ? x + 1 : high[0];
                low[1] = y < low[1] ? y : low[1];
                high[1] = y + 1;
            }
    if (low[0] >= high[0])
        return false;
    const double pixel = shown->side / size;
    /* A pixel more on all sides: what has lists may lie between the centres of two. */
    const double width = high[0] - low[0] + 2.0, height = high[1] - low[1] + 2.0;
    const double side = fmax(width, height) * pixel;
    if (side > 0.75 * shown->side)
        return false;
    shown->left += 0.5 * (low[0] + high[0]) * pixel - 0.5 * side;
    shown->top -= 0.5 * (low[1] + high[1]) * pixel - 0.5 * side;
    shown->side = side;
    return true;
}

void gn_light_buffer_draw(const gn_light_buffer *buffer, uint32_t face, uint32_t size,
                          float *lengths, float *extent)
{
    const bool central = buffer->frame.central;
    const uint32_t drawn = central ? face : GN_SUN_FACE;
    square shown = central ? (square){-1.0, 1.0, 2.0} : around_tiles(buffer, drawn);
    do
        draw_tiles(buffer, drawn, &shown, size, lengths);
    while (!central && narrow(lengths, size, &shown));
    *extent = (float)shown.side;
}
