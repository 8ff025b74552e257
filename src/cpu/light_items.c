/* What runs of triangles cover of a light's view. */
#include <math.h>
#include <string.h>

#include "cpu/light_buffer.h"

void gn_light_matrix(const gn_light_buffer *buffer, uint32_t instance, double rows[3][4])
{
    const gn_light_frame *f = &buffer->frame;
    const uint32_t node = buffer->accel->instances[instance].node;
    const float *m = node == GN_NONE ? NULL : buffer->scene->nodes[node].world;
    for (int i = 0; i < 3; i++) {
        const double *a = f->axes[i];
        for (int c = 0; c < 4; c++) {
            const double origin = c == 3 ? 1.0 : 0.0;
            double sum = 0.0;
            for (int k = 0; k < 3; k++) {
                const double part = m ? (double)m[4 * c + k] : (c == k ? 1.0 : 0.0);
                sum += a[k] * (part - origin * f->origin[k]);
            }
            rows[i][c] = sum;
        }
    }
}

void gn_light_items_free(gn_context *context, gn_light_items *items)
{
    for (int axis = 0; axis < 2; axis++) {
        gn_free(context, items->low[axis]);
        gn_free(context, items->high[axis]);
    }
    gn_free(context, items->instance);
    gn_free(context, items->run);
    *items = (gn_light_items){0};
}

/* Room for `more` items, and for loads of whole packets behind them. */
static bool reserve(gn_context *context, gn_light_items *items, uint32_t more)
{
    const uint64_t needed = (uint64_t)items->count + more;
    if (needed <= items->capacity)
        return true;
    if (needed > UINT32_MAX / 2)
        return false;
    gn_light_items grown = {.count = items->count, .capacity = (uint32_t)(needed + needed / 2)};
    void **const to[6] = {(void **)&grown.low[0],   (void **)&grown.low[1],
                          (void **)&grown.high[0],  (void **)&grown.high[1],
                          (void **)&grown.instance, (void **)&grown.run};
    void *const from[6] = {items->low[0],  items->low[1],   items->high[0],
                           items->high[1], items->instance, items->run};
    for (int i = 0; i < 6; i++) {
        *to[i] = gn_alloc_zero(context, (size_t)grown.capacity + GN_PACKET, 4);
        if (!*to[i]) {
            gn_light_items_free(context, &grown);
            return false;
        }
        if (items->count > 0)
            memcpy(*to[i], from[i], (size_t)items->count * 4);
    }
    gn_light_items_free(context, items);
    *items = grown;
    return true;
}

/* A float at most, or at least, x. */
static float round_down(double x)
{
    const float f = (float)x;
    return (double)f > x ? nextafterf(f, -INFINITY) : f;
}

static float round_up(double x)
{
    return -round_down(-x);
}

typedef struct span {
    double low[2], high[2];
} span;

/* The eight corners of a box on one face; false: none of it is there. */
static bool cover_face(double corners[8][3], uint32_t face, bool central, span *s)
{
    const int axis = (int)face / 2, right = (axis + 1) % 3, up = (axis + 2) % 3;
    const double sign = face % 2 ? -1.0 : 1.0;
    bool ahead = false, behind = false;
    *s = (span){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (int i = 0; i < 8; i++) {
        const double w = central ? sign * corners[i][axis] : 1.0;
        if (w > 0.0) {
            ahead = true;
            const double place[2] = {corners[i][right] / w, corners[i][up] / w};
            for (int k = 0; k < 2; k++) {
                s->low[k] = fmin(s->low[k], place[k]);
                s->high[k] = fmax(s->high[k], place[k]);
            }
        } else {
            behind = true;
        }
    }
    if (ahead && behind)
        *s = (span){{-INFINITY, -INFINITY}, {INFINITY, INFINITY}};
    if (!central)
        return true;
    return ahead && s->low[0] <= 1.0 && s->high[0] >= -1.0 && s->low[1] <= 1.0 &&
           s->high[1] >= -1.0;
}

bool gn_light_items_add(gn_light_buffer *buffer, uint32_t instance, gn_light_items *items)
{
    /* The tree belongs to the scene; its runs are made when they are first asked for. */
    gn_accel *accel = (gn_accel *)buffer->scene->accel;
    const gn_triangle_tree *tree = accel->instances[instance].tree;
    const gn_runs *runs = gn_tree_runs(accel, (gn_triangle_tree *)(uintptr_t)tree);
    const bool central = buffer->frame.central;
    if (!runs)
        return false;
    for (uint32_t face = 0; face < GN_LIGHT_FACES; face++)
        if ((central || face == GN_SUN_FACE) &&
            !reserve(buffer->context, &items[face], runs->count))
            return false;
    double rows[3][4];
    gn_light_matrix(buffer, instance, rows);
    for (uint32_t run = 0; run < runs->count; run++) {
        const gn_box *box = &runs->boxes[run];
        double corners[8][3];
        for (int i = 0; i < 8; i++) {
            const double p[3] = {(double)(i & 1 ? box->max : box->min)[0],
                                 (double)(i & 2 ? box->max : box->min)[1],
                                 (double)(i & 4 ? box->max : box->min)[2]};
            for (int k = 0; k < 3; k++)
                corners[i][k] =
                    rows[k][0] * p[0] + rows[k][1] * p[1] + rows[k][2] * p[2] + rows[k][3];
        }
        for (uint32_t face = 0; face < GN_LIGHT_FACES; face++) {
            span s;
            if (!(central || face == GN_SUN_FACE) || !cover_face(corners, face, central, &s))
                continue;
            gn_light_items *list = &items[face];
            for (int k = 0; k < 2; k++) {
                list->low[k][list->count] = round_down(s.low[k]);
                list->high[k][list->count] = round_up(s.high[k]);
            }
            list->instance[list->count] = instance;
            list->run[list->count++] = run;
        }
    }
    return true;
}
