#include "cpu/runs.h"

#include <math.h>
#include <string.h>

gn_sort_item *gn_sort(gn_sort_item *items, gn_sort_item *spare, uint32_t count)
{
    enum { BITS = 11, DIGITS = 1 << BITS };
    uint64_t differ = 0;
    for (uint32_t i = 0; i < count; i++)
        differ |= items[i].key ^ items[0].key;
    for (int shift = 0; shift < 64; shift += BITS) {
        uint32_t first[DIGITS + 1] = {0};
        if ((differ >> shift & (DIGITS - 1)) == 0)
            continue;
        for (uint32_t i = 0; i < count; i++)
            first[(items[i].key >> shift & (DIGITS - 1)) + 1]++;
        for (uint32_t d = 1; d <= DIGITS; d++)
            first[d] += first[d - 1];
        for (uint32_t i = 0; i < count; i++)
            spare[first[items[i].key >> shift & (DIGITS - 1)]++] = items[i];
        gn_sort_item *sorted = spare;
        spare = items;
        items = sorted;
    }
    return items;
}

/* Every third bit, from 21. */
static uint64_t spread(uint64_t x)
{
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

static void tree_corners(const gn_triangle_tree *tree, int kind, uint32_t triangle,
                         const float *corners[3])
{
    for (uint32_t c = 0; c < 3; c++)
        corners[c] = tree->vertices + (size_t)tree->indices[kind][(size_t)triangle * 3 + c] * 3;
}

static void grow_box(gn_box *box, const float p[3])
{
    for (int axis = 0; axis < 3; axis++) {
        box->min[axis] = fminf(box->min[axis], p[axis]);
        box->max[axis] = fmaxf(box->max[axis], p[axis]);
    }
}

static gn_box empty_box(void)
{
    return (gn_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static uint64_t morton(const gn_box *bounds, const float *const corners[3])
{
    uint64_t key = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double extent = (double)bounds->max[axis] - (double)bounds->min[axis];
        double sum = 0;
        for (int c = 0; c < 3; c++)
            sum += (double)corners[c][axis] - (double)bounds->min[axis];
        const double place = extent > 0 ? sum / (3 * extent) : 0;
        key |= spread((uint64_t)(fmin(fmax(place, 0), 1) * 2097151.0)) << axis;
    }
    return key;
}

/* Fills one run from sorted triangles; count <= GN_RUN. */
static void fill_run(const gn_triangle_tree *tree, int kind, const gn_sort_item *items,
                     uint32_t count, gn_batch *batches, gn_box *box)
{
    *box = empty_box();
    for (uint32_t i = 0; i < GN_RUN; i++) {
        const bool there = i < count;
        gn_batch *batch = &batches[i / GN_BATCH];
        const uint32_t lane = i % GN_BATCH, id = items[there ? i : 0].index;
        const float *corners[3];
        tree_corners(tree, kind, id, corners);
        batch->ids[lane] = id;
        for (int c = 0; c < 3; c++) {
            const float *corner = corners[there ? c : 0];
            for (int axis = 0; axis < 3; axis++)
                batch->corners[c][axis][lane] = corner[axis];
            grow_box(box, corner);
        }
    }
}

/* One kind of a tree's triangles, in parts. */
typedef struct part_job {
    const gn_triangle_tree *tree;
    int kind;
    gn_runs *runs;
    uint32_t first_run; /* of this kind */
    gn_sort_item *items;
    const gn_sort_item *sorted;
} part_job;

enum { PART_RUNS = 64, PART = PART_RUNS * GN_RUN };

static uint32_t part_end(const part_job *job, uint32_t part)
{
    const uint32_t count = job->tree->counts[job->kind];
    return count - part * PART < PART ? count : (part + 1) * PART;
}

static void make_keys(uint32_t part, uint32_t thread, void *user)
{
    const part_job *job = user;
    const uint32_t end = part_end(job, part);
    (void)thread;
    for (uint32_t i = part * PART; i < end; i++) {
        const float *corners[3];
        tree_corners(job->tree, job->kind, i, corners);
        job->items[i] = (gn_sort_item){morton(&job->runs->bounds, corners), i};
    }
}

static void fill_runs(uint32_t part, uint32_t thread, void *user)
{
    const part_job *job = user;
    const uint32_t end = part_end(job, part);
    (void)thread;
    for (uint32_t i = part * PART; i < end; i += GN_RUN) {
        const uint32_t run = job->first_run + i / GN_RUN;
        fill_run(job->tree, job->kind, job->sorted + i, end - i < GN_RUN ? end - i : GN_RUN,
                 job->runs->batches + (size_t)run * GN_RUN_BATCHES, &job->runs->boxes[run]);
    }
}

static gn_runs *build(gn_context *context, const gn_triangle_tree *tree)
{
    const uint32_t most = tree->counts[0] > tree->counts[1] ? tree->counts[0] : tree->counts[1];
    gn_runs *runs = gn_alloc_zero(context, 1, sizeof *runs);
    gn_sort_item *items = gn_alloc(context, (size_t)most + 1, sizeof *items);
    gn_sort_item *spare = gn_alloc(context, (size_t)most + 1, sizeof *spare);
    if (!runs || !items || !spare)
        goto failed;
    runs->first_masked = (tree->counts[0] + GN_RUN - 1) / GN_RUN;
    runs->count = runs->first_masked + (tree->counts[1] + GN_RUN - 1) / GN_RUN;
    runs->batches =
        gn_alloc(context, (size_t)runs->count * GN_RUN_BATCHES + 1, sizeof *runs->batches);
    runs->boxes = gn_alloc(context, (size_t)runs->count + 1, sizeof *runs->boxes);
    if (!runs->batches || !runs->boxes)
        goto failed;

    runs->bounds = empty_box();
    for (uint32_t v = 0; v < tree->vertex_count; v++)
        grow_box(&runs->bounds, tree->vertices + (size_t)v * 3);
    for (int kind = 0; kind < 2; kind++) {
        const uint32_t parts = (tree->counts[kind] + PART - 1) / PART;
        part_job job = {.tree = tree,
                        .kind = kind,
                        .runs = runs,
                        .first_run = kind == 0 ? 0 : runs->first_masked,
                        .items = items};
        gn_parallel_for(context, parts, make_keys, &job);
        job.sorted = gn_sort(items, spare, tree->counts[kind]);
        gn_parallel_for(context, parts, fill_runs, &job);
    }
    gn_free(context, items);
    gn_free(context, spare);
    return runs;
failed:
    gn_free(context, items);
    gn_free(context, spare);
    gn_runs_free(context, runs);
    return NULL;
}

const gn_runs *gn_tree_runs(gn_accel *accel, gn_triangle_tree *tree)
{
    pthread_mutex_lock(&accel->runs_mutex);
    if (!tree->runs)
        tree->runs = build(accel->context, tree);
    const gn_runs *runs = tree->runs;
    pthread_mutex_unlock(&accel->runs_mutex);
    return runs;
}

void gn_runs_free(gn_context *context, gn_runs *runs)
{
    if (!runs)
        return;
    gn_free(context, runs->batches);
    gn_free(context, runs->boxes);
    gn_free(context, runs);
}
