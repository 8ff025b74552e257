/* The Assimp reader, private to src/scene/assimp*.c. */
#ifndef GN_SCENE_ASSIMP_H
#define GN_SCENE_ASSIMP_H

#include <assimp/scene.h>

#include "scene/scene.h"

/* A texture that was loaded for a material. */
typedef struct gn_assimp_texture {
    char *path;
    uint32_t index;
    bool transparent; /* some texel's alpha is below 255 */
} gn_assimp_texture;

typedef struct gn_assimp {
    gn_context *context;
    gn_scene *scene;
    const char *file;
    const struct aiScene *source;
    uint32_t *meshes;    /* gn mesh of each aiMesh, GN_NONE where it has no triangles */
    uint32_t *materials; /* gn material of each aiMaterial, GN_NONE until used */
    gn_assimp_texture *textures;
    uint32_t texture_count, texture_capacity;
} gn_assimp;

gn_result gn_assimp_fail(gn_assimp *import, gn_result result, const char *reason);
/* Puts the file's name before the message of a failed gn_scene call. */
gn_result gn_assimp_refail(gn_assimp *import, gn_result result);

/* Adds a material at its first use: Assimp makes up one that nothing uses. */
gn_result gn_assimp_read_material(gn_assimp *import, uint32_t nth);
/* The nodes with lights, cameras and animation. */
gn_result gn_assimp_read_nodes(gn_assimp *import);

#endif
