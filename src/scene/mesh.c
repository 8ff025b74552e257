/* Meshes: checked and copied, with texture coordinates as the material wants them. */
#include "scene/scene.h"

#include <math.h>
#include <string.h>

#define EMBREE_PADDING 16 /* bytes: Embree reads a whole vector at the last vertex */

static gn_result check_part(gn_scene *scene, const gn_mesh_part *part, uint32_t nth,
                            const gn_label *label)
{
    gn_context *context = scene->context;
    const uint32_t materials = scene->material_count - (scene->default_material != GN_NONE);
    if (part->vertex_count < 3 || !part->positions)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s, part %u: fewer than 3 vertices, or no positions", label->text, nth);
    if (part->index_count < 3 || part->index_count % 3 != 0 || !part->indices)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s, part %u: %u indices, must be a positive multiple of 3", label->text,
                       nth, part->indices ? part->index_count : 0);
    if (part->material != GN_NONE && part->material >= materials)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s, part %u: material %u does not exist, there are %u", label->text, nth,
                       part->material, materials);
    for (uint32_t i = 0; i < part->index_count; i++) {
        if (part->indices[i] >= part->vertex_count)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "%s, part %u: index %u names vertex %u, there are %u", label->text, nth,
                           i, part->indices[i], part->vertex_count);
    }
    for (size_t i = 0; i < part->vertex_count; i++) {
        const char *what = !gn_all_finite(part->positions + 3 * i, 3)                  ? "position"
                           : part->normals && !gn_all_finite(part->normals + 3 * i, 3) ? "normal"
                           : part->uvs && !gn_all_finite(part->uvs + 2 * i, 2)
                               ? "texture coordinate"
                               : NULL;
        if (what)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "%s, part %u: the %s of vertex %u is not finite", label->text, nth, what,
                           (uint32_t)i);
    }
    return GN_OK;
}

/* The shared material of parts without one; GN_NONE where there is no memory. */
static uint32_t default_material(gn_scene *scene)
{
    if (scene->default_material != GN_NONE)
        return scene->default_material;
    gn_material_desc desc = gn_material_desc_default();
    desc.double_sided = true;
    uint32_t index = GN_NONE;
    if (gn_scene_add_material(scene, &desc, &index) != GN_OK)
        return GN_NONE;
    scene->default_material = index;
    return index;
}

/* Beyond this, in textures, a float has no fraction worth the name; the lookups count on it. */
#define MAX_TURNS 1e6f

static bool transform_uvs(float *uvs, size_t count, const float m[6])
{
    for (size_t i = 0; i < count; i++) {
        const float u = uvs[2 * i], v = uvs[2 * i + 1];
        uvs[2 * i] = m[0] * u + m[1] * v + m[2];
        uvs[2 * i + 1] = m[3] * u + m[4] * v + m[5];
    }
    if (!gn_all_finite(uvs, 2 * count))
        return false;
    for (size_t i = 0; i < 2 * count; i++)
        uvs[i] = fminf(fmaxf(uvs[i], -MAX_TURNS), MAX_TURNS);
    return true;
}

static gn_result copy_part(gn_scene *scene, const gn_mesh_part *source, gn_part *part, uint32_t nth,
                           const gn_label *label)
{
    gn_context *context = scene->context;
    const size_t vertices = source->vertex_count;
    part->vertex_count = source->vertex_count;
    part->triangle_count = source->index_count / 3;
    part->positions = gn_alloc(context, vertices * 3 * sizeof(float) + EMBREE_PADDING, 1);
    part->indices = gn_alloc_copy(context, source->indices, source->index_count, sizeof(uint32_t));
    if (source->normals)
        part->normals = gn_alloc_copy(context, source->normals, vertices * 3, sizeof(float));
    if (source->uvs)
        part->uvs = gn_alloc_copy(context, source->uvs, vertices * 2, sizeof(float));
    part->material = source->material == GN_NONE ? default_material(scene) : source->material;
    if (!part->positions || !part->indices || (source->normals && !part->normals) ||
        (source->uvs && !part->uvs) || part->material == GN_NONE)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s, part %u: out of memory", label->text,
                       nth);
    memcpy(part->positions, source->positions, vertices * 3 * sizeof(float));
    memset(part->positions + vertices * 3, 0, EMBREE_PADDING);
    if (part->uvs &&
        !transform_uvs(part->uvs, vertices, scene->materials[part->material].desc.uv_transform))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s, part %u: the material's uv_transform makes texture coordinates "
                       "infinite",
                       label->text, nth);
    return GN_OK;
}

static void grow_bounds(gn_mesh *mesh, const gn_part *part)
{
    for (size_t i = 0; i < 3 * (size_t)part->triangle_count; i++) {
        for (size_t axis = 0; axis < 3; axis++) {
            const float x = part->positions[3 * (size_t)part->indices[i] + axis];
            mesh->bounds_min[axis] = fminf(mesh->bounds_min[axis], x);
            mesh->bounds_max[axis] = fmaxf(mesh->bounds_max[axis], x);
        }
    }
}

void gn_mesh_free(gn_context *context, gn_mesh *mesh)
{
    for (uint32_t i = 0; mesh->parts && i < mesh->part_count; i++) {
        gn_free(context, mesh->parts[i].positions);
        gn_free(context, mesh->parts[i].normals);
        gn_free(context, mesh->parts[i].uvs);
        gn_free(context, mesh->parts[i].indices);
    }
    gn_free(context, mesh->parts);
    gn_free(context, mesh->name);
}

gn_result gn_scene_add_mesh(gn_scene *scene, const char *name, const gn_mesh_part *parts,
                            uint32_t part_count, uint32_t *index)
{
    gn_context *context = scene->context;
    gn_label label = gn_make_label("mesh", scene->mesh_count, name);
    if (part_count == 0 || !parts)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s: no parts", label.text);
    for (uint32_t i = 0; i < part_count; i++) {
        gn_result result = check_part(scene, &parts[i], i, &label);
        if (result != GN_OK)
            return result;
    }

    gn_mesh mesh = {.part_count = part_count,
                    .bounds_min = {INFINITY, INFINITY, INFINITY},
                    .bounds_max = {-INFINITY, -INFINITY, -INFINITY}};
    mesh.name = gn_alloc_string(context, name);
    mesh.parts = gn_alloc_zero(context, part_count, sizeof *mesh.parts);
    gn_result result = GN_OK;
    if (!mesh.name || !mesh.parts ||
        !gn_grow(context, (void **)&scene->meshes, scene->mesh_count, &scene->mesh_capacity,
                 sizeof *scene->meshes))
        result = gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", label.text);
    for (uint32_t i = 0; result == GN_OK && i < part_count; i++) {
        result = copy_part(scene, &parts[i], &mesh.parts[i], i, &label);
        if (result == GN_OK)
            grow_bounds(&mesh, &mesh.parts[i]);
    }
    if (result != GN_OK) {
        gn_mesh_free(context, &mesh);
        return result;
    }
    if (index)
        *index = scene->mesh_count;
    scene->meshes[scene->mesh_count++] = mesh;
    scene->structure_version++;
    scene->edits++;
    return GN_OK;
}
