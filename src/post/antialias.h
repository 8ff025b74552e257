/* What the ways of antialiasing share. */
#ifndef GN_POST_ANTIALIAS_H
#define GN_POST_ANTIALIAS_H

#include <gnomon/antialias.h>

#include "base/base.h"

struct gn_antialias {
    gn_context *context;
    gn_antialias_desc desc;
    uint32_t frame;     /* since the start: turns the jitter */
    bool has_before;    /* the frame before is there */
    uint32_t now;       /* which of the two below is the frame at hand's */
    float *pictures[2]; /* RGB; of TAA its results, of SMAA one frame each */
    /* TAA. */
    uint8_t *counts[2]; /* frames that are in a pixel */
    /* SMAA. */
    uint8_t *edges;    /* EDGE_LEFT, EDGE_TOP */
    float *weights;    /* 4 a pixel */
    float *motions[2]; /* gn_front_motion() of each pixel */
};

/* One frame, with which everything but gn_antialias.now and has_before is brought up to date. */
typedef struct gn_antialias_job {
    gn_antialias *antialias;
    const gn_gbuffer *gbuffer;
    const float *image;
    float *out;
} gn_antialias_job;

void gn_taa_apply(const gn_antialias_job *job);
void gn_smaa_apply(const gn_antialias_job *job);

/* RGB of a picture at x, y in pixels, bilinear, its edge pixels going on for ever. */
void gn_sample_bilinear(const float *picture, uint32_t width, uint32_t height, float x, float y,
                        float rgb[3]);

/* Where the nearest surface of the 3x3 pixels around one was a frame ago, as an offset in pixels:
 * an edge moves with what is in front. Far outside of the picture where it was not seen. */
void gn_front_motion(const gn_gbuffer *gbuffer, uint32_t x, uint32_t y, float motion[2]);

#endif
