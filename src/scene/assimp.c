/* Everything but glTF, through Assimp: OBJ, FBX, PLY, STL, DAE... */
#include "scene/assimp.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

gn_result gn_assimp_fail(gn_assimp *import, gn_result result, const char *reason)
{
    return gn_fail(import->context, result, "%s: %s", import->file, reason);
}

gn_result gn_assimp_refail(gn_assimp *import, gn_result result)
{
    char text[sizeof import->context->message];
    pthread_mutex_lock(&import->context->mutex);
    memcpy(text, import->context->message, sizeof text);
    pthread_mutex_unlock(&import->context->mutex);
    return gn_assimp_fail(import, result, text);
}

/* Meshes ------------------------------------------------------------------------------------ */

static void copy_uvs(const struct aiMesh *mesh, float *uvs)
{
    for (uint32_t i = 0; i < mesh->mNumVertices; i++) {
        uvs[2 * (size_t)i] = mesh->mTextureCoords[0][i].x;
        uvs[2 * (size_t)i + 1] = mesh->mTextureCoords[0][i].y;
    }
}

static gn_result add_part(gn_assimp *import, const struct aiMesh *mesh, float *uvs,
                          uint32_t *indices, uint32_t *index)
{
    gn_mesh_part part = {.vertex_count = mesh->mNumVertices,
                         .positions = &mesh->mVertices[0].x,
                         .normals = mesh->mNormals ? &mesh->mNormals[0].x : NULL,
                         .indices = indices,
                         .material = GN_NONE};
    if (mesh->mTextureCoords[0]) {
        copy_uvs(mesh, uvs);
        part.uvs = uvs;
    }
    for (uint32_t f = 0; f < mesh->mNumFaces; f++) {
        if (mesh->mFaces[f].mNumIndices != 3)
            continue;
        for (uint32_t i = 0; i < 3; i++)
            indices[part.index_count++] = mesh->mFaces[f].mIndices[i];
    }
    if (part.index_count == 0)
        return GN_OK;
    GN_TRY(gn_assimp_read_material(import, mesh->mMaterialIndex));
    if (mesh->mMaterialIndex < import->source->mNumMaterials)
        part.material = import->materials[mesh->mMaterialIndex];
    const gn_result result = gn_scene_add_mesh(import->scene, mesh->mName.data, &part, 1, index);
    return result == GN_OK ? GN_OK : gn_assimp_refail(import, result);
}

static gn_result read_mesh(gn_assimp *import, uint32_t nth)
{
    const struct aiMesh *mesh = import->source->mMeshes[nth];
    if (!mesh->mVertices || mesh->mNumVertices < 3 || mesh->mNumFaces == 0)
        return GN_OK;
    const gn_label label = gn_make_label("mesh", nth, mesh->mName.data);
    if (mesh->mNumBones > 0)
        gn_scene_warn(import->scene,
                      "%.100s: skins are not supported; the mesh is shown in its bind pose",
                      label.text);
    if (mesh->mNumAnimMeshes > 0)
        gn_scene_warn(import->scene,
                      "%.100s: morph targets are not supported; the base shape is shown",
                      label.text);
    if (mesh->mColors[0])
        gn_scene_warn(import->scene, "%.100s: vertex colours are not supported; left out",
                      label.text);
    if (mesh->mNumFaces > UINT32_MAX / 3)
        return gn_assimp_fail(import, GN_ERROR_UNSUPPORTED, "a mesh has too many faces");
    float *uvs = gn_alloc(import->context, (size_t)mesh->mNumVertices * 2, sizeof *uvs);
    uint32_t *indices = gn_alloc(import->context, (size_t)mesh->mNumFaces * 3, sizeof *indices);
    const gn_result result = uvs && indices
                                 ? add_part(import, mesh, uvs, indices, &import->meshes[nth])
                                 : gn_assimp_fail(import, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    gn_free(import->context, uvs);
    gn_free(import->context, indices);
    return result;
}

/* The file ---------------------------------------------------------------------------------- */

static const struct aiScene *open_file(const char *path)
{
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (!properties)
        return NULL;
    aiSetImportPropertyInteger(properties, AI_CONFIG_PP_SBP_REMOVE,
                               aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 0);
    /* No PreTransformVertices: it would write every instance out. FlipUVs: (0,0) is the upper left
     * corner here, the lower left one there. GlobalScale: FBX files in centimetres to metres. */
    const struct aiScene *source = aiImportFileExWithProperties(
        path,
        aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
            aiProcess_FlipUVs | aiProcess_GlobalScale | aiProcess_ValidateDataStructure,
        NULL, properties);
    aiReleasePropertyStore(properties);
    return source;
}

static gn_result fill(gn_assimp *import)
{
    const struct aiScene *source = import->source;
    if (!source->mRootNode)
        return gn_assimp_fail(import, GN_ERROR_FORMAT, "it has no nodes");
    import->meshes = gn_alloc(import->context, source->mNumMeshes, sizeof *import->meshes);
    import->materials = gn_alloc(import->context, source->mNumMaterials, sizeof *import->materials);
    if (!import->meshes || !import->materials)
        return gn_assimp_fail(import, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    memset(import->materials, 0xff, source->mNumMaterials * sizeof *import->materials);
    memset(import->meshes, 0xff, source->mNumMeshes * sizeof *import->meshes);
    for (uint32_t i = 0; i < source->mNumMeshes; i++)
        GN_TRY(read_mesh(import, i));
    return gn_assimp_read_nodes(import);
}

gn_result gn_import_assimp(gn_scene *scene, const char *path)
{
    gn_assimp import = {.context = scene->context, .scene = scene, .file = path};
    /* Assimp's own message for a file that cannot be opened does not say why. */
    FILE *file = fopen(path, "rb");
    if (!file)
        return gn_fail(scene->context, GN_ERROR_IO, "%s: it cannot be read: %s", path,
                       strerror(errno));
    fclose(file);
    import.source = open_file(path);
    if (!import.source)
        return gn_assimp_fail(&import, GN_ERROR_FORMAT, aiGetErrorString());
    const gn_result result = fill(&import);
    for (uint32_t i = 0; i < import.texture_count; i++)
        gn_free(import.context, import.textures[i].path);
    gn_free(import.context, import.textures);
    gn_free(import.context, import.meshes);
    gn_free(import.context, import.materials);
    aiReleaseImport(import.source);
    return result;
}
