/* gnomon info: what a scene has. */
#include <math.h>
#include <stdio.h>

#include "scene/scene.h"
#include "app.h"

static const char *const light_types[] = {"directional", "point", "spot"};

static void print_text(const gn_app *app)
{
    const gn_scene *scene = app->scene;
    const gn_scene_info *i = &app->info;
    typedef unsigned long long big;
    printf("%s\n", app->scene_name);
    printf("  nodes              %u, %u with a mesh\n", i->nodes, i->mesh_nodes);
    printf("  meshes             %u\n", i->meshes);
    printf("  triangles          %llu, %llu with instancing\n", (big)i->triangles,
           (big)i->instanced_triangles);
    printf("  masked triangles   %llu, %llu with instancing\n", (big)i->masked_triangles,
           (big)i->instanced_masked_triangles);
    printf("  materials          %u, %u masked\n", i->materials, i->masked_materials);
    printf("  textures           %u\n", i->textures);
    printf("  animation          %.3g s, %u channels\n", i->duration, i->channels);
    printf("  bounds             %g %g %g to %g %g %g m\n", (double)i->bounds_min[0],
           (double)i->bounds_min[1], (double)i->bounds_min[2], (double)i->bounds_max[0],
           (double)i->bounds_max[1], (double)i->bounds_max[2]);
    printf("  cameras            %u\n", i->cameras);
    for (uint32_t c = 0; c < i->cameras; c++) {
        const gn_camera *camera = &scene->cameras[c];
        const bool moves = camera->node != GN_NONE && scene->nodes[camera->node].animated;
        printf("    %-3u %-14s %s %.4g %s at %.4g %.4g %.4g%s\n", c, camera->name,
               camera->desc.orthographic ? "orthographic" : "perspective",
               camera->desc.orthographic ? 2 * (double)camera->desc.ymag
                                         : (double)camera->desc.yfov * 180 / M_PI,
               camera->desc.orthographic ? "m high" : "degrees", (double)camera->world[12],
               (double)camera->world[13], (double)camera->world[14], moves ? ", moving" : "");
    }
    printf("  lights             %u\n", i->lights);
    for (uint32_t l = 0; l < i->lights; l++) {
        const gn_light *light = &scene->lights[l];
        const bool sun = light->desc.type == GN_LIGHT_DIRECTIONAL;
        const float *v = sun ? light->direction : light->position;
        printf("    %-3u %-14s %s, intensity %.4g, %s %.4g %.4g %.4g%s\n", l, light->name,
               light_types[light->desc.type], (double)light->desc.intensity, sun ? "towards" : "at",
               (double)v[0], (double)v[1], (double)v[2], light->desc.on ? "" : ", off");
    }
    printf("  left out           %s\n", i->warning_count ? "" : "nothing");
    for (uint32_t w = 0; w < i->warning_count; w++)
        printf("    %s\n", gn_scene_warning(scene, w));
}

static void add_vector(cJSON *json, const char *key, const float v[3])
{
    cJSON *array = cJSON_AddArrayToObject(json, key);
    for (int i = 0; i < 3; i++)
        cJSON_AddItemToArray(array, cJSON_CreateNumber((double)v[i]));
}

static void add_cameras(const gn_app *app, cJSON *json)
{
    cJSON *cameras = cJSON_AddArrayToObject(json, "camera_list");
    for (uint32_t c = 0; c < app->info.cameras; c++) {
        const gn_camera *camera = &app->scene->cameras[c];
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddStringToObject(entry, "name", camera->name);
        if (camera->desc.orthographic)
            cJSON_AddNumberToObject(entry, "ymag", (double)camera->desc.ymag);
        else
            cJSON_AddNumberToObject(entry, "yfov", (double)camera->desc.yfov);
        add_vector(entry, "position", camera->world + 12);
        cJSON_AddBoolToObject(entry, "moving",
                              camera->node != GN_NONE && app->scene->nodes[camera->node].animated);
        cJSON_AddItemToArray(cameras, entry);
    }
}

static void add_lights(const gn_app *app, cJSON *json)
{
    cJSON *lights = cJSON_AddArrayToObject(json, "light_list");
    for (uint32_t l = 0; l < app->info.lights; l++) {
        const gn_light *light = &app->scene->lights[l];
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddStringToObject(entry, "name", light->name);
        cJSON_AddStringToObject(entry, "type", light_types[light->desc.type]);
        add_vector(entry, "color", light->desc.color);
        cJSON_AddNumberToObject(entry, "intensity", (double)light->desc.intensity);
        if (light->desc.type != GN_LIGHT_POINT)
            add_vector(entry, "direction", light->direction);
        if (light->desc.type != GN_LIGHT_DIRECTIONAL) {
            add_vector(entry, "position", light->position);
            if (isfinite(light->desc.range))
                cJSON_AddNumberToObject(entry, "range", (double)light->desc.range);
            else
                cJSON_AddNullToObject(entry, "range");
        }
        cJSON_AddBoolToObject(entry, "on", light->desc.on);
        cJSON_AddItemToArray(lights, entry);
    }
}

static cJSON *make_json(const gn_app *app)
{
    const gn_scene_info *i = &app->info;
    cJSON *json = gn_app_json(app);
    const struct {
        const char *key;
        double value;
    } counts[] = {
        {"nodes", i->nodes},
        {"mesh_nodes", i->mesh_nodes},
        {"meshes", i->meshes},
        {"triangles", (double)i->triangles},
        {"instanced_triangles", (double)i->instanced_triangles},
        {"masked_triangles", (double)i->masked_triangles},
        {"instanced_masked_triangles", (double)i->instanced_masked_triangles},
        {"materials", i->materials},
        {"masked_materials", i->masked_materials},
        {"textures", i->textures},
        {"cameras", i->cameras},
        {"lights", i->lights},
        {"channels", i->channels},
        {"duration", i->duration},
    };
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++)
        cJSON_AddNumberToObject(json, counts[k].key, counts[k].value);
    add_vector(json, "bounds_min", i->bounds_min);
    add_vector(json, "bounds_max", i->bounds_max);
    add_cameras(app, json);
    add_lights(app, json);
    cJSON *warnings = cJSON_AddArrayToObject(json, "warnings");
    for (uint32_t w = 0; w < i->warning_count; w++)
        cJSON_AddItemToArray(warnings, cJSON_CreateString(gn_scene_warning(app->scene, w)));
    return json;
}

int gn_app_info(int argc, char **argv)
{
    static const char *const names[] = {"SCENE", NULL};
    const gn_usage usage = {"info",
                            "what a scene has, and what of it gnomon leaves out",
                            "SCENE [options]",
                            names,
                            NULL,
                            {"gnomon info scene.glb", "gnomon info grove --scale 10 --json"}};
    gn_app_options common = gn_app_options_default();
    const gn_option options[] = {GN_APP_SCENE_OPTIONS(common), GN_APP_TIME_OPTION(common),
                                 GN_APP_DEVICE_OPTIONS(common), GN_OPTIONS_END};
    const char *name;
    int code = gn_options_parse(&usage, options, argc, argv, &name);
    if (code != GN_GO_ON)
        return code;

    gn_app app = {.keep_warnings = true};
    bool good = gn_app_open(&app, "info", &common) && gn_app_load(&app, name);
    if (good) {
        gn_bar_clear(&app.bar);
        if (common.json)
            good = gn_app_print_json(&app, make_json(&app));
        else
            print_text(&app);
    }
    good = good && gn_app_flush(&app);
    code = good ? GN_EXIT_OK : gn_app_fail(&app);
    gn_app_close(&app);
    return code;
}
