/* Life of a light buffer: what it is of, its tiles, and their building. The loops are in
 * light_gather.inc, light_tile.inc and light_trace.inc. */
#include "cpu/light_buffer.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Tiles that no ray has asked for in so many frames are dropped. */
#define KEPT_FRAMES 120u

/* Tiles are built in batches, between which the memory that they take is looked at. */
#define BATCH 64u

/* Life ---------------------------------------------------------------------------------------- */

static void free_lists(gn_light_buffer *buffer, gn_light_lists *lists)
{
    gn_free(buffer->context, lists->cell);
    gn_free(buffer->context, lists->data);
    buffer->info.bytes -= lists->bytes;
    buffer->info.entries -= lists->entries;
    *lists = (gn_light_lists){0};
}

/* As if it had never been built. */
static void empty_tile(gn_light_buffer *buffer, gn_light_tile *tile)
{
    for (int casters = 0; casters < 2; casters++)
        free_lists(buffer, &tile->lists[casters]);
    tile->moved = 0;
}

static void free_tile(gn_light_buffer *buffer, gn_light_tile *tile)
{
    empty_tile(buffer, tile);
    gn_free(buffer->context, tile);
}

static void empty(gn_light_buffer *buffer)
{
    for (uint32_t i = 0; i < buffer->tile_count; i++)
        free_tile(buffer, buffer->tiles[i]);
    buffer->tile_count = 0;
    buffer->info = (gn_light_buffer_info){0};
    if (buffer->slots)
        memset(buffer->slots, 0, GN_LIGHT_SLOTS * sizeof *buffer->slots);
    buffer->slots_used = 0;
    for (int casters = 0; casters < 2; casters++)
        for (uint32_t face = 0; face < GN_LIGHT_FACES; face++)
            gn_light_items_free(buffer->context, &buffer->items[casters][face]);
    gn_free(buffer->context, buffer->first_masked);
    buffer->first_masked = NULL;
    buffer->scene_number = 0;
}

gn_result gn_light_buffer_create(gn_context *context, gn_light_buffer **buffer)
{
    gn_light_buffer *made = *buffer = gn_alloc_zero(context, 1, sizeof *made);
    if (made) {
        made->context = context;
        made->slots = gn_alloc_zero(context, GN_LIGHT_SLOTS, sizeof *made->slots);
    }
    if (made && made->slots)
        return GN_OK;
    gn_light_buffer_destroy(buffer);
    return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a light buffer");
}

void gn_light_buffer_destroy(gn_light_buffer **buffer)
{
    if (!buffer || !*buffer)
        return;
    gn_light_buffer *b = *buffer;
    *buffer = NULL;
    empty(b);
    gn_free(b->context, b->tiles);
    gn_free(b->context, b->slots);
    gn_free(b->context, b);
}

static gn_result fail_memory(gn_light_buffer *buffer)
{
    empty(buffer);
    return gn_fail(buffer->context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a light buffer");
}

/* Casters ------------------------------------------------------------------------------------- */

static bool is_moving(const gn_light_buffer *buffer, uint32_t instance)
{
    const uint32_t node = buffer->accel->instances[instance].node;
    return node != GN_NONE && buffer->scene->nodes[node].animated;
}

static bool list_casters(gn_light_buffer *buffer, gn_casters casters)
{
    const gn_accel *accel = buffer->accel;
    for (uint32_t face = 0; face < GN_LIGHT_FACES; face++)
        buffer->items[casters][face].count = 0;
    for (uint32_t i = 0; i < accel->instance_count; i++)
        /* A node scaled to nothing casts nothing, as in the tree. */
        if (is_moving(buffer, i) == (casters == GN_CASTERS_DYNAMIC) &&
            (i == 0 || accel->instances[i].determinant > 0.0f) &&
            !gn_light_items_add(buffer, i, buffer->items[casters]))
            return false;
    return true;
}

/* Numbers all masked triangles of all instances. false: no memory, or too many. */
static bool number_masked(gn_light_buffer *buffer)
{
    const gn_accel *accel = buffer->accel;
    buffer->first_masked =
        gn_alloc(buffer->context, (size_t)accel->instance_count + 1, sizeof(uint32_t));
    uint64_t count = 0;
    for (uint32_t i = 0; buffer->first_masked && i <= accel->instance_count; i++) {
        buffer->first_masked[i] = (uint32_t)count;
        if (i < accel->instance_count)
            count += accel->instances[i].tree->counts[GN_GEOMETRY_MASKED];
    }
    return buffer->first_masked && count < UINT32_MAX;
}

/* Growth -------------------------------------------------------------------------------------- */

static uint32_t slot_of(uint64_t key)
{
    return (uint32_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> (64 - GN_LIGHT_SLOT_BITS));
}

const gn_light_slot *gn_light_find(gn_light_buffer *buffer, uint64_t key)
{
    uint32_t i = slot_of(key);
    for (;; i = (i + 1) % GN_LIGHT_SLOTS) {
        gn_light_slot *slot = &buffer->slots[i];
        uint64_t there = atomic_load_explicit(&slot->key, memory_order_relaxed);
        if (there == key)
            return slot;
        if (there != 0)
            continue;
        /* Never more than three quarters full: what is not noted is traced by the tree. */
        if (atomic_load_explicit(&buffer->slots_used, memory_order_relaxed) >
            GN_LIGHT_SLOTS / 4 * 3)
            return NULL;
        if (atomic_compare_exchange_strong(&slot->key, &there, key)) {
            atomic_fetch_add_explicit(&buffer->slots_used, 1, memory_order_relaxed);
            return slot;
        }
        if (there == key)
            return slot;
    }
}

/* Fills the table with the tiles that there are. */
static void fill_slots(gn_light_buffer *buffer)
{
    memset(buffer->slots, 0, GN_LIGHT_SLOTS * sizeof *buffer->slots);
    buffer->slots_used = buffer->tile_count;
    for (uint32_t n = 0; n < buffer->tile_count; n++) {
        uint32_t i = slot_of(buffer->tiles[n]->key);
        while (buffer->slots[i].key != 0)
            i = (i + 1) % GN_LIGHT_SLOTS;
        buffer->slots[i].key = buffer->tiles[n]->key;
        buffer->slots[i].tile = buffer->tiles[n];
    }
}

/* Drops tiles that were not asked for since the frame `oldest`. */
static void drop_tiles(gn_light_buffer *buffer, uint64_t oldest)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < buffer->tile_count; i++)
        if (buffer->tiles[i]->used < oldest)
            free_tile(buffer, buffer->tiles[i]);
        else
            buffer->tiles[kept++] = buffer->tiles[i];
    buffer->tile_count = kept;
}

typedef struct growth {
    gn_light_buffer *buffer;
    gn_light_tile **tiles; /* to be built */
    gn_light_scratch *scratch;
    gn_light_outcome *outcomes;
    uint32_t first; /* of the batch */
} growth;

static void build_tile(uint32_t index, uint32_t thread, void *user)
{
    growth *g = user;
    gn_light_tile *tile = g->tiles[g->first + index];
    const gn_light_buffer *buffer = g->buffer;
    gn_light_outcome outcome = GN_LIGHT_DONE;
    for (int casters = 0; casters < 2 && outcome == GN_LIGHT_DONE; casters++)
        if (casters == GN_CASTERS_DYNAMIC ? tile->moved != buffer->moved : tile->moved == 0)
            outcome = buffer->accel->kernels->light_tile(buffer, tile, (gn_casters)casters,
                                                         &g->scratch[thread]);
    g->outcomes[g->first + index] = outcome;
}

static int compare_keys(const void *a, const void *b)
{
    const gn_light_tile *const *x = a, *const *y = b;
    return ((*x)->key > (*y)->key) - ((*x)->key < (*y)->key);
}

/* Where a key's tile lies. */
static void place_tile(gn_light_tile *tile)
{
    const int64_t x = (int64_t)(tile->key >> 26 & 0x3ffffff) - (1 << 25);
    const int64_t y = (int64_t)(tile->key & 0x3ffffff) - (1 << 25);
    const int level = (int)(tile->key >> 52 & 511) - 256;
    const double size = ldexp(1.0, level);
    tile->face = (uint32_t)(tile->key >> 61);
    tile->half = 0.5 * size;
    tile->centre[0] = ((double)x + 0.5) * size;
    tile->centre[1] = ((double)y + 0.5) * size;
}

/* All tiles that were asked for and are not ready, in order. */
static bool list_wanted(gn_light_buffer *buffer, gn_light_tile ***wanted, uint32_t *count)
{
    *wanted = gn_alloc(buffer->context, GN_LIGHT_SLOTS, sizeof **wanted);
    *count = 0;
    for (uint32_t i = 0; *wanted && i < GN_LIGHT_SLOTS; i++) {
        gn_light_slot *slot = &buffer->slots[i];
        if (slot->key == 0)
            continue;
        if (!slot->tile) {
            if (!gn_grow(buffer->context, (void **)&buffer->tiles, buffer->tile_count,
                         &buffer->tile_capacity, sizeof(gn_light_tile *)))
                return false;
            gn_light_tile *tile = gn_alloc_zero(buffer->context, 1, sizeof *tile);
            if (!tile)
                return false;
            tile->key = slot->key;
            tile->used = buffer->time;
            place_tile(tile);
            slot->tile = buffer->tiles[buffer->tile_count++] = tile;
        }
        const gn_light_tile *tile = slot->tile;
        const bool possible =
            !tile->refused || (!tile->too_long && buffer->info.bytes < buffer->limit / 2);
        if (tile->used == buffer->time && tile->moved != buffer->moved && possible)
            (*wanted)[(*count)++] = slot->tile;
    }
    if (*wanted)
        qsort(*wanted, *count, sizeof **wanted, compare_keys);
    return *wanted != NULL;
}

/* Takes over what a batch has built, tile by tile while there is room. */
static bool take_batch(growth *g, uint32_t count)
{
    gn_light_buffer *buffer = g->buffer;
    for (uint32_t i = g->first; i < g->first + count; i++) {
        gn_light_tile *tile = g->tiles[i];
        const bool fresh = tile->moved == 0;
        for (int casters = 0; casters < 2; casters++) {
            const gn_light_lists *lists = &tile->lists[casters];
            /* Static lists of a tile whose moving casters were built anew are counted already. */
            if (casters == GN_CASTERS_DYNAMIC || fresh) {
                buffer->info.bytes += lists->bytes;
                buffer->info.entries += lists->entries;
                buffer->info.triangles += lists->triangles;
            }
        }
        if (g->outcomes[i] == GN_LIGHT_NO_MEMORY)
            return false;
        buffer->info.built += fresh;
        tile->moved = buffer->moved;
        tile->too_long = g->outcomes[i] == GN_LIGHT_TOO_MUCH;
        tile->refused = tile->too_long || buffer->info.bytes > buffer->limit;
        if (tile->refused)
            empty_tile(buffer, tile);
    }
    return true;
}

static void free_scratch(gn_context *context, gn_light_scratch *s)
{
    gn_free(context, s->triangles);
    gn_free(context, s->order);
    gn_free(context, s->spare);
    gn_free(context, s->pairs);
    gn_free(context, s->covers);
    gn_free(context, s->counts);
    gn_free(context, s->starts);
    gn_free(context, s->sorted);
}

static bool build_tiles(gn_light_buffer *buffer, gn_light_tile **tiles, uint32_t count)
{
    gn_context *context = buffer->context;
    growth g = {.buffer = buffer,
                .tiles = tiles,
                .scratch = gn_alloc_zero(context, context->threads, sizeof *g.scratch),
                .outcomes = gn_alloc_zero(context, count, sizeof *g.outcomes)};
    bool complete = g.scratch && g.outcomes;
    /* Moving casters of the tiles are built anew. */
    for (uint32_t i = 0; i < count; i++)
        free_lists(buffer, &tiles[i]->lists[GN_CASTERS_DYNAMIC]);
    for (; complete && g.first < count; g.first += BATCH) {
        const uint32_t batch = count - g.first < BATCH ? count - g.first : BATCH;
        if (buffer->info.bytes > buffer->limit / 8 * 7)
            drop_tiles(buffer, buffer->time);
        gn_parallel_for(context, batch, build_tile, &g);
        complete = take_batch(&g, batch);
    }
    for (uint32_t i = 0; g.scratch && i < context->threads; i++)
        free_scratch(context, &g.scratch[i]);
    gn_free(context, g.scratch);
    gn_free(context, g.outcomes);
    return complete;
}

/* Moving casters of the tiles that the frame before used: this one most likely does. */
static bool refresh_moving(gn_light_buffer *buffer)
{
    gn_light_tile **stale =
        gn_alloc(buffer->context, (size_t)buffer->tile_count + 1, sizeof *stale);
    uint32_t count = 0;
    for (uint32_t i = 0; stale && i < buffer->tile_count; i++) {
        gn_light_tile *tile = buffer->tiles[i];
        if (tile->used + 1 == buffer->time && tile->moved != buffer->moved && !tile->refused)
            stale[count++] = tile;
    }
    const bool complete = stale && build_tiles(buffer, stale, count);
    gn_free(buffer->context, stale);
    return complete;
}

static bool has_moving(const gn_light_buffer *buffer)
{
    uint32_t count = 0;
    for (uint32_t face = 0; face < GN_LIGHT_FACES; face++)
        count += buffer->items[GN_CASTERS_DYNAMIC][face].count;
    return count > 0;
}

gn_result gn_light_buffer_update(gn_light_buffer *buffer, const gn_scene *scene,
                                 const gn_light_frame *frame, bool selective, size_t limit)
{
    buffer->time++;
    buffer->limit = limit;
    buffer->info.built = buffer->info.refused = 0;
    buffer->info.triangles = 0;
    buffer->tree_rays = 0;
    buffer->info.build_ms = 0.0;
    const double start = gn_milliseconds();
    const bool same =
        buffer->scene_number == scene->number && buffer->accel_number == scene->accel_number &&
        buffer->selective == selective && memcmp(&buffer->frame, frame, sizeof *frame) == 0;
    buffer->scene = scene;
    buffer->accel = scene->accel;
    if (!same) {
        empty(buffer);
        buffer->frame = *frame;
        buffer->selective = selective;
        if (!number_masked(buffer) || !list_casters(buffer, GN_CASTERS_STATIC))
            return fail_memory(buffer);
    }
    if (!same || buffer->transform_version != scene->transform_version) {
        /* Casters that have vanished were there before. */
        const bool before = has_moving(buffer);
        if (!list_casters(buffer, GN_CASTERS_DYNAMIC))
            return fail_memory(buffer);
        if (!same || before || has_moving(buffer))
            buffer->moved++;
    }
    buffer->scene_number = scene->number;
    buffer->accel_number = scene->accel_number;
    buffer->transform_version = scene->transform_version;
    if (same && !refresh_moving(buffer))
        return fail_memory(buffer);
    buffer->info.build_ms = gn_milliseconds() - start;
    return GN_OK;
}

gn_result gn_light_buffer_grow(gn_light_buffer *buffer)
{
    const double start = gn_milliseconds();
    gn_light_tile **wanted;
    uint32_t count;
    bool complete = list_wanted(buffer, &wanted, &count);
    if (complete && count > 0)
        complete = build_tiles(buffer, wanted, count);
    gn_free(buffer->context, wanted);
    if (!complete)
        return fail_memory(buffer);
    if (buffer->time > KEPT_FRAMES)
        drop_tiles(buffer, buffer->time - KEPT_FRAMES);
    fill_slots(buffer);
    buffer->info.tiles = buffer->tile_count;
    for (uint32_t i = 0; i < buffer->tile_count; i++)
        buffer->info.refused += buffer->tiles[i]->refused && buffer->tiles[i]->used == buffer->time;
    buffer->info.build_ms += gn_milliseconds() - start;
    return GN_OK;
}

/* Pictures ------------------------------------------------------------------------------------ */

/* What the lists of the cell hold that a point of the tile lies in. */
static float length_at(const gn_light_tile *tile, const double place[2])
{
    uint32_t entries = 0;
    for (int casters = 0; casters < 2; casters++) {
        const gn_light_lists *lists = &tile->lists[casters];
        uint32_t cell[2];
        for (int k = 0; k < 2 && lists->cells > 0; k++) {
            const double part = (place[k] - tile->centre[k] + tile->half) / (2.0 * tile->half);
            cell[k] = (uint32_t)(part * lists->cells);
            cell[k] = cell[k] < lists->cells ? cell[k] : lists->cells - 1;
        }
        if (lists->cells > 0)
            entries += lists->cell[cell[1] * lists->cells + cell[0]].opaque +
                       lists->cell[cell[1] * lists->cells + cell[0]].masked;
    }
    return (float)entries;
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

static void draw_tile(const gn_light_tile *tile, const square *shown, uint32_t size, float *lengths)
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
            lengths[(size_t)y * size + x] = length_at(tile, place);
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
        for (uint32_t i = 0; i < buffer->tile_count; i++)
            if (buffer->tiles[i]->face == face && buffer->tiles[i]->half == half &&
                !buffer->tiles[i]->refused)
                draw_tile(buffer->tiles[i], shown, size, lengths);
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
