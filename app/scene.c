/* gnomon scene: built-in scenes as files. */
#include <stdio.h>
#include <string.h>

#include "app.h"

static int list(const gn_app_options *common)
{
    gn_app app = {.command = "scene"};
    if (!common->json) {
        for (const gn_procedural *scene = gn_procedurals; scene->name; scene++)
            printf("%-10s%s\n", scene->name, scene->description);
        return gn_app_flush(&app) ? GN_EXIT_OK : gn_app_fail(&app);
    }
    cJSON *json = gn_app_json(&app);
    cJSON *scenes = cJSON_AddArrayToObject(json, "scenes");
    for (const gn_procedural *scene = gn_procedurals; scene->name; scene++) {
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddStringToObject(entry, "name", scene->name);
        cJSON_AddStringToObject(entry, "description", scene->description);
        cJSON_AddItemToArray(scenes, entry);
    }
    return gn_app_print_json(&app, json) ? GN_EXIT_OK : gn_app_fail(&app);
}

static int check_name(const char *name)
{
    const char *names[32] = {NULL};
    uint32_t count = 0;
    for (const gn_procedural *scene = gn_procedurals; scene->name && count < 31; scene++) {
        if (strcmp(scene->name, name) == 0)
            return GN_GO_ON;
        names[count++] = scene->name;
    }
    const char *guess = gn_suggest(name, names);
    if (guess)
        return gn_usage_error("scene", "no built-in scene '%s'; did you mean '%s'?", name, guess);
    return gn_usage_error("scene", "no built-in scene '%s'; see --list", name);
}

int gn_app_scene(int argc, char **argv)
{
    static const char *const names[] = {"[NAME]", NULL};
    const gn_usage usage = {"scene",
                            "write a built-in scene as .glb",
                            "NAME -o OUT.glb [options]\n       gnomon scene --list",
                            names,
                            NULL,
                            {"gnomon scene grove -o grove.glb",
                             "gnomon scene court --seed 7 --scale 0.1 -o small-court.glb"}};
    gn_app_options common = gn_app_options_default();
    const char *output = NULL;
    double unit = 1;
    bool show_list = false;
    const gn_option options[] = {
        GN_TEXT("output", 'o', "OUT.glb", &output, "the file to write"),
        GN_APP_SCENE_OPTIONS(common),
        GN_REAL("unit", 0, "X", &unit, 1e-6, 1e6, "X times every length, default 1"),
        GN_FLAG("list", 0, &show_list, "the names of all built-in scenes"),
        GN_FLAG("quiet", 'q', &common.quiet, "no progress and no notes"),
        GN_FLAG("json", 0, &common.json, "results as JSON on standard output"),
        GN_OPTIONS_END,
    };
    const char *name;
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    if (code != GN_GO_ON)
        return code;
    if (show_list)
        return list(&common);
    if (!name)
        return gn_usage_error("scene", "NAME is missing; see --list");
    if ((code = check_name(name)) != GN_GO_ON)
        return code;
    if (!output)
        return gn_usage_error("scene", "-o OUT.glb is missing");

    gn_app app = {0};
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.seed = common.seed;
    desc.scale = common.scale;
    desc.unit = unit;
    bool good = gn_app_open(&app, "scene", &common);
    if (good) {
        gn_bar_step(&app.bar, 0, 0.5, "making %s", name);
        good = gn_scene_create_procedural(app.device, name, &desc, &app.scene) == GN_OK &&
               !gn_app_interrupted();
    }
    if (good) {
        gn_bar_step(&app.bar, 0.5, 0.5, "writing %s", output);
        good = gn_scene_write_glb(app.scene, output) == GN_OK;
    }
    if (good) {
        const gn_scene_info info = gn_scene_get_info(app.scene);
        if (common.json) {
            app.scene_name = name;
            cJSON *json = gn_app_json(&app);
            cJSON_AddStringToObject(json, "file", output);
            cJSON_AddNumberToObject(json, "seed", common.seed);
            cJSON_AddNumberToObject(json, "scale", common.scale);
            cJSON_AddNumberToObject(json, "unit", unit);
            cJSON_AddNumberToObject(json, "triangles", (double)info.triangles);
            cJSON_AddNumberToObject(json, "instanced_triangles", (double)info.instanced_triangles);
            good = gn_app_print_json(&app, json);
        } else {
            gn_app_note(&app, "%s: %llu triangles, %llu with instancing", output,
                        (unsigned long long)info.triangles,
                        (unsigned long long)info.instanced_triangles);
        }
    }
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_close(&app);
    return code;
}
