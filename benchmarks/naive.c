#include "naive.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cpu/embree.h"
#include "scene/scene.h"

typedef struct naive_part {
    const gn_part *part;
    const gn_material *material;
    const gn_texture *texture;
} naive_part;

struct gn_naive {
    const gn_scene *scene;
    uint32_t threads;
    RTCDevice device;
    RTCScene root;
    RTCScene *meshes;
    RTCGeometry *instances; /* a node each */
    naive_part **parts;     /* a mesh each */
};

static float wrap_coordinate(float x, gn_wrap wrap)
{
    if (wrap == GN_WRAP_CLAMP)
        return fminf(fmaxf(x, 0.0f), 1.0f);
    if (wrap == GN_WRAP_MIRROR)
        return fabsf(x - 2.0f * floorf(0.5f * x + 0.5f));
    return x - floorf(x);
}

static int wrap_texel(int i, int size, gn_wrap wrap)
{
    if (wrap == GN_WRAP_REPEAT)
        return ((i % size) + size) % size;
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

static float texel_alpha(const gn_texture *texture, int x, int y)
{
    return (float)texture->rgba[0][((size_t)y * texture->width + (size_t)x) * 4 + 3] / 255.0f;
}

static float sample_alpha(const gn_texture *texture, const gn_material_desc *m, float u, float v)
{
    const int w = (int)texture->width, h = (int)texture->height;
    const float x = wrap_coordinate(u, m->wrap_u) * (float)w - 0.5f;
    const float y = wrap_coordinate(v, m->wrap_v) * (float)h - 0.5f;
    const int ix = (int)floorf(x), iy = (int)floorf(y);
    const float fx = x - (float)ix, fy = y - (float)iy;
    const int x0 = wrap_texel(ix, w, m->wrap_u), x1 = wrap_texel(ix + 1, w, m->wrap_u);
    const int y0 = wrap_texel(iy, h, m->wrap_v), y1 = wrap_texel(iy + 1, h, m->wrap_v);
    const float top =
        texel_alpha(texture, x0, y0) * (1.0f - fx) + texel_alpha(texture, x1, y0) * fx;
    const float bottom =
        texel_alpha(texture, x0, y1) * (1.0f - fx) + texel_alpha(texture, x1, y1) * fx;
    return top * (1.0f - fy) + bottom * fy;
}

static void alpha_filter(const struct RTCFilterFunctionNArguments *args)
{
    if (args->valid[0] == 0)
        return;
    const naive_part *p = args->geometryUserPtr;
    const uint32_t triangle = gn_lane_id(args->hit, GN_HIT_PRIMITIVE, 1, 0);
    const float b1 = gn_lane_real(args->hit, GN_HIT_U, 1, 0);
    const float b2 = gn_lane_real(args->hit, GN_HIT_V, 1, 0);
    const uint32_t *index = p->part->indices + (size_t)triangle * 3;
    const float *t0 = p->part->uvs + (size_t)index[0] * 2;
    const float *t1 = p->part->uvs + (size_t)index[1] * 2;
    const float *t2 = p->part->uvs + (size_t)index[2] * 2;
    const float u = (1.0f - b1 - b2) * t0[0] + b1 * t1[0] + b2 * t2[0];
    const float v = (1.0f - b1 - b2) * t0[1] + b1 * t1[1] + b2 * t2[1];
    const float alpha =
        sample_alpha(p->texture, &p->material->desc, u, v) * p->material->desc.base_color[3];
    if (alpha < p->material->desc.alpha_cutoff)
        args->valid[0] = 0;
}

static void add_mesh(gn_naive *naive, uint32_t m)
{
    const gn_scene *scene = naive->scene;
    const gn_mesh *mesh = &scene->meshes[m];
    naive->meshes[m] = rtcNewScene(naive->device);
    naive->parts[m] = calloc(mesh->part_count + 1, sizeof *naive->parts[m]);
    for (uint32_t i = 0; i < mesh->part_count && naive->parts[m]; i++) {
        const gn_part *part = &mesh->parts[i];
        const gn_material *material = &scene->materials[part->material];
        const bool textured = material->desc.texture != GN_NONE && part->uvs;
        naive->parts[m][i] = (naive_part){
            part, material, textured ? &scene->textures[material->desc.texture] : NULL};
        RTCGeometry g = rtcNewGeometry(naive->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, part->positions,
                                   0, 12, part->vertex_count);
        rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, part->indices, 0,
                                   12, part->triangle_count);
        if (material->desc.alpha_mode == GN_ALPHA_MASK && textured) {
            rtcSetGeometryUserData(g, &naive->parts[m][i]);
            rtcSetGeometryOccludedFilterFunction(g, alpha_filter);
        }
        rtcCommitGeometry(g);
        rtcAttachGeometry(naive->meshes[m], g);
        rtcReleaseGeometry(g);
    }
    rtcCommitScene(naive->meshes[m]);
}

gn_naive *gn_naive_create(const gn_scene *scene, uint32_t threads)
{
    gn_naive *naive = calloc(1, sizeof *naive);
    if (!naive)
        return NULL;
    char config[32];
    snprintf(config, sizeof config, "threads=%u", threads);
    naive->scene = scene;
    naive->threads = threads;
    naive->device = rtcNewDevice(config);
    naive->meshes = calloc(scene->mesh_count + 1, sizeof *naive->meshes);
    naive->parts = calloc(scene->mesh_count + 1, sizeof(naive_part *));
    naive->instances = calloc(scene->node_count + 1, sizeof *naive->instances);
    if (!naive->device || !naive->meshes || !naive->parts || !naive->instances) {
        gn_naive_destroy(naive);
        return NULL;
    }
    naive->root = rtcNewScene(naive->device);
    for (uint32_t m = 0; m < scene->mesh_count; m++)
        add_mesh(naive, m);
    for (uint32_t n = 0; n < scene->node_count; n++) {
        if (scene->nodes[n].desc.mesh == GN_NONE)
            continue;
        naive->instances[n] = rtcNewGeometry(naive->device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(naive->instances[n], naive->meshes[scene->nodes[n].desc.mesh]);
        rtcAttachGeometry(naive->root, naive->instances[n]);
    }
    gn_naive_update(naive);
    return naive;
}

void gn_naive_update(gn_naive *naive)
{
    for (uint32_t n = 0; n < naive->scene->node_count; n++) {
        if (!naive->instances[n])
            continue;
        rtcSetGeometryTransform(naive->instances[n], 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                                naive->scene->nodes[n].world);
        rtcCommitGeometry(naive->instances[n]);
    }
    rtcCommitScene(naive->root);
}

void gn_naive_destroy(gn_naive *naive)
{
    if (!naive)
        return;
    for (uint32_t n = 0; naive->instances && n < naive->scene->node_count; n++)
        if (naive->instances[n])
            rtcReleaseGeometry(naive->instances[n]);
    for (uint32_t m = 0; naive->meshes && naive->parts && m < naive->scene->mesh_count; m++) {
        if (naive->meshes[m])
            rtcReleaseScene(naive->meshes[m]);
        free(naive->parts[m]);
    }
    if (naive->root)
        rtcReleaseScene(naive->root);
    if (naive->device)
        rtcReleaseDevice(naive->device);
    free(naive->instances);
    free(naive->meshes);
    free(naive->parts);
    free(naive);
}

static float trace_pixel(const gn_naive *naive, const gn_gbuffer *g, const gn_light *light,
                         size_t pixel)
{
    if (g->surface[pixel] == GN_NONE)
        return 0.0f;
    const float error = g->origin_error[pixel];
    float origin[3], direction[3], distance = INFINITY, cosine = 0.0f;
    for (int i = 0; i < 3; i++)
        origin[i] = g->position[i][pixel] + error * g->normal[i][pixel];
    if (light->desc.type == GN_LIGHT_DIRECTIONAL) {
        for (int i = 0; i < 3; i++)
            direction[i] = -light->direction[i];
    } else {
        distance = 0.0f;
        for (int i = 0; i < 3; i++) {
            direction[i] = light->position[i] - origin[i];
            distance += direction[i] * direction[i];
        }
        distance = sqrtf(distance);
        if (!(distance > 0.0f) || distance > light->desc.range)
            return 0.0f;
        for (int i = 0; i < 3; i++)
            direction[i] /= distance;
    }
    for (int i = 0; i < 3; i++)
        cosine += direction[i] * g->normal[i][pixel];
    if (cosine <= 0.0f)
        return 0.0f;
    if (light->desc.type == GN_LIGHT_SPOT) {
        float along = 0.0f;
        for (int i = 0; i < 3; i++)
            along -= direction[i] * light->direction[i];
        if (along <= cosf(light->desc.outer_cone_angle))
            return 0.0f;
    }
    gn_rtc_context context;
    gn_rtc_context_init(&context);
    struct RTCRay ray = {.org_x = origin[0],
                         .org_y = origin[1],
                         .org_z = origin[2],
                         .dir_x = direction[0],
                         .dir_y = direction[1],
                         .dir_z = direction[2],
                         .tfar = distance,
                         .mask = UINT32_MAX};
    gn_rtc_occluded1(naive->root, &context, &ray);
    return ray.tfar < 0.0f ? 0.0f : 1.0f;
}

void gn_naive_visibility(const gn_naive *naive, const gn_gbuffer *g, uint32_t light,
                         float *visibility)
{
    const gn_light *l = &naive->scene->lights[light];
    const int threads = (int)naive->threads;
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
    for (uint32_t y = 0; y < g->height; y++)
        for (uint32_t x = 0; x < g->width; x++) {
            const size_t pixel = (size_t)y * g->width + x;
            visibility[pixel] = trace_pixel(naive, g, l, pixel);
        }
}
