/* Files to scenes: which reader, and what every scene must have. */
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text), end_length = strlen(end);
    return length >= end_length && strcasecmp(text + length - end_length, end) == 0;
}

/* A .glb may have any name. */
static bool begins_as_glb(const char *path)
{
    char magic[4] = {0};
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    const size_t size = fread(magic, 1, sizeof magic, file);
    fclose(file);
    return size == sizeof magic && memcmp(magic, "glTF", sizeof magic) == 0;
}

static gn_result fill(gn_scene *scene, const char *path)
{
    gn_result result = ends_with(path, ".gltf") || ends_with(path, ".glb") || begins_as_glb(path)
                           ? gn_import_gltf(scene, path)
                           : gn_import_assimp(scene, path);
    if (result != GN_OK)
        return result;
    if (gn_scene_get_info(scene).instanced_triangles == 0)
        return gn_fail(scene->context, GN_ERROR_FORMAT, "%s: the scene has no triangles", path);
    return gn_scene_commit(scene);
}

gn_result gn_scene_load(gn_device *device, const char *path, gn_scene **scene)
{
    gn_result result = gn_scene_create(device, scene);
    if (result != GN_OK)
        return result;
    result = fill(*scene, path);
    if (result != GN_OK)
        gn_scene_destroy(scene);
    return result;
}
