/* The glTF 2.0 reader, private to src/scene/gltf*.c.
 *
 * Nothing in a file is trusted: every index, range and number is checked before it is used, with
 * 64-bit arithmetic, and no allocation is larger than what the file's own bytes account for. */
#ifndef GN_SCENE_GLTF_H
#define GN_SCENE_GLTF_H

#include <cjson/cJSON.h>

#include "scene/scene.h"

/* One top-level array of the file. cJSON keeps arrays as lists, so they are laid flat once. */
typedef struct gn_gltf_list {
    const char *noun; /* "accessor", for messages */
    const cJSON **items;
    uint32_t count;
} gn_gltf_list;

typedef struct gn_gltf_bytes {
    const uint8_t *data;
    uint64_t size;
    uint8_t *owned; /* gn_alloc()ed, or NULL where data lies in somebody else's memory */
} gn_gltf_bytes;

typedef struct gn_gltf {
    gn_context *context;
    gn_scene *scene;
    const char *file; /* for messages */
    bool external;    /* whether other files may be read, beside file */
    cJSON *root;
    gn_gltf_bytes chunk; /* BIN of a .glb; data is NULL where there is none */
    gn_gltf_list accessors, animations, buffers, views, cameras, images, lights, materials, meshes,
        nodes, samplers, scenes, skins, textures;
    gn_gltf_bytes *buffer_data; /* each buffer, loaded at first use */
    uint32_t *image_textures;   /* gn texture of each image, GN_NONE until used */
    uint32_t *mesh_indices;     /* gn mesh of each mesh, GN_NONE where it has no triangles */
    uint32_t *node_indices;     /* gn node of each node, GN_NONE outside the scene */
    uint8_t *node_paths;        /* bit p: path p of the node is animated by a channel already */
    char where[256];            /* what is being read, for messages: `mesh 3 "leaf"` */
} gn_gltf;

/* A view of an accessor's data, all of it inside its buffer. */
typedef struct gn_gltf_accessor {
    uint32_t index, count, components;
    uint32_t type; /* glTF componentType */
    bool normalized;
    const uint8_t *data; /* NULL: all zero */
    uint32_t stride;
    uint32_t sparse_count, sparse_type;
    const uint8_t *sparse_indices, *sparse_values;
} gn_gltf_accessor;

/* Which component types a use of an accessor allows. */
typedef enum gn_gltf_rule {
    GN_GLTF_FLOAT,      /* float only */
    GN_GLTF_NORMALIZED, /* float, or normalized 8 and 16 bit integers */
    GN_GLTF_QUANTIZED   /* also plain 8 and 16 bit integers (KHR_mesh_quantization) */
} gn_gltf_rule;

/* Messages: "FILE: WHERE: reason". */
gn_result gn_gltf_fail(gn_gltf *gltf, gn_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
gn_result gn_gltf_no_memory(gn_gltf *gltf);
/* Puts file and where before the message that a gn_scene_add function left. */
gn_result gn_gltf_refail(gn_gltf *gltf, gn_result result);
/* Sets where to `noun N "name"`, N being the item's place in its list. */
void gn_gltf_at(gn_gltf *gltf, const gn_gltf_list *list, uint32_t index);
/* The item's "name", "" if it has none. */
const char *gn_gltf_name(const cJSON *item);

/* JSON: each refuses a value of the wrong type; a missing one leaves *out as it is. */
gn_result gn_gltf_object(gn_gltf *gltf, const cJSON *parent, const char *key, const cJSON **out);
gn_result gn_gltf_array(gn_gltf *gltf, const cJSON *parent, const char *key, const cJSON **out);
gn_result gn_gltf_string(gn_gltf *gltf, const cJSON *parent, const char *key, const char **out);
gn_result gn_gltf_bool(gn_gltf *gltf, const cJSON *parent, const char *key, bool *out);
gn_result gn_gltf_float(gn_gltf *gltf, const cJSON *parent, const char *key, float *out);
gn_result gn_gltf_floats(gn_gltf *gltf, const cJSON *parent, const char *key, uint32_t count,
                         float *out);
gn_result gn_gltf_integer(gn_gltf *gltf, const cJSON *parent, const char *key, uint64_t *out);
/* An index into list. */
gn_result gn_gltf_index(gn_gltf *gltf, const cJSON *parent, const char *key,
                        const gn_gltf_list *list, uint32_t *out);
/* Lays an array of objects flat; list->items is gn_alloc()ed, also after an error. */
gn_result gn_gltf_make_list(gn_gltf *gltf, const cJSON *parent, const char *key, const char *noun,
                            gn_gltf_list *list);
/* The extension's object of an item, NULL if it has none. */
const cJSON *gn_gltf_extension(const cJSON *item, const char *name);

/* Bytes (gltf_buffers.c). uri: what the file calls path; NULL for the file itself. */
gn_result gn_gltf_read_file(gn_gltf *gltf, const char *path, const char *uri, gn_gltf_bytes *bytes);
gn_result gn_gltf_resolve_uri(gn_gltf *gltf, const char *uri, gn_gltf_bytes *bytes);
gn_result gn_gltf_view_bytes(gn_gltf *gltf, uint32_t view, gn_gltf_bytes *bytes);

/* Accessors (gltf_accessors.c). The read functions give gn_alloc()ed arrays. */
gn_result gn_gltf_open_accessor(gn_gltf *gltf, uint32_t index, gn_gltf_accessor *accessor);
gn_result gn_gltf_read_floats(gn_gltf *gltf, const gn_gltf_accessor *accessor, uint32_t components,
                              gn_gltf_rule rule, float **values);
gn_result gn_gltf_read_indices(gn_gltf *gltf, const gn_gltf_accessor *accessor,
                               uint32_t vertex_count, uint32_t **values);

/* Parts of the file, in the order in which they are read. */
gn_result gn_gltf_read_materials(gn_gltf *gltf);  /* gltf_material.c; fills image_textures */
gn_result gn_gltf_read_meshes(gn_gltf *gltf);     /* gltf_mesh.c; fills mesh_indices */
gn_result gn_gltf_read_nodes(gn_gltf *gltf);      /* gltf_node.c; fills node_indices */
gn_result gn_gltf_read_animations(gn_gltf *gltf); /* gltf_animation.c; fills node_paths */
/* The TEXCOORD set that a material's texture reads; GN_NONE where it has no texture. */
gn_result gn_gltf_material_uv_set(gn_gltf *gltf, uint32_t material, uint32_t *set);

#endif
