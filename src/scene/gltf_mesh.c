/* glTF meshes: primitives to triangle lists. */
#include "scene/gltf.h"

#include <stdio.h>
#include <string.h>

enum { TRIANGLES = 4, TRIANGLE_STRIP, TRIANGLE_FAN };

static void free_part(gn_gltf *gltf, gn_mesh_part *part)
{
    gn_free(gltf->context, (void *)part->positions);
    gn_free(gltf->context, (void *)part->normals);
    gn_free(gltf->context, (void *)part->uvs);
    gn_free(gltf->context, (void *)part->indices);
}

/* Reads an attribute with as many elements as there are positions; *values stays NULL where the
 * primitive has no such attribute. */
static gn_result read_attribute(gn_gltf *gltf, const cJSON *attributes, const char *name,
                                uint32_t components, gn_gltf_rule rule, gn_mesh_part *part,
                                const float **values)
{
    uint32_t index = GN_NONE;
    GN_TRY(gn_gltf_index(gltf, attributes, name, &gltf->accessors, &index));
    if (index == GN_NONE)
        return GN_OK;
    gn_gltf_accessor accessor;
    GN_TRY(gn_gltf_open_accessor(gltf, index, &accessor));
    if (part->vertex_count == 0)
        part->vertex_count = accessor.count;
    if (accessor.count != part->vertex_count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s has %u elements, POSITION has %u", name,
                            accessor.count, part->vertex_count);
    float *array = NULL;
    GN_TRY(gn_gltf_read_floats(gltf, &accessor, components, rule, &array));
    *values = array;
    return GN_OK;
}

/* The primitive's indices, or 0, 1, 2... where it has none. */
static gn_result read_indices(gn_gltf *gltf, const cJSON *primitive, uint32_t vertex_count,
                              uint32_t **indices, uint32_t *count)
{
    uint32_t index = GN_NONE;
    GN_TRY(gn_gltf_index(gltf, primitive, "indices", &gltf->accessors, &index));
    if (index != GN_NONE) {
        gn_gltf_accessor accessor;
        GN_TRY(gn_gltf_open_accessor(gltf, index, &accessor));
        *count = accessor.count;
        return gn_gltf_read_indices(gltf, &accessor, vertex_count, indices);
    }
    uint32_t *sequence = gn_alloc(gltf->context, vertex_count, sizeof *sequence);
    if (!sequence)
        return gn_gltf_no_memory(gltf);
    for (uint32_t i = 0; i < vertex_count; i++)
        sequence[i] = i;
    *indices = sequence;
    *count = vertex_count;
    return GN_OK;
}

/* Turns a strip or fan into a list; every second triangle of a strip is turned round. */
static gn_result make_list(gn_gltf *gltf, bool fan, uint32_t **indices, uint32_t *count)
{
    const uint32_t triangles = *count - 2;
    if (triangles > UINT32_MAX / 3)
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED, "%u triangles are too many", triangles);
    uint32_t *list = gn_alloc(gltf->context, (size_t)triangles * 3, sizeof *list);
    if (!list)
        return gn_gltf_no_memory(gltf);
    const uint32_t *strip = *indices;
    for (uint32_t i = 0; i < triangles; i++) {
        uint32_t *triangle = list + (size_t)i * 3;
        triangle[0] = fan ? strip[i + 1] : strip[i];
        triangle[1] = fan ? strip[i + 2] : strip[i + 1 + i % 2];
        triangle[2] = fan ? strip[0] : strip[i + 2 - i % 2];
    }
    gn_free(gltf->context, *indices);
    *indices = list;
    *count = triangles * 3;
    return GN_OK;
}

static gn_result read_triangles(gn_gltf *gltf, const cJSON *primitive, uint64_t mode,
                                gn_mesh_part *part)
{
    uint32_t *indices = NULL;
    GN_TRY(read_indices(gltf, primitive, part->vertex_count, &indices, &part->index_count));
    part->indices = indices; /* freed with the part, whatever follows */
    if (part->index_count < 3 || (mode == TRIANGLES && part->index_count % 3 != 0))
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%u indices do not make whole triangles",
                            part->index_count);
    gn_result result = GN_OK;
    if (mode != TRIANGLES)
        result = make_list(gltf, mode == TRIANGLE_FAN, &indices, &part->index_count);
    part->indices = indices;
    return result;
}

static gn_result read_uvs(gn_gltf *gltf, const cJSON *attributes, gn_mesh_part *part)
{
    uint32_t set = GN_NONE;
    GN_TRY(gn_gltf_material_uv_set(gltf, part->material, &set));
    if (set == GN_NONE)
        return GN_OK;
    char name[32];
    snprintf(name, sizeof name, "TEXCOORD_%u", set);
    GN_TRY(read_attribute(gltf, attributes, name, 2, GN_GLTF_QUANTIZED, part, &part->uvs));
    if (!part->uvs)
        gn_scene_warn(gltf->scene, "%s: it has no %s, which its texture reads; 0 is taken",
                      gltf->where, name);
    return GN_OK;
}

/* Reads a primitive of triangles; leaves part->index_count at 0 where it is something else. */
static gn_result read_primitive(gn_gltf *gltf, const cJSON *primitive, gn_mesh_part *part)
{
    uint64_t mode = TRIANGLES;
    const cJSON *attributes = NULL;
    GN_TRY(gn_gltf_integer(gltf, primitive, "mode", &mode));
    GN_TRY(gn_gltf_object(gltf, primitive, "attributes", &attributes));
    GN_TRY(gn_gltf_index(gltf, primitive, "material", &gltf->materials, &part->material));
    if (mode > TRIANGLE_FAN)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "unknown mode %llu", (unsigned long long)mode);
    if (mode < TRIANGLES) {
        gn_scene_warn(gltf->scene, "%s: points and lines are not supported; left out", gltf->where);
        return GN_OK;
    }
    GN_TRY(
        read_attribute(gltf, attributes, "POSITION", 3, GN_GLTF_QUANTIZED, part, &part->positions));
    if (part->vertex_count < 3) {
        gn_scene_warn(gltf->scene, "%s: it has no positions or fewer than 3; left out",
                      gltf->where);
        return GN_OK;
    }
    GN_TRY(read_attribute(gltf, attributes, "NORMAL", 3, GN_GLTF_NORMALIZED, part, &part->normals));
    GN_TRY(read_uvs(gltf, attributes, part));
    if (cJSON_HasObjectItem(attributes, "COLOR_0"))
        gn_scene_warn(gltf->scene, "%s: vertex colours are not supported; left out", gltf->where);
    if (cJSON_HasObjectItem(primitive, "targets"))
        gn_scene_warn(gltf->scene, "%s: morph targets are not supported; the base shape is shown",
                      gltf->where);
    return read_triangles(gltf, primitive, mode, part);
}

static gn_result read_parts(gn_gltf *gltf, uint32_t mesh, const cJSON *primitives,
                            gn_mesh_part *parts)
{
    uint32_t count = 0, nth = 0;
    const cJSON *primitive = NULL;
    cJSON_ArrayForEach(primitive, primitives)
    {
        gn_gltf_at(gltf, &gltf->meshes, mesh);
        const size_t length = strlen(gltf->where);
        snprintf(gltf->where + length, sizeof gltf->where - length, ", primitive %u", nth++);
        if (!cJSON_IsObject(primitive))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "it is not an object");
        gn_mesh_part *part = &parts[count];
        part->material = GN_NONE;
        GN_TRY(read_primitive(gltf, primitive, part));
        if (part->index_count > 0) {
            count++;
        } else {
            free_part(gltf, part);
            memset(part, 0, sizeof *part);
        }
    }
    gn_gltf_at(gltf, &gltf->meshes, mesh);
    if (count == 0) {
        gn_scene_warn(gltf->scene, "%s: it has no triangles", gltf->where);
        return GN_OK;
    }
    const gn_result result = gn_scene_add_mesh(gltf->scene, gn_gltf_name(gltf->meshes.items[mesh]),
                                               parts, count, &gltf->mesh_indices[mesh]);
    return result == GN_OK ? GN_OK : gn_gltf_refail(gltf, result);
}

gn_result gn_gltf_read_meshes(gn_gltf *gltf)
{
    for (uint32_t i = 0; i < gltf->meshes.count; i++) {
        if (gn_report(gltf->context, 0.5 + 0.5 * i / gltf->meshes.count, "meshes"))
            return gn_gltf_fail(gltf, GN_ERROR_CANCELLED, "cancelled");
        gn_gltf_at(gltf, &gltf->meshes, i);
        const cJSON *primitives = NULL;
        GN_TRY(gn_gltf_array(gltf, gltf->meshes.items[i], "primitives", &primitives));
        const uint32_t count = (uint32_t)cJSON_GetArraySize(primitives);
        gn_mesh_part *parts = gn_alloc_zero(gltf->context, count, sizeof *parts);
        if (!parts)
            return gn_gltf_no_memory(gltf);
        const gn_result result = read_parts(gltf, i, primitives, parts);
        for (uint32_t p = 0; p < count; p++)
            free_part(gltf, &parts[p]);
        gn_free(gltf->context, parts);
        GN_TRY(result);
    }
    gltf->where[0] = '\0';
    return GN_OK;
}
