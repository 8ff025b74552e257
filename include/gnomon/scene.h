/* Scenes: what is seen, what casts shadows, and what lights it.
 *
 * A scene follows glTF 2.0: +Y up, right handed, metres, counter-clockwise front faces, cameras and
 * lights look along their node's -Z, texture coordinates have (0,0) in the upper left corner.
 *
 * Edit, commit, query: after gn_scene_commit() any number of threads may render the scene; editing
 * it again needs another commit. Every add function copies its data and validates it; what is
 * returned is an index, counted from 0 in the order of the calls. */
#ifndef GNOMON_SCENE_H
#define GNOMON_SCENE_H

#include <stdbool.h>
#include <gnomon/device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Thread-safety: edits by one thread at a time; queries of a committed scene from any number. */
typedef struct gn_scene gn_scene;

/* Limits, checked when a scene is edited. */
#define GN_MAX_TEXTURE_SIZE 16384u

typedef enum gn_wrap { GN_WRAP_REPEAT = 0, GN_WRAP_CLAMP = 1, GN_WRAP_MIRROR = 2 } gn_wrap;

/* How the alpha channel of the base colour is read. */
typedef enum gn_alpha_mode {
    GN_ALPHA_OPAQUE = 0,
    GN_ALPHA_MASK = 1, /* a surface where alpha >= alpha_cutoff, nothing elsewhere */
    GN_ALPHA_BLEND = 2 /* as an occluder: lets 1 - alpha of the light through */
} gn_alpha_mode;

typedef enum gn_light_type {
    GN_LIGHT_DIRECTIONAL = 0,
    GN_LIGHT_POINT = 1,
    GN_LIGHT_SPOT = 2
} gn_light_type;

typedef enum gn_interpolation {
    GN_INTERPOLATION_STEP = 0,
    GN_INTERPOLATION_LINEAR = 1, /* rotations: spherical */
    GN_INTERPOLATION_CUBICSPLINE = 2
} gn_interpolation;

typedef enum gn_animation_path {
    GN_PATH_TRANSLATION = 0, /* 3 values a key */
    GN_PATH_ROTATION = 1,    /* 4: quaternion x y z w */
    GN_PATH_SCALE = 2        /* 3 */
} gn_animation_path;

/* An 8-bit RGBA image, rows from top to bottom. Colour is sRGB, alpha is linear. */
typedef struct gn_texture_desc {
    uint32_t cookie;
    const char *name;       /* for messages; may be NULL */
    uint32_t width, height; /* texels, [1, GN_MAX_TEXTURE_SIZE] */
    const uint8_t *rgba;    /* width * height * 4 bytes */
} gn_texture_desc;

/* Texture coordinates are transformed by uv' = (m[0] u + m[1] v + m[2], m[3] u + m[4] v + m[5])
 * (KHR_texture_transform) before wrapping. */
typedef struct gn_material_desc {
    uint32_t cookie;
    const char *name;
    float base_color[4]; /* linear RGB and alpha, [0,1], default 1; multiplies the texture */
    uint32_t texture;    /* index, default GN_NONE */
    gn_wrap wrap_u, wrap_v;
    float uv_transform[6];    /* default identity */
    gn_alpha_mode alpha_mode; /* default GN_ALPHA_OPAQUE */
    float alpha_cutoff;       /* [0,1], default 0.5; for GN_ALPHA_MASK */
    bool double_sided;        /* default false: camera rays pass through back faces */
} gn_material_desc;

/* Triangles of one material. */
typedef struct gn_mesh_part {
    uint32_t vertex_count;   /* >= 3 */
    const float *positions;  /* vertex_count * 3, finite */
    const float *normals;    /* vertex_count * 3, or NULL: flat shading */
    const float *uvs;        /* vertex_count * 2, or NULL: all zero; clamped to +-1e6 */
    uint32_t index_count;    /* a multiple of 3, >= 3 */
    const uint32_t *indices; /* index_count, each < vertex_count */
    uint32_t material;       /* index, or GN_NONE: white, opaque, double sided */
} gn_mesh_part;

/* A node's local transform: translation * rotation * scale, or matrix where use_matrix is set. */
typedef struct gn_node_desc {
    uint32_t cookie;
    const char *name;
    uint32_t parent;      /* index of an earlier node, or GN_NONE (default): the root */
    float translation[3]; /* default 0 */
    float rotation[4];    /* quaternion x y z w, default 0 0 0 1; normalised on entry */
    float scale[3];       /* default 1 */
    bool use_matrix;      /* default false */
    float matrix[16];     /* column major, affine; default identity */
    uint32_t mesh;        /* index, or GN_NONE (default) */
    uint32_t light;       /* index, or GN_NONE (default); a light hangs on one node at most */
    uint32_t camera;      /* index, or GN_NONE (default); likewise */
} gn_node_desc;

/* KHR_lights_punctual. */
typedef struct gn_light_desc {
    uint32_t cookie;
    const char *name;
    gn_light_type type;     /* default GN_LIGHT_DIRECTIONAL */
    float color[3];         /* linear, >= 0, default 1 */
    float intensity;        /* >= 0, default 1: lux (directional) or candela, relative */
    float range;            /* metres, > 0; default INFINITY; point and spot */
    float inner_cone_angle; /* radians, [0, outer), default 0; spot */
    float outer_cone_angle; /* radians, (inner, pi/2], default pi/4; spot */
    bool on;                /* default true: part of "all lights" */
} gn_light_desc;

typedef struct gn_camera_desc {
    uint32_t cookie;
    const char *name;
    bool orthographic; /* default false */
    float yfov;        /* radians, (0, pi), default pi/3; perspective */
    float ymag;        /* metres, half the height of the view, > 0, default 1; orthographic */
    float znear;       /* metres, >= 0, default 0.1: nothing nearer is seen */
} gn_camera_desc;

/* Keys of one animated property of one node. Times are in seconds, >= 0, strictly increasing.
 * Before the first and after the last key the value is that key's. For cubic splines each key has
 * three elements: in-tangent, value, out-tangent. */
typedef struct gn_channel_desc {
    uint32_t cookie;
    uint32_t node;
    gn_animation_path path;
    gn_interpolation interpolation; /* default GN_INTERPOLATION_LINEAR */
    uint32_t key_count;             /* >= 1 */
    const float *times;             /* key_count */
    const float *values;            /* key_count * components * (3 for cubic splines, else 1) */
} gn_channel_desc;

GN_API gn_texture_desc gn_texture_desc_default(void);
GN_API gn_material_desc gn_material_desc_default(void);
GN_API gn_node_desc gn_node_desc_default(void);
GN_API gn_light_desc gn_light_desc_default(void);
GN_API gn_camera_desc gn_camera_desc_default(void);
GN_API gn_channel_desc gn_channel_desc_default(void);

GN_API gn_result gn_scene_create(gn_device *device, gn_scene **scene);
GN_API void gn_scene_destroy(gn_scene **scene);

/* Reads a file into a new scene: .gltf and .glb by our own strict reader, everything else through
 * Assimp. The scene is committed at time 0. After an error *scene is NULL. */
GN_API gn_result gn_scene_load(gn_device *device, const char *path, gn_scene **scene);

/* Adds one thing; *index may be NULL. On an error the scene is unchanged. */
GN_API gn_result gn_scene_add_texture(gn_scene *scene, const gn_texture_desc *desc,
                                      uint32_t *index);
GN_API gn_result gn_scene_add_material(gn_scene *scene, const gn_material_desc *desc,
                                       uint32_t *index);
/* Triangles with a vertex that is not finite are refused; degenerate ones are kept and never hit.*/
GN_API gn_result gn_scene_add_mesh(gn_scene *scene, const char *name, const gn_mesh_part *parts,
                                   uint32_t part_count, uint32_t *index);
GN_API gn_result gn_scene_add_light(gn_scene *scene, const gn_light_desc *desc, uint32_t *index);
GN_API gn_result gn_scene_add_camera(gn_scene *scene, const gn_camera_desc *desc, uint32_t *index);
GN_API gn_result gn_scene_add_node(gn_scene *scene, const gn_node_desc *desc, uint32_t *index);
GN_API gn_result gn_scene_add_channel(gn_scene *scene, const gn_channel_desc *desc);

/* Replaces a node's local transform (for engines that animate by themselves). matrix: column
 * major, affine, finite. Such a node counts as moving from then on. */
GN_API gn_result gn_scene_set_node_matrix(gn_scene *scene, uint32_t node, const float matrix[16]);

/* Puts every animated node where it is at time seconds. Takes effect at the next commit. */
GN_API gn_result gn_scene_set_time(gn_scene *scene, double seconds);

/* Makes all edits visible to queries. The cost follows what changed: a moved node updates one
 * instance, not the scene. */
GN_API gn_result gn_scene_commit(gn_scene *scene);

/* Counts, for reports. Triangles: unique and with instancing, the share of MASK and BLEND ones. */
typedef struct gn_scene_info {
    uint32_t nodes, mesh_nodes, meshes, materials, masked_materials, textures, lights, cameras;
    uint32_t channels;
    uint64_t triangles, instanced_triangles;
    uint64_t masked_triangles, instanced_masked_triangles;
    double duration; /* seconds, the last key of any channel; 0 without animation */
    float bounds_min[3], bounds_max[3]; /* world space, of the committed state */
    uint32_t warning_count;             /* what the file has that gnomon leaves out */
} gn_scene_info;

GN_API gn_scene_info gn_scene_get_info(const gn_scene *scene);
/* index < warning_count; owned by the scene. */
GN_API const char *gn_scene_warning(const gn_scene *scene, uint32_t index);

/* Names, "" where there is none, and a search that returns GN_NONE where nothing has that name. */
GN_API const char *gn_scene_camera_name(const gn_scene *scene, uint32_t camera);
GN_API const char *gn_scene_light_name(const gn_scene *scene, uint32_t light);
GN_API uint32_t gn_scene_find_camera(const gn_scene *scene, const char *name);
GN_API uint32_t gn_scene_find_light(const gn_scene *scene, const char *name);
GN_API gn_light_desc gn_scene_get_light(const gn_scene *scene, uint32_t light);

/* A sun: a directional light from azimuth (degrees, clockwise from -Z seen from above) and
 * elevation (degrees above the horizon, [-90,90]). */
GN_API gn_result gn_scene_add_sun(gn_scene *scene, double azimuth, double elevation,
                                  uint32_t *light);
/* A camera that shows the whole scene from a little above. Commit the scene first, and after. */
GN_API gn_result gn_scene_add_overview(gn_scene *scene, uint32_t *camera);

#ifdef __cplusplus
}
#endif

#endif
