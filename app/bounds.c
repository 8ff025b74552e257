/* gnomon bounds: the shadow that four moments promise at least, over depth (moment paper, Figure
 * 3). */
#include <stdio.h>

#include <gnomon/shadow/moments_nonlinear.h>

#include "app.h"

enum { STEPS = 200 }; /* of z from -1 to 1 */

typedef struct bound_options {
    gn_app_options common;
    gn_reals depths, xi4;
    double weight;
} bound_options;

static double shadow(const bound_options *o, uint32_t curve, int step)
{
    const gn_nonlinear n = {(float)o->depths.values[0], (float)o->depths.values[1],
                            (float)o->weight, (float)o->xi4.values[curve]};
    return 1 - (double)gn_nonlinear_visibility(n, (float)step / STEPS);
}

static double depth(int step)
{
    return 2.0 * step / STEPS - 1;
}

static cJSON *make_json(const gn_app *app, const bound_options *o)
{
    cJSON *json = gn_app_json(app);
    cJSON_AddItemToObject(json, "depths", cJSON_CreateDoubleArray(o->depths.values, 2));
    cJSON_AddNumberToObject(json, "weight", o->weight);
    cJSON *z = cJSON_AddArrayToObject(json, "z");
    for (int i = 0; i <= STEPS; i++)
        cJSON_AddItemToArray(z, cJSON_CreateNumber(depth(i)));
    cJSON *curves = cJSON_AddArrayToObject(json, "bounds");
    for (uint32_t c = 0; c < o->xi4.count; c++) {
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(curves, item);
        cJSON_AddNumberToObject(item, "xi4", o->xi4.values[c]);
        cJSON *values = cJSON_AddArrayToObject(item, "shadow");
        for (int i = 0; i <= STEPS; i++)
            cJSON_AddItemToArray(values, cJSON_CreateNumber(shadow(o, c, i)));
    }
    return json;
}

static void print_table(const bound_options *o)
{
    printf("%8s", "z");
    for (uint32_t c = 0; c < o->xi4.count; c++)
        printf("%12.3g", o->xi4.values[c]);
    for (int i = 0; i <= STEPS; i += STEPS / 20) {
        printf("\n%8.2f", depth(i));
        for (uint32_t c = 0; c < o->xi4.count; c++)
            printf("%12.5f", shadow(o, c, i));
    }
    printf("\n");
}

static int check(const bound_options *o)
{
    const double *y = o->depths.values;
    if (!(y[0] >= -1 && y[0] < y[1] && y[1] <= 1))
        return gn_usage_error("bounds", "--depths: Y1 < Y2, both of -1 to 1");
    for (uint32_t i = 0; i < o->xi4.count; i++)
        if (!(o->xi4.values[i] >= 0 && o->xi4.values[i] <= 0.25))
            return gn_usage_error("bounds", "--xi4: %g: the range is 0 to 0.25", o->xi4.values[i]);
    return GN_GO_ON;
}

int gn_app_bounds(int argc, char **argv)
{
    static const char *const words[] = {NULL};
    static const char *const notes[] = {
        "A non-linear moment map keeps two depths, the share of the second, and xi4, what the",
        "fourth moment lacks. The table has the least shadow of all distributions with these",
        "moments, by Algorithm 3 of the moment paper, at depths z from -1 to 1.", NULL};
    const gn_usage usage = {
        "bounds",    "the shadow that four moments promise, over depth",
        "[options]", words,
        notes,       {"gnomon bounds", "gnomon bounds --depths -0.5,0.5 --weight 0.3 --json"}};
    bound_options o = {.common = gn_app_options_default(),
                       .depths = {2, {-0.8, 0.4}},
                       .xi4 = {5, {0, 1e-4, 1e-3, 1e-2, 1e-1}},
                       .weight = 0.6};
    const gn_option options[] = {
        GN_REALS("depths", 0, "Y1,Y2", &o.depths, 2, 2, "the two depths, default -0.8,0.4"),
        GN_REAL("weight", 0, "V2", &o.weight, 0, 1, "share of the second, default 0.6"),
        GN_REALS("xi4", 0, "A,B,...", &o.xi4, 1, GN_MAX_REALS,
                 "offsets of the fourth moment, default 0,1e-4,1e-3,1e-2,1e-1"),
        GN_APP_DEVICE_OPTIONS(o.common),
        GN_OPTIONS_END,
    };
    const char *unused;
    int code = gn_options_parse(&usage, options, argc, argv, &unused);
    if (code != GN_GO_ON || (code = check(&o)) != GN_GO_ON)
        return code;
    gn_app app = {.command = "bounds", .options = o.common};
    bool good = true;
    if (o.common.json) {
        good = gn_app_print_json(&app, make_json(&app, &o));
    } else {
        print_table(&o);
        good = gn_app_flush(&app);
    }
    return good ? GN_EXIT_OK : gn_app_fail(&app);
}
