/* What tests of depth maps share: views, maps, random numbers and triangles. */
#ifndef DEPTH_TESTING_H
#define DEPTH_TESTING_H

#include "render_testing.h"

#include "cpu/cpu.h"
#include "cpu/map.h"
#include "render/device.h"

#define QUANTUM (1.0 / 65535.0)

/* Views ---------------------------------------------------------------------------------------*/

/* From `from` to `to`, half-width `half` there, from `near` to `far` metres. */
static inline gn_map_projection look(vec from, vec to, bool perspective, double half, double near,
                                     double far, uint32_t resolution)
{
    float m[16];
    aim(from, to, m);
    const double reach = length(sub(to, from));
    gn_map_projection p = {.perspective = perspective,
                           .extent = (float)(perspective ? half / reach : half),
                           .near = (float)near,
                           .far = (float)far,
                           .resolution = resolution};
    for (int i = 0; i < 3; i++) {
        p.right[i] = m[i];
        p.up[i] = m[4 + i];
        p.forward[i] = -m[8 + i];
        p.origin[i] = m[12 + i];
    }
    return p;
}

typedef struct map {
    float *depth;
    size_t texels; /* of all planes */
    gn_rect covered;
} map;

typedef struct settings {
    gn_casters casters;
    gn_map_alpha alpha;
    uint32_t samples;
    bool rays;
} settings;

static inline map draw(const gn_scene *scene, const gn_map_projection *p, settings s)
{
    map m = {.texels = (size_t)p->resolution * p->resolution * s.samples};
    m.depth = malloc(m.texels * sizeof *m.depth);
    assert_non_null(m.depth);
    for (size_t i = 0; i < m.texels; i++)
        m.depth[i] = NAN; /* each must be written */
    gn_depth_job job = {.scene = scene,
                        .projection = *p,
                        .casters = s.casters,
                        .alpha = s.alpha,
                        .samples = s.samples,
                        .depth = m.depth};
    ok(s.rays ? gn_cpu_depth_rays(&scene->device->cpu, &job)
              : gn_cpu_depth(&scene->device->cpu, &job));
    m.covered = job.covered;
    return m;
}

static inline map draw_simply(const gn_scene *scene, const gn_map_projection *p, uint32_t samples)
{
    return draw(scene, p, (settings){GN_CASTERS_ALL, GN_MAP_ALPHA_TEST, samples, false});
}

/* Scenes --------------------------------------------------------------------------------------*/

static inline gn_scene *built_in(gn_device *on, const char *kind, double scale)
{
    gn_scene *scene;
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = scale;
    ok(gn_scene_create_procedural(on, kind, &desc, &scene));
    ok(gn_scene_set_time(scene, 0.7));
    ok(gn_scene_commit(scene));
    return scene;
}

/* Around what the first camera of a scene sees. */
static inline gn_map_projection view_of(const gn_scene *scene, bool perspective,
                                        uint32_t resolution)
{
    const float *camera = scene->cameras[0].world;
    const vec eye = v3((double)camera[12], (double)camera[13], (double)camera[14]);
    const vec back = v3((double)camera[8], (double)camera[9], (double)camera[10]);
    const vec target = add(eye, mul(back, -5));
    const vec from = add(target, v3(9, 21, 7));
    return look(from, target, perspective, 7, perspective ? 0.1 : 0, 60, resolution);
}

static const char *const kinds[] = {"grove", "court", "leafbox", "railing"};
#define KINDS (sizeof kinds / sizeof *kinds)

static uint64_t random_state;

static inline double random_between(double low, double high)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(random_state >> 40) / 16777216.0;
}

static inline vec random_point(double size)
{
    const double x = random_between(-size, size), y = random_between(-size, size);
    return v3(x, y, random_between(-size, size));
}

typedef enum shape { ANY, SLIVER, DEGENERATE, EDGE_ON, HUGE_ONE, TINY, SHAPES } shape;

/* Corners of a triangle around the origin, for light that travels along `along`. */
static inline void random_triangle(shape kind, vec along, vec p[3])
{
    const vec at = random_point(4);
    const double size = kind == HUGE_ONE ? 3e4 : kind == TINY ? 0.01 : 1.5;
    for (int i = 0; i < 3; i++)
        p[i] = add(at, random_point(size));
    const vec middle = add(p[0], mul(sub(p[1], p[0]), random_between(0, 1)));
    if (kind == SLIVER)
        p[2] = add(middle, random_point(1e-4));
    if (kind == DEGENERATE)
        p[2] = random_between(0, 1) < 0.5 ? p[1] : mul(add(p[0], p[1]), 0.5);
    if (kind == EDGE_ON)
        p[2] = add(middle, mul(along, random_between(-2, 2)));
}

static inline uint32_t add_soup(gn_scene *scene, shape kind, uint32_t count, vec along)
{
    float *positions = malloc((size_t)count * 9 * sizeof *positions);
    uint32_t *indices = malloc((size_t)count * 3 * sizeof *indices), mesh;
    assert_true(positions && indices);
    for (uint32_t i = 0; i < count; i++) {
        vec p[3];
        random_triangle(kind == SHAPES ? (shape)(i % SHAPES) : kind, along, p);
        for (uint32_t c = 0; c < 3; c++) {
            positions[9 * i + 3 * c] = (float)p[c].x;
            positions[9 * i + 3 * c + 1] = (float)p[c].y;
            positions[9 * i + 3 * c + 2] = (float)p[c].z;
            indices[3 * i + c] = 3 * i + c;
        }
    }
    const gn_mesh_part part = {.vertex_count = 3 * count,
                               .positions = positions,
                               .index_count = 3 * count,
                               .indices = indices,
                               .material = GN_NONE};
    ok(gn_scene_add_mesh(scene, "soup", &part, 1, &mesh));
    free(positions);
    free(indices);
    return mesh;
}

#endif
