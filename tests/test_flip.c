/* FLIP: against the paper's formulas written a second time, plainly, in double precision, with
 * filters of two dimensions; properties; and published values where there are files of them. */
#include "picture_testing.h"

#include "measure/picture.h"
#include "scene/scene.h"

#define PI 3.14159265358979323846

/* The paper, once more ------------------------------------------------------------------------ */

typedef struct triple {
    double v[3];
} triple;

static const double to_xyz[3][3] = {
    {0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};

static double white(int i)
{
    return to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2];
}

static triple xyz_of(triple rgb)
{
    triple xyz = {{0}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            xyz.v[i] += to_xyz[i][k] * rgb.v[k];
    return xyz;
}

static double determinant(double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Cramer's rule. */
static triple rgb_of(triple xyz)
{
    triple rgb;
    double m[3][3];
    memcpy(m, to_xyz, sizeof m);
    const double whole = determinant(m);
    for (int k = 0; k < 3; k++) {
        memcpy(m, to_xyz, sizeof m);
        for (int i = 0; i < 3; i++)
            m[i][k] = xyz.v[i];
        rgb.v[k] = determinant(m) / whole;
    }
    return rgb;
}

static triple opponent_of(const float *srgb)
{
    triple rgb;
    for (int i = 0; i < 3; i++) {
        const double s = (double)srgb[i];
        rgb.v[i] = s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
    }
    const triple xyz = xyz_of(rgb);
    const double x = xyz.v[0] / white(0), y = xyz.v[1] / white(1), z = xyz.v[2] / white(2);
    return (triple){{116 * y - 16, 500 * (x - y), 200 * (y - z)}};
}

/* Filtered YCxCz to L*a*b* with the Hunt effect. */
static triple lab_of(triple opponent)
{
    const double y = (opponent.v[0] + 16) / 116, x = y + opponent.v[1] / 500;
    const double z = y - opponent.v[2] / 200;
    triple rgb = rgb_of((triple){{x * white(0), y * white(1), z * white(2)}});
    for (int i = 0; i < 3; i++)
        rgb.v[i] = fmin(fmax(rgb.v[i], 0), 1);
    triple f = xyz_of(rgb);
    for (int i = 0; i < 3; i++) {
        const double t = f.v[i] / white(i), edge = 6.0 / 29;
        f.v[i] = t > edge * edge * edge ? cbrt(t) : t / (3 * edge * edge) + 4.0 / 29;
    }
    const double l = 116 * f.v[1] - 16;
    return (triple){{l, 0.01 * l * 500 * (f.v[0] - f.v[1]), 0.01 * l * 200 * (f.v[1] - f.v[2])}};
}

static double hyab(triple p, triple q)
{
    return fabs(p.v[0] - q.v[0]) + hypot(p.v[1] - q.v[1], p.v[2] - q.v[2]);
}

#define MAX_RADIUS 24

typedef struct kernel {
    int radius;
    double weights[2 * MAX_RADIUS + 1][2 * MAX_RADIUS + 1]; /* [y][x] */
} kernel;

static kernel sensitivity_kernel(int channel, double ppd)
{
    static const double a1[] = {1, 1, 34.1}, b1[] = {0.0047, 0.0053, 0.04};
    static const double a2[] = {0, 0, 13.5}, b2[] = {1e-5, 1e-5, 0.025};
    kernel k = {.radius = (int)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd)};
    double sum = 0;
    for (int y = -k.radius; y <= k.radius; y++)
        for (int x = -k.radius; x <= k.radius; x++) {
            const double r = (x * x + y * y) / (ppd * ppd);
            const double w =
                a1[channel] * sqrt(PI / b1[channel]) * exp(-PI * PI * r / b1[channel]) +
                a2[channel] * sqrt(PI / b2[channel]) * exp(-PI * PI * r / b2[channel]);
            sum += k.weights[y + k.radius][x + k.radius] = w;
        }
    for (int y = 0; y <= 2 * k.radius; y++)
        for (int x = 0; x <= 2 * k.radius; x++)
            k.weights[y][x] /= sum;
    return k;
}

/* Along x; along y it is its transpose. */
static kernel feature_kernel(bool point, double ppd)
{
    const double sigma = 0.5 * 0.082 * ppd;
    kernel k = {.radius = (int)ceil(3 * sigma)};
    double positive = 0, negative = 0;
    for (int y = -k.radius; y <= k.radius; y++)
        for (int x = -k.radius; x <= k.radius; x++) {
            const double gauss = exp(-(x * x + y * y) / (2 * sigma * sigma));
            const double w = gauss * (point ? x * x / (sigma * sigma) - 1 : -x);
            k.weights[y + k.radius][x + k.radius] = w;
            positive += fmax(w, 0);
            negative += fmax(-w, 0);
        }
    for (int y = 0; y <= 2 * k.radius; y++)
        for (int x = 0; x <= 2 * k.radius; x++)
            k.weights[y][x] /= k.weights[y][x] > 0 ? positive : negative;
    return k;
}

static int nearest(int i, int count)
{
    return i < 0 ? 0 : i >= count ? count - 1 : i;
}

static double filtered(const triple *image, int width, int height, int channel, const kernel *k,
                       bool transposed, int x, int y)
{
    double sum = 0;
    for (int j = -k->radius; j <= k->radius; j++)
        for (int i = -k->radius; i <= k->radius; i++) {
            const double w = transposed ? k->weights[i + k->radius][j + k->radius]
                                        : k->weights[j + k->radius][i + k->radius];
            sum += w * image[nearest(y + j, height) * width + nearest(x + i, width)].v[channel];
        }
    return sum;
}

typedef struct paper {
    int width, height;
    triple *images[2]; /* YCxCz */
    kernel sensitivity[3], edge, point;
    double worst;
} paper;

static double feature(const paper *p, int image, const kernel *k, int x, int y)
{
    const triple *pixels = p->images[image];
    return hypot(filtered(pixels, p->width, p->height, 0, k, false, x, y),
                 filtered(pixels, p->width, p->height, 0, k, true, x, y)) /
           116;
}

static double paper_error(const paper *p, int x, int y)
{
    triple lab[2];
    for (int i = 0; i < 2; i++) {
        triple seen;
        for (int c = 0; c < 3; c++)
            seen.v[c] =
                filtered(p->images[i], p->width, p->height, c, &p->sensitivity[c], false, x, y);
        lab[i] = lab_of(seen);
    }
    const double e = pow(hyab(lab[0], lab[1]), 0.7), bend = 0.4 * p->worst;
    const double color = e < bend ? 0.95 * e / bend : 0.95 + 0.05 * (e - bend) / (p->worst - bend);
    const double edge = fabs(feature(p, 0, &p->edge, x, y) - feature(p, 1, &p->edge, x, y));
    const double point = fabs(feature(p, 0, &p->point, x, y) - feature(p, 1, &p->point, x, y));
    return pow(color, 1 - sqrt(fmax(edge, point) / sqrt(2)));
}

static paper make_paper(const float *a, const float *b, int width, int height, double ppd)
{
    paper p = {.width = width,
               .height = height,
               .edge = feature_kernel(false, ppd),
               .point = feature_kernel(true, ppd)};
    const float primaries[2][3] = {{0, 1, 0}, {0, 0, 1}};
    p.worst = pow(hyab(lab_of(opponent_of(primaries[0])), lab_of(opponent_of(primaries[1]))), 0.7);
    for (int c = 0; c < 3; c++)
        p.sensitivity[c] = sensitivity_kernel(c, ppd);
    for (int i = 0; i < 2; i++) {
        p.images[i] = malloc((size_t)(width * height) * sizeof(triple));
        assert_non_null(p.images[i]);
        for (int k = 0; k < width * height; k++)
            p.images[i][k] = opponent_of((i ? b : a) + 3 * k);
    }
    return p;
}

/* Every pixel, and the mean. Single precision shows where features nearly agree, since the exponent
 * has the root of their difference. */
static void check_against_paper(const float *a, const float *b, int width, int height, double ppd)
{
    float *map = malloc((size_t)(width * height) * sizeof *map);
    assert_non_null(map);
    const gn_flip flip = measure(a, b, (uint32_t)width, (uint32_t)height, ppd, map).flip;
    paper p = make_paper(a, b, width, height, ppd);
    double sum = 0, most = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const double expected = paper_error(&p, x, y);
            const double value = (double)map[y * width + x];
            if (!(fabs(value - expected) <= 3e-4))
                fail_msg("%g pixels per degree, pixel %d, %d: %.7f, not %.7f", ppd, x, y, value,
                         expected);
            sum += expected;
            most = fmax(most, expected);
        }
    assert_near(flip.mean, sum / (width * height), 2e-5, "mean");
    assert_near(flip.max, most, 1e-4, "max");
    assert_true(flip.mean > 0.001);
    for (int i = 0; i < 2; i++)
        free(p.images[i]);
    free(map);
}

#define WIDTH  41
#define HEIGHT 26
#define PIXELS ((size_t)WIDTH * HEIGHT)

static float first[3 * PIXELS], second[3 * PIXELS];

static void test_paper(void **state)
{
    (void)state;
    fill_shapes(first, WIDTH, HEIGHT, 0);
    fill_shapes(second, WIDTH, HEIGHT, 1.6f);
    check_against_paper(first, second, WIDTH, HEIGHT, GN_PIXELS_PER_DEGREE);
    check_against_paper(first, second, WIDTH, HEIGHT, 20);
    fill_noise(first, 3 * PIXELS, 1);
    fill_noise(second, 3 * PIXELS, 2);
    check_against_paper(first, second, WIDTH, HEIGHT, 31.5);
    /* Filters wider than the picture, and as narrow as can be. */
    check_against_paper(first, second, 7, 3, 150);
    check_against_paper(first, second, WIDTH, HEIGHT, 1);
    /* More rows than one thread takes at once. */
    check_against_paper(first, second, 6, 150, 25);
}

/* Properties ---------------------------------------------------------------------------------- */

static void test_identical(void **state)
{
    (void)state;
    float map[PIXELS];
    fill_shapes(first, WIDTH, HEIGHT, 0);
    const gn_flip flip = measure(first, first, WIDTH, HEIGHT, 67, map).flip;
    for (size_t i = 0; i < PIXELS; i++)
        assert_near((double)map[i], 0, 0, "error of a picture against itself");
    assert_near(flip.mean + flip.quartile1 + flip.median + flip.quartile3 + flip.max, 0, 0, "sum");
}

static void test_symmetry_and_range(void **state)
{
    (void)state;
    float map[PIXELS], back[PIXELS];
    fill_shapes(first, WIDTH, HEIGHT, 0);
    fill_noise(second, 3 * PIXELS, 3);
    const gn_flip flip = measure(first, second, WIDTH, HEIGHT, 67, map).flip;
    const gn_flip same = measure(second, first, WIDTH, HEIGHT, 67, back).flip;
    assert_memory_equal(map, back, sizeof map);
    assert_memory_equal(&flip, &same, sizeof flip);
    for (size_t i = 0; i < PIXELS; i++)
        assert_true(map[i] > 0 && map[i] <= 1);
    assert_true(0 < flip.quartile1 && flip.quartile1 <= flip.median &&
                flip.median <= flip.quartile3 && flip.quartile3 <= flip.max && flip.max <= 1);
}

/* Green and blue are as far apart as FLIP's colours can be, black and white less far. */
static void test_plain_colors(void **state)
{
    (void)state;
    fill_color(first, PIXELS, 0, 1, 0);
    fill_color(second, PIXELS, 0, 0, 1);
    gn_flip flip = measure(first, second, WIDTH, HEIGHT, 67, NULL).flip;
    assert_near(flip.quartile1, 1, 1e-6, "green and blue");
    assert_near(flip.mean, 1, 1e-6, "green and blue");
    fill_color(first, PIXELS, 0, 0, 0);
    fill_color(second, PIXELS, 1, 1, 1);
    flip = measure(first, second, WIDTH, HEIGHT, 67, NULL).flip;
    const float primaries[2][3] = {{0, 1, 0}, {0, 0, 1}};
    const double worst =
        pow(hyab(lab_of(opponent_of(primaries[0])), lab_of(opponent_of(primaries[1]))), 0.7);
    const double e = pow(100, 0.7), bend = 0.4 * worst; /* L* of white is 100 */
    assert_true(e > bend);
    assert_near(flip.mean, 0.95 + 0.05 * (e - bend) / (worst - bend), 1e-5, "black and white");
}

/* Seen from farther away, noise of one pixel is less visible. */
static void test_distance(void **state)
{
    (void)state;
    fill_noise(first, 3 * PIXELS, 4);
    fill_noise(second, 3 * PIXELS, 5);
    double before = 1;
    for (double ppd = 10; ppd < 200; ppd *= 1.6) {
        const double mean = measure(first, second, WIDTH, HEIGHT, ppd, NULL).flip.mean;
        if (!(mean < before))
            fail_msg("at %g pixels per degree %g, no less than %g", ppd, mean, before);
        before = mean;
    }
}

static void test_threads(void **state)
{
    (void)state;
    enum { TALL = 300 }; /* several bands */
    static float a[3 * 20 * TALL], b[3 * 20 * TALL], map[20 * TALL], again[20 * TALL];
    fill_noise(a, 3 * 20 * TALL, 6);
    fill_shapes(b, 20, TALL, 0);
    const uint32_t threads = context.threads;
    context.threads = 1;
    const gn_picture_difference one = measure(a, b, 20, TALL, 67, map);
    context.threads = 5;
    const gn_picture_difference five = measure(a, b, 20, TALL, 67, again);
    context.threads = threads;
    assert_memory_equal(map, again, sizeof map);
    assert_memory_equal(&one, &five, sizeof one);
}

/* Pooling and colours ------------------------------------------------------------------------- */

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void test_pooling(void **state)
{
    (void)state;
    gn_flip flip;
    const float few[] = {0.5f, 0.125f, 0.25f, 0.0f}; /* sum 0.875; 0.125, 0.375, 0.875 */
    assert_int_equal(gn_flip_pool(&context, few, 4, &flip), GN_OK);
    assert_near(flip.mean, 0.875 / 4, 0, "mean");
    assert_near(flip.quartile1, 0.25, 0, "quartile 1");
    assert_near(flip.median, 0.5, 0, "median");
    assert_near(flip.quartile3, 0.5, 0, "quartile 3");
    assert_near(flip.max, 0.5, 0, "max");

    enum { COUNT = 5000 };
    static float map[COUNT], sorted[COUNT];
    uint32_t seed = 7;
    for (int i = 0; i < COUNT; i++)
        sorted[i] = map[i] = i % 7 ? random_unit(&seed) * random_unit(&seed) : 0.0f;
    qsort(sorted, COUNT, sizeof *sorted, compare_floats);
    assert_int_equal(gn_flip_pool(&context, map, COUNT, &flip), GN_OK);
    const double values[] = {flip.quartile1, flip.median, flip.quartile3};
    for (int q = 0; q < 3; q++) {
        double below = 0, sum = 0;
        for (int i = 0; i < COUNT; i++) {
            sum += (double)sorted[i];
            below += (double)sorted[i] < values[q] ? (double)sorted[i] : 0;
        }
        const double share = 0.25 * (q + 1);
        assert_true(below < share * sum && below + values[q] >= share * sum);
    }
    assert_near(flip.max, (double)sorted[COUNT - 1], 0, "max");
}

static void test_colors(void **state)
{
    (void)state;
    /* Of the 256 colours of magma. */
    static const struct {
        int number;
        uint8_t rgb[3];
    } known[] = {{0, {0, 0, 4}},        {32, {29, 17, 71}},    {63, {79, 18, 123}},
                 {128, {183, 55, 121}}, {191, {251, 135, 97}}, {222, {254, 193, 133}},
                 {255, {252, 253, 191}}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const float value = (float)known[i].number / 255.0f;
        uint8_t rgb[3];
        gn_flip_colors(&value, rgb, 1);
        for (int c = 0; c < 3; c++)
            if (abs(rgb[c] - known[i].rgb[c]) > 1)
                fail_msg("colour %d has %d in channel %d, not %d", known[i].number, rgb[c], c,
                         known[i].rgb[c]);
    }
    /* Brighter all the way, and a colour for whatever comes. */
    int before = -1;
    for (int i = 0; i < 256; i += 5) {
        const float value = (float)i / 255.0f;
        uint8_t rgb[3];
        gn_flip_colors(&value, rgb, 1);
        const int luma = 2126 * rgb[0] + 7152 * rgb[1] + 722 * rgb[2];
        assert_true(luma > before);
        before = luma;
    }
    const float odd[] = {NAN, -1.0f, -INFINITY, 2.0f, INFINITY};
    uint8_t rgb[15];
    gn_flip_colors(odd, rgb, 5);
    for (int i = 0; i < 15; i++)
        assert_int_equal(rgb[i], i < 9 ? known[0].rgb[i % 3] : known[6].rgb[i % 3]);
}

/* Published values ---------------------------------------------------------------------------- */

static float *read_png(const char *folder, const char *name, uint32_t *width, uint32_t *height)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("cannot open %s", path);
    static uint8_t bytes[1 << 22];
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    uint8_t *rgba = NULL;
    if (gn_image_decode(&context, path, bytes, size, width, height, &rgba) != GN_OK)
        fail_msg("%s", context.message);
    const size_t pixels = (size_t)*width * *height;
    float *rgb = malloc(3 * pixels * sizeof *rgb);
    assert_non_null(rgb);
    for (size_t i = 0; i < 3 * pixels; i++)
        rgb[i] = (float)rgba[4 * (i / 3) + i % 3] / 255.0f;
    gn_free(&context, rgba);
    return rgb;
}

/* Pairs in the folder GNOMON_FLIP, with their values in the table of its README.md: reference,
 * test, mean, weighted median, first and third quartile, maximum. */
static void test_published(void **state)
{
    (void)state;
    const char *folder = getenv("GNOMON_FLIP");
    if (!folder) {
        print_message("GNOMON_FLIP is not set: the published values are skipped\n");
        skip();
    }
    char path[512], line[512];
    snprintf(path, sizeof path, "%s/README.md", folder);
    FILE *table = fopen(path, "r");
    if (!table)
        fail_msg("cannot open %s", path);
    unsigned pairs = 0;
    while (fgets(line, sizeof line, table)) {
        char names[2][128];
        gn_flip expected;
        if (sscanf(line, "| %127s | %127s | %lf | %lf | %lf | %lf | %lf", names[0], names[1],
                   &expected.mean, &expected.median, &expected.quartile1, &expected.quartile3,
                   &expected.max) != 7)
            continue;
        uint32_t width[2], height[2];
        float *pictures[2];
        for (int k = 0; k < 2; k++)
            pictures[k] = read_png(folder, names[k], &width[k], &height[k]);
        assert_int_equal(width[0], width[1]);
        assert_int_equal(height[0], height[1]);
        const gn_flip flip = measure(pictures[0], pictures[1], width[0], height[0], 67, NULL).flip;
        print_message("%s, %s: %.6f %.6f %.6f %.6f %.6f\n", names[0], names[1], flip.mean,
                      flip.median, flip.quartile1, flip.quartile3, flip.max);
        assert_near(flip.mean, expected.mean, 5e-4, "mean");
        assert_near(flip.median, expected.median, 2e-3, "median");
        assert_near(flip.quartile1, expected.quartile1, 2e-3, "quartile 1");
        assert_near(flip.quartile3, expected.quartile3, 2e-3, "quartile 3");
        assert_near(flip.max, expected.max, 2e-3, "max");
        free(pictures[0]);
        free(pictures[1]);
        pairs++;
    }
    fclose(table);
    assert_true(pairs > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_paper),        cmocka_unit_test(test_identical),
        cmocka_unit_test(test_plain_colors), cmocka_unit_test(test_symmetry_and_range),
        cmocka_unit_test(test_distance),     cmocka_unit_test(test_threads),
        cmocka_unit_test(test_pooling),      cmocka_unit_test(test_colors),
        cmocka_unit_test(test_published),
    };
    return cmocka_run_group_tests_name("flip", tests, NULL, NULL);
}
