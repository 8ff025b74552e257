/* SMAA T2X: "SMAA: Enhanced Subpixel Morphological Antialiasing" (Jimenez, Echevarria, Sousa and
 * Gutierrez 2012). Edges between pixels of unlike colours (its section 3.1 with the adaptation to
 * local contrast), how each ends on either side (3.2), the area under the outline that this makes
 * (3.3), a blend by it, and the mean with the frame before where the surface was (3.5), each frame
 * with its own place in the pixel.
 *
 * A GPU reads areas and ends of edges from textures. Here the area is integrated for the pixel at
 * hand, and the ends are walked to. Patterns are the orthogonal ones: no diagonals, no corners, as
 * in the authors' preset for medium quality, with the reach of that for high quality. */
#include <math.h>

#include "post/antialias.h"

enum {
    EDGE_LEFT = 1,
    EDGE_TOP = 2,
    REACH = 32 /* pixels that an edge is followed to either side */
};

/* One axis of edges: between rows, along x, or between columns, along y. "Above" is the side of the
 * smaller coordinate. */
typedef struct axis {
    const gn_antialias *antialias;
    bool vertical;
} axis;

/* Edges ---------------------------------------------------------------------------------------- */

static float difference(const float *a, const float *b)
{
    const float r = fabsf(a[0] - b[0]), g = fabsf(a[1] - b[1]), blue = fabsf(a[2] - b[2]);
    return fmaxf(fmaxf(r, g), blue);
}

/* Of the colours of two pixels of job->out, the nearest there are. */
static float difference_at(const gn_antialias_job *job, int64_t ax, int64_t ay, int64_t bx,
                           int64_t by)
{
    const int64_t width = job->antialias->desc.width, height = job->antialias->desc.height;
    const int64_t at[4] = {ax, ay, bx, by};
    int64_t in[4];
    for (int i = 0; i < 4; i++) {
        const int64_t size = i & 1 ? height : width;
        in[i] = at[i] < 0 ? 0 : at[i] >= size ? size - 1 : at[i];
    }
    return difference(job->out + 3 * (in[1] * width + in[0]),
                      job->out + 3 * (in[3] * width + in[2]));
}

/* Colours as the eye tells them apart: their square root is near enough to sRGB. */
static void encode_row(uint32_t y, uint32_t thread, void *user)
{
    (void)thread;
    const gn_antialias_job *job = user;
    const size_t row = (size_t)job->antialias->desc.width * 3;
    for (size_t i = y * row; i < (y + 1) * row; i++)
        job->out[i] = sqrtf(fminf(fmaxf(job->image[i], 0.0f), 1.0f));
}

static void find_edges_row(uint32_t row, uint32_t thread, void *user)
{
    (void)thread;
    const gn_antialias_job *job = user;
    const gn_antialias *a = job->antialias;
    const float threshold = a->desc.threshold;
    const int64_t y = row;
    for (int64_t x = 0; x < a->desc.width; x++) {
        const float left = difference_at(job, x, y, x - 1, y);
        const float top = difference_at(job, x, y, x, y - 1);
        uint8_t edges = 0;
        if (fmaxf(left, top) > threshold) {
            float most = fmaxf(left, top);
            most = fmaxf(most, difference_at(job, x, y, x + 1, y));
            most = fmaxf(most, difference_at(job, x, y, x, y + 1));
            most = fmaxf(most, difference_at(job, x - 1, y, x - 2, y));
            most = fmaxf(most, difference_at(job, x, y - 1, x, y - 2));
            edges |= left > threshold && 2.0f * left >= most ? EDGE_LEFT : 0;
            edges |= top > threshold && 2.0f * top >= most ? EDGE_TOP : 0;
        }
        a->edges[(size_t)y * a->desc.width + (size_t)x] = edges;
    }
}

/* Areas ---------------------------------------------------------------------------------------- */

/* Shares of a pixel that lie between its edge and the outline, the edge's one end at 0. */
typedef struct areas {
    float above, below;
} areas;

/* Under the line from (x0, y0) to (x1, y1), in the pixel from `left` to `left` + 1. */
static areas under_line(float x0, float y0, float x1, float y1, float left)
{
    const float a = fmaxf(x0, left), b = fminf(x1, left + 1.0f);
    areas out = {0.0f, 0.0f};
    if (!(b > a))
        return out;
    const float slope = (y1 - y0) / (x1 - x0);
    const float ya = y0 + (a - x0) * slope, yb = y0 + (b - x0) * slope;
    if ((ya < 0.0f) == (yb < 0.0f)) {
        const float area = 0.5f * (ya + yb) * (b - a);
        *(area < 0.0f ? &out.below : &out.above) = fabsf(area);
        return out;
    }
    const float crossing = a - ya / slope;
    const float first = 0.5f * fabsf(ya) * (crossing - a),
                second = 0.5f * fabsf(yb) * (b - crossing);
    out.above = ya < 0.0f ? second : first;
    out.below = ya < 0.0f ? first : second;
    return out;
}

/* The authors' remedy for short U shapes, whose two halves would take too little. */
static float soften(float area, float length)
{
    const float blend = fminf(length / 32.0f, 1.0f), most = 0.5f * sqrtf(2.0f * area);
    return most + blend * (area - most);
}

/* Which way the outline leaves an end of the edge. */
typedef enum end { END_OPEN = 0, END_ABOVE = 1, END_BELOW = 2, END_BOTH = 3 } end;

static end opposite(end e)
{
    return e == END_ABOVE ? END_BELOW : END_ABOVE;
}

/* Section 3.3: before and after: pixels of the edge on either side of this one; offset: of the
 * frame's place in the pixel, upwards. */
static areas pattern_areas(end first, end last, uint32_t before, uint32_t after, float offset)
{
    const areas none = {0.0f, 0.0f};
    const bool closed_first = first == END_ABOVE || first == END_BELOW;
    const bool closed_last = last == END_ABOVE || last == END_BELOW;
    if (!closed_first && !closed_last)
        return none;
    /* A crossing to both sides goes on as a Z does. */
    if (first == END_BOTH)
        first = opposite(last);
    if (last == END_BOTH)
        last = opposite(first);
    const float left = (float)before, length = (float)(before + after + 1), middle = 0.5f * length;
    const float start = (first == END_ABOVE ? 0.5f : -0.5f) + offset;
    const float finish = (last == END_ABOVE ? 0.5f : -0.5f) + offset;
    if (last == END_OPEN) /* L */
        return under_line(0.0f, start, middle, 0.0f, left);
    if (first == END_OPEN)
        return under_line(middle, 0.0f, length, finish, left);
    if (first != last) /* Z */
        return under_line(0.0f, start, length, finish, left);
    const areas a = under_line(0.0f, start, middle, 0.0f, left); /* U */
    const areas b = under_line(middle, 0.0f, length, finish, left);
    return (areas){soften(a.above, length) + soften(b.above, length),
                   soften(a.below, length) + soften(b.below, length)};
}

/* Weights -------------------------------------------------------------------------------------- */

static bool has_edge(const axis *v, int64_t along, int64_t across, bool crossing)
{
    const gn_antialias *a = v->antialias;
    const int64_t x = v->vertical ? across : along, y = v->vertical ? along : across;
    if (x < 0 || y < 0 || x >= a->desc.width || y >= a->desc.height)
        return false;
    const uint8_t bit = v->vertical != crossing ? EDGE_LEFT : EDGE_TOP;
    return a->edges[(size_t)y * a->desc.width + (size_t)x] & bit;
}

/* How the outline leaves the edge in front of pixel `along`. */
static end end_at(const axis *v, int64_t along, int64_t across)
{
    return (end)((has_edge(v, along, across - 1, true) ? END_ABOVE : 0) |
                 (has_edge(v, along, across, true) ? END_BELOW : 0));
}

/* The weights of one edge: of the pixel below it, and of the one above. */
static void weigh(const axis *v, int64_t along, int64_t across, float offset, float weights[2])
{
    weights[0] = weights[1] = 0.0f;
    if (!has_edge(v, along, across, false))
        return;
    uint32_t before = 0, after = 0;
    end first = end_at(v, along, across), last = end_at(v, along + 1, across);
    while (before < REACH && first == END_OPEN && has_edge(v, along - before - 1, across, false))
        first = end_at(v, along - ++before, across);
    while (after < REACH && last == END_OPEN && has_edge(v, along + after + 1, across, false))
        last = end_at(v, along + ++after + 1, across);
    const areas a = pattern_areas(first, last, before, after, offset);
    weights[0] = a.below;
    weights[1] = a.above;
}

static void weigh_row(uint32_t y, uint32_t thread, void *user)
{
    (void)thread;
    const gn_antialias_job *job = user;
    const gn_antialias *a = job->antialias;
    const axis rows = {a, false}, columns = {a, true};
    float jitter[2];
    gn_antialias_jitter(a, jitter);
    /* What is seen at a pixel's centre lies in the scene at the frame's place in the pixel. */
    for (uint32_t x = 0; x < a->desc.width; x++) {
        float *weights = a->weights + 4 * ((size_t)y * a->desc.width + x);
        weigh(&rows, x, y, 0.5f - jitter[1], weights);
        weigh(&columns, y, x, 0.5f - jitter[0], weights + 2);
    }
}

/* Blending ------------------------------------------------------------------------------------- */

/* A pixel takes from its neighbours across the stronger of its edges. */
static void blend_row(uint32_t y, uint32_t thread, void *user)
{
    (void)thread;
    const gn_antialias_job *job = user;
    gn_antialias *a = job->antialias;
    const size_t width = a->desc.width, height = a->desc.height;
    for (size_t x = 0; x < width; x++) {
        const size_t pixel = y * width + x;
        const float *w = a->weights + 4 * pixel, *color = job->image + 3 * pixel;
        const float top = w[0], left = w[2];
        const float bottom = y + 1 < height ? w[4 * width + 1] : 0.0f;
        const float right = x + 1 < width ? w[4 + 3] : 0.0f;
        const bool across = fmaxf(left, right) > fmaxf(top, bottom);
        const float shares[2] = {across ? left : top, across ? right : bottom};
        const size_t step = 3 * (across ? 1 : width);
        const float sum = shares[0] + shares[1];
        for (size_t c = 0; c < 3; c++) {
            float value = color[c];
            if (shares[0] > 0.0f)
                value += shares[0] * shares[0] / sum * ((color - step)[c] - color[c]);
            if (shares[1] > 0.0f)
                value += shares[1] * shares[1] / sum * ((color + step)[c] - color[c]);
            a->pictures[a->now][3 * pixel + c] = value;
        }
        gn_front_motion(job->gbuffer, (uint32_t)x, y, a->motions[a->now] + 2 * pixel);
    }
}

static float length(const float v[2])
{
    return sqrtf(v[0] * v[0] + v[1] * v[1]);
}

/* Half of the frame before, less of it where something else was there: what moved otherwise. */
static void resolve_row(uint32_t y, uint32_t thread, void *user)
{
    (void)thread;
    const gn_antialias_job *job = user;
    const gn_antialias *a = job->antialias;
    const uint32_t width = a->desc.width, height = a->desc.height, now = a->now;
    for (uint32_t x = 0; x < width; x++) {
        const size_t pixel = (size_t)y * width + x;
        const float *motion = a->motions[now] + 2 * pixel;
        float before[3] = {0}, share = 0.0f;
        const float bx = (float)x + 0.5f + motion[0], by = (float)y + 0.5f + motion[1];
        if (a->has_before && bx >= 0.0f && bx < (float)width && by >= 0.0f && by < (float)height) {
            const size_t then = (size_t)by * width + (size_t)bx;
            const float change =
                fabsf(length(motion) - length(a->motions[now ^ 1] + 2 * then)) / (float)width;
            share = 0.5f * fmaxf(1.0f - 30.0f * sqrtf(change), 0.0f);
            gn_sample_bilinear(a->pictures[now ^ 1], width, height, bx, by, before);
        }
        for (size_t c = 0; c < 3; c++) {
            const float color = a->pictures[now][3 * pixel + c];
            job->out[3 * pixel + c] = color + share * (before[c] - color);
        }
    }
}

void gn_smaa_apply(const gn_antialias_job *job)
{
    static const gn_parallel_body passes[] = {encode_row, find_edges_row, weigh_row, blend_row,
                                              resolve_row};
    gn_antialias_job copy = *job;
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++)
        gn_parallel_for(job->antialias->context, job->antialias->desc.height, passes[i], &copy);
}
