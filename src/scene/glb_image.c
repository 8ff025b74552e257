/* Textures of a scene to the PNG images of a binary glTF file. */
#include <string.h>

#include <spng.h>

#include "scene/glb.h"

static bool is_opaque(const gn_texture *texture)
{
    size_t texels = (size_t)texture->width * texture->height;
    for (size_t i = 0; i < texels; i++)
        if (texture->rgba[0][4 * i + 3] != 255)
            return false;
    return true;
}

/* RGBA, or RGB where every texel is opaque. *png is freed with free(). */
static gn_result encode_png(gn_glb *w, const gn_texture *texture, void **png, size_t *size)
{
    size_t texels = (size_t)texture->width * texture->height;
    bool opaque = is_opaque(texture);
    const uint8_t *pixels = texture->rgba[0];
    uint8_t *rgb = NULL;
    if (opaque) {
        rgb = gn_alloc(w->context, texels, 3);
        for (size_t i = 0; i < texels && rgb; i++)
            memcpy(rgb + 3 * i, pixels + 4 * i, 3);
        pixels = rgb;
    }
    spng_ctx *encoder = pixels ? spng_ctx_new(SPNG_CTX_ENCODER) : NULL;
    int error = SPNG_EMEM;
    if (encoder) {
        struct spng_ihdr header = {.width = texture->width,
                                   .height = texture->height,
                                   .bit_depth = 8,
                                   .color_type = opaque ? SPNG_COLOR_TYPE_TRUECOLOR
                                                        : SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
        error = spng_set_option(encoder, SPNG_ENCODE_TO_BUFFER, 1);
        if (!error)
            error = spng_set_ihdr(encoder, &header);
        if (!error)
            error = spng_encode_image(encoder, pixels, texels * (opaque ? 3 : 4), SPNG_FMT_PNG,
                                      SPNG_ENCODE_FINALIZE);
        if (!error)
            *png = spng_get_png_buffer(encoder, size, &error);
    }
    spng_ctx_free(encoder);
    gn_free(w->context, rgb);
    if (error == SPNG_EMEM)
        w->out_of_memory = true;
    else if (error)
        return gn_fail(w->context, GN_ERROR_IO, "%s: cannot encode texture '%s' as PNG: %s",
                       w->path, texture->name, spng_strerror(error));
    return GN_OK;
}

gn_result gn_glb_add_images(gn_glb *w)
{
    for (uint32_t i = 0; i < w->scene->texture_count && !w->out_of_memory; i++) {
        const gn_texture *texture = &w->scene->textures[i];
        size_t size = 0;
        gn_result result = encode_png(w, texture, &w->pngs[i], &size);
        if (result != GN_OK)
            return result;
        cJSON *image = gn_glb_add(w, GN_GLB_IMAGES, NULL);
        gn_glb_put_name(w, image, texture->name);
        gn_glb_put(w, image, "mimeType", cJSON_CreateString("image/png"));
        gn_glb_piece data = {GN_GLB_PLAIN, w->pngs[i], size, 1};
        gn_glb_put_number(w, image, "bufferView", gn_glb_add_view(w, data, 0));
    }
    return GN_OK;
}
