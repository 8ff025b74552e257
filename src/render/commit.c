/* Commit: the scene floor resolves, the device updates its tree. */
#include "render/device.h"

gn_result gn_scene_commit(gn_scene *scene)
{
    gn_result result = gn_scene_resolve(scene);
    if (result != GN_OK)
        return result;
    result = gn_accel_update(scene, &scene->device->cpu);
    if (result == GN_OK)
        scene->committed = scene->edits;
    return result;
}
