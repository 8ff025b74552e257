/* Writing pictures: PNG for people, OpenEXR for machines. */
#ifndef GNOMON_IMAGE_H
#define GNOMON_IMAGE_H

#include <gnomon/device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One layer of an image. Channels are named by one letter each; the file's channel names are
 * "name.C", or "C" for the unnamed layer. */
typedef struct gn_layer {
    const char *name;       /* "light0.visibility"; NULL or "" for the main layer */
    const char *channels;   /* "Y", "XY", "XYZ", "RGB": 1 to 4 letters */
    const float *planes[4]; /* one for each letter */
    uint32_t stride;        /* floats from a pixel to the next: 1 planar, 3 interleaved RGB */
    int full_precision;     /* non-zero: 32 bits a value, else 16 */
} gn_layer;

/* A line of the header: how this picture was made. */
typedef struct gn_attribute {
    const char *key, *value;
} gn_attribute;

/* Both write to a temporary name beside path and rename it, so that path is never half written.
 * Failures name the file and the reason. */

/* 8-bit PNG, channels 1 (grey), 3 (RGB) or 4 (RGBA), rows from top to bottom; sRGB is marked. */
GN_API gn_result gn_write_png(gn_device *device, const char *path, uint32_t width, uint32_t height,
                              uint32_t channels, const uint8_t *pixels,
                              const gn_attribute *attributes, uint32_t attribute_count);

/* Multi-layer scan line OpenEXR, ZIP. */
GN_API gn_result gn_write_exr(gn_device *device, const char *path, uint32_t width, uint32_t height,
                              const gn_layer *layers, uint32_t layer_count,
                              const gn_attribute *attributes, uint32_t attribute_count);

/* Linear [0, inf) to 8-bit sRGB, clamped; count values. NaN gives 0. */
GN_API void gn_encode_srgb(const float *linear, uint8_t *srgb, size_t count);

#ifdef __cplusplus
}
#endif

#endif
