#include "measure/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void gn_flicker_state_free(gn_flicker_state *state)
{
    free(state->depth);
    free(state->visibility);
    free(state->surface);
    *state = (gn_flicker_state){0};
}

/* Makes room for frames of this size. false: no memory, and the state is empty. */
static bool resize(gn_flicker_state *state, uint32_t width, uint32_t height)
{
    gn_flicker_state_free(state);
    const size_t count = (size_t)width * height;
    state->depth = malloc(count * sizeof *state->depth);
    state->visibility = malloc(count * sizeof *state->visibility);
    state->surface = malloc(count * sizeof *state->surface);
    if (state->depth == NULL || state->visibility == NULL || state->surface == NULL) {
        gn_flicker_state_free(state);
        return false;
    }
    state->width = width;
    state->height = height;
    return true;
}

/* What is compared from frame to frame. The change of a difference is the difference of the
 * changes: so the reference's change is taken off. */
static float value_at(const float *visibility, const float *reference, size_t i)
{
    return reference ? visibility[i] - reference[i] : visibility[i];
}

static gn_flicker compare(const gn_flicker_state *before, const gn_gbuffer *now,
                          const float *visibility, const float *reference)
{
    uint64_t pixels = 0, toggles = 0;
    double squares = 0;
    const float width = (float)now->width, height = (float)now->height;
    for (uint32_t y = 0; y < now->height; y++) {
        for (uint32_t x = 0; x < now->width; x++) {
            const size_t i = (size_t)y * now->width + x;
            if (now->surface[i] == GN_NONE)
                continue;

            /* The pixel that the surface point fell into. Written so that NaN is outside. */
            const float fx = (float)x + 0.5f + now->motion[0][i];
            const float fy = (float)y + 0.5f + now->motion[1][i];
            if (!(fx >= 0.0f && fx < width && fy >= 0.0f && fy < height))
                continue;
            const size_t j = (size_t)(uint32_t)fy * now->width + (uint32_t)fx;

            /* The same surface, not one that hid it or was hidden. */
            const float foretold = now->depth[i] + now->motion[2][i];
            if (before->surface[j] != now->surface[i] ||
                !(fabsf(before->depth[j] - foretold) <= 2.0f * now->cone_width[i]))
                continue;

            const float change = fabsf(value_at(visibility, reference, i) - before->visibility[j]);
            pixels++;
            toggles += change > 0.5f;
            squares += (double)change * (double)change;
        }
    }
    if (pixels == 0)
        return (gn_flicker){0};
    return (gn_flicker){
        .flicker = squares / (double)pixels,
        .toggles = (double)toggles / (double)pixels,
        .pixels = pixels,
    };
}

gn_flicker gn_measure_residual_flicker(gn_flicker_state *state, const gn_gbuffer *gbuffer,
                                       const float *visibility, const float *reference)
{
    gn_flicker result = {0};
    if (state->width == gbuffer->width && state->height == gbuffer->height)
        result = compare(state, gbuffer, visibility, reference);
    else if (!resize(state, gbuffer->width, gbuffer->height))
        return result;

    const size_t count = (size_t)gbuffer->width * gbuffer->height;
    memcpy(state->depth, gbuffer->depth, count * sizeof *state->depth);
    memcpy(state->surface, gbuffer->surface, count * sizeof *state->surface);
    for (size_t i = 0; i < count; i++)
        state->visibility[i] = value_at(visibility, reference, i);
    return result;
}

gn_flicker gn_measure_flicker(gn_flicker_state *state, const gn_gbuffer *gbuffer,
                              const float *visibility)
{
    return gn_measure_residual_flicker(state, gbuffer, visibility, NULL);
}
