/* FLIP for pictures of low dynamic range (Andersson et al. 2020). Section and equation numbers are
 * the paper's; docs/metrics.md has the formulas.
 *
 * All its filters are products of a row and a column, or sums of two such products, so that each is
 * two passes. Rows are filtered in bands, for both pictures, before their columns. */
#include <math.h>
#include <string.h>

#include "measure/picture.h"

#define BAND 64u /* rows that a thread does at once */
#define PI   3.14159265f

/* One-dimensional filters, and what rows are made of: a channel through a filter. */
enum { SENSE_Y, SENSE_CX, SENSE_CZ, SENSE_CZ_WIDE, SMOOTH, EDGE, POINT, FILTERS };
static const uint32_t channel_of[FILTERS] = {0, 1, 2, 2, 0, 0, 0};

typedef struct flip_matrix {
    float rows[3][3];
} flip_matrix;

typedef struct flip_job {
    const gn_picture *pictures[2];
    flip_matrix to_xyz, to_rgb; /* linear RGB and XYZ, white at (1, 1, 1) */
    uint32_t radius;            /* of all filters */
    uint32_t stride;            /* floats of a row with the edges that the filters need */
    float *filters[FILTERS];    /* 2 radius + 1 weights each */
    float worst;                /* color_distance of green and blue */
    float *scratch;             /* for each thread */
    size_t scratch_size;
    float *map;
} flip_job;

/* A pixel as the colour difference sees it: L*, and a* and b* with the Hunt effect. */
typedef struct flip_color {
    float l, a, b;
} flip_color;

/* Colours ------------------------------------------------------------------------------------- */

static void multiply(const flip_matrix *m, const float from[3], float to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = m->rows[i][0] * from[0] + m->rows[i][1] * from[1] + m->rows[i][2] * from[2];
}

/* sRGB primaries (IEC 61966-2-1), with each row divided by its sum, XYZ of white. */
static void set_matrices(flip_job *job)
{
    static const double rgb_to_xyz[3][3] = {
        {0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
    double m[3][3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            m[i][k] = rgb_to_xyz[i][k] / (rgb_to_xyz[i][0] + rgb_to_xyz[i][1] + rgb_to_xyz[i][2]);
            job->to_xyz.rows[i][k] = (float)m[i][k];
        }
    double cofactors[3][3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            cofactors[i][k] = m[(i + 1) % 3][(k + 1) % 3] * m[(i + 2) % 3][(k + 2) % 3] -
                              m[(i + 1) % 3][(k + 2) % 3] * m[(i + 2) % 3][(k + 1) % 3];
    const double determinant =
        m[0][0] * cofactors[0][0] + m[0][1] * cofactors[0][1] + m[0][2] * cofactors[0][2];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            job->to_rgb.rows[i][k] = (float)(cofactors[k][i] / determinant);
}

static float lab_curve(float t)
{
    const float edge = 6.0f / 29.0f;
    return gn_select(t > edge * edge * edge, gn_power(t, 1.0f / 3.0f),
                     t * (1.0f / (3.0f * edge * edge)) + 4.0f / 29.0f);
}

/* Linear RGB in [0, 1] to L*a*b*, with the Hunt effect: dark colours look less colourful. */
static flip_color make_color(const flip_job *job, const float rgb[3])
{
    float xyz[3];
    multiply(&job->to_xyz, rgb, xyz);
    const float x = lab_curve(xyz[0]), y = lab_curve(xyz[1]), z = lab_curve(xyz[2]);
    const float l = 116.0f * y - 16.0f;
    return (flip_color){l, 0.01f * l * 500.0f * (x - y), 0.01f * l * 200.0f * (y - z)};
}

/* HyAB, to the power of q_c = 0.7. */
static float color_distance(flip_color p, flip_color q)
{
    const float a = p.a - q.a, b = p.b - q.b;
    return gn_power(gn_abs(p.l - q.l) + gn_sqrt(a * a + b * b), 0.7f);
}

/* To [0, 1]: up to p_c = 0.4 of the worst distance fills p_t = 0.95 of it. */
static float spread_distance(float distance, float worst)
{
    const float bend = 0.4f * worst;
    return gn_select(distance < bend, distance * (0.95f / bend),
                     0.95f + 0.05f * (distance - bend) / (worst - bend));
}

/* Filters ------------------------------------------------------------------------------------- */

/* The Gaussian of contrast sensitivity, exp(-pi^2 x^2 / b) with x in degrees; sum 1. */
static float set_sensitivity(float *filter, uint32_t radius, float ppd, float b)
{
    float sum = 0;
    for (uint32_t k = 0; k <= 2 * radius; k++) {
        const float x = ((float)k - (float)radius) / ppd;
        filter[k] = gn_exp2(-1.44269504f * PI * PI * x * x / b);
        sum += filter[k];
    }
    for (uint32_t k = 0; k <= 2 * radius; k++)
        filter[k] /= sum;
    return sum;
}

static void scale_filter(float *filter, uint32_t radius, float factor)
{
    for (uint32_t k = 0; k <= 2 * radius; k++)
        filter[k] *= factor;
}

/* Yellow to blue is a sum of two Gaussians in the plane; their shares go half into rows, half into
 * columns. */
static void set_wide_sensitivity(flip_job *job, float ppd)
{
    const float b[2] = {0.04f, 0.025f}, a[2] = {34.1f, 13.5f};
    float shares[2];
    for (int i = 0; i < 2; i++) {
        const float sum = set_sensitivity(job->filters[SENSE_CZ + i], job->radius, ppd, b[i]);
        shares[i] = a[i] * gn_sqrt(PI / b[i]) * sum * sum;
    }
    for (int i = 0; i < 2; i++)
        scale_filter(job->filters[SENSE_CZ + i], job->radius,
                     gn_sqrt(shares[i] / (shares[0] + shares[1])));
}

/* Positive weights have the sum 1, negative ones -1. */
static void balance(float *filter, uint32_t radius)
{
    float positive = 0, negative = 0;
    for (uint32_t k = 0; k <= 2 * radius; k++) {
        positive += gn_max(filter[k], 0.0f);
        negative -= gn_min(filter[k], 0.0f);
    }
    for (uint32_t k = 0; k <= 2 * radius; k++)
        filter[k] /= filter[k] > 0.0f ? positive : negative;
}

/* Derivatives of a Gaussian, as wide as the features that one sees: the first finds edges, the
 * second points and lines. */
static void set_features(flip_job *job, float ppd)
{
    const float sigma = 0.5f * 0.082f * ppd;
    const float reach = ceilf(3.0f * sigma);
    float sum = 0;
    for (uint32_t k = 0; k <= 2 * job->radius; k++) {
        const float x = (float)k - (float)job->radius;
        const float gauss =
            gn_abs(x) <= reach ? gn_exp2(-1.44269504f * x * x / (2.0f * sigma * sigma)) : 0.0f;
        job->filters[SMOOTH][k] = gauss;
        job->filters[EDGE][k] = -x * gauss;
        job->filters[POINT][k] = (x * x / (sigma * sigma) - 1.0f) * gauss;
        sum += gauss;
    }
    scale_filter(job->filters[SMOOTH], job->radius, 1.0f / sum);
    balance(job->filters[EDGE], job->radius);
    balance(job->filters[POINT], job->radius);
}

/* to = filter over count values from `from` on; the taps are `step` floats apart. */
static void apply(const float *filter, uint32_t radius, const float *from, size_t step, float *to,
                  size_t count)
{
    memset(to, 0, count * sizeof *to);
    for (uint32_t k = 0; k <= 2 * radius; k++) {
        const float weight = filter[k];
        const float *tap = from + k * step;
#pragma omp simd
        for (size_t x = 0; x < count; x++)
            to[x] += weight * tap[x];
    }
}

/* A picture in bands -------------------------------------------------------------------------- */

/* Row y (any, the nearest is taken) in YCxCz, a plane each, its ends repeated by the radius. */
static void load_row(const flip_job *job, const gn_picture *picture, int64_t y, float *rgb,
                     float *planes)
{
    const int64_t last = picture->height - 1;
    gn_picture_linear(picture, (uint32_t)(y < 0 ? 0 : y > last ? last : y), rgb);
    const size_t radius = job->radius, width = picture->width;
    for (size_t x = 0; x < width; x++) {
        float xyz[3];
        multiply(&job->to_xyz, rgb + 3 * x, xyz);
        float *to = planes + radius + x;
        to[0] = 116.0f * xyz[1] - 16.0f;
        to[job->stride] = 500.0f * (xyz[0] - xyz[1]);
        to[2 * (size_t)job->stride] = 200.0f * (xyz[1] - xyz[2]);
    }
    for (int c = 0; c < 3; c++) {
        float *plane = planes + (size_t)c * job->stride;
        for (size_t x = 0; x < radius; x++) {
            plane[x] = plane[radius];
            plane[radius + width + x] = plane[radius + width - 1];
        }
    }
}

/* What one picture has in a row of the map. */
typedef struct flip_row {
    float *opponent[3];              /* filtered as the eye does */
    float *edge[2], *point[2], *add; /* along x, along y; add: room */
} flip_row;

/* Columns of the filtered rows from `lines` on. */
static void filter_columns(const flip_job *job, const float *lines, flip_row *row)
{
    const size_t width = job->pictures[0]->width, step = FILTERS * width;
    const struct {
        uint32_t line, filter;
        float *to;
    } passes[] = {
        {SENSE_Y, SENSE_Y, row->opponent[0]},   {SENSE_CX, SENSE_CX, row->opponent[1]},
        {SENSE_CZ, SENSE_CZ, row->opponent[2]}, {SENSE_CZ_WIDE, SENSE_CZ_WIDE, row->add},
        {EDGE, SMOOTH, row->edge[0]},           {SMOOTH, EDGE, row->edge[1]},
        {POINT, SMOOTH, row->point[0]},         {SMOOTH, POINT, row->point[1]},
    };
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++)
        apply(job->filters[passes[i].filter], job->radius, lines + passes[i].line * width, step,
              passes[i].to, width);
    for (size_t x = 0; x < width; x++)
        row->opponent[2][x] += row->add[x];
}

/* The filtered colour at x, back by way of RGB, which keeps it a colour of the display. */
static flip_color seen_color(const flip_job *job, const flip_row *row, size_t x)
{
    const float y = (row->opponent[0][x] + 16.0f) * (1.0f / 116.0f);
    const float xyz[3] = {y + row->opponent[1][x] * (1.0f / 500.0f), y,
                          y - row->opponent[2][x] * (1.0f / 200.0f)};
    float rgb[3];
    multiply(&job->to_rgb, xyz, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] = gn_clamp(rgb[i], 0.0f, 1.0f);
    return make_color(job, rgb);
}

static float magnitude(float *const along[2], size_t x)
{
    return gn_sqrt(along[0][x] * along[0][x] + along[1][x] * along[1][x]);
}

/* A color difference counts the more, the more edges or points differ. Luminance of the features is
 * (Y + 16) / 116; their filters do not see the 16. */
static float pixel_error(const flip_job *job, const flip_row rows[2], size_t x)
{
    const float color = spread_distance(
        color_distance(seen_color(job, &rows[0], x), seen_color(job, &rows[1], x)), job->worst);
    const float edge = gn_abs(magnitude(rows[0].edge, x) - magnitude(rows[1].edge, x));
    const float point = gn_abs(magnitude(rows[0].point, x) - magnitude(rows[1].point, x));
    const float feature = gn_sqrt(gn_max(edge, point) * (0.707106781f / 116.0f)); /* q_f = 0.5 */
    return gn_clamp(gn_power(color, 1.0f - gn_min(feature, 1.0f)), 0.0f, 1.0f);
}

static void measure_band(uint32_t band, uint32_t thread, void *user)
{
    const flip_job *job = user;
    const size_t width = job->pictures[0]->width, line = FILTERS * width;
    const uint32_t height = job->pictures[0]->height, first = band * BAND;
    const uint32_t rows = height - first < BAND ? height - first : BAND;
    const uint32_t lines = rows + 2 * job->radius;

    float *room = job->scratch + thread * job->scratch_size;
    float *filtered[2] = {room, room + (BAND + 2 * (size_t)job->radius) * line};
    float *rgb = filtered[1] + (BAND + 2 * (size_t)job->radius) * line;
    float *planes = rgb + 3 * width, *columns = planes + 3 * (size_t)job->stride;
    flip_row row[2];
    for (int k = 0; k < 2; k++) {
        for (uint32_t i = 0; i < lines; i++) {
            load_row(job, job->pictures[k], (int64_t)first + i - job->radius, rgb, planes);
            for (uint32_t f = 0; f < FILTERS; f++)
                apply(job->filters[f], job->radius, planes + channel_of[f] * (size_t)job->stride, 1,
                      filtered[k] + i * line + f * width, width);
        }
        float **parts[8] = {&row[k].opponent[0], &row[k].opponent[1], &row[k].opponent[2],
                            &row[k].edge[0],     &row[k].edge[1],     &row[k].point[0],
                            &row[k].point[1],    &row[k].add};
        for (int i = 0; i < 8; i++, columns += width)
            *parts[i] = columns;
    }
    for (uint32_t i = 0; i < rows; i++) {
        for (int k = 0; k < 2; k++)
            filter_columns(job, filtered[k] + i * line, &row[k]);
        float *errors = job->map + (size_t)(first + i) * width;
        for (size_t x = 0; x < width; x++)
            errors[x] = pixel_error(job, row, x);
    }
}

/* The map ------------------------------------------------------------------------------------- */

static void set_up(flip_job *job, float ppd)
{
    set_matrices(job);
    job->worst = color_distance(make_color(job, (const float[]){0, 1, 0}),
                                make_color(job, (const float[]){0, 0, 1}));
    set_sensitivity(job->filters[SENSE_Y], job->radius, ppd, 0.0047f);
    set_sensitivity(job->filters[SENSE_CX], job->radius, ppd, 0.0053f);
    set_wide_sensitivity(job, ppd);
    set_features(job, ppd);
}

gn_result gn_flip_map(gn_context *context, const gn_picture *reference, const gn_picture *test,
                      double pixels_per_degree, float *map)
{
    const size_t width = reference->width;
    flip_job job = {.pictures = {reference, test}, .map = map};
    /* Three standard deviations of the widest Gaussian; features are narrower. */
    job.radius = (uint32_t)ceil(3 * sqrt(0.04 / 2) / 3.14159265358979 * pixels_per_degree);
    job.stride = (uint32_t)width + 2 * job.radius;
    /* Filtered rows and columns of both pictures, a row of RGB and of YCxCz. */
    job.scratch_size = 2 * (BAND + 2 * (size_t)job.radius) * FILTERS * width + 2 * 8 * width +
                       3 * width + 3 * (size_t)job.stride;
    job.scratch = gn_alloc(context, context->threads * job.scratch_size, sizeof *job.scratch);
    const size_t taps = 2 * (size_t)job.radius + 1;
    float *filters = gn_alloc(context, FILTERS * taps, sizeof *filters);
    const bool good = job.scratch && filters;
    if (good) {
        for (size_t f = 0; f < FILTERS; f++)
            job.filters[f] = filters + f * taps;
        set_up(&job, (float)pixels_per_degree);
        gn_parallel_for(context, (reference->height + BAND - 1) / BAND, measure_band, &job);
    }
    gn_free(context, filters);
    gn_free(context, job.scratch);
    return good ? GN_OK : gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "no memory for FLIP");
}
