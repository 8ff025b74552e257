/* Scenes made by formula: deterministic, licence-free, of any size. */
#ifndef GNOMON_PROCEDURAL_H
#define GNOMON_PROCEDURAL_H

#include <gnomon/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Made by gn_procedural_desc_default(). */
typedef struct gn_procedural_desc {
    uint32_t cookie;
    uint32_t seed; /* default 1; the same seed gives the same bytes */
    double scale;  /* [0.001, 1000], default 1: multiplies the number of instanced triangles */
    double unit;   /* [1e-6, 1e6], default 1: multiplies every length */
} gn_procedural_desc;

typedef struct gn_procedural {
    const char *name, *description;
} gn_procedural;

/* All of them, ending with a NULL name: grove, railing, leafbox, court, edges. */
GN_API extern const gn_procedural gn_procedurals[];

GN_API gn_procedural_desc gn_procedural_desc_default(void);

/* Makes the named scene, committed at time 0. desc may be NULL. */
GN_API gn_result gn_scene_create_procedural(gn_device *device, const char *name,
                                            const gn_procedural_desc *desc, gn_scene **scene);

/* Writes any scene as a valid .glb: meshes, instancing by nodes, materials, textures as PNG,
 * lights, cameras, animation. Never leaves half a file. */
GN_API gn_result gn_scene_write_glb(const gn_scene *scene, const char *path);

#ifdef __cplusplus
}
#endif

#endif
