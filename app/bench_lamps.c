/* gnomon bench --lamps: many point lights in place of the scene's. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene/scene.h"
#include "bench.h"

/* Where the scene has a lamp, or else over its middle, at three quarters of its height; and what
 * all lamps together give. */
static void find_place(const gn_scene *scene, const gn_scene_info *info, double place[3],
                       double *intensity)
{
    for (int i = 0; i < 3; i++)
        place[i] =
            (double)info->bounds_min[i] +
            (i == 1 ? 0.75 : 0.5) * ((double)info->bounds_max[i] - (double)info->bounds_min[i]);
    *intensity = 20;
    for (uint32_t l = 0; l < scene->light_count; l++) {
        const gn_light *light = &scene->lights[l];
        if (light->desc.type == GN_LIGHT_DIRECTIONAL)
            continue;
        for (int i = 0; i < 3; i++)
            place[i] = (double)light->position[i];
        *intensity = (double)light->desc.intensity;
        return;
    }
}

bool gn_bench_hang_lamps(gn_app *app, uint32_t count)
{
    double place[3], intensity;
    find_place(app->scene, &app->info, place, &intensity);
    const double width = fmin((double)app->info.bounds_max[0] - (double)app->info.bounds_min[0],
                              (double)app->info.bounds_max[2] - (double)app->info.bounds_min[2]);
    uint32_t *lights = malloc(count * sizeof *lights);
    if (!lights)
        return gn_app_error(app, "out of memory");
    free(app->lights);
    app->lights = lights;
    app->light_count = count;
    for (uint32_t i = 0; i < count; i++) {
        /* A sunflower's seeds: even over a disc, whatever their number. */
        const double radius = 0.24 * width * sqrt((double)i / count), angle = i * 2.39996322972865;
        char name[32];
        snprintf(name, sizeof name, "Lamp%u", i);
        gn_light_desc light = gn_light_desc_default();
        light.name = name;
        light.type = GN_LIGHT_POINT;
        light.intensity = (float)(intensity / count);
        gn_node_desc node = gn_node_desc_default();
        node.translation[0] = (float)(place[0] + radius * cos(angle));
        node.translation[1] = (float)place[1];
        node.translation[2] = (float)(place[2] + radius * sin(angle));
        if (gn_scene_add_light(app->scene, &light, &lights[i]) != GN_OK)
            return false;
        node.light = lights[i];
        if (gn_scene_add_node(app->scene, &node, NULL) != GN_OK)
            return false;
    }
    return gn_scene_commit(app->scene) == GN_OK;
}
