/* Shadow maps: what a light sees, kept from frame to frame.
 *
 * A map has layers: the cascades of a directional light, one view of a spot light, six faces around
 * a point light. gn_scene_visibility() makes and keeps maps by itself; this header has their
 * settings, and functions to hold and inspect one directly. */
#ifndef GNOMON_SHADOW_MAP_H
#define GNOMON_SHADOW_MAP_H

#include <gnomon/method.h>
#include <gnomon/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GN_MAX_CASCADES 8u

/* How a texel is chosen from a place between texels. */
typedef enum gn_map_reading {
    GN_READING_AUTO = 0, /* BLUE_NOISE for NLMSM, NEAREST for DEPTH, BILINEAR for others */
    GN_READING_NEAREST = 1,
    GN_READING_WHITE_NOISE = 2, /* one texel, chosen by an even random number */
    GN_READING_BLUE_NOISE = 3,  /* one texel, chosen by blue noise (moment paper, section 4.2) */
    GN_READING_BILINEAR = 4     /* four: their vectors are blended where the format is linear, their
                                   visibilities for NLMSM and DEPTH */
} gn_map_reading;

/* What an alpha-tested occluder does to a texel of depth. */
typedef enum gn_map_alpha {
    GN_MAP_ALPHA_TEST = 0,   /* test at the mip of the texel's footprint; mips keep their share of
                                passing texels */
    GN_MAP_ALPHA_MIP0 = 1,   /* test in mip 0, as GN_ALPHA_RULE_MIP0 */
    GN_MAP_ALPHA_HASHED = 2, /* test against a hash of the place (Wyman and McGuire 2017) */
    GN_MAP_ALPHA_OPAQUE = 3  /* no test */
} gn_map_alpha;

/* Made by gn_map_desc_default(). */
typedef struct gn_map_desc {
    uint32_t cookie;
    uint32_t resolution;    /* texels a side, [16, 16384], default 2048 */
    uint32_t samples;       /* depths a texel, 1 or 4, default 1; more than 1 only where they are
                               filtered (not DEPTH, PCF, single_depth: those take 1) */
    gn_map_alpha alpha;     /* default GN_MAP_ALPHA_TEST */
    uint32_t cascades;      /* directional lights: [1, 8], default 4 */
    float distance;         /* directional lights: metres from the camera up to which the cascades
                               reach, >= 0, default 0: to the end of what is seen of the scene */
    float split_weight;     /* [0, 1]: cascades split evenly (0) to logarithmically (1); evenly for
                               orthographic cameras. < 0 (default): 0.85, in leak tracing 0.95 */
    uint32_t split_count;   /* 0 (default): by split_weight; else == cascades */
    float splits[8];        /* far end of each cascade as a share of distance, (0, 1], increasing,
                               the last 1 */
    uint32_t undrawn;       /* directional lights: so many cascades at the far end are left out, [0,
                               cascades]; what lies there is lit, or gets a ray (leak tracing).
                               GN_NONE (default): 0; in leak tracing 1 of 2 or more cascades */
    float enlarge;          /* [0, 1], default 0.15: share by which a cascade is made larger than
                               its need, so that it can be reused as the camera moves */
    uint32_t filter_width;  /* texels, odd, [1, 33], default 9; 1: no filter */
    float filter_sigma;     /* texels, (0, 16], default 2.4 */
    bool mip_maps;          /* default false; linear formats only (not NLMSM, not plain depth) */
    gn_map_reading reading; /* default GN_READING_AUTO */
    float depth_bias;       /* subtracted from the receiver's depth, in parts of the layer's depth
                               range, [0, 0.1]; < 0 (default): the format's own */
    float normal_bias;      /* the receiver is moved along its normal by so many texels of its
                               layer, times the sine of the angle between normal and the layer's
                               axis, [0, 16]; < 0 (default): the format's own, in leak tracing 0
                               (a map that doubts itself at a slope gets a ray) */
    float minimum_variance; /* VSM, EVSM: >= 0; < 0 (default): 1e-10 (leak tracing paper), or what
                               the format's rounding needs */
    float moment_bias;      /* MSM, NLMSM: [0, 1]; < 0 (default): 6e-5 at 64 bits, 3e-7 at 128 and
                               for NLMSM (moment paper, section 3.2) */
    uint32_t refresh;       /* updates over which a layer that is placed anew is drawn, [1, 64]; 0
                               (default): 1, at once; in leak tracing 8. More than 1: an old layer
                               stays in use until the new one is whole, and what no layer holds is
                               lit, or gets a ray (leak tracing) */
    uint32_t seed;          /* of the noise, default 0 */
} gn_map_desc;

GN_API gn_map_desc gn_map_desc_default(void);

/* Thread-safety: updates by one thread at a time; reads of an updated map from any number. */
typedef struct gn_shadow_map gn_shadow_map;

/* Refuses a format or a value out of its range, with the range in the message. */
GN_API gn_result gn_shadow_map_create(gn_device *device, const gn_map_format *format,
                                      const gn_map_desc *desc, gn_shadow_map **map);
GN_API void gn_shadow_map_destroy(gn_shadow_map **map);

/* What an update did. */
typedef struct gn_map_update {
    uint32_t fitted;            /* layers that were placed anew; the others were reused */
    uint32_t pending;           /* layers of which a part was drawn that are not in use yet */
    uint32_t filtered;          /* layers whose texels were made again */
    double depth_ms, filter_ms; /* rasterization; resolve, filter and quantization */
} gn_map_update;

/* Brings the map up to date with a committed scene, one of its lights, and a camera whose picture
 * has the given aspect (width / height); camera and aspect matter to directional lights alone.
 * Layers that still hold what the camera sees are kept; static casters are drawn only into layers
 * that were placed anew, moving ones whenever something moved. update may be NULL. After an error
 * the map is empty until an update succeeds. */
GN_API gn_result gn_shadow_map_update(gn_shadow_map *map, const gn_scene *scene, uint32_t light,
                                      uint32_t camera, float aspect, gn_map_update *update);

/* Forgets all layers: the next update places and draws them anew. */
GN_API void gn_shadow_map_reset(gn_shadow_map *map);

/* One layer, for pictures and reports. A point p of the world lies at
 *   x = dot(p - origin, right), y = dot(p - origin, up), w = dot(p - origin, forward),
 * divided by w where perspective; texel column (x / extent + 1) / 2 * resolution, row
 * (1 - y / extent) / 2 * resolution, depth (w - near) / (far - near). */
typedef struct gn_map_layer_info {
    float origin[3], right[3], up[3], forward[3]; /* metres; unit vectors at right angles */
    bool perspective;
    float extent;    /* half the width: metres, or the tangent of half the angle */
    float near, far; /* metres from the origin along forward */
    uint32_t resolution, samples;
    const float *depth;         /* of static casters: samples planes of resolution^2, each depth in
                                   [0, 1], 1 where there is nothing; owned by the map */
    const float *dynamic_depth; /* of moving ones, or NULL */
} gn_map_layer_info;

/* Layers that are drawn: with gn_map_desc.refresh more than 1, none of them may be at first. */
GN_API uint32_t gn_shadow_map_layer_count(const gn_shadow_map *map);
/* layer < gn_shadow_map_layer_count(), else all zero. */
GN_API gn_map_layer_info gn_shadow_map_layer(const gn_shadow_map *map, uint32_t layer);
/* Bytes of texels and depths, all layers. */
GN_API size_t gn_shadow_map_bytes(const gn_shadow_map *map);

/* xi4, the offset of the fourth moment (moment paper, section 3.2), of every texel of a layer of an
 * NLMSM map into resolution^2 floats, as it is read back. Others are refused. */
GN_API gn_result gn_shadow_map_xi4(const gn_shadow_map *map, uint32_t layer, float *xi4);

#ifdef __cplusplus
}
#endif

#endif
