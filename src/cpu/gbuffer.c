/* The G-buffer: camera rays in packets of 4x4 pixels, and for each hit the surface. */
#include "cpu/cpu.h"

#include <math.h>
#include <string.h>

#include <gnomon/shadow/ray_cone.h>

typedef struct camera_ray {
    float origin[3], direction[3]; /* direction: unit length */
    float near;                    /* where the view begins along the ray */
} camera_ray;

/* x, y: in pixels from the upper left corner. */
static inline camera_ray make_camera_ray(const gn_rays *rays, const gn_gbuffer *g, float x, float y)
{
    camera_ray r;
    const float sx = 2.0f * x / (float)g->width - 1.0f, sy = 1.0f - 2.0f * y / (float)g->height;
    float length2 = 0.0f;
    for (int i = 0; i < 3; i++) {
        const float offset = sx * rays->right[i] + sy * rays->up[i];
        r.origin[i] = rays->origin[i] + (rays->orthographic ? offset : 0.0f);
        r.direction[i] = (rays->orthographic ? 0.0f : offset) - rays->back[i];
        length2 += r.direction[i] * r.direction[i];
    }
    const float length = sqrtf(length2);
    for (int i = 0; i < 3; i++)
        r.direction[i] /= length;
    r.near = rays->near * length;
    return r;
}

static inline float dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* false where v has no direction. */
static inline bool normalize3(float v[3])
{
    const float length = sqrtf(dot3(v, v));
    if (!(length > 0.0f) || !isfinite(length))
        return false;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return true;
}

/* Pixel coordinates and depth of a world point. false behind the camera. */
static inline bool project(const gn_rays *rays, const gn_gbuffer *g, const float p[3], float out[3])
{
    const float d[3] = {p[0] - rays->origin[0], p[1] - rays->origin[1], p[2] - rays->origin[2]};
    const float depth = -dot3(d, rays->back);
    const float scale = rays->orthographic ? 1.0f : depth;
    const float x = dot3(d, rays->right) / dot3(rays->right, rays->right);
    const float y = dot3(d, rays->up) / dot3(rays->up, rays->up);
    if (!(scale > 0.0f))
        return false;
    out[0] = (x / scale + 1.0f) * 0.5f * (float)g->width;
    out[1] = (1.0f - y / scale) * 0.5f * (float)g->height;
    out[2] = depth;
    return true;
}

/* One hit, resolved to the triangle and its place in the world. */
typedef struct hit {
    const gn_triangle_tree *tree;
    const gn_instance *instance; /* NULL: flat */
    const gn_part *part;
    const gn_node *node;
    uint32_t surface, triangle;
    float u, v, w;     /* barycentric weights of corners 1, 2 and 0 */
    float object[3];   /* position in the tree's space */
    float position[3]; /* in the world */
    float normal[3];   /* of the front side, in the world; not normalised */
    float origin_error;
} hit;

static inline hit resolve_hit(const gn_gbuffer_job *job, const struct RTCRayHit16 *r, uint32_t lane)
{
    const gn_accel *accel = job->accel;
    hit h;
    const uint32_t id = r->hit.instID[0][lane];
    const gn_instance *instance = &accel->instances[id == RTC_INVALID_GEOMETRY_ID ? 0 : id];
    h.tree = instance->tree;
    h.instance = instance->node == GN_NONE ? NULL : instance;
    const uint32_t geometry = r->hit.geomID[lane], primitive = r->hit.primID[lane];
    const gn_source source = h.tree->sources[geometry][primitive];
    h.surface = source.surface + instance->first_surface;
    h.triangle = source.triangle;
    h.part = accel->surfaces[h.surface].part;
    h.node = &job->scene->nodes[accel->surfaces[h.surface].node];
    h.u = r->hit.u[lane];
    h.v = r->hit.v[lane];
    h.w = 1.0f - h.u - h.v;

    const uint32_t *index = h.tree->indices[geometry] + (size_t)primitive * 3;
    const float *a = h.tree->vertices + (size_t)index[0] * 3;
    const float *b = h.tree->vertices + (size_t)index[1] * 3;
    const float *c = h.tree->vertices + (size_t)index[2] * 3;
    float e1[3], e2[3];
    for (int i = 0; i < 3; i++) {
        e1[i] = b[i] - a[i];
        e2[i] = c[i] - a[i];
        h.object[i] = a[i] + (h.u * e1[i] + h.v * e2[i]);
    }
    cross3(e1, e2, h.normal);
    memcpy(h.position, h.object, sizeof h.position);

    /* The bound on rounding, along the normal only, so that large level ground costs nothing: of
     * the position, and of Embree's N.(a - origin) for rays that start there, where N has the
     * rounding of the products that it is made of. It scales with the scene. */
    float error = 0.0f;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const float products = fabsf(e1[j] * e2[k]) + fabsf(e1[k] * e2[j]);
        const float extent = fabsf(e1[i]) + fabsf(e2[i]);
        error += fabsf(h.normal[i]) * (fabsf(h.object[i]) + fabsf(a[i]) + extent) +
                 products * fabsf(h.object[i] - a[i]);
    }
    error *= 4.0f / sqrtf(dot3(h.normal, h.normal));
    if (h.instance) {
        const float *m = h.node->world;
        const float *n = h.instance->normal_matrix;
        float normal[3], scale = 0.0f, world = 0.0f;
        for (int i = 0; i < 3; i++) {
            h.position[i] =
                m[i] * h.object[0] + m[4 + i] * h.object[1] + m[8 + i] * h.object[2] + m[12 + i];
            normal[i] = n[i] * h.normal[0] + n[3 + i] * h.normal[1] + n[6 + i] * h.normal[2];
            world += fabsf(h.position[i]) + fabsf(m[12 + i]);
            for (int j = 0; j < 3; j++)
                scale = fmaxf(scale, fabsf(m[4 * j + i]));
        }
        /* Mirrored instances turn the triangle's front. */
        const float sign = dot3(m, n) < 0.0f ? -1.0f : 1.0f;
        for (int i = 0; i < 3; i++)
            h.normal[i] = sign * normal[i];
        error = error * scale * 2.0f + 8.0f * world;
    } else if (accel->surfaces[h.surface].mirrored) {
        for (int i = 0; i < 3; i++)
            h.normal[i] = -h.normal[i];
    }
    h.origin_error = error * 1.1920929e-7f;
    return h;
}

static inline void texel_add(const gn_tables *tables, const uint8_t *texel, float weight,
                             float color[3])
{
    for (int i = 0; i < 3; i++)
        color[i] += weight * tables->linear[texel[i]];
}

/* The two texels around a coordinate; u in turns. */
static inline int wrap(float u, uint32_t size, gn_wrap rule, int *next, float *fraction)
{
    const int last = (int)size - 1;
    if (rule == GN_WRAP_REPEAT)
        u -= floorf(u);
    else if (rule == GN_WRAP_CLAMP)
        u = gn_clamp(u, 0.0f, 1.0f);
    else
        u = fabsf(u - 2.0f * floorf(0.5f * u + 0.5f));
    const float x = u * (float)size - 0.5f, low = floorf(x);
    const int i = (int)low;
    *fraction = x - low;
    *next = i < last ? i + 1 : rule == GN_WRAP_REPEAT ? 0 : last;
    return i >= 0 ? i : rule == GN_WRAP_REPEAT ? last : 0;
}

/* Adds weight times a mip of a texture at (u, v), bilinear, to color. */
static inline void add_mip(const gn_tables *tables, const gn_texture *texture,
                           const gn_material_desc *material, uint32_t level, float u, float v,
                           float weight, float color[3])
{
    const uint32_t width = gn_level_size(texture->width, level);
    const uint32_t height = gn_level_size(texture->height, level);
    int x1, y1;
    float fx, fy;
    const int x0 = wrap(u, width, material->wrap_u, &x1, &fx);
    const int y0 = wrap(v, height, material->wrap_v, &y1, &fy);
    const uint8_t *row0 = texture->rgba[level] + (size_t)y0 * width * 4;
    const uint8_t *row1 = texture->rgba[level] + (size_t)y1 * width * 4;
    texel_add(tables, row0 + x0 * 4, weight * (1.0f - fx) * (1.0f - fy), color);
    texel_add(tables, row0 + x1 * 4, weight * fx * (1.0f - fy), color);
    texel_add(tables, row1 + x0 * 4, weight * (1.0f - fx) * fy, color);
    texel_add(tables, row1 + x1 * 4, weight * fx * fy, color);
}

/* Base colour of a hit, trilinear at the footprint's area. */
static inline uint32_t hit_albedo(const gn_gbuffer_job *job, const hit *h, float cosine,
                                  float cone_width)
{
    const gn_material *material = &job->scene->materials[h->part->material];
    const gn_tables *tables = job->accel->tables;
    float color[3] = {1.0f, 1.0f, 1.0f};
    if (material->desc.texture != GN_NONE && h->part->uvs) {
        const gn_texture *texture = &job->scene->textures[material->desc.texture];
        const uint32_t *index = h->part->indices + (size_t)h->triangle * 3;
        const float *t0 = h->part->uvs + (size_t)index[0] * 2;
        const float *t1 = h->part->uvs + (size_t)index[1] * 2;
        const float *t2 = h->part->uvs + (size_t)index[2] * 2;
        const float u = h->w * t0[0] + h->u * t1[0] + h->v * t2[0];
        const float v = h->w * t0[1] + h->u * t1[1] + h->v * t2[1];
        const float t_a =
            (float)texture->width * (float)texture->height *
            fabsf((t1[0] - t0[0]) * (t2[1] - t0[1]) - (t2[0] - t0[0]) * (t1[1] - t0[1]));
        const float p_a = sqrtf(dot3(h->normal, h->normal));
        const float footprint = gn_ray_cone_footprint_area(cone_width, t_a, p_a * cosine);
        /* Edge-on footprints are infinite, those without texture coordinates nothing. */
        const float lod = gn_clamp(gn_log2(gn_clamp(footprint, 1.0f, 65536.0f)), 0.0f,
                                   (float)(texture->levels - 1));
        const uint32_t level = (uint32_t)(int)lod;
        const float between = lod - (float)(int)level;
        color[0] = color[1] = color[2] = 0.0f;
        add_mip(tables, texture, &material->desc, level, u, v, 1.0f - between, color);
        if (between > 0.0f)
            add_mip(tables, texture, &material->desc, level + 1, u, v, between, color);
    }
    uint32_t packed = 0xff000000u;
    for (int i = 0; i < 3; i++) {
        const float linear = gn_clamp(color[i] * material->desc.base_color[i], 0.0f, 1.0f);
        packed |= (uint32_t)tables->srgb[(int)(linear * GN_LINEAR_STEPS + 0.5f)] << (8 * i);
    }
    return packed;
}

static inline void clear_pixel(const gn_gbuffer *g, size_t pixel)
{
    for (int i = 0; i < 3; i++) {
        g->position[i][pixel] = 0.0f;
        g->normal[i][pixel] = 0.0f;
        g->shading_normal[i][pixel] = 0.0f;
        g->motion[i][pixel] = 0.0f;
    }
    g->origin_error[pixel] = 0.0f;
    g->cone_width[pixel] = 0.0f;
    g->depth[pixel] = 0.0f;
    g->albedo[pixel] = 0;
    g->surface[pixel] = GN_NONE;
}

/* Interpolated normal on the side of the geometric one. */
static inline void hit_shading_normal(const hit *h, const float n[3], float out[3])
{
    memcpy(out, n, 3 * sizeof *out);
    if (!h->part->normals)
        return;
    const uint32_t *index = h->part->indices + (size_t)h->triangle * 3;
    const float *n0 = h->part->normals + (size_t)index[0] * 3;
    const float *n1 = h->part->normals + (size_t)index[1] * 3;
    const float *n2 = h->part->normals + (size_t)index[2] * 3;
    float object[3], world[3];
    for (int i = 0; i < 3; i++)
        object[i] = h->w * n0[i] + h->u * n1[i] + h->v * n2[i];
    /* Normals are transformed by the cofactors of the node's matrix. */
    const float *m = h->node->world;
    float cofactor[3];
    for (int c = 0; c < 3; c++) {
        cross3(m + 4 * ((c + 1) % 3), m + 4 * ((c + 2) % 3), cofactor);
        for (int i = 0; i < 3; i++)
            world[i] = (c ? world[i] : 0.0f) + cofactor[i] * object[c];
    }
    if (!normalize3(world))
        return;
    const float side = dot3(world, n) < 0.0f ? -1.0f : 1.0f;
    for (int i = 0; i < 3; i++)
        out[i] = side * world[i];
}

static inline void write_pixel(const gn_gbuffer_job *job, const hit *h, const camera_ray *ray,
                               float t, float x, float y, size_t pixel)
{
    const gn_gbuffer *g = job->gbuffer;
    float n[3];
    memcpy(n, h->normal, sizeof n);
    if (!normalize3(n)) {
        clear_pixel(g, pixel);
        return;
    }
    float cosine = -dot3(n, ray->direction);
    if (cosine < 0.0f) {
        cosine = -cosine;
        for (int i = 0; i < 3; i++)
            n[i] = -n[i];
    }

    /* Steps 1 to 3 of sections 3.1 and 3.2 of the ray cone paper. */
    const gn_ray_cone start = {job->now.cone_width, job->now.cone_angle};
    const gn_ray_cone arrived = gn_ray_cone_propagate(start, t);
    const gn_ray_cone on_surface = gn_ray_cone_hit(arrived, cosine);

    float shading[3];
    hit_shading_normal(h, n, shading);
    for (int i = 0; i < 3; i++) {
        g->position[i][pixel] = h->position[i];
        g->normal[i][pixel] = n[i];
        g->shading_normal[i][pixel] = shading[i];
    }
    g->origin_error[pixel] = h->origin_error;
    g->cone_width[pixel] = on_surface.width;
    g->albedo[pixel] = hit_albedo(job, h, cosine, arrived.width);
    g->surface[pixel] = h->surface;

    /* Motion: the same point of the object, where it stood a frame ago. */
    float then[3];
    memcpy(then, h->position, sizeof then);
    if (h->instance) {
        const float *m = job->world_before + 16 * (size_t)(h->node - job->scene->nodes);
        for (int i = 0; i < 3; i++)
            then[i] =
                m[i] * h->object[0] + m[4 + i] * h->object[1] + m[8 + i] * h->object[2] + m[12 + i];
    }
    float here[3] = {x, y, 0.0f}, there[3];
    project(&job->now, g, h->position, here);
    g->depth[pixel] = here[2];
    const bool seen = project(&job->before, g, then, there);
    for (int i = 0; i < 3; i++)
        g->motion[i][pixel] = seen ? there[i] - here[i] : 1e9f;
}

static void gbuffer_block(const gn_gbuffer_job *job, uint32_t bx, uint32_t by)
{
    const gn_gbuffer *g = job->gbuffer;
    struct RTCRayHit16 r;
    int valid[GN_PACKET] __attribute__((aligned(64)));
    camera_ray rays[GN_PACKET];
    uint32_t waiting = 0;
    gn_query q;
    gn_rtc_context_init(&q.embree);
    q.accel = job->accel;
    for (uint32_t i = 0; i < GN_PACKET; i++) {
        const uint32_t px = bx + i % 4, py = by + i / 4;
        const bool inside = px < g->width && py < g->height;
        rays[i] =
            make_camera_ray(&job->now, g, (float)px + job->jitter[0], (float)py + job->jitter[1]);
        q.cone_width[i] = job->now.cone_width;
        q.cone_angle[i] = job->now.cone_angle;
        waiting |= (uint32_t)inside << i;
        r.ray.org_x[i] = rays[i].origin[0];
        r.ray.org_y[i] = rays[i].origin[1];
        r.ray.org_z[i] = rays[i].origin[2];
        r.ray.dir_x[i] = rays[i].direction[0];
        r.ray.dir_y[i] = rays[i].direction[1];
        r.ray.dir_z[i] = rays[i].direction[2];
        r.ray.tnear[i] = rays[i].near;
        r.ray.time[i] = 0.0f;
        r.ray.mask[i] = UINT32_MAX;
        r.ray.id[i] = i;
        r.ray.flags[i] = 0;
    }
    /* Camera rays pass through the back of single-sided surfaces; few do, so they start again
     * behind it. Each round begins farther away, so that there is an end. */
    while (waiting) {
        for (uint32_t i = 0; i < GN_PACKET; i++) {
            valid[i] = waiting >> i & 1 ? -1 : 0;
            r.ray.tfar[i] = INFINITY;
            r.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        gn_rtc_intersect16_coherent(valid, job->accel->root, &q.embree, &r);
        for (uint32_t lanes = waiting; lanes; lanes &= lanes - 1) {
            const uint32_t i = (uint32_t)__builtin_ctz(lanes);
            const uint32_t px = bx + i % 4, py = by + i / 4;
            const size_t pixel = (size_t)py * g->width + px;
            if (r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
                clear_pixel(g, pixel);
                waiting &= ~(1u << i);
                continue;
            }
            const hit h = resolve_hit(job, &r, i);
            const bool back = dot3(h.normal, rays[i].direction) > 0.0f;
            if (back && !job->scene->materials[h.part->material].desc.double_sided) {
                r.ray.tnear[i] = nextafterf(r.ray.tfar[i], INFINITY) + h.origin_error;
                continue;
            }
            write_pixel(job, &h, &rays[i], r.ray.tfar[i], (float)px + job->jitter[0],
                        (float)py + job->jitter[1], pixel);
            waiting &= ~(1u << i);
        }
    }
}

static void gbuffer_tile(uint32_t tile, uint32_t thread, void *user)
{
    const gn_gbuffer_job *job = user;
    (void)thread;
    const gn_gbuffer *g = job->gbuffer;
    const uint32_t across = gn_tiles_across(g->width);
    const uint32_t left = tile % across * GN_TILE, top = tile / across * GN_TILE;
    for (uint32_t y = top; y < top + GN_TILE && y < g->height; y += 4)
        for (uint32_t x = left; x < left + GN_TILE && x < g->width; x += 4)
            gbuffer_block(job, x, y);
}

void gn_cpu_gbuffer(const gn_cpu *cpu, const gn_gbuffer_job *job)
{
    gn_gbuffer_job copy = *job;
    gn_parallel_for(cpu->context,
                    gn_tiles_across(job->gbuffer->width) * gn_tiles_across(job->gbuffer->height),
                    gbuffer_tile, &copy);
}
