#include "cpu/accel.h"

#include <math.h>
#include <string.h>

#include "cpu/cpu.h"
#include "cpu/tree.h"

static void accel_destroy(void *pointer)
{
    gn_accel *accel = pointer;
    if (!accel)
        return;
    gn_context *context = accel->context;
    if (accel->has_instances && accel->root)
        rtcReleaseScene(accel->root);
    for (uint32_t i = 0; i < accel->instance_count; i++)
        if (accel->instances[i].geometry)
            rtcReleaseGeometry(accel->instances[i].geometry);
    gn_tree_free(context, &accel->flat);
    for (uint32_t i = 0; i < accel->tree_count; i++)
        gn_tree_free(context, &accel->trees[i]);
    gn_free(context, accel->trees);
    gn_free(context, accel->instances);
    gn_free(context, accel->surfaces);
    gn_free(context, accel->first_surface);
    gn_free(context, accel->samplers);
    gn_free(context, accel->texels);
    if (accel->rtc)
        rtcReleaseDevice(accel->rtc);
    pthread_mutex_destroy(&accel->runs_mutex);
    gn_free(context, accel);
}

static uint64_t mesh_triangles(const gn_mesh *mesh)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < mesh->part_count; i++)
        triangles += mesh->parts[i].triangle_count;
    return triangles;
}

/* Where each node goes: into the flat tree, an instance of its own, or nowhere. */
enum { NOWHERE = 0, FLAT = 1, INSTANCE = 2 };

static uint8_t *place_nodes(gn_context *context, const gn_scene *scene)
{
    uint8_t *places = gn_alloc_zero(context, scene->node_count + 1, 1);
    uint32_t *uses = gn_alloc_zero(context, scene->mesh_count + 1, sizeof *uses);
    if (!places || !uses) {
        gn_free(context, places);
        gn_free(context, uses);
        return NULL;
    }
    uint64_t still = 0;
    for (uint32_t i = 0; i < scene->node_count; i++) {
        const gn_node *node = &scene->nodes[i];
        if (node->desc.mesh == GN_NONE)
            continue;
        uses[node->desc.mesh]++;
        if (!node->animated)
            still += mesh_triangles(&scene->meshes[node->desc.mesh]);
    }
    for (uint32_t i = 0; i < scene->node_count; i++) {
        const gn_node *node = &scene->nodes[i];
        if (node->desc.mesh != GN_NONE)
            places[i] =
                !node->animated && (still <= GN_FLAT_TRIANGLES || uses[node->desc.mesh] == 1)
                    ? FLAT
                    : INSTANCE;
    }
    gn_free(context, uses);
    return places;
}

/* Does a node's matrix turn right hands into left ones? */
static bool is_mirrored(const float m[16])
{
    const float *a = m, *b = m + 4, *c = m + 8;
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]) <
           0.0f;
}

static bool number_surfaces(gn_accel *accel, const gn_scene *scene)
{
    gn_context *context = accel->context;
    uint64_t count = 0;
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (scene->nodes[i].desc.mesh != GN_NONE)
            count += scene->meshes[scene->nodes[i].desc.mesh].part_count;
    if (count >= GN_NONE)
        return false;
    accel->surfaces = gn_alloc(context, count + 1, sizeof *accel->surfaces);
    accel->first_surface =
        gn_alloc(context, (size_t)scene->node_count + 1, sizeof *accel->first_surface);
    if (!accel->surfaces || !accel->first_surface)
        return false;
    for (uint32_t i = 0; i < scene->node_count; i++) {
        const uint32_t m = scene->nodes[i].desc.mesh;
        accel->first_surface[i] = m == GN_NONE ? GN_NONE : accel->surface_count;
        for (uint32_t p = 0; m != GN_NONE && p < scene->meshes[m].part_count; p++)
            accel->surfaces[accel->surface_count++] =
                (gn_surface){.node = i,
                             .mirrored = is_mirrored(scene->nodes[i].world),
                             .part = &scene->meshes[m].parts[p]};
    }
    return true;
}

/* Copies the alpha of every masked material into one block, so that a level is 8 bytes to look up.
 */
static gn_result fill_samplers(gn_accel *accel, const gn_scene *scene)
{
    gn_context *context = accel->context;
    const size_t count = (size_t)scene->material_count + 1;
    size_t bytes = 4; /* loads of 4 bytes may begin at the last texel */
    for (uint32_t i = 0; i < scene->material_count; i++)
        if (scene->materials[i].alpha.levels > 0)
            bytes += GN_CHAINS * gn_chain_texels(scene->materials[i].alpha.width,
                                                 scene->materials[i].alpha.height);
    if (bytes > UINT32_MAX)
        return gn_fail(context, GN_ERROR_UNSUPPORTED,
                       "the masked textures have more than 4 GB of texels");
    accel->samplers = gn_alloc_zero(context, count, sizeof *accel->samplers);
    accel->texels = gn_alloc_zero(context, bytes, 1);
    if (!accel->samplers || !accel->texels)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for %zu bytes of alpha",
                       bytes);
    size_t next = 0;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const gn_material *material = &scene->materials[i];
        const gn_alpha_map *map = &material->alpha;
        const bool blend = material->desc.alpha_mode == GN_ALPHA_BLEND;
        if (map->levels == 0)
            continue;
        const float cutoff = blend ? 0.5f : fmaxf(material->desc.alpha_cutoff, 1e-6f);
        gn_sampler *sampler = &accel->samplers[i];
        const double cutoff_sum = (double)cutoff * GN_ALPHA_ONE;
        *sampler =
            (gn_sampler){.cutoff = cutoff,
                         .cutoff_sum = (uint32_t)ceil(cutoff_sum),
                         .saturate_scale = (uint64_t)(4294967296.0 * GN_OPACITY_STEPS / cutoff_sum),
                         .last_mip = (int)map->levels - 1,
                         .texels = (float)map->width * (float)map->height,
                         .wrap_u = material->desc.wrap_u,
                         .wrap_v = material->desc.wrap_v,
                         .blend = blend};
        uint8_t *const *const chains[GN_CHAINS] = {map->averaged, map->rescaled, map->coverage};
        for (uint32_t chain = 0; chain < GN_CHAINS; chain++)
            for (uint32_t level = 0; level < map->levels; level++) {
                const uint32_t width = gn_level_size(map->width, level);
                const uint32_t height = gn_level_size(map->height, level);
                sampler->levels[chain][level] =
                    (gn_level){(uint32_t)next, (uint16_t)width, (uint16_t)height};
                memcpy(accel->texels + next, chains[chain][level], (size_t)width * height);
                next += (size_t)width * height;
            }
    }
    return GN_OK;
}

/* Parts of all flat nodes, a part's instances next to each other. */
static gn_result build_flat(gn_accel *accel, const gn_scene *scene, const uint8_t *places)
{
    gn_tree_part *parts = gn_alloc(accel->context, (size_t)accel->surface_count + 1, sizeof *parts);
    uint32_t *first = gn_alloc_zero(accel->context, (size_t)scene->mesh_count + 2, sizeof *first);
    uint32_t *nodes = gn_alloc(accel->context, (size_t)scene->node_count + 1, sizeof *nodes);
    gn_result result = GN_OK;
    if (!parts || !first || !nodes) {
        result = gn_fail(accel->context, GN_ERROR_OUT_OF_MEMORY, "out of memory for %u surfaces",
                         accel->surface_count);
        goto done;
    }
    /* Counting sort of the nodes by mesh. */
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (places[i] == FLAT)
            first[scene->nodes[i].desc.mesh + 2]++;
    for (uint32_t m = 1; m < scene->mesh_count + 2; m++)
        first[m] += first[m - 1];
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (places[i] == FLAT)
            nodes[first[scene->nodes[i].desc.mesh + 1]++] = i;

    uint32_t count = 0;
    for (uint32_t m = 0; m < scene->mesh_count; m++)
        for (uint32_t p = 0; p < scene->meshes[m].part_count; p++)
            for (uint32_t n = first[m]; n < first[m + 1]; n++)
                parts[count++] = (gn_tree_part){.part = &scene->meshes[m].parts[p],
                                                .world = scene->nodes[nodes[n]].world,
                                                .surface = accel->first_surface[nodes[n]] + p};
    result = gn_tree_build(accel, scene, parts, count, &accel->flat);
done:
    gn_free(accel->context, parts);
    gn_free(accel->context, first);
    gn_free(accel->context, nodes);
    return result;
}

static gn_result build_mesh_tree(gn_accel *accel, const gn_scene *scene, uint32_t mesh)
{
    const gn_mesh *m = &scene->meshes[mesh];
    gn_tree_part *parts = gn_alloc(accel->context, (size_t)m->part_count + 1, sizeof *parts);
    if (!parts)
        return gn_fail(accel->context, GN_ERROR_OUT_OF_MEMORY, "out of memory for mesh \"%s\"",
                       m->name);
    for (uint32_t p = 0; p < m->part_count; p++)
        parts[p] = (gn_tree_part){.part = &m->parts[p], .world = NULL, .surface = p};
    gn_result result = gn_tree_build(accel, scene, parts, m->part_count, &accel->trees[mesh]);
    gn_free(accel->context, parts);
    return result;
}

static void set_transform(gn_instance *instance, const float world[16], bool moving)
{
    /* Cofactors: the cross product of two columns each. */
    float *n = instance->normal_matrix;
    for (int c = 0; c < 3; c++) {
        const float *a = world + 4 * ((c + 1) % 3), *b = world + 4 * ((c + 2) % 3);
        n[3 * c + 0] = a[1] * b[2] - a[2] * b[1];
        n[3 * c + 1] = a[2] * b[0] - a[0] * b[2];
        n[3 * c + 2] = a[0] * b[1] - a[1] * b[0];
    }
    float lengths[3];
    bool orthogonal = true;
    for (int c = 0; c < 3; c++) {
        const float *a = world + 4 * c, *b = world + 4 * ((c + 1) % 3);
        lengths[c] = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
        const float dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        orthogonal = orthogonal && fabsf(dot) <= 1e-5f * lengths[c];
    }
    instance->determinant = fabsf(world[0] * n[0] + world[1] * n[1] + world[2] * n[2]);
    instance->uniform = orthogonal && fabsf(lengths[0] - lengths[1]) <= 1e-5f * lengths[0] &&
                        fabsf(lengths[0] - lengths[2]) <= 1e-5f * lengths[0];
    /* 2^LOD = w sqrt(t_a p_a) / |N.d|; lengths grow by s, p_a and N.d (with the object space
     * direction) by s^2 and s^3, so that the object's value shrinks by s^2. */
    instance->lod_factor = 1.0f / lengths[0];
    /* A node scaled to nothing cannot be hit, and its matrix cannot be inverted. */
    if (instance->determinant > 0.0f)
        rtcEnableGeometry(instance->geometry);
    else
        rtcDisableGeometry(instance->geometry);
    rtcSetGeometryMask(instance->geometry, moving ? GN_MASK_DYNAMIC : GN_MASK_STATIC);
    rtcSetGeometryTransform(instance->geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, world);
    rtcCommitGeometry(instance->geometry);
}

static void add_instance(gn_accel *accel, const gn_triangle_tree *tree, uint32_t node,
                         uint32_t first_surface, const float world[16], bool moving)
{
    gn_instance *instance = &accel->instances[accel->instance_count];
    *instance = (gn_instance){.tree = tree,
                              .node = node,
                              .first_surface = first_surface,
                              .uniform = true,
                              .lod_factor = 1.0f};
    if (accel->has_instances && tree->counts[0] + tree->counts[1] > 0) {
        instance->geometry = rtcNewGeometry(accel->rtc, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance->geometry, tree->scene);
        rtcSetGeometryTimeStepCount(instance->geometry, 1);
        set_transform(instance, world, moving);
        rtcAttachGeometryByID(accel->root, instance->geometry, accel->instance_count);
    }
    accel->instance_count++;
}

static gn_result check_rtc(gn_accel *accel)
{
    switch (rtcGetDeviceError(accel->rtc)) {
    case RTC_ERROR_NONE:
        return GN_OK;
    case RTC_ERROR_OUT_OF_MEMORY:
        return gn_fail(accel->context, GN_ERROR_OUT_OF_MEMORY,
                       "Embree is out of memory building the tree");
    default:
        return gn_fail(accel->context, GN_ERROR_UNSUPPORTED, "Embree failed building the tree");
    }
}

static gn_result build(gn_accel *accel, const gn_scene *scene)
{
    gn_context *context = accel->context;
    static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    uint8_t *places = place_nodes(context, scene);
    accel->trees = gn_alloc_zero(context, (size_t)scene->mesh_count + 1, sizeof *accel->trees);
    accel->tree_count = accel->trees ? scene->mesh_count : 0;
    accel->instances =
        gn_alloc_zero(context, (size_t)scene->node_count + 2, sizeof *accel->instances);
    gn_result result = GN_OK;
    if (!places || !accel->trees || !accel->instances || !number_surfaces(accel, scene)) {
        result = gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for %u nodes",
                         scene->node_count);
        goto done;
    }
    if ((result = fill_samplers(accel, scene)) != GN_OK ||
        (result = build_flat(accel, scene, places)) != GN_OK)
        goto done;
    for (uint32_t i = 0; i < scene->node_count; i++) {
        const uint32_t mesh = scene->nodes[i].desc.mesh;
        if (places[i] != INSTANCE)
            continue;
        accel->has_instances = true;
        if (!accel->trees[mesh].scene && (result = build_mesh_tree(accel, scene, mesh)) != GN_OK)
            goto done;
    }
    if (accel->has_instances)
        accel->root = rtcNewScene(accel->rtc);
    else
        accel->root = accel->flat.scene;
    add_instance(accel, &accel->flat, GN_NONE, 0, identity, false);
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (places[i] == INSTANCE)
            add_instance(accel, &accel->trees[scene->nodes[i].desc.mesh], i,
                         accel->first_surface[i], scene->nodes[i].world, scene->nodes[i].animated);
    if (accel->has_instances)
        rtcCommitScene(accel->root);
    result = check_rtc(accel);
done:
    gn_free(context, places);
    return result;
}

/* Moves the instances. False where a node of the flat tree began to move: build anew. */
static bool move(gn_accel *accel, const gn_scene *scene)
{
    uint32_t moving = 0, instances = 0;
    for (uint32_t i = 0; i < scene->node_count; i++)
        moving += scene->nodes[i].desc.mesh != GN_NONE && scene->nodes[i].animated;
    for (uint32_t i = 1; i < accel->instance_count; i++)
        instances += scene->nodes[accel->instances[i].node].animated;
    if (moving != instances)
        return false;
    for (uint32_t i = 1; i < accel->instance_count; i++) {
        gn_instance *instance = &accel->instances[i];
        if (instance->geometry && scene->nodes[instance->node].animated)
            set_transform(instance, scene->nodes[instance->node].world, true);
    }
    if (accel->has_instances)
        rtcCommitScene(accel->root);
    return true;
}

gn_result gn_accel_update(gn_scene *scene, const gn_cpu *cpu)
{
    gn_accel *accel = scene->accel;
    if (accel && accel->structure_version == scene->structure_version) {
        if (accel->transform_version == scene->transform_version)
            return GN_OK;
        if (move(accel, scene)) {
            accel->transform_version = scene->transform_version;
            return check_rtc(accel);
        }
    }
    accel_destroy(accel);
    scene->accel = NULL;
    accel = gn_alloc_zero(scene->context, 1, sizeof *accel);
    if (!accel)
        return gn_fail(scene->context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a tree");
    accel->context = scene->context;
    accel->rtc = cpu->rtc;
    rtcRetainDevice(cpu->rtc);
    pthread_mutex_init(&accel->runs_mutex, NULL);
    accel->kernels = cpu->kernels;
    accel->tables = &cpu->tables;
    gn_result result = build(accel, scene);
    if (result != GN_OK) {
        accel_destroy(accel);
        return result;
    }
    accel->structure_version = scene->structure_version;
    accel->transform_version = scene->transform_version;
    scene->accel = accel;
    scene->accel_number++;
    scene->accel_destroy = accel_destroy;
    return GN_OK;
}
