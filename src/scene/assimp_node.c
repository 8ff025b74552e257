/* Assimp's nodes, with the lights, cameras and animations that name them. */
#include "scene/assimp.h"

#include <assimp/cimport.h>
#include <math.h>
#include <string.h>

/* Lights and cameras ------------------------------------------------------------------------ */

/* A matrix at position whose -Z is forward and whose Y is near up. */
static void look(const struct aiVector3D *position, const struct aiVector3D *forward,
                 const struct aiVector3D *up, float matrix[16])
{
    double z[3] = {-forward->x, -forward->y, -forward->z}, x[3], y[3];
    double length = sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
    if (!(length > 0) || !isfinite(length)) {
        z[0] = z[1] = 0;
        z[2] = length = 1;
    }
    for (int i = 0; i < 3; i++)
        z[i] /= length;
    double u[3] = {up->x, up->y, up->z};
    for (int attempt = 0;; attempt++) {
        x[0] = u[1] * z[2] - u[2] * z[1];
        x[1] = u[2] * z[0] - u[0] * z[2];
        x[2] = u[0] * z[1] - u[1] * z[0];
        length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        if (attempt == 1 || (length > 1e-6 && isfinite(length)))
            break;
        /* up is missing or parallel: the axis that is farthest from forward */
        u[0] = fabs(z[1]) < 0.9 ? 0 : 1;
        u[1] = 1 - u[0];
        u[2] = 0;
    }
    for (int i = 0; i < 3; i++)
        x[i] /= length;
    y[0] = z[1] * x[2] - z[2] * x[1];
    y[1] = z[2] * x[0] - z[0] * x[2];
    y[2] = z[0] * x[1] - z[1] * x[0];
    for (int i = 0; i < 3; i++) {
        matrix[i] = (float)x[i];
        matrix[4 + i] = (float)y[i];
        matrix[8 + i] = (float)z[i];
    }
    matrix[12] = position->x;
    matrix[13] = position->y;
    matrix[14] = position->z;
}

static gn_result add_light(gn_assimp *import, const struct aiLight *source, uint32_t parent)
{
    gn_light_desc desc = gn_light_desc_default();
    desc.name = source->mName.data;
    if (source->mType == aiLightSource_DIRECTIONAL)
        desc.type = GN_LIGHT_DIRECTIONAL;
    else if (source->mType == aiLightSource_POINT)
        desc.type = GN_LIGHT_POINT;
    else if (source->mType == aiLightSource_SPOT)
        desc.type = GN_LIGHT_SPOT;
    else {
        gn_scene_warn(import->scene,
                      "light \"%.100s\": area and ambient lights are not supported; "
                      "left out",
                      desc.name);
        return GN_OK;
    }
    desc.color[0] = fmaxf(source->mColorDiffuse.r, 0);
    desc.color[1] = fmaxf(source->mColorDiffuse.g, 0);
    desc.color[2] = fmaxf(source->mColorDiffuse.b, 0);
    if (desc.type != GN_LIGHT_DIRECTIONAL && source->mAttenuationQuadratic > 1e-6f)
        desc.intensity = 1 / source->mAttenuationQuadratic;
    if (desc.type == GN_LIGHT_SPOT) { /* whole angles there, half angles here */
        desc.outer_cone_angle = fminf(fmaxf(source->mAngleOuterCone / 2, 1e-3f), 1.5707963f);
        desc.inner_cone_angle =
            fminf(fmaxf(source->mAngleInnerCone / 2, 0), desc.outer_cone_angle * 0.999f);
    }
    gn_node_desc node = gn_node_desc_default();
    node.parent = parent;
    node.use_matrix = true;
    look(&source->mPosition, &source->mDirection, &source->mUp, node.matrix);
    gn_result result = gn_scene_add_light(import->scene, &desc, &node.light);
    if (result == GN_OK)
        result = gn_scene_add_node(import->scene, &node, NULL);
    return result == GN_OK ? GN_OK : gn_assimp_refail(import, result);
}

static gn_result add_camera(gn_assimp *import, const struct aiCamera *source, uint32_t parent)
{
    gn_camera_desc desc = gn_camera_desc_default();
    const double aspect = source->mAspect > 0 ? (double)source->mAspect : 16.0 / 9.0;
    desc.name = source->mName.data;
    desc.orthographic = source->mOrthographicWidth > 0;
    if (desc.orthographic) /* half the width */
        desc.ymag = (float)((double)source->mOrthographicWidth / aspect);
    else if (source->mHorizontalFOV > 0 && source->mHorizontalFOV < 3.1415f)
        desc.yfov = (float)(2 * atan(tan(0.5 * (double)source->mHorizontalFOV) / aspect));
    if (source->mClipPlaneNear >= 0)
        desc.znear = source->mClipPlaneNear;
    gn_node_desc node = gn_node_desc_default();
    node.parent = parent;
    node.use_matrix = true;
    look(&source->mPosition, &source->mLookAt, &source->mUp, node.matrix);
    gn_result result = gn_scene_add_camera(import->scene, &desc, &node.camera);
    if (result == GN_OK)
        result = gn_scene_add_node(import->scene, &node, NULL);
    return result == GN_OK ? GN_OK : gn_assimp_refail(import, result);
}

/* Animation --------------------------------------------------------------------------------- */

/* One property of a node; sorted keys with times in ticks. */
typedef struct track {
    gn_animation_path path;
    uint32_t count;
    const struct aiVectorKey *vectors; /* or */
    const struct aiQuatKey *rotations;
} track;

static gn_result add_track(gn_assimp *import, uint32_t node, const track *keys, double rate)
{
    if (keys->count == 0)
        return GN_OK;
    float *times = gn_alloc(import->context, keys->count, sizeof *times);
    float *values = gn_alloc(import->context, (size_t)keys->count * 4, sizeof *values);
    gn_channel_desc desc = gn_channel_desc_default();
    desc.node = node;
    desc.path = keys->path;
    desc.times = times;
    desc.values = values;
    for (uint32_t i = 0; times && values && i < keys->count; i++) {
        const double ticks = keys->vectors ? keys->vectors[i].mTime : keys->rotations[i].mTime;
        const float time = (float)(ticks / rate);
        if (!(time >= 0) || (desc.key_count > 0 && time <= times[desc.key_count - 1]))
            continue; /* some exporters repeat a key */
        times[desc.key_count] = time;
        if (keys->vectors) {
            const struct aiVector3D v = keys->vectors[i].mValue;
            memcpy(values + 3 * (size_t)desc.key_count, (float[]){v.x, v.y, v.z}, 12);
        } else {
            const struct aiQuaternion q = keys->rotations[i].mValue;
            memcpy(values + 4 * (size_t)desc.key_count, (float[]){q.x, q.y, q.z, q.w}, 16);
        }
        desc.key_count++;
    }
    gn_result result = GN_OK;
    if (!times || !values)
        result = gn_assimp_fail(import, GN_ERROR_OUT_OF_MEMORY, "out of memory");
    else if (desc.key_count > 0 && (result = gn_scene_add_channel(import->scene, &desc)) != GN_OK)
        gn_assimp_refail(import, result);
    gn_free(import->context, times);
    gn_free(import->context, values);
    return result;
}

/* The first animation of a node; *rate in ticks a second. */
static const struct aiNodeAnim *find_animation(const struct aiScene *source, const char *name,
                                               double *rate)
{
    for (uint32_t a = 0; a < source->mNumAnimations; a++) {
        const struct aiAnimation *animation = source->mAnimations[a];
        *rate = animation->mTicksPerSecond > 0 ? animation->mTicksPerSecond : 25;
        for (uint32_t c = 0; c < animation->mNumChannels; c++) {
            if (strcmp(animation->mChannels[c]->mNodeName.data, name) == 0)
                return animation->mChannels[c];
        }
    }
    return NULL;
}

static gn_result add_animation(gn_assimp *import, const struct aiNodeAnim *animation, double rate,
                               uint32_t node)
{
    const track tracks[3] = {
        {GN_PATH_TRANSLATION, animation->mNumPositionKeys, animation->mPositionKeys, NULL},
        {GN_PATH_ROTATION, animation->mNumRotationKeys, NULL, animation->mRotationKeys},
        {GN_PATH_SCALE, animation->mNumScalingKeys, animation->mScalingKeys, NULL}};
    for (int i = 0; i < 3; i++)
        GN_TRY(add_track(import, node, &tracks[i], rate));
    return GN_OK;
}

/* Nodes ------------------------------------------------------------------------------------- */

static void set_transform(gn_node_desc *desc, const struct aiMatrix4x4 *m, bool animated)
{
    if (!animated) {
        const float matrix[16] = {m->a1, m->b1, m->c1, m->d1, m->a2, m->b2, m->c2, m->d2,
                                  m->a3, m->b3, m->c3, m->d3, m->a4, m->b4, m->c4, m->d4};
        desc->use_matrix = true;
        memcpy(desc->matrix, matrix, sizeof matrix);
        return;
    }
    struct aiVector3D scale, position;
    struct aiQuaternion rotation;
    aiDecomposeMatrix(m, &scale, &rotation, &position);
    memcpy(desc->translation, (float[]){position.x, position.y, position.z}, 12);
    memcpy(desc->rotation, (float[]){rotation.x, rotation.y, rotation.z, rotation.w}, 16);
    memcpy(desc->scale, (float[]){scale.x, scale.y, scale.z}, 12);
}

/* A node holds one mesh here: the second and further ones hang on children of their own. */
static gn_result add_meshes(gn_assimp *import, const struct aiNode *source, uint32_t node,
                            uint32_t first)
{
    for (uint32_t i = first; i < source->mNumMeshes; i++) {
        gn_node_desc desc = gn_node_desc_default();
        desc.parent = node;
        desc.mesh = import->meshes[source->mMeshes[i]];
        if (desc.mesh == GN_NONE)
            continue;
        const gn_result result = gn_scene_add_node(import->scene, &desc, NULL);
        if (result != GN_OK)
            return gn_assimp_refail(import, result);
    }
    return GN_OK;
}

static gn_result read_node(gn_assimp *import, const struct aiNode *source, uint32_t parent,
                           uint32_t *index)
{
    const char *name = source->mName.data;
    double rate = 25;
    const struct aiNodeAnim *animation = find_animation(import->source, name, &rate);
    gn_node_desc desc = gn_node_desc_default();
    desc.name = name;
    desc.parent = parent;
    set_transform(&desc, &source->mTransformation, animation != NULL);
    if (source->mNumMeshes > 0)
        desc.mesh = import->meshes[source->mMeshes[0]];
    const gn_result result = gn_scene_add_node(import->scene, &desc, index);
    if (result != GN_OK)
        return gn_assimp_refail(import, result);
    GN_TRY(add_meshes(import, source, *index, 1));
    if (animation)
        GN_TRY(add_animation(import, animation, rate, *index));
    for (uint32_t i = 0; i < import->source->mNumLights; i++) {
        if (strcmp(import->source->mLights[i]->mName.data, name) == 0)
            GN_TRY(add_light(import, import->source->mLights[i], *index));
    }
    for (uint32_t i = 0; i < import->source->mNumCameras; i++) {
        if (strcmp(import->source->mCameras[i]->mName.data, name) == 0)
            GN_TRY(add_camera(import, import->source->mCameras[i], *index));
    }
    return GN_OK;
}

typedef struct pending_node {
    const struct aiNode *source;
    uint32_t parent;
} pending_node;

static bool push_children(gn_assimp *import, const struct aiNode *source, uint32_t parent,
                          pending_node **stack, uint32_t *count, uint32_t *capacity)
{
    for (uint32_t i = source->mNumChildren; i-- > 0;) {
        if (!gn_grow(import->context, (void **)stack, *count, capacity, sizeof **stack))
            return false;
        (*stack)[(*count)++] = (pending_node){source->mChildren[i], parent};
    }
    return true;
}

gn_result gn_assimp_read_nodes(gn_assimp *import)
{
    pending_node *stack = NULL, next = {import->source->mRootNode, GN_NONE};
    uint32_t count = 0, capacity = 0;
    gn_result result = GN_OK;
    for (;;) {
        uint32_t index = GN_NONE;
        result = read_node(import, next.source, next.parent, &index);
        if (result == GN_OK &&
            !push_children(import, next.source, index, &stack, &count, &capacity))
            result = gn_assimp_fail(import, GN_ERROR_OUT_OF_MEMORY, "out of memory");
        if (result != GN_OK || count == 0)
            break;
        next = stack[--count];
    }
    gn_free(import->context, stack);
    return result;
}
