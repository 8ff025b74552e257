/* What tests of the scene share: a device without a tracer, a triangle, and checks. */
#ifndef SCENE_TESTING_H
#define SCENE_TESTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "scene/scene.h"

static gn_context context = {.mutex = PTHREAD_MUTEX_INITIALIZER, .threads = 1};

/* The context is the first member of every device. */
static inline gn_scene *make_scene(void)
{
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create((gn_device *)&context, &scene), GN_OK);
    return scene;
}

static inline void assert_near(double value, double expected, double tolerance, const char *what)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s is %.9g, expected %.9g within %g", what, value, expected, tolerance);
}

static inline void assert_vector(const float *value, double x, double y, double z, const char *what)
{
    assert_near((double)value[0], x, 1e-5, what);
    assert_near((double)value[1], y, 1e-5, what);
    assert_near((double)value[2], z, 1e-5, what);
}

/* Refused with INVALID_ARGUMENT and a message that has the words. */
static inline void assert_refused(gn_result result, const char *words)
{
    assert_int_equal(result, GN_ERROR_INVALID_ARGUMENT);
    if (!strstr(context.message, words))
        fail_msg("the message is \"%s\", expected \"%s\" in it", context.message, words);
}

static const float triangle[] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
static const float triangle_uvs[] = {0, 0, 1, 0, 0, 1};
static const uint32_t triangle_indices[] = {0, 1, 2};

static inline gn_mesh_part triangle_part(void)
{
    return (gn_mesh_part){.vertex_count = 3,
                          .positions = triangle,
                          .uvs = triangle_uvs,
                          .index_count = 3,
                          .indices = triangle_indices,
                          .material = GN_NONE};
}

static inline uint32_t add_triangle(gn_scene *scene)
{
    gn_mesh_part part = triangle_part();
    uint32_t mesh = GN_NONE;
    assert_int_equal(gn_scene_add_mesh(scene, "triangle", &part, 1, &mesh), GN_OK);
    return mesh;
}

static inline uint32_t add_node(gn_scene *scene, const gn_node_desc *desc)
{
    uint32_t node = GN_NONE;
    assert_int_equal(gn_scene_add_node(scene, desc, &node), GN_OK);
    return node;
}

#endif
