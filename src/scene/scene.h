/* The scene as the devices and the renderer see it. Only scene.c and the importers write it. */
#ifndef GN_SCENE_SCENE_H
#define GN_SCENE_SCENE_H

#include <gnomon/scene.h>

#include "base/base.h"

/* Colour with its mip chain: level 0 first, each level half the size of the one before, rounded
 * down, at least 1; rows from top to bottom. */
#define GN_MAX_LEVELS 15 /* 16384 and all below */

typedef struct gn_texture {
    char *name;
    uint32_t width, height, levels;
    uint8_t *rgba[GN_MAX_LEVELS]; /* level sizes: gn_level_size(); one allocation, at rgba[0] */
} gn_texture;

static inline uint32_t gn_level_size(uint32_t size, uint32_t level)
{
    return size >> level > 0 ? size >> level : 1;
}

/* Levels down to 1x1, that one included. */
static inline uint32_t gn_level_count(uint32_t width, uint32_t height)
{
    uint32_t levels = 1;
    for (uint32_t size = width > height ? width : height; size > 1; size >>= 1)
        levels++;
    return levels;
}

/* Texels of a whole chain. */
static inline size_t gn_chain_texels(uint32_t width, uint32_t height)
{
    size_t texels = 0;
    for (uint32_t level = 0; level < gn_level_count(width, height); level++)
        texels += (size_t)gn_level_size(width, level) * gn_level_size(height, level);
    return texels;
}

/* What a MASK or BLEND material lets through: its alpha alone, times base_color[3]. Chains may
 * share levels (BLEND: all three are one). One allocation, at averaged[0], 64 bytes longer than
 * its texels: wide loads may read past the last. */
typedef struct gn_alpha_map {
    uint32_t width, height, levels;   /* levels 0: no map, since every texel is opaque */
    uint8_t *averaged[GN_MAX_LEVELS]; /* plain box averages; level 0 is the texture's alpha */
    uint8_t *rescaled[GN_MAX_LEVELS]; /* R11: share of texels >= cutoff as in level 0 */
    uint8_t *coverage[GN_MAX_LEVELS]; /* share of the texel's footprint where the test passes */
} gn_alpha_map;

typedef struct gn_material {
    char *name;
    gn_material_desc desc; /* name and cookie cleared */
    gn_alpha_map alpha;    /* where masked; 1x1 without a texture */
    bool masked;           /* MASK or BLEND, and not wholly opaque */
} gn_material;

/* One glTF primitive. */
typedef struct gn_part {
    uint32_t vertex_count, triangle_count;
    float *positions;  /* 3 a vertex, padded by 16 bytes (Embree reads past the last) */
    float *normals;    /* 3 a vertex, or NULL */
    float *uvs;        /* 2 a vertex, or NULL; the material's transform is already applied */
    uint32_t *indices; /* 3 a triangle */
    uint32_t material; /* always valid: GN_NONE was replaced by the scene's default_material */
} gn_part;

typedef struct gn_mesh {
    char *name;
    gn_part *parts;
    uint32_t part_count;
    float bounds_min[3], bounds_max[3];
} gn_mesh;

typedef struct gn_node {
    char *name;
    gn_node_desc desc; /* as added; name and cookie cleared */
    bool animated;     /* it or (as of the last commit) an ancestor has a channel or was moved by
                          set_node_matrix */
    uint32_t paths;    /* bit gn_animation_path: has a channel */
    float translation[3], rotation[4], scale[3]; /* desc's, or its channels' at the scene's time */
    float local[16];                             /* as of the last set_time / set_node_matrix */
    float world[16];                             /* as of the last commit; column major, affine */
} gn_node;

typedef struct gn_channel {
    gn_channel_desc desc; /* times and values owned */
} gn_channel;

typedef struct gn_light {
    char *name;
    gn_light_desc desc;
    uint32_t node;                   /* GN_NONE: the root */
    float position[3], direction[3]; /* world, as of the last commit; direction: of the light's
                                        travel, unit length */
} gn_light;

typedef struct gn_camera {
    char *name;
    gn_camera_desc desc;
    uint32_t node;
    float world[16]; /* orthonormal: scale removed, as glTF asks */
} gn_camera;

struct gn_scene {
    gn_device *device;
    gn_context *context;
    uint64_t number; /* of the device's scenes, from 1: addresses come back, numbers do not */
    gn_texture *textures;
    gn_material *materials;
    gn_mesh *meshes;
    gn_node *nodes;
    gn_channel *channels;
    gn_light *lights;
    gn_camera *cameras;
    char **warnings;
    uint32_t default_material; /* the last of materials, made for parts without one; or GN_NONE */
    uint32_t texture_count, texture_capacity;
    uint32_t material_count, material_capacity;
    uint32_t mesh_count, mesh_capacity;
    uint32_t node_count, node_capacity;
    uint32_t channel_count, channel_capacity;
    uint32_t light_count, light_capacity;
    uint32_t camera_count, camera_capacity;
    uint32_t warning_count, warning_capacity;

    double time;
    uint64_t edits, committed;  /* equal: nothing to commit */
    uint64_t structure_version; /* grows when nodes, meshes or materials are added */
    uint64_t transform_version; /* grows when a commit moved a node */
    float bounds_min[3], bounds_max[3];

    /* The device's acceleration structures for this scene, made at the first commit. */
    void *accel;
    uint64_t accel_number; /* grows when they are built anew */
    void (*accel_destroy)(void *accel);
};

/* Resolves hierarchy, lights, cameras and bounds. Device-independent half of gn_scene_commit(),
 * which sets `committed`. Bounds hold the instances' transformed boxes; zero without meshes. */
gn_result gn_scene_resolve(gn_scene *scene);

void gn_mesh_free(gn_context *context, gn_mesh *mesh);
/* "leaf 3" or "leaf 3 \"oak\"", for messages. */
typedef struct gn_label {
    char text[288];
} gn_label;
gn_label gn_make_label(const char *kind, uint32_t index, const char *name);
/* False for NaN and infinity in any of count values. */
bool gn_all_finite(const float *values, size_t count);
/* Element-wise, column major: translation * rotation * scale. */
void gn_compose(const float translation[3], const float rotation[4], const float scale[3],
                float matrix[16]);

/* Notes that a file has something which gnomon leaves out. Equal warnings are kept once. */
void gn_scene_warn(gn_scene *scene, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Fills all three chains of map for the alpha of a texture (NULL: 1x1 of 1), as a MASK or BLEND
 * material of this descriptor sees it: times base_color[3], tested with alpha_cutoff, wrapped.
 * Every texel opaque: map is all zero. */
gn_result gn_alpha_map_build(gn_context *context, const gn_texture *texture,
                             const gn_material_desc *desc, gn_alpha_map *map);
void gn_alpha_map_free(gn_context *context, gn_alpha_map *map);

/* The smallest and the largest stored value of a level in the texels [x0, x1] x [y0, y1], wrapped.
 */
typedef struct gn_texel_range {
    uint8_t min, max;
} gn_texel_range;
gn_texel_range gn_alpha_range(const uint8_t *level, uint32_t width, uint32_t height, gn_wrap wrap_u,
                              gn_wrap wrap_v, int64_t x0, int64_t y0, int64_t x1, int64_t y1);

/* The smallest 8-bit alpha that passes a cutoff in [0,1]: value / 255 >= cutoff. */
uint32_t gn_alpha_threshold(float cutoff);

/* Fills levels and rgba[1..] of a texture whose width, height and rgba[0] are set; rgba[0] has room
 * for gn_chain_texels() texels. Box filter; colour is averaged in linear light, weighted by alpha.
 */
gn_result gn_texture_build_mips(gn_context *context, gn_texture *texture);

/* Importers: fill an empty scene; it is neither resolved nor committed. */
gn_result gn_import_gltf(gn_scene *scene, const char *path);
gn_result gn_import_assimp(gn_scene *scene, const char *path);
/* The same reader on memory, for fuzzing: .glb or .gltf text whose URIs are data: only. */
gn_result gn_import_gltf_memory(gn_scene *scene, const void *data, size_t size);

/* Decodes PNG, JPEG or WebP, told apart by their first bytes, to RGBA8. name is for messages.
 * *pixels is freed with gn_free(). */
gn_result gn_image_decode(gn_context *context, const char *name, const void *data, size_t size,
                          uint32_t *width, uint32_t *height, uint8_t **pixels);

#endif
