/* Life of a light buffer: what it is of, its tiles, and their building. The loops are in
 * light_gather.inc, light_tile.inc and light_trace.inc. */
#include "cpu/light_buffer.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Tiles that no ray has asked for in so many frames are dropped. */
#define KEPT_FRAMES 120u

/* Room for more triangles, or pairs of triangles and cells, is not kept between frames. */
#define KEPT_SCRATCH (1u << 16)

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
    free_lists(buffer, &tile->lists);
    tile->moved = 0;
}

static void free_tile(gn_light_buffer *buffer, gn_light_tile *tile)
{
    empty_tile(buffer, tile);
    gn_free(buffer->context, tile);
}

static void drop_moving(gn_light_buffer *buffer)
{
    for (uint32_t i = 0; i < buffer->moving_count; i++)
        free_tile(buffer, buffer->moving[i]);
    buffer->moving_count = 0;
}

static void empty(gn_light_buffer *buffer)
{
    drop_moving(buffer);
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
    *s = (gn_light_scratch){0};
}

gn_result gn_light_buffer_create(gn_context *context, gn_light_buffer **buffer)
{
    gn_light_buffer *made = *buffer = gn_alloc_zero(context, 1, sizeof *made);
    if (made) {
        made->context = context;
        made->slots = gn_alloc_zero(context, GN_LIGHT_SLOTS, sizeof *made->slots);
        made->scratch = gn_alloc_zero(context, context->threads, sizeof *made->scratch);
    }
    if (made && made->slots && made->scratch)
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
    gn_free(b->context, b->moving);
    gn_free(b->context, b->slots);
    for (uint32_t i = 0; b->scratch && i < b->context->threads; i++)
        free_scratch(b->context, &b->scratch[i]);
    gn_free(b->context, b->scratch);
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

static bool has_moving(const gn_light_buffer *buffer)
{
    uint32_t count = 0;
    for (uint32_t face = 0; face < GN_LIGHT_FACES; face++)
        count += buffer->items[GN_CASTERS_DYNAMIC][face].count;
    return count > 0;
}

/* Tiles whose finest cells are an eighth of the runs' sides, about as large as their triangles. */
static int32_t find_moving_level(const gn_light_buffer *buffer)
{
    double sum = 0.0;
    uint32_t count = 0;
    for (uint32_t face = 0; face < GN_LIGHT_FACES; face++) {
        const gn_light_items *items = &buffer->items[GN_CASTERS_DYNAMIC][face];
        for (uint32_t i = 0; i < items->count; i++) {
            const double width = (double)items->high[0][i] - (double)items->low[0][i];
            const double height = (double)items->high[1][i] - (double)items->low[1][i];
            const double side = sqrt(width * height);
            if (isfinite(side)) {
                sum += side;
                count++;
            }
        }
    }
    const double side = GN_LIGHT_CELLS / 8.0 * sum / count;
    const int32_t level = count > 0 && sum > 0.0 ? (int32_t)lround(log2(side)) : INT32_MIN;
    return buffer->frame.central && level > 0 ? 0 : level;
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
    gn_casters casters;
    gn_light_tile **tiles; /* to be built */
    gn_light_outcome *outcomes;
    uint32_t first; /* of the batch */
} growth;

static void build_tile(uint32_t index, uint32_t thread, void *user)
{
    growth *g = user;
    g->outcomes[g->first + index] = g->buffer->accel->kernels->light_tile(
        g->buffer, g->tiles[g->first + index], g->casters, &g->buffer->scratch[thread]);
}

static int compare_keys(const void *a, const void *b)
{
    const gn_light_tile *const *x = a, *const *y = b;
    return ((*x)->key > (*y)->key) - ((*x)->key < (*y)->key);
}

/* Parts of a key. */
static int32_t key_level(uint64_t key)
{
    return (int32_t)(key >> 52 & 511) - 256;
}

static int32_t key_column(uint64_t key)
{
    return (int32_t)(key >> 26 & 0x3ffffff) - (1 << 25);
}

static int32_t key_row(uint64_t key)
{
    return (int32_t)(key & 0x3ffffff) - (1 << 25);
}

/* A tile where its key says, added to an array of them. NULL: no memory. */
static gn_light_tile *add_tile(gn_light_buffer *buffer, uint64_t key, gn_light_tile ***tiles,
                               uint32_t *count, uint32_t *capacity)
{
    if (!gn_grow(buffer->context, (void **)tiles, *count, capacity, sizeof **tiles))
        return NULL;
    gn_light_tile *tile = gn_alloc_zero(buffer->context, 1, sizeof *tile);
    if (!tile)
        return NULL;
    const double size = ldexp(1.0, key_level(key));
    tile->key = key;
    tile->face = (uint32_t)(key >> 61);
    tile->half = 0.5 * size;
    tile->centre[0] = (key_column(key) + 0.5) * size;
    tile->centre[1] = (key_row(key) + 0.5) * size;
    return (*tiles)[(*count)++] = tile;
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
            slot->tile = add_tile(buffer, slot->key, &buffer->tiles, &buffer->tile_count,
                                  &buffer->tile_capacity);
            if (!slot->tile)
                return false;
            slot->tile->used = buffer->time;
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
        buffer->info.bytes += tile->lists.bytes;
        buffer->info.entries += tile->lists.entries;
        buffer->info.triangles += tile->lists.triangles;
        if (g->outcomes[i] == GN_LIGHT_NO_MEMORY)
            return false;
        tile->too_long = g->outcomes[i] == GN_LIGHT_TOO_MUCH;
        tile->refused = tile->too_long || buffer->info.bytes > buffer->limit;
        if (tile->refused)
            free_lists(buffer, &tile->lists);
    }
    return true;
}

/* Where memory is short, tiles that were not asked for since the frame `oldest` make room. */
static bool build_lists(gn_light_buffer *buffer, gn_casters casters, gn_light_tile **tiles,
                        uint32_t count, uint64_t oldest)
{
    gn_context *context = buffer->context;
    growth g = {.buffer = buffer,
                .casters = casters,
                .tiles = tiles,
                .outcomes = gn_alloc_zero(context, count, sizeof *g.outcomes)};
    bool complete = g.outcomes != NULL;
    for (; complete && g.first < count; g.first += BATCH) {
        const uint32_t batch = count - g.first < BATCH ? count - g.first : BATCH;
        if (buffer->info.bytes > buffer->limit / 8 * 7)
            drop_tiles(buffer, oldest);
        gn_parallel_for(context, batch, build_tile, &g);
        complete = take_batch(&g, batch);
    }
    gn_free(context, g.outcomes);
    for (uint32_t i = 0; i < context->threads; i++)
        if (buffer->scratch[i].triangle_capacity > KEPT_SCRATCH ||
            buffer->scratch[i].pair_capacity > KEPT_SCRATCH)
            free_scratch(context, &buffer->scratch[i]);
    return complete;
}

/* So many levels up one tile is a quarter of everything. */
enum { LEVELS_UP = 25 };

/* The tile of moving casters around a tile, made where it is not there. false: no memory. */
static bool find_moving(gn_light_buffer *buffer, gn_light_tile *tile)
{
    const int32_t level = key_level(tile->key);
    int32_t up = buffer->moving_level > level ? buffer->moving_level - level : 0;
    up = up < LEVELS_UP ? up : LEVELS_UP;
    const uint64_t key =
        gn_light_key(tile->face, level + up, key_column(tile->key) >> up, key_row(tile->key) >> up);
    for (uint32_t i = buffer->moving_count; i-- > 0;)
        if (buffer->moving[i]->key == key) {
            tile->moving = buffer->moving[i];
            return true;
        }
    return (tile->moving = add_tile(buffer, key, &buffer->moving, &buffer->moving_count,
                                    &buffer->moving_capacity)) != NULL;
}

/* Of a tile's cells, those along one axis that [low, high] reaches. */
static void find_range(double low, double high, const gn_light_tile *tile, double centre,
                       uint32_t *first, uint32_t *last)
{
    const double cells = tile->lists.cells, scale = 0.5 * cells / tile->half;
    const double edge = centre - tile->half;
    *first = (uint32_t)fmin(fmax((low - edge) * scale, 0.0), cells - 1.0);
    *last = (uint32_t)fmin(fmax((high - edge) * scale, 0.0), cells - 1.0);
}

/* Does anything that moves lie in a tile's part of the one around it? */
static bool is_moved_over(const gn_light_tile *tile)
{
    const gn_light_tile *moving = tile->moving;
    uint32_t first[2], last[2];
    if (moving->refused || moving->lists.cells == 0)
        return moving->refused;
    for (int k = 0; k < 2; k++)
        find_range(tile->centre[k] - tile->half, tile->centre[k] + tile->half, moving,
                   moving->centre[k], &first[k], &last[k]);
    for (uint32_t row = first[1]; row <= last[1]; row++)
        for (uint32_t column = first[0]; column <= last[0]; column++) {
            const gn_light_cell *cell = &moving->lists.cell[row * moving->lists.cells + column];
            if (cell->opaque + cell->masked > 0)
                return true;
        }
    return false;
}

/* Tiles that are new, or whose moving casters have moved; no tile of them is older than `oldest`,
 * as in build_lists(). Puts new ones first. */
static bool build_tiles(gn_light_buffer *buffer, gn_light_tile **tiles, uint32_t count,
                        uint64_t oldest)
{
    const uint32_t there = buffer->moving_count;
    uint32_t fresh = 0;
    for (uint32_t i = 0; i < count; i++) {
        gn_light_tile *tile = tiles[i];
        tile->moving = NULL;
        if (has_moving(buffer) && !find_moving(buffer, tile))
            return false;
        if (tile->moved == 0) {
            tiles[i] = tiles[fresh];
            tiles[fresh++] = tile;
        }
    }
    if (!build_lists(buffer, GN_CASTERS_DYNAMIC, buffer->moving + there,
                     buffer->moving_count - there, oldest) ||
        !build_lists(buffer, GN_CASTERS_STATIC, tiles, fresh, oldest))
        return false;
    buffer->info.built += fresh;
    for (uint32_t i = 0; i < count; i++) {
        if (tiles[i]->moving && !is_moved_over(tiles[i]))
            tiles[i]->moving = NULL;
        tiles[i]->moved = tiles[i]->refused ? 0 : buffer->moved;
    }
    return true;
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
    const uint32_t tiles = buffer->tile_count;
    const bool complete = stale && build_tiles(buffer, stale, count, buffer->time - 1);
    if (complete && buffer->tile_count < tiles)
        fill_slots(buffer);
    gn_free(buffer->context, stale);
    return complete;
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
        if (!same || before || has_moving(buffer)) {
            buffer->moved++;
            buffer->moving_level = find_moving_level(buffer);
            drop_moving(buffer);
        }
    }
    buffer->scene_number = scene->number;
    buffer->accel_number = scene->accel_number;
    buffer->transform_version = scene->transform_version;
    if (same && !refresh_moving(buffer))
        return fail_memory(buffer);
    buffer->info.build_ms = gn_milliseconds() - start;
    return GN_OK;
}

/* Are a tile's rays left to the tree? */
static bool is_left(const gn_light_buffer *buffer, const gn_light_tile *tile)
{
    return tile->refused || (tile->moved == buffer->moved && tile->moving && tile->moving->refused);
}

gn_result gn_light_buffer_grow(gn_light_buffer *buffer)
{
    const double start = gn_milliseconds();
    gn_light_tile **wanted;
    uint32_t count;
    bool complete = list_wanted(buffer, &wanted, &count);
    if (complete && count > 0)
        complete = build_tiles(buffer, wanted, count, buffer->time);
    gn_free(buffer->context, wanted);
    if (!complete)
        return fail_memory(buffer);
    if (buffer->time > KEPT_FRAMES)
        drop_tiles(buffer, buffer->time - KEPT_FRAMES);
    fill_slots(buffer);
    buffer->info.tiles = buffer->tile_count;
    for (uint32_t i = 0; i < buffer->tile_count; i++)
        buffer->info.refused +=
            buffer->tiles[i]->used == buffer->time && is_left(buffer, buffer->tiles[i]);
    buffer->info.build_ms += gn_milliseconds() - start;
    return GN_OK;
}
