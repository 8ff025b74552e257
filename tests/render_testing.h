/* What tests of the renderer share: vectors in double, scenes from a few calls, frames, pictures.
 * With the environment variable GNOMON_PICTURES naming a folder, picture() writes what it is given
 * there, for people to look at. */
#ifndef RENDER_TESTING_H
#define RENDER_TESTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/gnomon.h>

#include "scene/scene.h"

/* Vectors ------------------------------------------------------------------------------------ */

typedef struct vec {
    double x, y, z;
} vec;

static inline vec v3(double x, double y, double z)
{
    return (vec){x, y, z};
}

static inline vec add(vec a, vec b)
{
    return v3(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline vec sub(vec a, vec b)
{
    return v3(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline vec mul(vec a, double s)
{
    return v3(a.x * s, a.y * s, a.z * s);
}

static inline double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec cross(vec a, vec b)
{
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double length(vec a)
{
    return sqrt(dot(a, a));
}

static inline vec unit(vec a)
{
    return mul(a, 1 / length(a));
}

/* A frame at eye that looks along -Z to target. */
static inline void aim(vec eye, vec target, float m[16])
{
    const vec back = unit(sub(eye, target));
    const vec right = unit(cross(fabs(back.y) < 0.999 ? v3(0, 1, 0) : v3(0, 0, 1), back));
    const vec columns[4] = {right, cross(back, right), back, eye};
    for (int c = 0; c < 4; c++) {
        m[4 * c] = (float)columns[c].x;
        m[4 * c + 1] = (float)columns[c].y;
        m[4 * c + 2] = (float)columns[c].z;
        m[4 * c + 3] = c == 3 ? 1.0f : 0.0f;
    }
}

static inline vec transform(const float m[16], vec p)
{
    return v3((double)m[0] * p.x + (double)m[4] * p.y + (double)m[8] * p.z + (double)m[12],
              (double)m[1] * p.x + (double)m[5] * p.y + (double)m[9] * p.z + (double)m[13],
              (double)m[2] * p.x + (double)m[6] * p.y + (double)m[10] * p.z + (double)m[14]);
}

/* A device, and checked calls ---------------------------------------------------------------- */

static gn_device *device;

static inline int open_device(void **state)
{
    (void)state;
    return (int)gn_device_create(NULL, &device);
}

static inline int close_device(void **state)
{
    (void)state;
    gn_device_destroy(&device);
    return 0;
}

#define ok(call) check_ok((call), #call, __FILE__, __LINE__)
static inline void check_ok(gn_result result, const char *call, const char *file, int line)
{
    if (result == GN_OK)
        return;
    print_error("%s is %s: %s\n", call, gn_result_string(result), gn_device_message(device));
    _fail(file, line);
}

/* At most share of total pixels may be wrong. */
#define few(wrong, total, share, ...)                                                              \
    check_few(wrong, total, share, __FILE__, __LINE__, __VA_ARGS__)
__attribute__((format(printf, 6, 7))) static inline void check_few(size_t wrong, size_t total,
                                                                   double share, const char *file,
                                                                   int line, const char *what, ...)
{
    char text[200];
    va_list arguments;
    va_start(arguments, what);
    vsnprintf(text, sizeof text, what, arguments);
    va_end(arguments);
    if ((double)wrong <= share * (double)total)
        return;
    print_error("%s: %zu of %zu pixels, at most %g are allowed\n", text, wrong, total,
                share * (double)total);
    _fail(file, line);
}

/* Scenes ------------------------------------------------------------------------------------- */

static inline gn_scene *new_scene(void)
{
    gn_scene *scene = NULL;
    ok(gn_scene_create(device, &scene));
    return scene;
}

/* p: corners counter-clockwise seen from the front; texture coordinates run from (0,0) at p[0]
 * through (1,0) at p[1] to (1,1) at p[2], times `turns`. */
static inline uint32_t add_quad(gn_scene *scene, const vec p[4], double turns, uint32_t material)
{
    float positions[12], uvs[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    for (int i = 0; i < 4; i++) {
        positions[3 * i] = (float)p[i].x;
        positions[3 * i + 1] = (float)p[i].y;
        positions[3 * i + 2] = (float)p[i].z;
    }
    for (int i = 0; i < 8; i++)
        uvs[i] *= (float)turns;
    const gn_mesh_part part = {.vertex_count = 4,
                               .positions = positions,
                               .uvs = uvs,
                               .index_count = 6,
                               .indices = (const uint32_t[]){0, 1, 2, 0, 2, 3},
                               .material = material};
    uint32_t mesh;
    ok(gn_scene_add_mesh(scene, "quad", &part, 1, &mesh));
    return mesh;
}

/* A square floor at a height, facing up. */
static inline uint32_t add_floor(gn_scene *scene, double half, double y, uint32_t material)
{
    const vec p[4] = {v3(-half, y, half), v3(half, y, half), v3(half, y, -half),
                      v3(-half, y, -half)};
    return add_quad(scene, p, 1, material);
}

static inline uint32_t add_box(gn_scene *scene, vec low, vec high, uint32_t material)
{
    float positions[24];
    for (int i = 0; i < 8; i++) {
        positions[3 * i] = (float)(i & 1 ? high.x : low.x);
        positions[3 * i + 1] = (float)(i & 2 ? high.y : low.y);
        positions[3 * i + 2] = (float)(i & 4 ? high.z : low.z);
    }
    static const uint32_t indices[] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    const gn_mesh_part part = {.vertex_count = 8,
                               .positions = positions,
                               .index_count = 36,
                               .indices = indices,
                               .material = material};
    uint32_t mesh;
    ok(gn_scene_add_mesh(scene, "box", &part, 1, &mesh));
    return mesh;
}

/* A cube of 12 n^2 triangles blown up to a sphere; its quads are cut along the shorter diagonal,
 * which makes it convex. */
static inline uint32_t add_sphere(gn_scene *scene, vec center, double radius, uint32_t n,
                                  uint32_t material)
{
    const uint32_t side = (n + 1) * (n + 1);
    vec *points = malloc(sizeof *points * 6 * side);
    float *positions = malloc(sizeof *positions * 6 * side * 3);
    uint32_t *indices = malloc(sizeof *indices * 36 * n * n), *index = indices;
    assert_true(points && positions && indices);
    for (uint32_t i = 0; i < 6 * side; i++) {
        /* Points of a lattice on the cube, so that faces share their borders exactly. */
        const uint32_t face = i / side,
                       lattice[3] = {face < 3 ? n : 0, i % side % (n + 1), i % side / (n + 1)};
        double cube[3];
        for (uint32_t axis = 0; axis < 3; axis++)
            cube[(face + axis) % 3] = tan((2.0 * lattice[axis] / n - 1) * atan(1));
        points[i] = add(center, mul(unit(v3(cube[0], cube[1], cube[2])), radius));
        positions[3 * i] = (float)points[i].x;
        positions[3 * i + 1] = (float)points[i].y;
        positions[3 * i + 2] = (float)points[i].z;
    }
    for (uint32_t face = 0; face < 6; face++)
        for (uint32_t j = 0; j < n; j++)
            for (uint32_t i = 0; i < n; i++) {
                uint32_t c[4] = {0, 1, n + 2, n + 1};
                for (int k = 0; k < 4; k++)
                    c[k] += face * side + j * (n + 1) + i;
                const bool first = length(sub(points[c[0]], points[c[2]])) <
                                   length(sub(points[c[1]], points[c[3]]));
                const uint32_t pairs[2][6] = {{c[0], c[1], c[3], c[1], c[2], c[3]},
                                              {c[0], c[1], c[2], c[0], c[2], c[3]}};
                for (int k = 0; k < 6; k += 3) {
                    const uint32_t *t = pairs[first] + k;
                    index[0] = t[0];
                    index[1] = t[face < 3 ? 1 : 2];
                    index[2] = t[face < 3 ? 2 : 1];
                    index += 3;
                }
            }
    const gn_mesh_part part = {.vertex_count = 6 * side,
                               .positions = positions,
                               .index_count = 36 * n * n,
                               .indices = indices,
                               .material = material};
    uint32_t mesh;
    ok(gn_scene_add_mesh(scene, "sphere", &part, 1, &mesh));
    free(points);
    free(positions);
    free(indices);
    return mesh;
}

/* Single-sided, opaque, white. */
static inline uint32_t add_single_sided(gn_scene *scene)
{
    const gn_material_desc desc = gn_material_desc_default();
    uint32_t material;
    ok(gn_scene_add_material(scene, &desc, &material));
    return material;
}

/* moving: the node gets a channel that keeps it where it is, so that it is kept as an instance. */
static inline uint32_t place_desc(gn_scene *scene, const gn_node_desc *desc, bool moving)
{
    uint32_t node;
    ok(gn_scene_add_node(scene, desc, &node));
    if (moving) {
        gn_channel_desc channel = gn_channel_desc_default();
        channel.node = node;
        channel.path = GN_PATH_SCALE;
        channel.key_count = 1;
        channel.times = (const float[]){0};
        channel.values = desc->scale;
        ok(gn_scene_add_channel(scene, &channel));
    }
    return node;
}

static inline uint32_t place(gn_scene *scene, uint32_t mesh, bool moving)
{
    gn_node_desc desc = gn_node_desc_default();
    desc.mesh = mesh;
    return place_desc(scene, &desc, moving);
}

static inline uint32_t add_camera(gn_scene *scene, vec eye, vec target, double yfov, double znear)
{
    gn_camera_desc desc = gn_camera_desc_default();
    desc.yfov = (float)yfov;
    desc.znear = (float)znear;
    uint32_t camera;
    ok(gn_scene_add_camera(scene, &desc, &camera));
    gn_node_desc node = gn_node_desc_default();
    node.camera = camera;
    node.use_matrix = true;
    aim(eye, target, node.matrix);
    ok(gn_scene_add_node(scene, &node, NULL));
    return camera;
}

/* At `from`, shining to `to`. */
static inline uint32_t add_light(gn_scene *scene, const gn_light_desc *desc, vec from, vec to)
{
    uint32_t light;
    ok(gn_scene_add_light(scene, desc, &light));
    gn_node_desc node = gn_node_desc_default();
    node.light = light;
    node.use_matrix = true;
    aim(from, to, node.matrix);
    ok(gn_scene_add_node(scene, &node, NULL));
    return light;
}

/* towards: where it shines from. */
static inline uint32_t add_sun(gn_scene *scene, vec towards)
{
    gn_light_desc desc = gn_light_desc_default();
    desc.intensity = 3;
    return add_light(scene, &desc, towards, v3(0, 0, 0));
}

static inline uint32_t add_lamp(gn_scene *scene, vec position)
{
    gn_light_desc desc = gn_light_desc_default();
    desc.type = GN_LIGHT_POINT;
    desc.intensity = (float)(3 * dot(position, position));
    return add_light(scene, &desc, position, add(position, v3(0, -1, 0)));
}

/* Frames ------------------------------------------------------------------------------------- */

/* One view of one light. */
typedef struct frame {
    gn_view *view;
    const gn_gbuffer *g;
    const float *visibility;
    size_t pixels;
} frame;

static inline frame render_desc(const gn_scene *scene, uint32_t camera, uint32_t light,
                                const gn_visibility_desc *desc, uint32_t width, uint32_t height)
{
    gn_view_desc view_desc = gn_view_desc_default();
    view_desc.width = width;
    view_desc.height = height;
    frame f = {.pixels = (size_t)width * height};
    ok(gn_view_create(scene->device, &view_desc, &f.view));
    ok(gn_view_render(f.view, scene, camera, desc, &light, 1));
    f.g = gn_view_gbuffer(f.view);
    f.visibility = gn_view_visibility(f.view, 0);
    return f;
}

static inline frame render(const gn_scene *scene, uint32_t camera, uint32_t light, uint32_t width,
                           uint32_t height)
{
    return render_desc(scene, camera, light, NULL, width, height);
}

static inline void end(frame *f)
{
    gn_view_destroy(&f->view);
}

static inline vec position_at(const gn_gbuffer *g, size_t i)
{
    return v3((double)g->position[0][i], (double)g->position[1][i], (double)g->position[2][i]);
}

static inline vec normal_at(const gn_gbuffer *g, size_t i)
{
    return v3((double)g->normal[0][i], (double)g->normal[1][i], (double)g->normal[2][i]);
}

/* Visibilities that differ by more than `by`. */
static inline size_t count_different(const float *a, const float *b, size_t count, float by)
{
    size_t different = 0;
    for (size_t i = 0; i < count; i++)
        different += fabsf(a[i] - b[i]) <= by ? 0 : 1;
    return different;
}

/* The image, and beside it the visibility. */
static inline void picture(const frame *f, const char *name)
{
    const char *folder = getenv("GNOMON_PICTURES");
    if (!folder)
        return;
    const uint32_t width = f->g->width, height = f->g->height;
    const float *image = gn_view_image(f->view);
    uint8_t *rgb = malloc(f->pixels * 6);
    assert_non_null(rgb);
    for (uint32_t y = 0; y < height; y++) {
        uint8_t *row = rgb + (size_t)y * width * 6;
        gn_encode_srgb(image + (size_t)y * width * 3, row, (size_t)width * 3);
        for (uint32_t x = 0; x < width * 3; x++)
            row[width * 3 + x] =
                (uint8_t)(f->visibility[(size_t)y * width + x / 3] * 255.0f + 0.5f);
    }
    char path[512];
    snprintf(path, sizeof path, "%s/%s.png", folder, name);
    ok(gn_write_png(device, path, width * 2, height, 3, rgb, NULL, 0));
    free(rgb);
}

#endif
