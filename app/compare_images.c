/* gnomon compare --images: two picture files. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <gnomon/measure.h>

#include "output/output.h"
#include "scene/scene.h"
#include "app.h"

typedef struct picture_file {
    const char *path;
    uint32_t width, height;
    float *rgb;
    bool linear;
} picture_file;

typedef struct image_comparison {
    gn_app app;
    picture_file files[2]; /* reference, test */
    double pixels_per_degree;
    const char *output; /* NULL: no map */
    gn_picture_difference difference;
    float *map;
} image_comparison;

/* Files --------------------------------------------------------------------------------------- */

/* All bytes, to be freed by the caller; NULL after an error. */
static uint8_t *read_bytes(gn_app *app, const char *path, size_t *size)
{
    FILE *stream = fopen(path, "rb");
    if (!stream) {
        gn_app_error(app, "%s: %s", path, strerror(errno));
        return NULL;
    }
    uint8_t *bytes = NULL;
    size_t room = 0, got = 1;
    *size = 0;
    while (got > 0) {
        if (*size == room) {
            room = room ? 2 * room : 1 << 16;
            uint8_t *more = realloc(bytes, room);
            if (!more) {
                gn_app_error(app, "%s: out of memory", path);
                break;
            }
            bytes = more;
        }
        got = fread(bytes + *size, 1, room - *size, stream);
        *size += got;
    }
    const bool good = got == 0 && !ferror(stream);
    if (!good && got == 0)
        gn_app_error(app, "%s: %s", path, strerror(errno));
    fclose(stream);
    if (good)
        return bytes;
    free(bytes);
    return NULL;
}

static bool decode(gn_app *app, const uint8_t *bytes, size_t size, picture_file *file)
{
    gn_context *context = gn_device_context(app->device);
    file->linear = gn_exr_is(bytes, size);
    if (file->linear)
        return gn_exr_decode(context, file->path, bytes, size, &file->width, &file->height,
                             &file->rgb) == GN_OK;
    uint8_t *rgba;
    if (gn_image_decode(context, file->path, bytes, size, &file->width, &file->height, &rgba) !=
        GN_OK)
        return false;
    const size_t pixels = (size_t)file->width * file->height;
    file->rgb = gn_alloc(context, pixels, 3 * sizeof *file->rgb);
    for (size_t i = 0; i < pixels && file->rgb; i++)
        for (size_t c = 0; c < 3; c++)
            file->rgb[3 * i + c] = (float)rgba[4 * i + c] * (1.0f / 255.0f);
    gn_free(context, rgba);
    return file->rgb || gn_app_error(app, "%s: out of memory", file->path);
}

static bool read_picture(gn_app *app, picture_file *file)
{
    size_t size;
    uint8_t *bytes = read_bytes(app, file->path, &size);
    const bool good = bytes && decode(app, bytes, size, file);
    free(bytes);
    return good;
}

/* FLIP's error map, with where it comes from in its header. */
static bool write_map(image_comparison *c)
{
    gn_device *device = c->app.device;
    gn_context *context = gn_device_context(device);
    const uint32_t width = c->files[0].width, height = c->files[0].height;
    const size_t pixels = (size_t)width * height;
    uint8_t *rgb = gn_alloc(context, pixels, 3);
    if (!rgb)
        return gn_app_error(&c->app, "out of memory");
    char mean[32], degree[32];
    snprintf(mean, sizeof mean, "%.6f", c->difference.flip.mean);
    snprintf(degree, sizeof degree, "%g", c->pixels_per_degree);
    const gn_attribute attributes[] = {{"reference", c->files[0].path},
                                       {"test", c->files[1].path},
                                       {"flip_mean", mean},
                                       {"pixels_per_degree", degree}};
    gn_flip_colors(c->map, rgb, pixels);
    const gn_result result = gn_write_png(device, c->output, width, height, 3, rgb, attributes,
                                          sizeof attributes / sizeof *attributes);
    gn_free(context, rgb);
    return result == GN_OK;
}

/* Results ------------------------------------------------------------------------------------- */

static void print_table(const image_comparison *c)
{
    const gn_picture_difference *d = &c->difference;
    const gn_flip *flip = &d->flip;
    printf("%s and %s, %u x %u pixels, %g pixels per degree\n\n", c->files[0].path,
           c->files[1].path, c->files[0].width, c->files[0].height, c->pixels_per_degree);
    printf("%-10s%10s%12s%12s%12s%12s\n", "", "mean", "quartile 1", "median", "quartile 3", "max");
    printf("%-10s%10.6f%12.6f%12.6f%12.6f%12.6f\n", "FLIP", flip->mean, flip->quartile1,
           flip->median, flip->quartile3, flip->max);
    printf("%-10s%10.6f\n", "mean abs", d->mean_abs);
    printf("%-10s%10.4f dB\n", "PSNR", d->psnr);
    printf("%-10s%10.6f\n", "SSIM", d->ssim);
}

static void add_number(cJSON *json, const char *name, double value)
{
    cJSON_AddItemToObject(json, name,
                          isfinite(value) ? cJSON_CreateNumber(value) : cJSON_CreateNull());
}

static bool print_json(image_comparison *c)
{
    const gn_picture_difference *d = &c->difference;
    cJSON *json = gn_app_json(&c->app);
    cJSON_AddStringToObject(json, "reference", c->files[0].path);
    cJSON_AddStringToObject(json, "test", c->files[1].path);
    cJSON_AddNumberToObject(json, "width", c->files[0].width);
    cJSON_AddNumberToObject(json, "height", c->files[0].height);
    cJSON_AddNumberToObject(json, "pixels_per_degree", c->pixels_per_degree);
    add_number(json, "flip_mean", d->flip.mean);
    add_number(json, "flip_quartile1", d->flip.quartile1);
    add_number(json, "flip_median", d->flip.median);
    add_number(json, "flip_quartile3", d->flip.quartile3);
    add_number(json, "flip_max", d->flip.max);
    add_number(json, "mean_abs", d->mean_abs);
    add_number(json, "psnr", d->psnr);
    add_number(json, "ssim", d->ssim);
    cJSON *files = cJSON_AddArrayToObject(json, "files");
    if (c->output)
        cJSON_AddItemToArray(files, cJSON_CreateString(c->output));
    return gn_app_print_json(&c->app, json);
}

static bool measure(image_comparison *c)
{
    gn_app *app = &c->app;
    const picture_file *a = &c->files[0], *b = &c->files[1];
    if (a->width != b->width || a->height != b->height)
        return gn_app_error(app, "%s has %u x %u pixels, %s has %u x %u; they must be the same",
                            a->path, a->width, a->height, b->path, b->width, b->height);
    gn_bar_step(&app->bar, 0.3, 0.6, "comparing");
    c->map = gn_alloc(gn_device_context(app->device), (size_t)a->width * a->height, sizeof *c->map);
    if (!c->map)
        return gn_app_error(app, "out of memory");
    const gn_picture pictures[] = {{a->width, a->height, a->rgb, a->linear},
                                   {b->width, b->height, b->rgb, b->linear}};
    return gn_measure_pictures(app->device, &pictures[0], &pictures[1], c->pixels_per_degree,
                               &c->difference, c->map) == GN_OK &&
           !gn_app_interrupted();
}

static bool run(image_comparison *c, const gn_app_options *options)
{
    gn_app *app = &c->app;
    bool good = gn_app_open(app, "compare", options);
    for (int k = 0; k < 2 && good; k++) {
        gn_bar_step(&app->bar, 0.15 * k, 0.15, "reading %s", c->files[k].path);
        good = read_picture(app, &c->files[k]);
    }
    good = good && measure(c) && (!c->output || write_map(c));
    gn_bar_clear(&app->bar);
    if (good && options->json)
        good = print_json(c);
    else if (good)
        print_table(c);
    return good && gn_app_flush(app);
}

int gn_app_compare_images(int argc, char **argv)
{
    static const char *const words[] = {"REFERENCE", "TEST", NULL};
    static const char *const notes[] = {
        "Pictures are PNG, OpenEXR, JPEG or WebP, of the same size. FLIP, PSNR, SSIM and the mean",
        "absolute difference are of pictures as a display shows them: sRGB, linear values of",
        "OpenEXR clamped to 0 to 1. Alpha is not looked at. docs/metrics.md defines all of them.",
        "In the map of FLIP black is no difference and light yellow the greatest.", NULL};
    const gn_usage usage = {"compare",
                            "two picture files: FLIP, PSNR, SSIM, mean absolute difference",
                            "--images REFERENCE TEST [-o MAP.png] [options]",
                            words,
                            notes,
                            {"gnomon compare --images reference.exr test.exr -o flip.png",
                             "gnomon compare --images reference.png test.png --json"}};
    gn_app_options common = gn_app_options_default();
    image_comparison c = {.pixels_per_degree = GN_PIXELS_PER_DEGREE};
    bool chosen = false;
    const char *paths[2];
    const gn_option options[] = {
        GN_FLAG("images", 0, &chosen, "compare two pictures"),
        GN_TEXT("output", 'o', "MAP.png", &c.output, "write the map of FLIP's errors"),
        GN_REAL("ppd", 0, "X", &c.pixels_per_degree, 1, 1000,
                "pixels per degree of the viewer's sight, default 67"),
        GN_APP_DEVICE_OPTIONS(common),
        GN_OPTIONS_END,
    };
    int code = gn_options_parse(&usage, options, argc, argv, paths);
    if (code != GN_GO_ON)
        return code;
    for (int k = 0; k < 2; k++)
        c.files[k].path = paths[k];
    code = run(&c, &common) ? GN_EXIT_OK : gn_app_fail(&c.app);
    if (c.app.device) {
        gn_context *context = gn_device_context(c.app.device);
        for (int k = 0; k < 2; k++)
            gn_free(context, c.files[k].rgb);
        gn_free(context, c.map);
    }
    gn_app_close(&c.app);
    return code;
}
