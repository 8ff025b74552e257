/* glTF materials, textures and images. */
#include "scene/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Images ------------------------------------------------------------------------------------ */

static gn_result image_bytes(gn_gltf *gltf, uint32_t image, gn_gltf_bytes *bytes)
{
    const cJSON *item = gltf->images.items[image];
    const char *uri = NULL;
    uint32_t view = GN_NONE;
    GN_TRY(gn_gltf_string(gltf, item, "uri", &uri));
    GN_TRY(gn_gltf_index(gltf, item, "bufferView", &gltf->views, &view));
    if (uri)
        return gn_gltf_resolve_uri(gltf, uri, bytes);
    if (view != GN_NONE)
        return gn_gltf_view_bytes(gltf, view, bytes);
    return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "it has neither a URI nor a bufferView");
}

/* Decodes an image at its first use. */
static gn_result load_image(gn_gltf *gltf, uint32_t image, uint32_t *texture)
{
    if (gltf->image_textures[image] == GN_NONE) {
        gn_gltf_at(gltf, &gltf->images, image);
        gn_gltf_bytes bytes = {0};
        GN_TRY(image_bytes(gltf, image, &bytes));
        gn_texture_desc desc = gn_texture_desc_default();
        desc.name = gn_gltf_name(gltf->images.items[image]);
        char name[512];
        snprintf(name, sizeof name, "%.250s: %s", gltf->file, gltf->where);
        uint8_t *pixels = NULL;
        gn_result result = gn_image_decode(gltf->context, name, bytes.data, bytes.size, &desc.width,
                                           &desc.height, &pixels);
        gn_free(gltf->context, bytes.owned);
        GN_TRY(result);
        desc.rgba = pixels;
        result = gn_scene_add_texture(gltf->scene, &desc, &gltf->image_textures[image]);
        gn_free(gltf->context, pixels);
        if (result != GN_OK)
            return gn_gltf_refail(gltf, result);
    }
    *texture = gltf->image_textures[image];
    return GN_OK;
}

/* Textures ---------------------------------------------------------------------------------- */

static gn_result read_wrap(gn_gltf *gltf, const cJSON *sampler, const char *key, gn_wrap *wrap)
{
    uint64_t value = 10497;
    GN_TRY(gn_gltf_integer(gltf, sampler, key, &value));
    switch (value) {
    case 10497:
        *wrap = GN_WRAP_REPEAT;
        return GN_OK;
    case 33071:
        *wrap = GN_WRAP_CLAMP;
        return GN_OK;
    case 33648:
        *wrap = GN_WRAP_MIRROR;
        return GN_OK;
    default:
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s %llu is not a wrap mode", key,
                            (unsigned long long)value);
    }
}

static gn_result read_texture(gn_gltf *gltf, uint32_t index, gn_material_desc *desc)
{
    gn_gltf_at(gltf, &gltf->textures, index);
    const cJSON *texture = gltf->textures.items[index];
    uint32_t image = GN_NONE, sampler = GN_NONE;
    GN_TRY(gn_gltf_index(gltf, texture, "sampler", &gltf->samplers, &sampler));
    GN_TRY(gn_gltf_index(gltf, texture, "source", &gltf->images, &image));
    const cJSON *webp = gn_gltf_extension(texture, "EXT_texture_webp");
    if (webp)
        GN_TRY(gn_gltf_index(gltf, webp, "source", &gltf->images, &image));
    if (image == GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED,
                            "it has no PNG, JPEG or WebP image as its source");
    if (sampler != GN_NONE) {
        gn_gltf_at(gltf, &gltf->samplers, sampler);
        const cJSON *item = gltf->samplers.items[sampler];
        GN_TRY(read_wrap(gltf, item, "wrapS", &desc->wrap_u));
        GN_TRY(read_wrap(gltf, item, "wrapT", &desc->wrap_v));
    }
    return load_image(gltf, image, &desc->texture);
}

/* KHR_texture_transform: translation * rotation * scale, the rotation counter-clockwise as seen
 * on the image. */
static gn_result read_uv_transform(gn_gltf *gltf, const cJSON *info, float m[6])
{
    const cJSON *transform = gn_gltf_extension(info, "KHR_texture_transform");
    float offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
    GN_TRY(gn_gltf_floats(gltf, transform, "offset", 2, offset));
    GN_TRY(gn_gltf_floats(gltf, transform, "scale", 2, scale));
    GN_TRY(gn_gltf_float(gltf, transform, "rotation", &rotation));
    const double c = cos((double)rotation), s = sin((double)rotation);
    m[0] = (float)(c * scale[0]);
    m[1] = (float)(s * scale[1]);
    m[2] = offset[0];
    m[3] = (float)(-s * scale[0]);
    m[4] = (float)(c * scale[1]);
    m[5] = offset[1];
    return GN_OK;
}

static const cJSON *base_color_texture(const cJSON *material)
{
    const cJSON *pbr = cJSON_GetObjectItemCaseSensitive(material, "pbrMetallicRoughness");
    return cJSON_GetObjectItemCaseSensitive(pbr, "baseColorTexture");
}

gn_result gn_gltf_material_uv_set(gn_gltf *gltf, uint32_t material, uint32_t *set)
{
    *set = GN_NONE;
    const cJSON *info =
        material == GN_NONE ? NULL : base_color_texture(gltf->materials.items[material]);
    if (!info)
        return GN_OK;
    uint64_t value = 0;
    GN_TRY(gn_gltf_integer(gltf, info, "texCoord", &value));
    GN_TRY(gn_gltf_integer(gltf, gn_gltf_extension(info, "KHR_texture_transform"), "texCoord",
                           &value));
    if (value >= GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "texCoord %llu is not usable",
                            (unsigned long long)value);
    *set = (uint32_t)value;
    return GN_OK;
}

/* Materials --------------------------------------------------------------------------------- */

static gn_result read_base_color(gn_gltf *gltf, const cJSON *material, gn_material_desc *desc)
{
    const cJSON *pbr = NULL, *info = NULL;
    GN_TRY(gn_gltf_object(gltf, material, "pbrMetallicRoughness", &pbr));
    GN_TRY(gn_gltf_floats(gltf, pbr, "baseColorFactor", 4, desc->base_color));
    for (int i = 0; i < 4; i++) {
        if (!(desc->base_color[i] >= 0 && desc->base_color[i] <= 1))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "baseColorFactor %g is outside 0 to 1",
                                (double)desc->base_color[i]);
    }
    GN_TRY(gn_gltf_object(gltf, pbr, "baseColorTexture", &info));
    if (!info)
        return GN_OK;
    uint32_t texture = GN_NONE;
    GN_TRY(read_uv_transform(gltf, info, desc->uv_transform));
    GN_TRY(gn_gltf_index(gltf, info, "index", &gltf->textures, &texture));
    if (texture == GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "baseColorTexture has no index");
    return read_texture(gltf, texture, desc);
}

static gn_result read_alpha(gn_gltf *gltf, const cJSON *material, gn_material_desc *desc)
{
    const char *mode = "OPAQUE";
    GN_TRY(gn_gltf_string(gltf, material, "alphaMode", &mode));
    if (strcmp(mode, "OPAQUE") == 0)
        desc->alpha_mode = GN_ALPHA_OPAQUE;
    else if (strcmp(mode, "MASK") == 0)
        desc->alpha_mode = GN_ALPHA_MASK;
    else if (strcmp(mode, "BLEND") == 0)
        desc->alpha_mode = GN_ALPHA_BLEND;
    else
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "unknown alphaMode \"%.20s\"", mode);
    GN_TRY(gn_gltf_float(gltf, material, "alphaCutoff", &desc->alpha_cutoff));
    if (!(desc->alpha_cutoff >= 0 && desc->alpha_cutoff <= 1))
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "alphaCutoff %g is outside 0 to 1",
                            (double)desc->alpha_cutoff);
    return gn_gltf_bool(gltf, material, "doubleSided", &desc->double_sided);
}

gn_result gn_gltf_read_materials(gn_gltf *gltf)
{
    for (uint32_t i = 0; i < gltf->materials.count; i++) {
        if (gn_report(gltf->context, 0.5 * i / gltf->materials.count, "textures"))
            return gn_gltf_fail(gltf, GN_ERROR_CANCELLED, "cancelled");
        const cJSON *material = gltf->materials.items[i];
        gn_material_desc desc = gn_material_desc_default();
        desc.name = gn_gltf_name(material);
        gn_gltf_at(gltf, &gltf->materials, i);
        GN_TRY(read_alpha(gltf, material, &desc));
        GN_TRY(read_base_color(gltf, material, &desc));
        gn_gltf_at(gltf, &gltf->materials, i);
        const gn_result result = gn_scene_add_material(gltf->scene, &desc, NULL);
        if (result != GN_OK)
            return gn_gltf_refail(gltf, result);
    }
    gltf->where[0] = '\0';
    return GN_OK;
}
