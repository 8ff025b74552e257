#include "cpu/cpu.h"

#include <math.h>

typedef struct shade_job {
    const gn_cpu *cpu;
    const gn_gbuffer *gbuffer;
    const gn_rays *rays;
    const gn_shade_light *lights;
    uint32_t light_count;
    float weight;
    float *image;
} shade_job;

/* A clear sky: brighter towards the horizon; below it, light from the ground. */
static void sky_color(float up, float color[3])
{
    static const float zenith[3] = {0.18f, 0.34f, 0.68f}, horizon[3] = {0.62f, 0.72f, 0.85f},
                       ground[3] = {0.22f, 0.20f, 0.17f};
    const float t = up > 0.0f ? sqrtf(up) : 0.0f;
    const float below = up < 0.0f ? fminf(-up * 4.0f, 1.0f) : 0.0f;
    for (int i = 0; i < 3; i++) {
        const float above = horizon[i] + t * (zenith[i] - horizon[i]);
        color[i] = above + below * (ground[i] - above);
    }
}

/* Light that the sky sends to a surface: between ground and zenith by the normal. */
static void ambient_color(float up, float color[3])
{
    static const float low[3] = {0.14f, 0.125f, 0.105f}, high[3] = {0.30f, 0.36f, 0.46f};
    const float t = 0.5f + 0.5f * up;
    for (int i = 0; i < 3; i++)
        color[i] = low[i] + t * (high[i] - low[i]);
}

/* Irradiance factor of a light at a point: cosine, falloff, range window, spot cone
 * (KHR_lights_punctual). */
static float light_factor(const gn_light *light, const float p[3], const float n[3])
{
    const gn_light_desc *d = &light->desc;
    if (d->type == GN_LIGHT_DIRECTIONAL) {
        const float cosine =
            -(n[0] * light->direction[0] + n[1] * light->direction[1] + n[2] * light->direction[2]);
        return cosine > 0.0f ? cosine * d->intensity : 0.0f;
    }
    float l[3], distance2 = 0.0f;
    for (int i = 0; i < 3; i++) {
        l[i] = light->position[i] - p[i];
        distance2 += l[i] * l[i];
    }
    const float distance = sqrtf(distance2);
    float factor = (n[0] * l[0] + n[1] * l[1] + n[2] * l[2]) / distance / distance2;
    if (!(factor > 0.0f))
        return 0.0f;
    if (isfinite(d->range)) {
        const float r = distance / d->range;
        factor *= fmaxf(fminf(1.0f - r * r * r * r, 1.0f), 0.0f);
    }
    if (d->type == GN_LIGHT_SPOT) {
        const float cosine = -(l[0] * light->direction[0] + l[1] * light->direction[1] +
                               l[2] * light->direction[2]) /
                             distance;
        const float inner = cosf(d->inner_cone_angle), outer = cosf(d->outer_cone_angle);
        const float t = fmaxf(fminf((cosine - outer) / fmaxf(inner - outer, 1e-4f), 1.0f), 0.0f);
        factor *= t * t;
    }
    return factor * d->intensity;
}

static void shade_pixel(const shade_job *job, uint32_t x, uint32_t y, float color[3])
{
    const gn_gbuffer *g = job->gbuffer;
    const size_t pixel = (size_t)y * g->width + x;
    if (g->surface[pixel] == GN_NONE) {
        const gn_rays *r = job->rays;
        const float sx = 2.0f * ((float)x + 0.5f) / (float)g->width - 1.0f;
        const float sy = 1.0f - 2.0f * ((float)y + 0.5f) / (float)g->height;
        float d[3], length2 = 0.0f;
        for (int i = 0; i < 3; i++) {
            d[i] = (r->orthographic ? 0.0f : sx * r->right[i] + sy * r->up[i]) - r->back[i];
            length2 += d[i] * d[i];
        }
        sky_color(d[1] / sqrtf(length2), color);
        return;
    }
    const float p[3] = {g->position[0][pixel], g->position[1][pixel], g->position[2][pixel]};
    const float n[3] = {g->shading_normal[0][pixel], g->shading_normal[1][pixel],
                        g->shading_normal[2][pixel]};
    float light[3];
    ambient_color(n[1], light);
    for (uint32_t i = 0; i < job->light_count; i++) {
        const gn_shade_light *l = &job->lights[i];
        const float visibility = l->visibility[pixel];
        if (visibility <= 0.0f)
            continue;
        const float factor = visibility * light_factor(l->light, p, n) * 0.31830989f;
        for (int c = 0; c < 3; c++)
            light[c] += factor * l->light->desc.color[c];
    }
    for (int c = 0; c < 3; c++)
        color[c] = light[c] * job->cpu->tables.linear[g->albedo[pixel] >> (8 * c) & 255u];
}

static void shade_row(uint32_t y, uint32_t thread, void *user)
{
    const shade_job *job = user;
    (void)thread;
    float *row = job->image + (size_t)y * job->gbuffer->width * 3;
    for (uint32_t x = 0; x < job->gbuffer->width; x++) {
        float color[3];
        shade_pixel(job, x, y, color);
        for (int c = 0; c < 3; c++)
            row[x * 3 + (uint32_t)c] += job->weight * color[c];
    }
}

void gn_cpu_shade(const gn_cpu *cpu, const gn_gbuffer *gbuffer, const gn_rays *rays,
                  const gn_shade_light *lights, uint32_t light_count, float weight, float *image)
{
    shade_job job = {cpu, gbuffer, rays, lights, light_count, weight, image};
    gn_parallel_for(cpu->context, gbuffer->height, shade_row, &job);
}
