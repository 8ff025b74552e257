/* A binary glTF file while it is put together, private to src/scene/glb_*.c.
 *
 * The JSON is built first, and with it a list of what the binary chunk holds; the chunk itself is
 * then written piece by piece, straight from the scene's own arrays. */
#ifndef GN_SCENE_GLB_H
#define GN_SCENE_GLB_H

#include <cjson/cJSON.h>

#include "output/output.h"
#include "scene/scene.h"

/* The top-level arrays of the file. */
typedef enum gn_glb_array {
    GN_GLB_ACCESSORS,
    GN_GLB_ANIMATIONS,
    GN_GLB_VIEWS,
    GN_GLB_CAMERAS,
    GN_GLB_IMAGES,
    GN_GLB_LIGHTS,
    GN_GLB_MATERIALS,
    GN_GLB_MESHES,
    GN_GLB_NODES,
    GN_GLB_SAMPLERS,
    GN_GLB_TEXTURES,
    GN_GLB_ARRAYS
} gn_glb_array;

/* How the file's bytes come from a piece's data. */
typedef enum gn_glb_form {
    GN_GLB_PLAIN,
    GN_GLB_SHORTENED,   /* from 32 to 16 bits */
    GN_GLB_UNIT_LENGTH, /* normals */
    GN_GLB_ZERO         /* there is no data */
} gn_glb_form;

/* A piece of the binary chunk: count elements of size bytes as they will be in the file. */
typedef struct gn_glb_piece {
    gn_glb_form form;
    const void *data;
    uint64_t count, size;
} gn_glb_piece;

typedef struct gn_glb {
    const gn_scene *scene;
    gn_context *context;
    const char *path;
    cJSON *root, *arrays[GN_GLB_ARRAYS];
    uint32_t counts[GN_GLB_ARRAYS];
    cJSON **nodes;        /* of each of the scene's nodes */
    cJSON *roots;         /* node indices of the file's scene */
    uint32_t *lookup;     /* file's texture for each scene texture and pair of wrap modes */
    void **pngs;          /* of each scene texture, from spng */
    gn_glb_piece *pieces; /* as long as views */
    uint32_t piece_capacity;
    uint64_t size;      /* of the binary chunk */
    bool out_of_memory; /* checked once, before the file is written */
} gn_glb;

/* JSON: item belongs to the list or object, and is returned; NULL without memory. */
cJSON *gn_glb_append(gn_glb *w, cJSON *list, cJSON *item);
cJSON *gn_glb_put(gn_glb *w, cJSON *object, const char *key, cJSON *item);
void gn_glb_put_number(gn_glb *w, cJSON *object, const char *key, double value);
void gn_glb_put_name(gn_glb *w, cJSON *object, const char *name); /* unless it is empty */
void gn_glb_put_floats(gn_glb *w, cJSON *object, const char *key, const float *values, int count);

/* Adds an object to one of the top-level arrays; index may be NULL. */
cJSON *gn_glb_add(gn_glb *w, gn_glb_array kind, uint32_t *index);
/* Notes a piece of the binary chunk and gives the number of its buffer view; target may be 0. */
uint32_t gn_glb_add_view(gn_glb *w, gn_glb_piece new_piece, int target);

/* Encodes the scene's textures (glb_image.c). */
gn_result gn_glb_add_images(gn_glb *w);

/* Hangs the filled arrays on the root. */
void gn_glb_assemble(gn_glb *w);
gn_result gn_glb_write_file(gn_glb *w, gn_file *file, const char *json);

#endif
