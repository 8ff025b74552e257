/* gnomon histogram: the offset of the fourth moment, as numbers and a plot. */
#include "histogram.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <gnomon/shadow/moments_nonlinear.h>

#include "method.h"

typedef struct histogram_options {
    gn_app_options common;
    const char *output;
    gn_reals sigmas;
} histogram_options;

static uint32_t bin_of(double share)
{
    const double bin = share * GN_HISTOGRAM_BINS;
    return bin > 0 ? (bin < GN_HISTOGRAM_BINS ? (uint32_t)bin : GN_HISTOGRAM_BINS - 1) : 0;
}

void gn_histogram_add(gn_histogram *h, const float *xi4, size_t count)
{
    const double low = log(GN_XI4_LEAST), span = log(GN_XI4_MOST) - low;
    for (size_t i = 0; i < count; i++) {
        const double value = fmax((double)xi4[i], GN_XI4_LEAST);
        h->warped[bin_of((double)gn_xi4_warp(xi4[i]))]++;
        h->logarithmic[bin_of((log(value) - low) / span)]++;
        h->below += value < GN_XI4_RARE;
        h->above += value > GN_XI4_BIAS;
    }
    h->texels += count;
}

/* As wide for its sigma as the paper's filter, 9 texels for 2.4. */
static uint32_t filter_width(double sigma)
{
    return 2 * (uint32_t)ceil(sigma * 5 / 3 - 1e-9) + 1;
}

static gn_map_desc describe_map(const gn_app *app, const gn_histogram *h)
{
    gn_map_desc desc = gn_app_map_desc(&app->options.map);
    desc.filter_width = h->width;
    if (h->sigma > 0)
        desc.filter_sigma = (float)h->sigma;
    return desc;
}

/* The format that keeps xi4 best. */
static const gn_map_format format = {.kind = GN_MAP_NLMSM, .bits = 64};

/* Adds all layers of a light's map. */
static bool add_light(gn_app *app, gn_histogram *h, uint32_t light)
{
    const gn_map_desc desc = describe_map(app, h);
    const float aspect = (float)app->options.size[0] / (float)app->options.size[1];
    const size_t texels = (size_t)desc.resolution * desc.resolution;
    gn_shadow_map *map = NULL;
    float *xi4 = malloc(texels * sizeof *xi4);
    bool good = xi4 || gn_app_error(app, "out of memory");
    good = good && gn_shadow_map_create(app->device, &format, &desc, &map) == GN_OK &&
           gn_shadow_map_update(map, app->scene, light, app->camera, aspect, NULL) == GN_OK;
    for (uint32_t l = 0; good && l < gn_shadow_map_layer_count(map); l++) {
        good = gn_shadow_map_xi4(map, l, xi4) == GN_OK && !gn_app_interrupted();
        if (good)
            gn_histogram_add(h, xi4, texels);
    }
    gn_shadow_map_destroy(&map);
    free(xi4);
    return good;
}

static double share(uint64_t part, const gn_histogram *h)
{
    return h->texels > 0 ? (double)part / (double)h->texels : 0;
}

static void print_table(const gn_histogram *histograms, uint32_t count)
{
    printf("%8s%8s%14s%16s%16s\n", "sigma", "width", "texels", "below 1e-6, %", "above 6e-5, %");
    for (uint32_t i = 0; i < count; i++) {
        const gn_histogram *h = &histograms[i];
        printf("%8.2f%8u%14llu%16.2f%16.2f\n", h->sigma, h->width, (unsigned long long)h->texels,
               share(h->below, h) * 100, share(h->above, h) * 100);
    }
}

static void add_counts(cJSON *json, const char *key, const uint64_t counts[GN_HISTOGRAM_BINS])
{
    cJSON *array = cJSON_AddArrayToObject(json, key);
    for (uint32_t i = 0; i < GN_HISTOGRAM_BINS; i++)
        cJSON_AddItemToArray(array, cJSON_CreateNumber((double)counts[i]));
}

static bool print_json(gn_app *app, const char *output, const gn_histogram *histograms,
                       uint32_t count)
{
    cJSON *json = gn_app_json(app);
    if (output)
        cJSON_AddStringToObject(json, "file", output);
    cJSON_AddNumberToObject(json, "map_size", app->map.resolution);
    cJSON_AddNumberToObject(json, "log10_min", log10(GN_XI4_LEAST));
    cJSON_AddNumberToObject(json, "log10_max", log10(GN_XI4_MOST));
    cJSON *list = cJSON_AddArrayToObject(json, "histograms");
    for (uint32_t i = 0; i < count; i++) {
        const gn_histogram *h = &histograms[i];
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddItemToArray(list, entry);
        cJSON_AddNumberToObject(entry, "sigma", h->sigma);
        cJSON_AddNumberToObject(entry, "filter_width", h->width);
        cJSON_AddNumberToObject(entry, "texels", (double)h->texels);
        cJSON_AddNumberToObject(entry, "below_1e_6", share(h->below, h));
        cJSON_AddNumberToObject(entry, "above_6e_5", share(h->above, h));
        add_counts(entry, "warped", h->warped);
        add_counts(entry, "log10", h->logarithmic);
    }
    return gn_app_print_json(app, json);
}

static bool run(gn_app *app, const histogram_options *o, const char *scene)
{
    gn_histogram histograms[GN_MAX_REALS] = {0};
    if (!gn_app_open(app, "histogram", &o->common))
        return false;
    app->map = gn_app_map_desc(&o->common.map);
    for (uint32_t i = 0; i < o->sigmas.count; i++) {
        gn_histogram *h = &histograms[i];
        h->sigma = o->sigmas.values[i];
        h->width = filter_width(h->sigma);
        const gn_map_desc desc = describe_map(app, h);
        app->wrong_usage = !gn_app_accepts_map(app, &format, &desc);
        if (app->wrong_usage)
            return false;
    }
    if (!gn_app_load(app, scene) || !gn_app_choose(app))
        return false;
    for (uint32_t i = 0; i < o->sigmas.count; i++) {
        const double part = 0.9 / o->sigmas.count;
        gn_bar_step(&app->bar, 0.1 + part * i, part, "maps, sigma %g", histograms[i].sigma);
        for (uint32_t l = 0; l < app->light_count; l++)
            if (!add_light(app, &histograms[i], app->lights[l]))
                return false;
    }
    gn_bar_clear(&app->bar);
    if (o->output && !gn_histogram_write_svg(app, o->output, histograms, o->sigmas.count))
        return false;
    if (o->common.json)
        return print_json(app, o->output, histograms, o->sigmas.count);
    print_table(histograms, o->sigmas.count);
    return gn_app_flush(app);
}

static int parse(int argc, char **argv, histogram_options *o, const char **scene)
{
    static const char *const words[] = {"SCENE", NULL};
    static const char *const notes[] = {
        "xi4 tells how far a texel's moments are from those of two depths alone: 0 where two are",
        "enough. It is taken from non-linear moment maps of the chosen lights, all cascades or",
        "faces together, after a Gaussian filter of each sigma (0: none) as wide as five thirds of",
        "sigma to either side. The plot has the warped values, as stored, and the logarithm.",
        NULL};
    const gn_usage usage = {
        "histogram",
        "how the offset of the fourth moment spreads over a map",
        "SCENE [-o OUT.svg] [options]",
        words,
        notes,
        {"gnomon histogram railing -o xi4.svg",
         "gnomon histogram grove --sigmas 0,2.4 --map-size 1024 --cascades 1 --json"}};
    const gn_option options[] = {
        GN_TEXT("output", 'o', "OUT.svg", &o->output, "the plot to write"),
        GN_REALS("sigmas", 0, "A,B,...", &o->sigmas, 1, GN_MAX_REALS,
                 "filters in texels, 0 to 9, default 0,1.2,2.4,4.8"),
        GN_APP_SHOT_OPTIONS(o->common),
        GN_APP_TIME_OPTION(o->common),
        GN_APP_PLACE_OPTIONS(o->common),
        GN_APP_DEVICE_OPTIONS(o->common),
        GN_OPTIONS_END,
    };
    return gn_options_parse(&usage, options, argc, argv, scene);
}

int gn_app_histogram(int argc, char **argv)
{
    histogram_options o = {.common = gn_app_options_default(), .sigmas = {4, {0, 1.2, 2.4, 4.8}}};
    const char *scene;
    int code = parse(argc, argv, &o, &scene);
    if (code != GN_GO_ON)
        return code;
    const size_t length = o.output ? strlen(o.output) : 0;
    if (o.output && (length < 5 || strcmp(o.output + length - 4, ".svg") != 0))
        return gn_usage_error("histogram", "--output: '%s' does not end in .svg", o.output);
    for (uint32_t i = 0; i < o.sigmas.count; i++)
        if (!(o.sigmas.values[i] >= 0 && o.sigmas.values[i] <= 9))
            return gn_usage_error("histogram", "--sigmas: %g: the range is 0 to 9",
                                  o.sigmas.values[i]);
    gn_app app = {0};
    code = run(&app, &o, scene) ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_close(&app);
    return code;
}
