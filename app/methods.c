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
        if (method->trace == GN_TRACE_NONE)
            cJSON_AddNullToObject(entry, "alpha");
        else
            cJSON_AddStringToObject(entry, "alpha", gn_app_alpha_names[method->alpha]);
    }
    return json;
}

/* Papers are long, and few: numbers beside the methods, names below. */
static void print_list(void)
{
    const char *papers[GN_APP_MAX_METHODS];
    uint32_t count = 0;
    for (uint32_t i = 0; gn_methods[i] && count < GN_APP_MAX_METHODS; i++) {
        const gn_method *method = gn_methods[i];
        uint32_t number = 0;
        while (number < count && strcmp(papers[number], method->paper) != 0)
            number++;
        if (number == count && *method->paper)
            papers[count++] = method->paper;
        printf("%-16s%s", method->name, method->description);
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
        "Each has a page in docs/methods.md. 'gnomon render' can also make one of parts: --map,",
        "--trace and --alpha.", NULL};
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
