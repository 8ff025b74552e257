/* Views: a camera's picture of a scene, frame after frame.
 *
 * gn_view_render() does the whole frame: G-buffer, visibility of each light, shading. The same
 * passes can be called one by one, so that several methods share one G-buffer, or an engine brings
 * its own G-buffer and takes only visibility (gn_scene_visibility()). */
#ifndef GNOMON_VIEW_H
#define GNOMON_VIEW_H

#include <gnomon/method.h>
#include <gnomon/scene.h>
#include <gnomon/shadow_map.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What the camera sees, one value a pixel, rows from top to bottom, width * height floats a plane.
 * Sky pixels have surface GN_NONE, and zero elsewhere. */
typedef struct gn_gbuffer {
    uint32_t width, height;
    float *position[3];       /* world space */
    float *normal[3];         /* geometric, unit length, towards the camera */
    float *origin_error;      /* metres: how far the position may lie off its plane by rounding;
                                 shadow rays start that far along the normal. >= 0 */
    float *cone_width;        /* metres: ray cone width on the surface, after Hit (Equation 3) */
    float *shading_normal[3]; /* interpolated, unit length, towards the camera */
    float *motion[3];         /* where this surface point was one frame ago, minus where it is:
                                 pixels to the right, pixels down, metres of depth */
    float *depth;             /* metres along the camera's axis */
    uint32_t *albedo;         /* sRGB, 0xAABBGGRR */
    uint32_t *surface;        /* the same number for the same part of the same node */
} gn_gbuffer;

/* Milliseconds of the last frame, a pass. */
typedef struct gn_timings {
    double update, gbuffer, visibility, shade;
    double shadow_map, filter, test, trace; /* parts of visibility, all lights */
} gn_timings;

typedef struct gn_view_desc {
    uint32_t cookie;
    uint32_t width, height; /* pixels, [1, 16384], default 1920 x 1080 */
    uint32_t samples;       /* a pixel, [1, 4096], default 1; more: a supersampled reference, camera
                               jitter, geometry and all */
} gn_view_desc;

/* What a method remembers from frame to frame: the shadow maps of each light, and the masks of leak
 * tracing. A frame begins when a light comes round again, and with gn_view_render(). What belongs
 * to the picture is trusted only where it is of the frame just before; where it is not (the first
 * frame, a light that was left out, another size or camera, nodes that were added, a cut) the frame
 * is right all the same, and costs more rays.
 *
 * Thread-safety: one thread at a time. */
typedef struct gn_history gn_history;

GN_API gn_result gn_history_create(gn_device *device, gn_history **history);
GN_API void gn_history_destroy(gn_history **history);
/* Forgets everything. */
GN_API void gn_history_reset(gn_history *history);
/* A camera cut: forgets what belongs to the picture (masks, depth) and keeps the maps, which belong
 * to the world. A change of size or camera does the same by itself. */
GN_API void gn_history_cut(gn_history *history);
/* Forgets the maps and keeps the rest: the next frame places and draws them anew. */
GN_API void gn_history_reset_maps(gn_history *history);
/* Writes a history to a file, from which gn_history_load() makes one that goes on with the same
 * bits, for the same scene at the same time. Maps are written as places and drawn again. */
GN_API gn_result gn_history_save(const gn_history *history, const char *path);
/* Refuses files that are damaged or belong to another scene. After an error *history is NULL. */
GN_API gn_result gn_history_load(const gn_scene *scene, const char *path, gn_history **history);
/* A text of the caller's that is saved with a history: which frame it is of, what settings made it.
 * Copied, at most GN_MAX_NOTE bytes; NULL: none. */
#define GN_MAX_NOTE 65535u
GN_API gn_result gn_history_set_note(gn_history *history, const char *note);
GN_API const char *gn_history_note(const gn_history *history); /* "" where there is none */
/* Bytes of masks and depth; of maps, see gn_shadow_map_bytes(). */
GN_API size_t gn_history_mask_bytes(const gn_history *history);
/* The map of a light as of the last frame, or NULL. Owned by the history. */
GN_API const gn_shadow_map *gn_history_map(const gn_history *history, uint32_t light);
/* A picture of a light buffer, size * size floats, rows from top to bottom: how many triangles the
 * lists of each cell hold, of the finest tile there; -1 where there is none. face: 0 for a sun; of
 * a point or spot light 0 to 5 (gn_light_face()). Shows *extent metres (a sun; chosen to hold all
 * cells that list anything) or the whole face (extent 2). GN_ERROR_INVALID_ARGUMENT where the light
 * has no light buffer in this history. */
GN_API gn_result gn_history_draw_light_buffer(const gn_history *history, uint32_t light,
                                              uint32_t face, uint32_t size, float *lengths,
                                              float *extent);

/* Which neighbours in the mask are asked. */
typedef enum gn_leak_kernel {
    GN_LEAK_GATHER = 0, /* rays are added by 2x2, which in four frames cover 3x3, and taken away
                           by 3x3 */
    GN_LEAK_FULL = 1    /* 3x3 for both */
} gn_leak_kernel;

typedef enum gn_switch { GN_SWITCH_AUTO = 0, GN_SWITCH_OFF = 1, GN_SWITCH_ON = 2 } gn_switch;

/* Leak tracing (leak tracing paper, section 3). */
typedef struct gn_leak_desc {
    float epsilon;         /* a map's test below it is shadow, above 1 - epsilon light, between them
                              a ray is traced (Equation 3); [0, 0.49], default 0.01 */
    gn_leak_kernel kernel; /* default GATHER */
    bool expand, remove;   /* rays that the mask adds (Equation 6), takes away (Equation 8); default
                              true. Without the method's mask they do nothing */
    gn_switch
        depth_test; /* take rays away only where the camera's depth was the same a frame ago,
                       within 10 %; AUTO (default): for ESM and four moments (section 3.1.2) */
} gn_leak_desc;

/* What a pixel was in the eyes of leak tracing (Table 1), as in the temporal mask: bits LTT, ST, RS
 * of gnomon/shadow/leak.h. */
typedef enum gn_leak_class {
    GN_LEAK_BLACK = 0,   /* lit: no ray */
    GN_LEAK_RED = 1,     /* test lit, ray lit */
    GN_LEAK_GREEN = 2,   /* in shadow: no ray */
    GN_LEAK_YELLOW = 3,  /* test in shadow, ray lit */
    GN_LEAK_NOTHING = 4, /* no surface, or it faces away from the light (black in the paper) */
    GN_LEAK_PURPLE = 5,  /* test lit, ray in shadow */
    GN_LEAK_WHITE = 7    /* test in shadow, ray in shadow */
} gn_leak_class;

/* What answers shadow rays. All give the same visibility up to rounding. */
typedef enum gn_tracer_kind {
    GN_TRACER_AUTO = 0,        /* the light buffer where it is expected to be faster: all rays are
                                  traced, there is a history to keep it in, the light stands, and
                                  little of the scene moves; else the tree. Of a picture's tiles
                                  those whose lists are long are the tree's in any case */
    GN_TRACER_BVH = 1,         /* the scene's tree (Embree) */
    GN_TRACER_LIGHT_BUFFER = 2 /* a grid of triangle lists over the light's view (Haines and
                                  Greenberg 1986; gnomon/shadow/light_buffer.h) */
} gn_tracer_kind;

/* A light buffer after a call. It is made of tiles, which are built where receivers lie and kept
 * while the light stands; rays of tiles that are not there are traced by the tree. */
typedef struct gn_light_buffer_info {
    uint32_t tiles;     /* that are there */
    uint32_t built;     /* of them in this call, static casters */
    uint32_t refused;   /* that were asked for and are not: beyond the limit of memory, or their
                           lists are too long to be worth it */
    uint64_t triangles; /* put into tiles in this call, static and moving, once a tile */
    uint64_t entries;   /* of all lists of all tiles */
    size_t bytes;       /* of all tiles and tables */
    uint64_t tree_rays; /* of this call's rays, those that the tree traced */
    double build_ms;    /* of this call */
} gn_light_buffer_info;

/* How visibility is found. */
typedef struct gn_visibility_desc {
    uint32_t cookie;
    const gn_method *method;   /* default gn_method_find("ray") */
    uint32_t light;            /* index, default 0 */
    bool rescale_alpha;        /* default true: mips keep the share of passing texels (R11); false:
                                  plain averages, for comparison */
    float cutoff;              /* visibility under which a ray ends, [0, 0.5], default 0.01; what
                                  remains is rescaled to [0,1] */
    float point_light_clip;    /* metres, >= 0, default 0: hits nearer to a point or spot light are
                                  ignored (a lamp modelled around its light) */
    gn_tracer_kind tracer;     /* default AUTO; what was taken: gn_visibility_stats.tracer */
    size_t light_buffer_limit; /* bytes that the light buffers of a history may take, default
                                  512 MB; more is traced by the tree */
    /* Methods with a map. */
    gn_map_desc map;     /* default gn_map_desc_default() */
    gn_history *history; /* keeps maps, masks and light buffers between frames; NULL (default): made
                            for this call alone. One scene and one camera at a time; a change of
                            method, map settings or scene starts it anew. gn_scene_visibility() sees
                            no frame but those that it is asked for: cut the history where a
                            G-buffer went by without it */
    gn_leak_desc leak;   /* of methods with GN_TRACE_LEAK; their mask needs a history */
    uint32_t camera;     /* whose picture the G-buffer is, default 0; gn_view_render() sets it */
    uint32_t frame;      /* number of the frame, default 0: turns the noise */
} gn_visibility_desc;

/* Pixels that leak tracing looked at. */
typedef struct gn_leak_counts {
    uint64_t tested;   /* by a map */
    uint64_t unsure;   /* of them, by the map's test (Equation 3) */
    uint64_t expanded; /* sure, and traced for the mask's sake */
    uint64_t removed;  /* unsure, and not traced for the mask's sake */
    uint64_t lost;     /* traced since they were not seen in the frame before */
    uint64_t unheld;   /* traced since no layer of the map holds them */
} gn_leak_counts;

/* Optional facts, one value a pixel each; any pointer may be NULL. Make it zero first. */
typedef struct gn_visibility_stats {
    float *lod;        /* the coarsest level of detail read on the ray's way, in mips; 0 if none */
    float *lookups;    /* alpha lookups on the ray's way */
    float *layer;      /* methods with a map: cascade or face that was read; -1 where none */
    float *test;       /* methods with a map: its test, [0,1]; 1 where it was not asked */
    float *traced;     /* 1 where a ray was traced, else 0 */
    float *leak_class; /* leak tracing: gn_leak_class; NOTHING with other methods */
    float *entries;    /* light buffer: triangles in the lists of the ray's cell; 0 where the tree
                          traced, or no ray was */
    uint64_t rays;     /* out: rays traced */
    gn_tracer_kind tracer;             /* out: BVH or LIGHT_BUFFER */
    gn_light_buffer_info light_buffer; /* out: zero with BVH */
    gn_leak_counts leak;               /* out */
    gn_map_update map;                 /* out: what was done to the map */
    double test_ms, trace_ms;          /* out: reading the map; tracing rays */
} gn_visibility_stats;

/* Thread-safety: one thread at a time for each view; views of one committed scene may render at
 * the same time. */
typedef struct gn_view gn_view;

GN_API gn_view_desc gn_view_desc_default(void);
GN_API gn_visibility_desc gn_visibility_desc_default(void);

GN_API gn_result gn_view_create(gn_device *device, const gn_view_desc *desc, gn_view **view);
GN_API void gn_view_destroy(gn_view **view);

/* One whole frame of a committed scene: G-buffer, visibility of the count lights, shaded image.
 * desc->light is ignored. Remembers the camera and the nodes for the next frame's motion. Of
 * several samples a pixel each is a picture of its own: its motion leads to the frame before, not
 * to the sample before, so the history is cut before each (leak tracing then uses no mask). */
GN_API gn_result gn_view_render(gn_view *view, const gn_scene *scene, uint32_t camera,
                                const gn_visibility_desc *desc, const uint32_t *lights,
                                uint32_t light_count);

/* Where in their pixels the rays of frames with one sample go from now on: right and down, in [0,
 * 1), 0.5 (as at first) is the centre. For antialiasing over time (gnomon/antialias.h). Motion is
 * that of surfaces: it knows nothing of jitter. */
GN_API gn_result gn_view_set_jitter(gn_view *view, float x, float y);

/* Facts that each gn_view_render() from now on fills in, one a light, of several samples the last;
 * NULL (as at first): no more. The caller's, as are their planes. */
GN_API void gn_view_set_stats(gn_view *view, gn_visibility_stats *stats);

/* Results of the last gn_view_render(); owned by the view, valid until its next call. */
GN_API const gn_gbuffer *gn_view_gbuffer(const gn_view *view);
GN_API const float *gn_view_visibility(const gn_view *view, uint32_t nth_light); /* [0,1] */
GN_API const float *gn_view_image(const gn_view *view); /* linear RGB, 3 floats a pixel */
GN_API gn_timings gn_view_timings(const gn_view *view);

/* A camera cut: forgets the frame before, so that motion of the next frame is zero, and cuts the
 * view's own history (gn_history_cut()). Shadow maps are kept. */
GN_API void gn_view_reset_history(gn_view *view);

/* The view's own history, which gn_view_render() uses where desc->history is NULL. */
GN_API gn_history *gn_view_history(gn_view *view);

/* A sequence that goes on in another process, with the same bits: gn_history_save() of the view's
 * own history, and with it the frame before, against which motion is measured. */
GN_API gn_result gn_view_save_history(const gn_view *view, const char *path);
/* Takes what gn_view_save_history() wrote in place of the view's own history and frame before; then
 * the next frame can be rendered. Refuses files that are damaged, of another scene, of a picture of
 * another size, or written by gn_history_save(); after an error the view is unchanged. */
GN_API gn_result gn_view_load_history(gn_view *view, const gn_scene *scene, const char *path);

/* The passes alone. gn_view_trace_gbuffer() fills the view's G-buffer and advances its history. */
GN_API gn_result gn_view_trace_gbuffer(gn_view *view, const gn_scene *scene, uint32_t camera);

/* Visibility of desc->light at each pixel of a G-buffer, the caller's own or a view's, into
 * visibility (width * height floats in [0,1]; 0 where the surface faces away or is sky, beyond a
 * light's range or outside its cone). Reads position, normal, origin_error, cone_width and
 * surface. stats may be NULL.
 * Implements steps 4 to 8 of sections 3.1 and 3.2 of the ray cone paper. */
GN_API gn_result gn_scene_visibility(const gn_scene *scene, const gn_gbuffer *gbuffer,
                                     const gn_visibility_desc *desc, float *visibility,
                                     gn_visibility_stats *stats);

#ifdef __cplusplus
}
#endif

#endif
