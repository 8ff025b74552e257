/* Antialiasing of shaded pictures, after the fact: what shadows without ray cones are usually left
 * to, and are compared with (ray cone paper, sections 2.4 and 4).
 *
 * Each frame's rays go to other places in their pixels (gn_antialias_jitter()), and the picture
 * that comes of it is put together with those of the frames before. */
#ifndef GNOMON_ANTIALIAS_H
#define GNOMON_ANTIALIAS_H

#include <gnomon/view.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum gn_antialias_kind {
    GN_ANTIALIAS_TAA = 0,     /* an average over time of 8 places in the pixel, clipped to what the
                                 new frame has around (Yang, Liu and Salvi 2020) */
    GN_ANTIALIAS_SMAA_T2X = 1 /* edges of the picture blended by the area that their outlines cover,
                                 and of two frames the mean (Jimenez et al. 2012) */
} gn_antialias_kind;

/* Made by gn_antialias_desc_default(). */
typedef struct gn_antialias_desc {
    uint32_t cookie;
    gn_antialias_kind kind; /* default GN_ANTIALIAS_TAA */
    uint32_t width, height; /* pixels, [1, 16384], default 1920 x 1080 */
    float blend;            /* TAA: least share of the new frame, (0, 1], default 0.1 */
    float deviations;       /* TAA: what came before may be so many standard deviations of the 3x3
                               pixels from their mean, (0, 100], default 1 */
    float threshold; /* SMAA: least difference of an edge, of colours in [0, 1] by their square
                        root, [0, 1], default 0.1 */
} gn_antialias_desc;

/* Thread-safety: one thread at a time. */
typedef struct gn_antialias gn_antialias;

GN_API gn_antialias_desc gn_antialias_desc_default(void);
GN_API gn_result gn_antialias_create(gn_device *device, const gn_antialias_desc *desc,
                                     gn_antialias **antialias);
GN_API void gn_antialias_destroy(gn_antialias **antialias);

/* Where in their pixels the rays of the next frame go, in [0, 1): for gn_view_set_jitter(). */
GN_API void gn_antialias_jitter(const gn_antialias *antialias, float jitter[2]);

/* The next frame: image and out are linear RGB, 3 floats a pixel, not the same memory. Of the
 * G-buffer, which has the same size, motion and depth are read, and surface. */
GN_API gn_result gn_antialias_apply(gn_antialias *antialias, const gn_gbuffer *gbuffer,
                                    const float *image, float *out);

/* A camera cut: nothing of the frames before is in the next one. */
GN_API void gn_antialias_reset(gn_antialias *antialias);

#ifdef __cplusplus
}
#endif

#endif
