/* Meshes of the procedural scenes: boxes, beams, tubes, cards, curved surfaces. */
#include "scene/procedural.h"

#include <string.h>

gn_shape gn_shape_begin(gn_maker *maker, uint32_t material)
{
    return (gn_shape){.maker = maker, .material = material};
}

static void out_of_memory(gn_maker *maker)
{
    if (maker->result == GN_OK)
        maker->result = gn_fail(maker->context, GN_ERROR_OUT_OF_MEMORY,
                                "no memory for a mesh of a procedural scene");
}

static uint32_t add_vertex(gn_shape *shape, gn_vec position, gn_vec normal, float u, float v)
{
    gn_maker *maker = shape->maker;
    if (maker->result != GN_OK)
        return 0;
    if (!gn_grow(maker->context, (void **)&shape->vertices, shape->vertex_count,
                 &shape->vertex_capacity, sizeof *shape->vertices)) {
        out_of_memory(maker);
        return 0;
    }
    shape->vertices[shape->vertex_count] = (gn_vertex){position, normal, u, v};
    return shape->vertex_count++;
}

static bool same_place(const gn_shape *shape, uint32_t a, uint32_t b)
{
    gn_vec p = shape->vertices[a].position, q = shape->vertices[b].position;
    return p.x == q.x && p.y == q.y && p.z == q.z;
}

/* Leaves out triangles with two corners in one place: the poles of curved surfaces. */
static void add_triangle(gn_shape *shape, uint32_t a, uint32_t b, uint32_t c)
{
    gn_maker *maker = shape->maker;
    if (maker->result != GN_OK || same_place(shape, a, b) || same_place(shape, b, c) ||
        same_place(shape, c, a))
        return;
    const uint32_t corners[3] = {a, b, c};
    for (unsigned i = 0; i < 3; i++) {
        if (!gn_grow(maker->context, (void **)&shape->indices, shape->index_count,
                     &shape->index_capacity, sizeof *shape->indices)) {
            out_of_memory(maker);
            return;
        }
        shape->indices[shape->index_count++] = corners[i];
    }
}

/* Splits the vertices into the arrays of a mesh part; one allocation, at positions. */
static bool fill_part(gn_maker *maker, const gn_shape *shape, gn_mesh_part *part)
{
    uint32_t count = shape->vertex_count;
    float *data = gn_alloc(maker->context, count, 8 * sizeof *data);
    if (!data) {
        out_of_memory(maker);
        return false;
    }
    float *positions = data, *normals = data + 3 * (size_t)count, *uvs = data + 6 * (size_t)count;
    for (uint32_t i = 0; i < count; i++) {
        const gn_vertex *vertex = &shape->vertices[i];
        gn_vec position = gn_vec_scale(vertex->position, maker->unit);
        memcpy(positions + 3 * (size_t)i, &position, sizeof position);
        memcpy(normals + 3 * (size_t)i, &vertex->normal, sizeof vertex->normal);
        uvs[2 * (size_t)i] = vertex->u;
        uvs[2 * (size_t)i + 1] = vertex->v;
    }
    *part = (gn_mesh_part){.vertex_count = count,
                           .positions = positions,
                           .normals = normals,
                           .uvs = uvs,
                           .index_count = shape->index_count,
                           .indices = shape->indices,
                           .material = shape->material};
    return true;
}

uint32_t gn_make_mesh(gn_maker *maker, const char *name, gn_shape *shapes, uint32_t count)
{
    gn_mesh_part parts[4] = {0};
    uint32_t part_count = 0, triangles = 0, index = GN_NONE;
    for (uint32_t i = 0; i < count && maker->result == GN_OK; i++)
        if (shapes[i].index_count > 0 && fill_part(maker, &shapes[i], &parts[part_count])) {
            triangles += shapes[i].index_count / 3;
            part_count++;
        }
    if (maker->result == GN_OK)
        maker->result = gn_scene_add_mesh(maker->scene, name, parts, part_count, &index);
    if (maker->result == GN_OK && index < GN_MAKER_MESHES)
        maker->mesh_triangles[index] = triangles;
    for (uint32_t i = 0; i < part_count; i++)
        gn_free(maker->context, (void *)(uintptr_t)parts[i].positions);
    for (uint32_t i = 0; i < count; i++) {
        gn_free(maker->context, shapes[i].vertices);
        gn_free(maker->context, shapes[i].indices);
        shapes[i] = gn_shape_begin(maker, shapes[i].material);
    }
    return index;
}

void gn_shape_quad(gn_shape *shape, const gn_vec corners[4], const float uv[4])
{
    gn_vec normal = gn_vec_unit(
        gn_vec_cross(gn_vec_sub(corners[2], corners[0]), gn_vec_sub(corners[3], corners[1])));
    uint32_t a = add_vertex(shape, corners[0], normal, uv[0], uv[3]);
    uint32_t b = add_vertex(shape, corners[1], normal, uv[2], uv[3]);
    uint32_t c = add_vertex(shape, corners[2], normal, uv[2], uv[1]);
    uint32_t d = add_vertex(shape, corners[3], normal, uv[0], uv[1]);
    add_triangle(shape, a, b, c);
    add_triangle(shape, a, c, d);
}

/* A box with half axes x, y, z (right handed), each face textured at its size in tiles. */
static void oriented_box(gn_shape *shape, gn_vec center, gn_vec x, gn_vec y, gn_vec z, float tile)
{
    const gn_vec axes[3] = {x, y, z};
    for (unsigned i = 0; i < 3; i++) {
        for (int side = 1; side >= -1; side -= 2) {
            /* right cross up = out */
            gn_vec out = gn_vec_scale(axes[i], (float)side);
            gn_vec up = i == 1 ? z : y;
            gn_vec right = i == 2 ? x : i == 0 ? gn_vec_scale(z, -1) : gn_vec_scale(x, -1);
            right = gn_vec_scale(right, (float)side);
            gn_vec face = gn_vec_add(center, out);
            const gn_vec corners[4] = {
                gn_vec_sub(gn_vec_sub(face, right), up), gn_vec_sub(gn_vec_add(face, right), up),
                gn_vec_add(gn_vec_add(face, right), up), gn_vec_add(gn_vec_sub(face, right), up)};
            const float uv[4] = {0, 0, 2 * gn_vec_length(right) / tile,
                                 2 * gn_vec_length(up) / tile};
            gn_shape_quad(shape, corners, uv);
        }
    }
}

void gn_shape_box(gn_shape *shape, gn_vec center, gn_vec half, float yaw, float tile)
{
    float c = cosf(yaw), s = sinf(yaw);
    oriented_box(shape, center, (gn_vec){half.x * c, 0, -half.x * s}, (gn_vec){0, half.y, 0},
                 (gn_vec){half.z * s, 0, half.z * c}, tile);
}

void gn_shape_beam(gn_shape *shape, gn_vec from, gn_vec to, float width, float height, float tile)
{
    gn_vec axis = gn_vec_sub(to, from), z = gn_vec_unit(axis);
    gn_vec x = gn_vec_beside(z), y = gn_vec_cross(z, x);
    /* The box's Y is the beam's axis, so that the grain runs along it. */
    oriented_box(shape, gn_vec_along(from, 0.5f, axis), gn_vec_scale(x, width / 2),
                 gn_vec_scale(axis, 0.5f), gn_vec_scale(y, -height / 2), tile);
}

void gn_shape_tube(gn_shape *shape, const gn_vec *points, const float *radii, uint32_t count,
                   uint32_t sides, float tile)
{
    gn_vec beside = gn_vec_beside(gn_vec_unit(gn_vec_sub(points[1], points[0])));
    uint32_t before = 0;
    float v = 0;
    for (uint32_t i = 0; i < count; i++) {
        /* Carries one side vector along, so that the tube does not twist. */
        gn_vec axis =
            gn_vec_unit(gn_vec_sub(points[i + 1 < count ? i + 1 : i], points[i > 0 ? i - 1 : 0]));
        beside = gn_vec_unit(gn_vec_along(beside, -gn_vec_dot(beside, axis), axis));
        gn_vec third = gn_vec_cross(axis, beside);
        if (i > 0)
            v += gn_vec_length(gn_vec_sub(points[i], points[i - 1])) / tile;
        uint32_t ring = shape->vertex_count;
        for (uint32_t j = 0; j <= sides; j++) {
            float turn = 2 * GN_PI * (float)(j % sides) / (float)sides;
            gn_vec normal = gn_vec_along(gn_vec_scale(beside, cosf(turn)), sinf(turn), third);
            add_vertex(shape, gn_vec_along(points[i], radii[i], normal), normal,
                       (float)j / (float)sides, -v);
        }
        for (uint32_t j = 0; j < sides && i > 0; j++) {
            add_triangle(shape, before + j, before + j + 1, ring + j + 1);
            add_triangle(shape, before + j, ring + j + 1, ring + j);
        }
        before = ring;
    }
}

void gn_shape_card(gn_shape *shape, gn_vec base, gn_vec along, gn_vec across, gn_vec outward)
{
    gn_vec normal = gn_vec_unit(gn_vec_cross(across, along));
    if (gn_vec_dot(normal, outward) < 0) {
        across = gn_vec_scale(across, -1);
        normal = gn_vec_scale(normal, -1);
    }
    normal = gn_vec_unit(gn_vec_add(normal, gn_vec_unit(outward)));
    uint32_t corners[4];
    for (unsigned i = 0; i < 4; i++) {
        bool right = i == 1 || i == 2, top = i >= 2;
        gn_vec corner = gn_vec_along(base, right ? 0.5f : -0.5f, across);
        corner = gn_vec_along(corner, top ? 1 : 0, along);
        corners[i] = add_vertex(shape, corner, normal, right ? 1 : 0, top ? 0 : 1);
    }
    add_triangle(shape, corners[0], corners[1], corners[2]);
    add_triangle(shape, corners[0], corners[2], corners[3]);
}

void gn_shape_surface(gn_shape *shape, uint32_t columns, uint32_t rows, gn_surface surface,
                      const void *user, float u_tiles, float v_tiles)
{
    const float step = 1e-3f;
    uint32_t first = shape->vertex_count;
    for (uint32_t j = 0; j <= rows; j++) {
        for (uint32_t i = 0; i <= columns; i++) {
            float u = (float)i / (float)columns, v = (float)j / (float)rows;
            /* Normals a little inside, where poles and seams have both derivatives. */
            float nu = gn_clamp(u, step, 1 - step), nv = gn_clamp(v, 2 * step, 1 - 2 * step);
            gn_vec du = gn_vec_sub(surface(nu + step, nv, user), surface(nu - step, nv, user));
            gn_vec dv = gn_vec_sub(surface(nu, nv + step, user), surface(nu, nv - step, user));
            add_vertex(shape, surface(u, v, user), gn_vec_unit(gn_vec_cross(du, dv)), u * u_tiles,
                       (1 - v) * v_tiles);
        }
    }
    for (uint32_t j = 0; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = first + j * (columns + 1) + i, d = a + columns + 1;
            add_triangle(shape, a, a + 1, d + 1);
            add_triangle(shape, a, d + 1, d);
        }
    }
}

void gn_shape_lathe(gn_shape *shape, gn_vec foot, const float (*profile)[2], uint32_t count,
                    uint32_t sides, float u_tiles, float tile)
{
    float v = 0;
    for (uint32_t k = 0; k + 1 < count; k++) {
        /* Each ring band has normals of its own: a profile's corners stay sharp. */
        float rise = profile[k + 1][1] - profile[k][1], grow = profile[k + 1][0] - profile[k][0];
        float length = sqrtf(rise * rise + grow * grow);
        uint32_t first = shape->vertex_count;
        for (uint32_t j = 0; j <= sides; j++) {
            float turn = -2 * GN_PI * (float)(j % sides) / (float)sides;
            float c = cosf(turn), s = sinf(turn);
            gn_vec normal = {c * rise / length, -grow / length, s * rise / length};
            for (uint32_t end = 0; end < 2; end++) {
                float radius = profile[k + end][0];
                gn_vec point = {foot.x + c * radius, foot.y + profile[k + end][1],
                                foot.z + s * radius};
                add_vertex(shape, point, normal, u_tiles * (float)j / (float)sides,
                           -v - (float)end * length / tile);
            }
        }
        for (uint32_t j = 0; j < sides; j++) {
            uint32_t a = first + 2 * j;
            add_triangle(shape, a, a + 2, a + 3);
            add_triangle(shape, a, a + 3, a + 1);
        }
        v += length / tile;
    }
}
