#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "cpu/cpu.h"

const float gn_map_samples[4][2] = {
    {0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};

static const float center_sample[1][2] = {{0.5f, 0.5f}};

/* Runs of one draw that one thread culls at a time. */
#define CHUNK 512u

typedef struct chunk {
    uint32_t draw, first_run;
} chunk;

/* One call at work. */
typedef struct drawing {
    gn_depth_frame frame;
    gn_context *context;
    gn_depth_draw *draws;
    chunk *chunks;
    gn_depth_run *runs, *sorted_runs;
    gn_sort_item *order, *spare; /* of runs, by their nearest point */
    uint32_t *first_in_tile, *in_tiles;
    uint32_t draw_count, chunk_count;
    uint64_t run_capacity;
    _Atomic uint32_t run_count;
} drawing;

/* Draws ---------------------------------------------------------------------------------------*/

/* The rows of gn_depth_draw for a tree in world space. */
static void world_rows(const gn_map_projection *p, double rows[3][4])
{
    const double half = 0.5 * (double)p->resolution;
    const double scale = half / (double)p->extent;
    const double depth = p->perspective ? 1.0 : 1.0 / ((double)p->far - (double)p->near);
    const float *axes[3] = {p->right, p->up, p->forward};
    const double scales[3] = {scale, -scale, depth};
    for (int row = 0; row < 3; row++) {
        rows[row][3] = 0;
        for (int i = 0; i < 3; i++) {
            rows[row][i] = scales[row] * (double)axes[row][i];
            rows[row][3] -= rows[row][i] * (double)p->origin[i];
        }
    }
    if (p->perspective)
        return;
    rows[0][3] += half;
    rows[1][3] += half;
    rows[2][3] -= depth * (double)p->near;
}

static bool is_drawn(const gn_depth_job *job, const gn_instance *instance)
{
    if (instance->tree->counts[0] + instance->tree->counts[1] == 0)
        return false;
    const bool flat = instance->node == GN_NONE;
    const bool moving = !flat && job->scene->nodes[instance->node].animated;
    /* Trees scaled to nothing have no inside; rays cannot hit them either. */
    if (!flat && !(instance->determinant > 0.0f))
        return false;
    return job->casters == GN_CASTERS_ALL || moving == (job->casters == GN_CASTERS_DYNAMIC);
}

/* Screen rectangle and depth of a box, larger than any of its points can come out. false: nothing
 * of it can be seen. */
static bool project_box(const gn_depth_frame *frame, const gn_depth_draw *draw, const gn_box *box,
                        uint16_t first[2], uint16_t last[2], float *nearest)
{
    const gn_map_projection *p = &frame->job->projection;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double error[3]; /* of a projected corner in single precision */
    for (int row = 0; row < 3; row++) {
        const float *r = draw->rows[row];
        double size = fabs((double)r[3]);
        for (int i = 0; i < 3; i++)
            size += fabs((double)r[i]) * fmax(fabs((double)box->min[i]), fabs((double)box->max[i]));
        error[row] = size * 1e-6;
    }
    bool crosses = false;
    int beside[4] = {0}; /* corners beyond each side of the pyramid */
    for (int corner = 0; corner < 8; corner++) {
        double q[3];
        for (int row = 0; row < 3; row++) {
            const float *r = draw->rows[row];
            q[row] = (double)r[3];
            for (int i = 0; i < 3; i++)
                q[row] += (double)r[i] * (double)(corner >> i & 1 ? box->max[i] : box->min[i]);
        }
        if (p->perspective) {
            crosses = crosses || q[2] - error[2] < (double)p->near;
            for (int row = 0; row < 2; row++) {
                const double side = (double)frame->centre * (q[2] + error[2]) + error[row];
                beside[2 * row] += q[row] > side;
                beside[2 * row + 1] += -q[row] > side;
            }
            const double w = fmax(q[2], 1e-30);
            q[0] = q[0] / w + (double)frame->centre;
            q[1] = q[1] / w + (double)frame->centre;
        }
        for (int row = 0; row < 3; row++) {
            low[row] = fmin(low[row], q[row]);
            high[row] = fmax(high[row], q[row]);
        }
    }
    *nearest = (float)low[2];
    if (p->perspective) {
        if (high[2] + error[2] < (double)p->near || low[2] - error[2] > (double)p->far)
            return false;
        if (beside[0] == 8 || beside[1] == 8 || beside[2] == 8 || beside[3] == 8)
            return false;
        for (int row = 0; row < 2; row++) {
            const double w = fmax(low[2], (double)p->near);
            const double far_out = fmax(fabs(low[row]), fabs(high[row]));
            error[row] =
                (error[row] + (far_out + (double)frame->centre) * error[2]) / w + far_out * 1e-6;
        }
    } else if (low[2] - error[2] >= 1.0) {
        return false;
    }
    const double end = (double)p->resolution - 1.0;
    for (int row = 0; row < 2; row++) {
        const double from = ceil(low[row] - error[row] - (double)frame->sample_max);
        const double to = floor(high[row] + error[row] - (double)frame->sample_min);
        /* A box that crosses the near plane can be anywhere. */
        if (!crosses && !(from <= end && to >= 0.0 && from <= to))
            return false;
        first[row] = crosses ? 0 : (uint16_t)(fmax(from, 0.0) / GN_DEPTH_TILE);
        last[row] = (uint16_t)((crosses ? end : fmin(to, end)) / GN_DEPTH_TILE);
    }
    return true;
}

static gn_result add_draws(drawing *d)
{
    const gn_depth_job *job = d->frame.job;
    gn_accel *accel = job->scene->accel;
    double world[3][4];
    world_rows(&job->projection, world);
    d->draws = gn_alloc(d->context, (size_t)accel->instance_count + 1, sizeof *d->draws);
    if (!d->draws)
        return GN_ERROR_OUT_OF_MEMORY;
    d->frame.draws = d->draws;
    uint64_t chunks = 0;
    for (uint32_t i = 0; i < accel->instance_count; i++) {
        const gn_instance *instance = &accel->instances[i];
        if (!is_drawn(job, instance))
            continue;
        gn_depth_draw *draw = &d->draws[d->draw_count];
        draw->tree = instance->tree;
        draw->unit = 1.0f;
        gn_triangle_tree *tree = &accel->flat;
        if (instance->node != GN_NONE) {
            const gn_node *node = &job->scene->nodes[instance->node];
            tree = &accel->trees[node->desc.mesh];
            draw->unit = 1.0f / cbrtf(instance->determinant);
            for (int row = 0; row < 3; row++)
                for (int c = 0; c < 4; c++) {
                    double sum = c == 3 ? world[row][3] : 0.0;
                    for (int k = 0; k < 3; k++)
                        sum += world[row][k] * (double)node->world[4 * c + k];
                    draw->rows[row][c] = (float)sum;
                }
        } else {
            for (int row = 0; row < 3; row++)
                for (int c = 0; c < 4; c++)
                    draw->rows[row][c] = (float)world[row][c];
        }
        draw->runs = gn_tree_runs(accel, tree);
        if (!draw->runs)
            return GN_ERROR_OUT_OF_MEMORY;
        uint16_t first[2], last[2];
        float nearest;
        if (!project_box(&d->frame, draw, &draw->runs->bounds, first, last, &nearest))
            continue;
        d->draw_count++;
        d->run_capacity += draw->runs->count;
        chunks += (draw->runs->count + CHUNK - 1) / CHUNK;
    }
    if (d->run_capacity > UINT32_MAX)
        return GN_ERROR_OUT_OF_MEMORY;
    d->chunks = gn_alloc(d->context, chunks + 1, sizeof *d->chunks);
    if (!d->chunks)
        return GN_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; i < d->draw_count; i++)
        for (uint32_t run = 0; run < d->draws[i].runs->count; run += CHUNK)
            d->chunks[d->chunk_count++] = (chunk){i, run};
    return GN_OK;
}

/* Runs ----------------------------------------------------------------------------------------*/

/* Ascending as the number is. */
static uint32_t sortable(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/* Tiles are dealt out to parts along rows, and each row starts three parts on from the one above:
 * what is dear to draw lies close together. Parts of casters instead of tiles would be drawn over
 * each other, not front to back, and every tile in every part. */
static bool is_in_part(const gn_depth_job *job, uint32_t x, uint32_t y)
{
    return job->parts == 0 || (x + 3 * y) % job->parts == job->part;
}

static bool touches_part(const gn_depth_job *job, const gn_depth_run *run)
{
    for (uint32_t y = run->first[1]; y <= run->last[1]; y++)
        for (uint32_t x = run->first[0]; x <= run->last[0]; x++)
            if (is_in_part(job, x, y))
                return true;
    return false;
}

static void cull_chunk(uint32_t index, uint32_t thread, void *user)
{
    (void)thread;
    drawing *d = user;
    const chunk c = d->chunks[index];
    const gn_runs *runs = d->draws[c.draw].runs;
    const uint32_t end = runs->count - c.first_run < CHUNK ? runs->count : c.first_run + CHUNK;
    for (uint32_t run = c.first_run; run < end; run++) {
        gn_depth_run seen = {.draw = c.draw, .run = run};
        float nearest;
        if (!project_box(&d->frame, &d->draws[c.draw], &runs->boxes[run], seen.first, seen.last,
                         &nearest) ||
            !touches_part(d->frame.job, &seen))
            continue;
        const uint32_t n = atomic_fetch_add(&d->run_count, 1);
        d->runs[n] = seen;
        d->order[n] = (gn_sort_item){sortable(nearest), n};
    }
}

/* Runs that can be seen, front to back: the sooner a tile is full, the less is drawn into it. */
static gn_result find_runs(drawing *d)
{
    const size_t capacity = (size_t)d->run_capacity + 1;
    d->runs = gn_alloc(d->context, capacity, sizeof *d->runs);
    d->order = gn_alloc(d->context, capacity, sizeof *d->order);
    if (!d->runs || !d->order)
        return GN_ERROR_OUT_OF_MEMORY;
    gn_parallel_for(d->context, d->chunk_count, cull_chunk, d);
    const uint32_t count = d->run_count;
    d->spare = gn_alloc(d->context, (size_t)count + 1, sizeof *d->spare);
    d->sorted_runs = gn_alloc(d->context, (size_t)count + 1, sizeof *d->sorted_runs);
    if (!d->spare || !d->sorted_runs)
        return GN_ERROR_OUT_OF_MEMORY;
    const gn_sort_item *sorted = gn_sort(d->order, d->spare, count);
    for (uint32_t i = 0; i < count; i++)
        d->sorted_runs[i] = d->runs[sorted[i].index];
    d->frame.runs = d->sorted_runs;
    return GN_OK;
}

static gn_result fill_tiles(drawing *d)
{
    const gn_depth_job *job = d->frame.job;
    const uint32_t across = d->frame.tiles, tiles = across * across;
    uint32_t *first = gn_alloc_zero(d->context, (size_t)tiles + 2, sizeof *first);
    if (!first)
        return GN_ERROR_OUT_OF_MEMORY;
    d->first_in_tile = first;
    uint64_t total = 0;
    for (uint32_t i = 0; i < d->run_count; i++) {
        const gn_depth_run *run = &d->sorted_runs[i];
        for (uint32_t y = run->first[1]; y <= run->last[1]; y++)
            for (uint32_t x = run->first[0]; x <= run->last[0]; x++)
                if (is_in_part(job, x, y)) {
                    first[y * across + x + 2]++;
                    total++;
                }
    }
    if (total > UINT32_MAX)
        return GN_ERROR_OUT_OF_MEMORY;
    d->in_tiles = gn_alloc(d->context, total + 1, sizeof *d->in_tiles);
    if (!d->in_tiles)
        return GN_ERROR_OUT_OF_MEMORY;
    for (uint32_t t = 1; t < tiles + 2; t++)
        first[t] += first[t - 1];
    for (uint32_t i = 0; i < d->run_count; i++) {
        const gn_depth_run *run = &d->sorted_runs[i];
        for (uint32_t y = run->first[1]; y <= run->last[1]; y++)
            for (uint32_t x = run->first[0]; x <= run->last[0]; x++)
                if (is_in_part(job, x, y))
                    d->in_tiles[first[y * across + x + 1]++] = i;
    }
    d->frame.first_in_tile = first;
    d->frame.in_tiles = d->in_tiles;
    return GN_OK;
}

/* Tiles ---------------------------------------------------------------------------------------*/

/* Is a tile empty, and was before? */
static bool is_clear(const gn_depth_frame *frame, uint32_t tile)
{
    const gn_rect *stale = frame->job->stale;
    const uint32_t x = tile % frame->tiles * GN_DEPTH_TILE, y = tile / frame->tiles * GN_DEPTH_TILE;
    return stale && frame->first_in_tile[tile] == frame->first_in_tile[tile + 1] &&
           (x >= stale->x1 || x + GN_DEPTH_TILE <= stale->x0 || y >= stale->y1 ||
            y + GN_DEPTH_TILE <= stale->y0);
}

static void draw_tile(uint32_t tile, uint32_t thread, void *user)
{
    const gn_depth_frame *frame = user;
    if (is_in_part(frame->job, tile % frame->tiles, tile / frame->tiles) && !is_clear(frame, tile))
        frame->accel->kernels->depth_tile(frame, tile, frame->buffers[thread]);
}

static void grow_rect(gn_rect *rect, gn_rect by)
{
    if (by.x0 >= by.x1)
        return;
    if (rect->x0 >= rect->x1) {
        *rect = by;
        return;
    }
    rect->x0 = by.x0 < rect->x0 ? by.x0 : rect->x0;
    rect->y0 = by.y0 < rect->y0 ? by.y0 : rect->y0;
    rect->x1 = by.x1 > rect->x1 ? by.x1 : rect->x1;
    rect->y1 = by.y1 > rect->y1 ? by.y1 : rect->y1;
}

static gn_result draw_tiles(drawing *d)
{
    gn_depth_frame *frame = &d->frame;
    const uint32_t tiles = frame->tiles * frame->tiles, threads = d->context->threads;
    const size_t texels = (size_t)frame->job->samples * GN_DEPTH_TILE * GN_DEPTH_TILE;
    frame->covered = gn_alloc_zero(d->context, tiles, sizeof *frame->covered);
    frame->buffers = gn_alloc(d->context, threads, sizeof *frame->buffers);
    float *buffer = gn_alloc(d->context, threads * texels, sizeof *buffer);
    gn_result result = GN_ERROR_OUT_OF_MEMORY;
    if (frame->covered && frame->buffers && buffer) {
        for (uint32_t i = 0; i < threads; i++)
            frame->buffers[i] = buffer + i * texels;
        gn_parallel_for(d->context, tiles, draw_tile, frame);
        result = GN_OK;
    }
    gn_free(d->context, buffer);
    return result;
}

gn_result gn_cpu_depth(const gn_cpu *cpu, gn_depth_job *job)
{
    const uint32_t resolution = job->projection.resolution;
    const bool one = job->samples == 1;
    drawing d = {.context = cpu->context};
    d.frame = (gn_depth_frame){.job = job,
                               .accel = job->scene->accel,
                               .samples = one ? center_sample : gn_map_samples,
                               .sample_min = one ? 0.5f : 0.125f,
                               .sample_max = one ? 0.5f : 0.875f,
                               .centre = 0.5f * (float)resolution,
                               .depth_scale = 1.0f / (job->projection.far - job->projection.near),
                               .tiles = (resolution + GN_DEPTH_TILE - 1) / GN_DEPTH_TILE};
    job->covered = (gn_rect){0, 0, 0, 0};
    gn_result result = add_draws(&d);
    if (result == GN_OK)
        result = find_runs(&d);
    if (result == GN_OK)
        result = fill_tiles(&d);
    if (result == GN_OK)
        result = draw_tiles(&d);
    if (result == GN_OK)
        for (uint32_t i = 0; i < d.frame.tiles * d.frame.tiles; i++)
            grow_rect(&job->covered, d.frame.covered[i]);
    else
        gn_fail(cpu->context, result, "out of memory drawing a shadow map of %u x %u texels",
                resolution, resolution);
    gn_free(cpu->context, d.draws);
    gn_free(cpu->context, d.chunks);
    gn_free(cpu->context, d.runs);
    gn_free(cpu->context, d.sorted_runs);
    gn_free(cpu->context, d.order);
    gn_free(cpu->context, d.spare);
    gn_free(cpu->context, d.first_in_tile);
    gn_free(cpu->context, d.in_tiles);
    gn_free(cpu->context, d.frame.covered);
    gn_free(cpu->context, d.frame.buffers);
    return result;
}

/* Rays ----------------------------------------------------------------------------------------*/

/* Metres along forward in front of everything that an orthographic map can meet. */
static float start_of_rays(const gn_scene *scene, const gn_map_projection *p)
{
    double low = (double)p->near, size = 0;
    for (int corner = 0; corner < 8; corner++) {
        double w = 0;
        for (int i = 0; i < 3; i++) {
            const double at =
                (double)(corner >> i & 1 ? scene->bounds_max[i] : scene->bounds_min[i]);
            w += (at - (double)p->origin[i]) * (double)p->forward[i];
            size = fmax(size, fabs(at));
        }
        low = fmin(low, w);
    }
    return (float)(low - 1e-5 * (size + fabs(low)));
}

static void trace_rows(uint32_t index, uint32_t thread, void *user)
{
    (void)thread;
    const gn_depth_rays *rays = user;
    const uint32_t resolution = rays->job->projection.resolution, rows = (resolution + 3) / 4;
    for (uint32_t x = 0; x < resolution; x += 4)
        rays->accel->kernels->depth_packet(rays, index / rows, x, index % rows * 4);
}

gn_result gn_cpu_depth_rays(const gn_cpu *cpu, gn_depth_job *job)
{
    const gn_accel *accel = job->scene->accel;
    const gn_map_projection *p = &job->projection;
    const gn_depth_rays rays = {.job = job,
                                .accel = accel,
                                .samples = job->samples == 1 ? center_sample : gn_map_samples,
                                .start = p->perspective ? 0.0f : start_of_rays(job->scene, p),
                                .mask = job->casters == GN_CASTERS_STATIC ? GN_MASK_STATIC
                                        : job->casters == GN_CASTERS_DYNAMIC
                                            ? GN_MASK_DYNAMIC
                                            : GN_MASK_STATIC | GN_MASK_DYNAMIC};
    if (!rtcGetDeviceProperty(cpu->rtc, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) &&
        job->casters != GN_CASTERS_ALL)
        return gn_fail(cpu->context, GN_ERROR_UNSUPPORTED,
                       "this Embree cannot tell moving casters from others: it has no ray masks");
    const size_t texels = (size_t)p->resolution * p->resolution;
    job->covered = (gn_rect){0, 0, 0, 0};
    /* Without instances the root is the flat tree itself, which has no mask. */
    if (!accel->has_instances && job->casters == GN_CASTERS_DYNAMIC)
        for (size_t i = 0; i < texels * job->samples; i++)
            job->depth[i] = 1.0f;
    else
        gn_parallel_for(cpu->context, (p->resolution + 3) / 4 * job->samples, trace_rows,
                        (void *)&rays);
    for (size_t i = 0; i < texels * job->samples; i++) {
        const uint32_t x = (uint32_t)(i % texels % p->resolution);
        const uint32_t y = (uint32_t)(i % texels / p->resolution);
        if (job->depth[i] < 1.0f)
            grow_rect(&job->covered, (gn_rect){x, y, x + 1, y + 1});
    }
    return GN_OK;
}
