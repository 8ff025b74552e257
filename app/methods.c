/* gnomon methods: the ways of finding visibility. */
#include <stdio.h>
#include <string.h>

#include "method.h"

static cJSON *make_json(const gn_app *app)
{
    cJSON *json = gn_app_json(app);
    cJSON_AddStringToObject(json, "default", gn_method_find("ray")->name);
    cJSON *methods = cJSON_AddArrayToObject(json, "methods");
    for (uint32_t i = 0; gn_methods[i]; i++) {
        const gn_method *method = gn_methods[i];
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddItemToArray(methods, entry);
        cJSON_AddStringToObject(entry, "name", method->name);
        cJSON_AddStringToObject(entry, "description", method->description);
        cJSON_AddStringToObject(entry, "paper", method->paper);
        cJSON_AddItemToObject(entry, "map", gn_app_map_json(&method->map));
        cJSON_AddStringToObject(entry, "trace", gn_app_trace_names[method->trace]);
        cJSON_AddBoolToObject(entry, "mask", method->trace == GN_TRACE_LEAK && method->mask);
        if (method->trace == GN_TRACE_NONE)
            cJSON_AddNullToObject(entry, "alpha");
        else
            cJSON_AddStringToObject(entry, "alpha", gn_app_alpha_names[method->alpha]);
    }
    return json;
}

/* What the light's view stores, which pixels get a ray, and what masked occluders do to it. */
static void print_parts(const gn_method *method)
{
    char map[32] = "-";
    const gn_map_format *format = &method->map;
    if (format->kind != GN_MAP_NONE)
        snprintf(map, sizeof map, "%s", gn_app_map_names[format->kind]);
    const char *rays = method->trace == GN_TRACE_ALL    ? "all"
                       : method->trace == GN_TRACE_NONE ? "-"
                       : method->mask                   ? "leak, mask"
                                                        : "leak";
    const uint32_t bits = format->single_depth ? 32 : format->bits;
    printf("%-16s%-7s%5.0u %-11s%-9s ", method->name, map, bits, rays,
           method->trace == GN_TRACE_NONE ? "-" : gn_app_alpha_names[method->alpha]);
}

/* Papers are long, and few: numbers beside the methods, names below. */
static void print_list(void)
{
    printf("%-16s%-7s%5s %-11s%-9s\n", "", "map", "bits", "rays", "alpha");
    const char *papers[GN_APP_MAX_METHODS];
    uint32_t count = 0;
    for (uint32_t i = 0; gn_methods[i] && count < GN_APP_MAX_METHODS; i++) {
        const gn_method *method = gn_methods[i];
        uint32_t number = 0;
        while (number < count && strcmp(papers[number], method->paper) != 0)
            number++;
        if (number == count && *method->paper)
            papers[count++] = method->paper;
        print_parts(method);
        printf("%s", method->description);
        if (*method->paper)
            printf(" [%u]", number + 1);
        printf("\n");
    }
    printf("%-16s%s, the default\n\n", "ray", gn_method_find("ray")->name);
    for (uint32_t i = 0; i < count; i++)
        printf("[%u] %s\n", i + 1, papers[i]);
}

int gn_app_methods(int argc, char **argv)
{
    static const char *const words[] = {NULL};
    static const char *const notes[] = {
        "Each has a page in docs/methods.md. map, bits: what the light's view stores, and in how",
        "much a texel; rays: pixels that get one, all or where the map may leak, with a mask of",
        "the frame before or without; alpha: what masked occluders do to a ray.",
        "'gnomon render' can also make one of parts: --map, --trace and --alpha.", NULL};
    const gn_usage usage = {"methods",   "the ways of finding visibility, with their papers",
                            "[options]", words,
                            notes,       {"gnomon methods", "gnomon methods --json"}};
    bool json = false;
    const gn_option options[] = {GN_FLAG("json", 0, &json, "the same as JSON"), GN_OPTIONS_END};
    const char *unused;
    const int code = gn_options_parse(&usage, options, argc, argv, &unused);
    if (code != GN_GO_ON)
        return code;
    gn_app app = {.command = "methods"};
    if (json)
        return gn_app_print_json(&app, make_json(&app)) ? GN_EXIT_OK : gn_app_fail(&app);
    print_list();
    return gn_app_flush(&app) ? GN_EXIT_OK : gn_app_fail(&app);
}
