#include "cpu/tree.h"

#include <math.h>
#include <string.h>

#include "cpu/runs.h"

static void transform_point(const float m[16], const float p[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
}

/* Equations 5 to 7 of the ray cone paper, the part that belongs to the triangle. */
static gn_masked_triangle masked_triangle(const gn_material *material, uint32_t sampler,
                                          const float uv[3][2], const float *const corners[3])
{
    gn_masked_triangle t = {.u0 = uv[0][0],
                            .v0 = uv[0][1],
                            .du1 = uv[1][0] - uv[0][0],
                            .dv1 = uv[1][1] - uv[0][1],
                            .du2 = uv[2][0] - uv[0][0],
                            .dv2 = uv[2][1] - uv[0][1],
                            .sampler = sampler};
    double edges[2][3];
    for (int i = 0; i < 3; i++) {
        edges[0][i] = (double)corners[1][i] - (double)corners[0][i];
        edges[1][i] = (double)corners[2][i] - (double)corners[0][i];
    }
    const double nx = edges[0][1] * edges[1][2] - edges[0][2] * edges[1][1];
    const double ny = edges[0][2] * edges[1][0] - edges[0][0] * edges[1][2];
    const double nz = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
    const double p_a = sqrt(nx * nx + ny * ny + nz * nz);
    const double t_a = (double)material->alpha.width * (double)material->alpha.height *
                       fabs((double)t.du1 * (double)t.dv2 - (double)t.du2 * (double)t.dv1);
    t.texel_scale = (float)sqrt(t_a * p_a);
    return t;
}

static void triangle_uvs(const gn_part *part, uint32_t triangle, float uv[3][2])
{
    for (int corner = 0; corner < 3; corner++)
        for (int axis = 0; axis < 2; axis++)
            uv[corner][axis] =
                part->uvs
                    ? part->uvs[part->indices[triangle * 3 + (uint32_t)corner] * 2 + (uint32_t)axis]
                    : 0.0f;
}

/* Classes of a part's triangles; the same part may stand in many places of a flat tree. */
static uint8_t *classify_part(gn_context *context, const gn_scene *scene, const gn_part *part)
{
    uint8_t *classes = gn_alloc(context, part->triangle_count, 1);
    for (uint32_t t = 0; classes && t < part->triangle_count; t++) {
        float uv[3][2];
        triangle_uvs(part, t, uv);
        classes[t] =
            (uint8_t)gn_classify_triangle(&scene->materials[part->material], (const float(*)[2])uv);
    }
    return classes;
}

/* Appends one part; the arrays are large enough. */
static void append_part(const gn_scene *scene, const gn_tree_part *entry, const uint8_t *classes,
                        gn_triangle_tree *tree)
{
    const gn_part *part = entry->part;
    const uint32_t first_vertex = tree->vertex_count;
    float *vertices = tree->vertices + (size_t)first_vertex * 3;
    if (entry->world)
        for (uint32_t v = 0; v < part->vertex_count; v++)
            transform_point(entry->world, part->positions + v * 3, vertices + v * 3);
    else
        memcpy(vertices, part->positions, (size_t)part->vertex_count * 3 * sizeof *vertices);
    tree->vertex_count += part->vertex_count;

    const gn_material *material = &scene->materials[part->material];
    for (uint32_t t = 0; t < part->triangle_count; t++) {
        if (classes[t] == GN_CLASS_EMPTY)
            continue;
        const int geometry =
            classes[t] == GN_CLASS_MASKED ? GN_GEOMETRY_MASKED : GN_GEOMETRY_OPAQUE;
        const uint32_t n = tree->counts[geometry]++;
        const float *corners[3];
        for (uint32_t corner = 0; corner < 3; corner++) {
            const uint32_t index = part->indices[t * 3 + corner];
            tree->indices[geometry][(size_t)n * 3 + corner] = first_vertex + index;
            corners[corner] = vertices + index * 3;
        }
        tree->sources[geometry][n] = (gn_source){entry->surface, t};
        if (geometry == GN_GEOMETRY_MASKED) {
            float uv[3][2];
            triangle_uvs(part, t, uv);
            tree->masked[n] =
                masked_triangle(material, part->material, (const float(*)[2])uv, corners);
        }
    }
}

static void attach(gn_accel *accel, gn_triangle_tree *tree, int geometry)
{
    if (tree->counts[geometry] == 0)
        return;
    RTCGeometry g = rtcNewGeometry(accel->rtc, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, tree->vertices, 0,
                               3 * sizeof(float), tree->vertex_count);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               tree->indices[geometry], 0, 3 * sizeof(uint32_t),
                               tree->counts[geometry]);
    if (geometry == GN_GEOMETRY_MASKED) {
        rtcSetGeometryUserData(g, tree);
        rtcSetGeometryIntersectFilterFunction(g, accel->kernels->intersect_filter);
        rtcSetGeometryOccludedFilterFunction(g, accel->kernels->occluded_filter);
    }
    rtcSetGeometryMask(g, UINT32_MAX);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(tree->scene, g, (unsigned)geometry);
    rtcReleaseGeometry(g);
}

gn_result gn_tree_build(gn_accel *accel, const gn_scene *scene, const gn_tree_part *parts,
                        uint32_t part_count, gn_triangle_tree *tree)
{
    gn_context *context = accel->context;
    uint64_t vertices = 0, triangles[2] = {0, 0};

    /* Classes are found once a part, not once an instance: parts repeat, sorted or not. */
    const gn_part *last = NULL;
    uint8_t **classes = gn_alloc_zero(context, part_count + 1, sizeof *classes);
    if (!classes)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory building a triangle tree");
    bool complete = true;
    for (uint32_t i = 0; i < part_count && complete; i++) {
        const gn_part *part = parts[i].part;
        classes[i] = part == last && i > 0 ? classes[i - 1] : classify_part(context, scene, part);
        complete = classes[i] != NULL;
        last = part;
        vertices += part->vertex_count;
        for (uint32_t t = 0; complete && t < part->triangle_count; t++)
            if (classes[i][t] != GN_CLASS_EMPTY)
                triangles[classes[i][t] == GN_CLASS_MASKED]++;
    }

    /* 4 floats of padding: Embree reads 16 bytes from the last vertex. */
    tree->vertices = gn_alloc_zero(context, vertices * 3 + 4, sizeof *tree->vertices);
    for (int geometry = 0; geometry < 2; geometry++) {
        tree->indices[geometry] =
            gn_alloc(context, triangles[geometry] * 3 + 1, sizeof *tree->indices[0]);
        tree->sources[geometry] =
            gn_alloc(context, triangles[geometry] + 1, sizeof *tree->sources[0]);
        complete = complete && tree->indices[geometry] && tree->sources[geometry];
    }
    tree->masked = gn_alloc(context, triangles[GN_GEOMETRY_MASKED] + 1, sizeof *tree->masked);
    complete = complete && tree->vertices && tree->masked;

    for (uint32_t i = 0; i < part_count && complete; i++)
        append_part(scene, &parts[i], classes[i], tree);
    for (uint32_t i = 0; i < part_count; i++)
        if (i == 0 || classes[i] != classes[i - 1])
            gn_free(context, classes[i]);
    gn_free(context, classes);
    if (!complete)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY,
                       "out of memory for a tree of %llu triangles",
                       (unsigned long long)(triangles[0] + triangles[1]));

    tree->scene = rtcNewScene(accel->rtc);
    attach(accel, tree, GN_GEOMETRY_OPAQUE);
    attach(accel, tree, GN_GEOMETRY_MASKED);
    rtcCommitScene(tree->scene);
    return GN_OK;
}

void gn_tree_free(gn_context *context, gn_triangle_tree *tree)
{
    if (tree->scene)
        rtcReleaseScene(tree->scene);
    gn_free(context, tree->vertices);
    for (int geometry = 0; geometry < 2; geometry++) {
        gn_free(context, tree->indices[geometry]);
        gn_free(context, tree->sources[geometry]);
    }
    gn_free(context, tree->masked);
    gn_runs_free(context, tree->runs);
    memset(tree, 0, sizeof *tree);
}
