/* Temporal antialiasing, as the survey of Yang, Liu and Salvi (2020) has it: a jittered frame (its
 * section 3.1), a history that is fetched where the surface was, through a Catmull-Rom filter
 * (3.2), clipped to the spread of the new frame's 3x3 pixels (4.2), and blended in (3.4). */
#include <math.h>

#include "post/antialias.h"

/* Luma and two differences, in which the spread of colours is narrower than in RGB. */
static void to_ycocg(const float rgb[3], float out[3])
{
    out[0] = 0.25f * rgb[0] + 0.5f * rgb[1] + 0.25f * rgb[2];
    out[1] = 0.5f * rgb[0] - 0.5f * rgb[2];
    out[2] = -0.25f * rgb[0] + 0.5f * rgb[1] - 0.25f * rgb[2];
}

static void from_ycocg(const float in[3], float rgb[3])
{
    rgb[0] = in[0] + in[1] - in[2];
    rgb[1] = in[0] + in[2];
    rgb[2] = in[0] - in[1] - in[2];
}

/* Three pixels one above the other, or nine: how many there are, their colours in YCoCg added up,
 * and the squares of these. */
typedef struct sums {
    float count, colors[3], squares[3];
} sums;

/* Those of column x around row y; none outside. */
static sums sum_column(const gn_antialias_job *job, int64_t x, uint32_t y)
{
    const uint32_t width = job->antialias->desc.width, height = job->antialias->desc.height;
    sums out = {0};
    if (x < 0 || x >= width)
        return out;
    for (uint32_t py = y > 0 ? y - 1 : 0; py <= y + 1 && py < height; py++, out.count += 1.0f) {
        float c[3];
        to_ycocg(job->image + 3 * ((size_t)py * width + (size_t)x), c);
        for (int i = 0; i < 3; i++) {
            out.colors[i] += c[i];
            out.squares[i] += c[i] * c[i];
        }
    }
    return out;
}

/* Mean and standard deviation of three columns. */
static void spread_of(const sums columns[3], float mean[3], float deviation[3])
{
    const float count = columns[0].count + columns[1].count + columns[2].count;
    for (int i = 0; i < 3; i++) {
        const float sum = columns[0].colors[i] + columns[1].colors[i] + columns[2].colors[i];
        const float squares = columns[0].squares[i] + columns[1].squares[i] + columns[2].squares[i];
        mean[i] = sum / count;
        deviation[i] = sqrtf(fmaxf(squares / count - mean[i] * mean[i], 0.0f));
    }
}

/* Weights of the Catmull-Rom spline between the second and third of four texels. */
static void spline(float t, float weights[4])
{
    weights[0] = t * (-0.5f + t * (1.0f - 0.5f * t));
    weights[1] = 1.0f + t * t * (-2.5f + 1.5f * t);
    weights[2] = t * (0.5f + t * (2.0f - 1.5f * t));
    weights[3] = t * t * (-0.5f + 0.5f * t);
}

static uint32_t clamped(int32_t at, uint32_t size)
{
    return at < 0 ? 0 : (uint32_t)at >= size ? size - 1 : (uint32_t)at;
}

/* A sharp picture stays sharp when it is fetched again and again. */
static void sample_spline(const float *picture, uint32_t width, uint32_t height, float x, float y,
                          float rgb[3])
{
    const float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    const int32_t x0 = (int32_t)left - 1, y0 = (int32_t)top - 1;
    float wx[4], wy[4];
    spline(x - 0.5f - left, wx);
    spline(y - 0.5f - top, wy);
    size_t columns[4];
    for (int32_t i = 0; i < 4; i++)
        columns[i] = 3 * (size_t)clamped(x0 + i, width);
    rgb[0] = rgb[1] = rgb[2] = 0.0f;
    for (int32_t j = 0; j < 4; j++) {
        const float *row = picture + 3 * (size_t)clamped(y0 + j, height) * width;
        const float *a = row + columns[0], *b = row + columns[1], *c = row + columns[2],
                    *d = row + columns[3];
        for (int k = 0; k < 3; k++)
            rgb[k] += wy[j] * (wx[0] * a[k] + wx[1] * b[k] + wx[2] * c[k] + wx[3] * d[k]);
    }
}

/* Along the line to the mean, until it is inside. */
static void clip(const float mean[3], const float deviation[3], float deviations, float rgb[3])
{
    float color[3], farthest = 1.0f;
    to_ycocg(rgb, color);
    for (int i = 0; i < 3; i++) {
        const float most = deviations * deviation[i], away = fabsf(color[i] - mean[i]);
        if (away > farthest * most)
            farthest = most > 0.0f ? away / most : INFINITY;
    }
    for (int i = 0; i < 3; i++)
        color[i] = mean[i] + (color[i] - mean[i]) / farthest;
    from_ycocg(color, rgb);
}

/* columns: the three around x. */
static void resolve(const gn_antialias_job *job, const sums columns[3], uint32_t x, uint32_t y)
{
    gn_antialias *a = job->antialias;
    const uint32_t width = a->desc.width, height = a->desc.height, now = a->now;
    const size_t pixel = (size_t)y * width + x;
    const float *color = job->image + 3 * pixel;
    float *out = job->out + 3 * pixel, motion[2], history[3] = {0}, mean[3], deviation[3];
    float share = 1.0f;
    uint32_t count = 0;
    gn_front_motion(job->gbuffer, x, y, motion);
    const float bx = (float)x + 0.5f + motion[0], by = (float)y + 0.5f + motion[1];
    const bool inside = bx >= 0.0f && bx < (float)width && by >= 0.0f && by < (float)height;
    if (a->has_before && inside) {
        count = a->counts[now ^ 1][(size_t)by * width + (size_t)bx];
        share = fmaxf(1.0f / (float)(count + 1), a->desc.blend);
        sample_spline(a->pictures[now ^ 1], width, height, bx, by, history);
        spread_of(columns, mean, deviation);
        clip(mean, deviation, a->desc.deviations, history);
    }
    for (int c = 0; c < 3; c++) {
        out[c] =
            share < 1.0f ? fmaxf(history[c] + share * (color[c] - history[c]), 0.0f) : color[c];
        a->pictures[now][3 * pixel + (size_t)c] = out[c];
    }
    a->counts[now][pixel] = (uint8_t)(count < UINT8_MAX ? count + 1 : count);
}

static void resolve_row(uint32_t y, uint32_t thread, void *user)
{
    (void)thread;
    const gn_antialias_job *job = user;
    sums columns[3] = {{0}, sum_column(job, -1, y), sum_column(job, 0, y)};
    for (uint32_t x = 0; x < job->antialias->desc.width; x++) {
        columns[0] = columns[1];
        columns[1] = columns[2];
        columns[2] = sum_column(job, (int64_t)x + 1, y);
        resolve(job, columns, x, y);
    }
}

void gn_taa_apply(const gn_antialias_job *job)
{
    gn_antialias_job copy = *job;
    gn_parallel_for(job->antialias->context, job->antialias->desc.height, resolve_row, &copy);
}
