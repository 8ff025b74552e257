/* What methods keep from frame to frame. */
#ifndef GN_RENDER_HISTORY_H
#define GN_RENDER_HISTORY_H

#include "cpu/leak.h"

/* Frames. A frame of the history is one picture: its number, from 1, means nothing but before and
 * after. It begins when gn_history_reserve_map() is called for a light that was already asked for
 * in the frame at hand, or with gn_history_begin_frame(). */

/* One light's share. */
typedef struct gn_history_entry {
    uint32_t light;
    gn_map_format format;
    gn_map_desc desc;
    gn_shadow_map *map; /* NULL: it could not be made */
    uint64_t asked;     /* frame of the last call for its map; 0: none */
    uint64_t masked;    /* frame of its newest mask; 0: none */
    uint32_t slot;      /* where masked: its bits are 3 * slot and the next two */
    uint32_t side;      /* where masked: the texture that its newest mask is in */
} gn_history_entry;

/* One light's light buffer. */
typedef struct gn_history_buffer {
    uint32_t light;
    struct gn_light_buffer *buffer;
} gn_history_buffer;

/* What tells one scene from another, at any time of its animation. */
typedef struct gn_fingerprint {
    uint64_t nodes, meshes, materials, lights, cameras, vertices, triangles;
    uint64_t digest; /* of sizes and bounds of meshes, nodes as they were added, alpha tests */
} gn_fingerprint;

gn_fingerprint gn_fingerprint_make(const gn_scene *scene);

/* Only history.c and history_file.c look inside. */
struct gn_history {
    gn_device *device;
    uint64_t scene, structure; /* the scene's number, 0: none yet; its structure_version */
    gn_fingerprint fingerprint;
    char *note; /* the caller's; NULL: none */
    uint64_t frame;
    gn_history_entry *entries;
    uint32_t count, capacity;
    gn_history_buffer *buffers;
    uint32_t buffer_count, buffer_capacity;
    /* What belongs to the picture. Lights turn from one mask texture to the other by themselves:
     * their bits have nothing to do with each other. */
    uint32_t width, height, camera;
    uint32_t texel_bytes; /* 0: no masks yet */
    uint8_t *masks[2];
    float *depth[2];
    uint64_t depth_frame[2]; /* 0: none */
};

/* Tells the history what scene it is of. Another one has nothing in common with it: all is
 * forgotten. One that got nodes or meshes is a cut. */
gn_result gn_history_use_scene(gn_history *history, const gn_scene *scene);

/* Ends the frame at hand: lights that are asked for from now on belong to the next one, and a mask
 * that nobody asked for meanwhile is too old. */
void gn_history_begin_frame(gn_history *history);

/* The map of a light for a format and settings, made or kept; the history owns it. */
gn_result gn_history_reserve_map(gn_history *history, const gn_scene *scene, uint32_t light,
                                 const gn_map_format *format, const gn_map_desc *desc,
                                 gn_shadow_map **map);

/* The light buffer of a light, made or kept; the history owns it. *others: bytes that those of
 * other lights take. */
gn_result gn_history_reserve_light_buffer(gn_history *history, const gn_scene *scene,
                                          uint32_t light, struct gn_light_buffer **buffer,
                                          size_t *others);

/* Replaces what a history holds by what another one does, which is destroyed. */
void gn_history_take(gn_history *history, gn_history **from);

/* Most lights with a mask: 3 bits each in 128. */
#define GN_MAX_MASKS 42u

/* The mask of a light for the frame at hand, after gn_history_reserve_map() for it. A frame begins
 * when a light comes round again. `before` is NULL in the first frame, after a cut, a change of
 * camera or of the picture's size, and where the light was not asked for in the frame before;
 * `depth_before` then is NULL too. keep_depth: the G-buffer's depth is needed in the next frame.
 * After it the caller writes the light's 3 bits of every pixel, or calls gn_history_cut(). */
gn_result gn_history_begin_mask(gn_history *history, uint32_t light, uint32_t camera,
                                const gn_gbuffer *gbuffer, bool keep_depth, gn_leak_mask *mask);

#endif
