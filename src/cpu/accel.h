/* The tree of a scene: Embree scenes, and beside them what the filters and the G-buffer look up
 * for a hit.
 *
 * What stands still and is not too large is one flat tree in world space (8 to 16 % faster to trace
 * than instances, and one lookup a hit); what moves, and what is repeated too often to be
 * flattened, is one tree a mesh and an instance a node. */
#ifndef GN_CPU_ACCEL_H
#define GN_CPU_ACCEL_H

#include "cpu/embree.h"
#include "cpu/tables.h"
#include "scene/scene.h"

/* Static geometry with more instanced triangles than this keeps its instances. */
#define GN_FLAT_TRIANGLES 4000000u

/* Bits of rays and instances, so that a ray can ask for one kind of caster. Flat trees stand still.
 */
enum { GN_MASK_STATIC = 1, GN_MASK_DYNAMIC = 2 };

/* Geometry ids in every triangle tree. */
enum { GN_GEOMETRY_OPAQUE = 0, GN_GEOMETRY_MASKED = 1 };

/* What an alpha filter reads for one triangle: half a cache line. */
typedef struct gn_masked_triangle {
    float u0, v0, du1, dv1, du2, dv2; /* texture coordinates, 1 = the whole texture */
    float texel_scale;                /* sqrt(t_a p_a), in the tree's space (ray_cone.h) */
    uint32_t sampler;                 /* index into gn_accel.samplers */
} gn_masked_triangle;

/* Mip chains of a masked material (gn_alpha_map). */
enum { GN_CHAIN_AVERAGED = 0, GN_CHAIN_RESCALED = 1, GN_CHAIN_COVERAGE = 2, GN_CHAINS = 3 };

typedef struct gn_level {
    uint32_t offset; /* into gn_accel.texels */
    uint16_t width, height;
} gn_level;

/* The alpha of one material. The filters work with sums of four texels whose weights add up to
 * 2^24: alpha times GN_ALPHA_ONE. */
#define GN_ALPHA_ONE (255u << 24)

typedef struct gn_sampler {
    float cutoff;            /* of the test, > 0; 0.5 for BLEND */
    uint32_t cutoff_sum;     /* the least sum that passes */
    uint64_t saturate_scale; /* sum * this / 2^32: steps of opacity under saturate */
    int last_mip;
    float texels; /* of mip 0 */
    gn_wrap wrap_u, wrap_v;
    bool blend;
    gn_level levels[GN_CHAINS][GN_MAX_LEVELS];
} gn_sampler;

/* Where a triangle of the tree comes from. surface: of the whole scene in the flat tree, counted
 * from 0 in a mesh's. */
typedef struct gn_source {
    uint32_t surface, triangle;
} gn_source;

/* Triangles in one space: a mesh's, or the whole static scene. Index [GN_GEOMETRY_...]. */
typedef struct gn_triangle_tree {
    RTCScene scene;
    float *vertices;      /* 3 each, padded for Embree */
    uint32_t *indices[2]; /* 3 a triangle */
    gn_source *sources[2];
    gn_masked_triangle *masked;
    uint32_t vertex_count, counts[2];
    struct gn_runs *runs; /* for drawing (runs.h); NULL until they are first asked for */
} gn_triangle_tree;

/* A part of a node: what G-buffers call a surface. */
typedef struct gn_surface {
    uint32_t node;
    bool mirrored; /* as built: triangles of the flat tree turn their fronts */
    const gn_part *part;
} gn_surface;

typedef struct gn_instance {
    RTCGeometry geometry;
    const gn_triangle_tree *tree;
    uint32_t node;          /* GN_NONE: the flat tree, in world space */
    uint32_t first_surface; /* added to gn_source.surface */
    bool uniform;           /* scale is the same in all directions */
    float lod_factor;       /* world footprint / object footprint where uniform */
    float normal_matrix[9]; /* cofactors of the world matrix, column major: maps crosses of edges */
    float determinant;      /* absolute value */
} gn_instance;

typedef struct gn_accel {
    gn_context *context;
    RTCDevice rtc;
    RTCScene root;      /* the flat scene itself where nothing else is there */
    bool has_instances; /* root holds instances; else hits carry no instance id */
    gn_triangle_tree flat;
    gn_triangle_tree *trees; /* a mesh each, empty where unused */
    uint32_t tree_count;
    gn_instance *instances; /* by Embree's instance id; [0] is the flat tree, also without others */
    uint32_t instance_count;
    gn_surface *surfaces;
    uint32_t surface_count;
    uint32_t *first_surface; /* of each node; GN_NONE without a mesh */
    gn_sampler *samplers;    /* one a material */
    uint8_t *texels;         /* every chain of every masked material */
    const struct gn_kernels *kernels;
    const gn_tables *tables;
    pthread_mutex_t runs_mutex; /* guards the trees' runs */
    uint64_t structure_version, transform_version;
} gn_accel;

struct gn_cpu;

/* Builds or updates scene->accel after gn_scene_resolve(). */
gn_result gn_accel_update(gn_scene *scene, const struct gn_cpu *cpu);

/* The triangles of one part, told apart by what their alpha can do (split.c). */
typedef enum gn_triangle_class {
    GN_CLASS_OPAQUE = 0, /* every texel passes the test: no filter */
    GN_CLASS_MASKED = 1,
    GN_CLASS_EMPTY = 2 /* no texel has any alpha: left out of the tree */
} gn_triangle_class;

gn_triangle_class gn_classify_triangle(const gn_material *material, const float uv[3][2]);

#endif
