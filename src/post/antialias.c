#include "post/antialias.h"

#include <math.h>
#include <string.h>

/* Life ----------------------------------------------------------------------------------------- */

gn_antialias_desc gn_antialias_desc_default(void)
{
    return (gn_antialias_desc){.cookie = GN_COOKIE,
                               .kind = GN_ANTIALIAS_TAA,
                               .width = 1920,
                               .height = 1080,
                               .blend = 0.1f,
                               .deviations = 1.0f,
                               .threshold = 0.1f};
}

static gn_result check(gn_context *context, const gn_antialias_desc *desc)
{
    GN_CHECK_DESC(context, desc, gn_antialias_desc);
    if (desc->kind != GN_ANTIALIAS_TAA && desc->kind != GN_ANTIALIAS_SMAA_T2X)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "antialiasing %d does not exist",
                       (int)desc->kind);
    if (desc->width < 1 || desc->width > 16384 || desc->height < 1 || desc->height > 16384)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "antialiasing of %u x %u pixels: the range is 1 to 16384", desc->width,
                       desc->height);
    if (!(desc->blend > 0.0f && desc->blend <= 1.0f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "antialiasing with a blend of %g: the range is above 0 to 1",
                       (double)desc->blend);
    if (!(desc->deviations > 0.0f && desc->deviations <= 100.0f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "antialiasing with %g deviations: the range is above 0 to 100",
                       (double)desc->deviations);
    if (!(desc->threshold >= 0.0f && desc->threshold <= 1.0f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "antialiasing with a threshold of %g: the range is 0 to 1",
                       (double)desc->threshold);
    return GN_OK;
}

static bool allocate(gn_antialias *a)
{
    const size_t pixels = (size_t)a->desc.width * a->desc.height;
    const bool smaa = a->desc.kind == GN_ANTIALIAS_SMAA_T2X;
    bool good = true;
    for (int i = 0; i < 2; i++) {
        good &= (a->pictures[i] = gn_alloc(a->context, pixels * 3, sizeof(float))) != NULL;
        if (smaa)
            good &= (a->motions[i] = gn_alloc(a->context, pixels * 2, sizeof(float))) != NULL;
        else
            good &= (a->counts[i] = gn_alloc(a->context, pixels, 1)) != NULL;
    }
    if (smaa) {
        good &= (a->edges = gn_alloc(a->context, pixels, 1)) != NULL;
        good &= (a->weights = gn_alloc(a->context, pixels * 4, sizeof(float))) != NULL;
    }
    return good;
}

gn_result gn_antialias_create(gn_device *device, const gn_antialias_desc *desc,
                              gn_antialias **antialias)
{
    gn_context *context = gn_device_context(device);
    *antialias = NULL;
    const gn_antialias_desc defaults = gn_antialias_desc_default();
    if (!desc)
        desc = &defaults;
    GN_TRY(check(context, desc));
    gn_antialias *made = gn_alloc_zero(context, 1, sizeof *made);
    if (made) {
        made->context = context;
        made->desc = *desc;
        if (!allocate(made))
            gn_antialias_destroy(&made);
    }
    *antialias = made;
    return made ? GN_OK
                : gn_fail(context, GN_ERROR_OUT_OF_MEMORY,
                          "out of memory for antialiasing %u x %u pixels", desc->width,
                          desc->height);
}

void gn_antialias_destroy(gn_antialias **antialias)
{
    if (!antialias || !*antialias)
        return;
    gn_antialias *a = *antialias;
    *antialias = NULL;
    for (int i = 0; i < 2; i++) {
        gn_free(a->context, a->pictures[i]);
        gn_free(a->context, a->counts[i]);
        gn_free(a->context, a->motions[i]);
    }
    gn_free(a->context, a->edges);
    gn_free(a->context, a->weights);
    gn_free(a->context, a);
}

void gn_antialias_reset(gn_antialias *antialias)
{
    antialias->frame = 0;
    antialias->has_before = false;
}

/* Frames --------------------------------------------------------------------------------------- */

/* The base's radical inverse of i: the Halton sequence in one dimension. */
static float halton(uint32_t i, uint32_t base)
{
    float value = 0.0f, digit = 1.0f;
    for (; i > 0; i /= base) {
        digit /= (float)base;
        value += digit * (float)(i % base);
    }
    return value;
}

void gn_antialias_jitter(const gn_antialias *antialias, float jitter[2])
{
    if (antialias->desc.kind == GN_ANTIALIAS_SMAA_T2X) {
        /* Two places on a diagonal of the pixel. */
        jitter[0] = antialias->frame & 1 ? 0.25f : 0.75f;
        jitter[1] = antialias->frame & 1 ? 0.75f : 0.25f;
        return;
    }
    const uint32_t i = antialias->frame % 8 + 1;
    jitter[0] = halton(i, 2);
    jitter[1] = halton(i, 3);
}

gn_result gn_antialias_apply(gn_antialias *antialias, const gn_gbuffer *gbuffer, const float *image,
                             float *out)
{
    const gn_antialias_desc *desc = &antialias->desc;
    if (gbuffer->width != desc->width || gbuffer->height != desc->height)
        return gn_fail(antialias->context, GN_ERROR_INVALID_ARGUMENT,
                       "antialiasing of %u x %u pixels got a picture of %u x %u", desc->width,
                       desc->height, gbuffer->width, gbuffer->height);
    const gn_antialias_job job = {antialias, gbuffer, image, out};
    if (desc->kind == GN_ANTIALIAS_SMAA_T2X)
        gn_smaa_apply(&job);
    else
        gn_taa_apply(&job);
    antialias->now ^= 1;
    antialias->has_before = true;
    antialias->frame++;
    return GN_OK;
}

/* Pictures ------------------------------------------------------------------------------------- */

static uint32_t clamped(int64_t at, uint32_t size)
{
    return at < 0 ? 0 : at >= size ? size - 1 : (uint32_t)at;
}

void gn_sample_bilinear(const float *picture, uint32_t width, uint32_t height, float x, float y,
                        float rgb[3])
{
    const float left = floorf(x - 0.5f), top = floorf(y - 0.5f);
    const float fx = x - 0.5f - left, fy = y - 0.5f - top;
    const size_t x0 = clamped((int64_t)left, width), x1 = clamped((int64_t)left + 1, width);
    const size_t y0 = clamped((int64_t)top, height), y1 = clamped((int64_t)top + 1, height);
    for (size_t c = 0; c < 3; c++) {
        const float a = picture[3 * (y0 * width + x0) + c], b = picture[3 * (y0 * width + x1) + c];
        const float d = picture[3 * (y1 * width + x0) + c], e = picture[3 * (y1 * width + x1) + c];
        const float above = a + fx * (b - a), below = d + fx * (e - d);
        rgb[c] = above + fy * (below - above);
    }
}

void gn_front_motion(const gn_gbuffer *g, uint32_t x, uint32_t y, float motion[2])
{
    size_t nearest = (size_t)y * g->width + x;
    float depth = g->surface[nearest] == GN_NONE ? INFINITY : g->depth[nearest];
    for (uint32_t py = y > 0 ? y - 1 : 0; py <= y + 1 && py < g->height; py++)
        for (uint32_t px = x > 0 ? x - 1 : 0; px <= x + 1 && px < g->width; px++) {
            const size_t pixel = (size_t)py * g->width + px;
            if (g->surface[pixel] != GN_NONE && g->depth[pixel] < depth) {
                depth = g->depth[pixel];
                nearest = pixel;
            }
        }
    motion[0] = g->motion[0][nearest];
    motion[1] = g->motion[1][nearest];
}
