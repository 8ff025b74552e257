/* Assimp's materials and textures. */
#include "scene/assimp.h"

#include <assimp/material.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/file.h"

/* Textures ---------------------------------------------------------------------------------- */

/* The texture inside the file that path names: "*3", or by its name. */
static const struct aiTexture *find_embedded(const struct aiScene *source, const char *path)
{
    if (path[0] == '*') {
        const unsigned long index = strtoul(path + 1, NULL, 10);
        return index < source->mNumTextures ? source->mTextures[index] : NULL;
    }
    for (uint32_t i = 0; i < source->mNumTextures; i++) {
        if (strcmp(source->mTextures[i]->mFilename.data, path) == 0)
            return source->mTextures[i];
    }
    return NULL;
}

/* name: the file and the texture, for messages. */
static gn_result read_external(gn_assimp *import, const char *name, const char *texture,
                               uint8_t **data, uint64_t *size)
{
    char relative[PATH_MAX], path[PATH_MAX];
    snprintf(relative, sizeof relative, "%s", texture);
    for (char *letter = relative; *letter; letter++) {
        if (*letter == '\\')
            *letter = '/';
    }
    if (!gn_file_beside(import->file, relative, path, sizeof path))
        return gn_fail(import->context, GN_ERROR_IO, "%s: its path is too long", name);
    const char *reason = gn_file_read(import->context, path, data, size);
    if (reason)
        return gn_fail(import->context, GN_ERROR_IO, "%s cannot be read: %s (%.200s)", name, reason,
                       path);
    return GN_OK;
}

/* Encoded images have no height; others are BGRA texels. */
static gn_result decode_embedded(gn_assimp *import, const char *name,
                                 const struct aiTexture *texture, gn_texture_desc *desc,
                                 uint8_t **pixels)
{
    if (texture->mHeight == 0)
        return gn_image_decode(import->context, name, texture->pcData, texture->mWidth,
                               &desc->width, &desc->height, pixels);
    desc->width = texture->mWidth;
    desc->height = texture->mHeight;
    const size_t count = (size_t)texture->mWidth * texture->mHeight;
    *pixels = gn_alloc(import->context, count, 4);
    if (!*pixels)
        return gn_fail(import->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", name);
    for (size_t i = 0; i < count; i++) {
        const struct aiTexel texel = texture->pcData[i];
        memcpy(*pixels + 4 * i, (uint8_t[]){texel.r, texel.g, texel.b, texel.a}, 4);
    }
    return GN_OK;
}

static gn_result decode(gn_assimp *import, const char *path, gn_texture_desc *desc,
                        uint8_t **pixels)
{
    char name[512];
    snprintf(name, sizeof name, "%.250s: texture \"%.200s\"", import->file, path);
    const struct aiTexture *embedded = find_embedded(import->source, path);
    if (embedded)
        return decode_embedded(import, name, embedded, desc, pixels);
    uint8_t *data = NULL;
    uint64_t size = 0;
    GN_TRY(read_external(import, name, path, &data, &size));
    const gn_result result =
        gn_image_decode(import->context, name, data, size, &desc->width, &desc->height, pixels);
    gn_free(import->context, data);
    return result;
}

static bool has_alpha(const uint8_t *pixels, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (pixels[4 * i + 3] < 255)
            return true;
    }
    return false;
}

static gn_result load_texture(gn_assimp *import, const char *path, gn_assimp_texture *texture)
{
    for (uint32_t i = 0; i < import->texture_count; i++) {
        if (strcmp(import->textures[i].path, path) == 0) {
            *texture = import->textures[i];
            return GN_OK;
        }
    }
    if (!gn_grow(import->context, (void **)&import->textures, import->texture_count,
                 &import->texture_capacity, sizeof *import->textures))
        return gn_assimp_fail(import, GN_ERROR_OUT_OF_MEMORY, "out of memory");

    gn_texture_desc desc = gn_texture_desc_default();
    desc.name = path;
    uint8_t *pixels = NULL;
    GN_TRY(decode(import, path, &desc, &pixels));
    desc.rgba = pixels;
    texture->transparent = has_alpha(pixels, (size_t)desc.width * desc.height);
    const gn_result result = gn_scene_add_texture(import->scene, &desc, &texture->index);
    gn_free(import->context, pixels);
    if (result != GN_OK)
        return gn_assimp_refail(import, result);
    texture->path = gn_alloc_string(import->context, path);
    if (!texture->path)
        return gn_assimp_fail(import, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    import->textures[import->texture_count++] = *texture;
    return GN_OK;
}

/* Materials --------------------------------------------------------------------------------- */

static gn_wrap wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? GN_WRAP_CLAMP
           : mode == aiTextureMapMode_Mirror                                ? GN_WRAP_MIRROR
                                                                            : GN_WRAP_REPEAT;
}

static float in_unit_interval(float value)
{
    return value >= 0 ? fminf(value, 1) : 0; /* 0 for NaN */
}

static gn_result read_texture(gn_assimp *import, const struct aiMaterial *source,
                              gn_material_desc *desc)
{
    enum aiTextureType type = aiTextureType_BASE_COLOR;
    if (aiGetMaterialTextureCount(source, type) == 0)
        type = aiTextureType_DIFFUSE;
    if (aiGetMaterialTextureCount(source, type) == 0)
        return GN_OK;
    struct aiString path;
    unsigned int set = 0;
    enum aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap,
                                      aiTextureMapMode_Wrap};
    if (aiGetMaterialTexture(source, type, 0, &path, NULL, &set, NULL, NULL, modes, NULL) !=
        aiReturn_SUCCESS)
        return GN_OK;
    if (set != 0)
        gn_scene_warn(import->scene,
                      "material \"%.100s\": texture coordinates %u are not supported; 0 is taken",
                      desc->name, set);
    gn_assimp_texture texture = {.index = GN_NONE};
    GN_TRY(load_texture(import, path.data, &texture));
    desc->texture = texture.index;
    desc->wrap_u = wrap_of(modes[0]);
    desc->wrap_v = wrap_of(modes[1]);
    if (texture.transparent)
        desc->alpha_mode = GN_ALPHA_MASK;
    struct aiString opacity;
    if (aiGetMaterialTexture(source, aiTextureType_OPACITY, 0, &opacity, NULL, NULL, NULL, NULL,
                             NULL, NULL) == aiReturn_SUCCESS &&
        strcmp(opacity.data, path.data) != 0)
        gn_scene_warn(import->scene,
                      "material \"%.100s\": an opacity texture of its own is not supported; the "
                      "alpha of the colour texture is taken",
                      desc->name);
    return GN_OK;
}

gn_result gn_assimp_read_material(gn_assimp *import, uint32_t nth)
{
    if (nth >= import->source->mNumMaterials || import->materials[nth] != GN_NONE)
        return GN_OK;
    const struct aiMaterial *source = import->source->mMaterials[nth];
    gn_material_desc desc = gn_material_desc_default();
    struct aiString name = {.length = 0};
    struct aiColor4D color = {1, 1, 1, 1};
    ai_real opacity = 1;
    int two_sided = 1; /* most of these formats do not know sides */
    aiGetMaterialString(source, AI_MATKEY_NAME, &name);
    if (aiGetMaterialColor(source, AI_MATKEY_BASE_COLOR, &color) != aiReturn_SUCCESS)
        aiGetMaterialColor(source, AI_MATKEY_COLOR_DIFFUSE, &color);
    aiGetMaterialFloatArray(source, AI_MATKEY_OPACITY, &opacity, NULL);
    aiGetMaterialIntegerArray(source, AI_MATKEY_TWOSIDED, &two_sided, NULL);
    desc.name = name.data;
    desc.base_color[0] = in_unit_interval(color.r);
    desc.base_color[1] = in_unit_interval(color.g);
    desc.base_color[2] = in_unit_interval(color.b);
    desc.base_color[3] = in_unit_interval(opacity);
    desc.double_sided = two_sided != 0;
    GN_TRY(read_texture(import, source, &desc));
    if (desc.base_color[3] < 1)
        desc.alpha_mode = GN_ALPHA_BLEND;
    const gn_result result = gn_scene_add_material(import->scene, &desc, &import->materials[nth]);
    return result == GN_OK ? GN_OK : gn_assimp_refail(import, result);
}
