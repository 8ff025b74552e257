/* Procedural scenes: counts, determinism, geometry, cameras, units, messages. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "scene/procedural.h"
#include "scene/scene.h"

static gn_device *device;

static gn_scene *make(const char *name, uint32_t seed, double scale, double unit)
{
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.seed = seed;
    desc.scale = scale;
    desc.unit = unit;
    gn_scene *scene = NULL;
    if (gn_scene_create_procedural(device, name, &desc, &scene) != GN_OK)
        fail_msg("%s: %s", name, gn_device_message(device));
    return scene;
}

static uint64_t triangles_of(const char *name, double scale)
{
    gn_scene *scene = make(name, 1, scale, 1);
    uint64_t count = gn_scene_get_info(scene).instanced_triangles;
    gn_scene_destroy(&scene);
    return count;
}

static void assert_between(double value, double low, double high, const char *what)
{
    if (!(value >= low && value <= high))
        fail_msg("%s is %.9g, expected between %.9g and %.9g", what, value, low, high);
}

/* Counts ------------------------------------------------------------------------------------ */

static void test_scale(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        const double few = (double)triangles_of(kind->name, 0.01);
        const double one = (double)triangles_of(kind->name, 1);
        const double ten = (double)triangles_of(kind->name, 10);
        assert_between(few, 500, 12000, kind->name);
        assert_true(few < one);
        assert_between(ten / one, 9, 11.5, kind->name);
        /* More than ten million are within the range of scale. */
        assert_true(one * 1000 > 1e7);
    }
}

static void test_grove_counts(void **state)
{
    (void)state;
    assert_between((double)triangles_of("grove", 0.01), 2000, 6000, "grove at scale 0.01");
    assert_between((double)triangles_of("grove", 0.1), 34000, 38000, "grove at scale 0.1");
    assert_between((double)triangles_of("grove", 60), 20e6, 22e6, "grove at scale 60");
    gn_scene *scene = make("grove", 1, 1, 1);
    gn_scene_info info = gn_scene_get_info(scene);
    assert_between((double)info.instanced_triangles, 340e3, 360e3, "grove at scale 1");
    assert_between((double)info.instanced_masked_triangles / (double)info.instanced_triangles, 0.6,
                   0.95, "share of masked triangles");
    assert_between((double)info.triangles, 1000, 50000, "unique triangles");
    gn_scene_destroy(&scene);
}

/* What stands near the middle does not depend on the scale. */
static void test_grove_neighbourhood(void **state)
{
    (void)state;
    gn_scene *small = make("grove", 1, 1, 1), *large = make("grove", 1, 4, 1);
    uint32_t found = 0, wanted = 0;
    for (uint32_t i = 0; i < small->node_count; i++) {
        const gn_node *a = &small->nodes[i];
        if (a->desc.mesh == GN_NONE || hypotf(a->world[12], a->world[14]) > 30)
            continue;
        wanted++;
        for (uint32_t k = 0; k < large->node_count; k++) {
            const gn_node *b = &large->nodes[k];
            if (a->desc.mesh == b->desc.mesh && memcmp(a->world, b->world, sizeof a->world) == 0) {
                found++;
                break;
            }
        }
    }
    assert_true(wanted > 200);
    assert_int_equal(found, wanted);
    gn_scene_destroy(&small);
    gn_scene_destroy(&large);
}

/* Determinism ------------------------------------------------------------------------------- */

/* A hash of all that a renderer sees (FNV-1a). */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ ((const uint8_t *)data)[i]) * 0x100000001b3u;
    return hash;
}

static uint64_t hash_scene(const gn_scene *scene)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        const gn_texture *texture = &scene->textures[i];
        hash = hash_bytes(hash, texture->rgba[0], (size_t)texture->width * texture->height * 4);
    }
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        for (uint32_t k = 0; k < scene->meshes[i].part_count; k++) {
            const gn_part *part = &scene->meshes[i].parts[k];
            hash = hash_bytes(hash, part->positions, (size_t)part->vertex_count * 12);
            hash = hash_bytes(hash, part->indices, (size_t)part->triangle_count * 12);
        }
    for (uint32_t i = 0; i < scene->node_count; i++)
        hash = hash_bytes(hash, scene->nodes[i].world, sizeof scene->nodes[i].world);
    return hash;
}

static void test_seed(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        uint64_t hashes[3];
        for (uint32_t i = 0; i < 3; i++) {
            gn_scene *scene = make(kind->name, i < 2 ? 7 : 8, 0.3, 1);
            hashes[i] = hash_scene(scene);
            gn_scene_destroy(&scene);
        }
        assert_true(hashes[0] == hashes[1]);
        assert_true(hashes[0] != hashes[2]);
    }
}

/* Geometry ---------------------------------------------------------------------------------- */

static gn_vec vertex_of(const float *values, uint32_t index)
{
    return (gn_vec){values[3 * (size_t)index], values[3 * (size_t)index + 1],
                    values[3 * (size_t)index + 2]};
}

static void test_geometry(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        gn_scene *scene = make(kind->name, 3, 0.5, 1);
        for (uint32_t m = 0; m < scene->mesh_count; m++) {
            const gn_mesh *mesh = &scene->meshes[m];
            uint32_t agree = 0, all = 0;
            for (uint32_t k = 0; k < mesh->part_count; k++) {
                const gn_part *part = &mesh->parts[k];
                for (uint32_t i = 0; i < part->vertex_count; i++) {
                    float length = gn_vec_length(vertex_of(part->normals, i));
                    assert_between((double)length, 0.999, 1.001, mesh->name);
                }
                for (uint32_t t = 0; t < part->triangle_count; t++, all++) {
                    const uint32_t *corner = part->indices + 3 * (size_t)t;
                    gn_vec p = vertex_of(part->positions, corner[0]);
                    gn_vec cross =
                        gn_vec_cross(gn_vec_sub(vertex_of(part->positions, corner[1]), p),
                                     gn_vec_sub(vertex_of(part->positions, corner[2]), p));
                    assert_true(isfinite(cross.x) && isfinite(cross.y) && isfinite(cross.z));
                    assert_true(gn_vec_length(cross) > 0);
                    gn_vec normal = {0, 0, 0};
                    for (uint32_t i = 0; i < 3; i++)
                        normal = gn_vec_add(normal, vertex_of(part->normals, corner[i]));
                    agree += gn_vec_dot(cross, normal) > 0;
                }
            }
            if (agree < 0.99 * all)
                fail_msg("%s: in %u of %u triangles normal and winding agree", mesh->name, agree,
                         all);
            for (uint32_t i = 0; i < 3; i++) {
                assert_between((double)(mesh->bounds_max[i] - mesh->bounds_min[i]), 0, 65,
                               mesh->name);
                assert_between((double)mesh->bounds_min[i], -40, 40, mesh->name);
            }
        }
        gn_scene_destroy(&scene);
    }
}

/* By the divergence theorem: positive where closed surfaces are wound outward. */
static double volume(const gn_shape *shape)
{
    double sum = 0;
    for (uint32_t i = 0; i < shape->index_count; i += 3) {
        gn_vec a = shape->vertices[shape->indices[i]].position;
        gn_vec b = shape->vertices[shape->indices[i + 1]].position;
        gn_vec c = shape->vertices[shape->indices[i + 2]].position;
        sum += (double)gn_vec_dot(a, gn_vec_cross(b, c)) / 6;
    }
    return sum;
}

static void clear(gn_shape *shape)
{
    gn_context *context = shape->maker->context;
    gn_free(context, shape->vertices);
    gn_free(context, shape->indices);
    *shape = gn_shape_begin(shape->maker, GN_NONE);
}

static void test_closed_shapes(void **state)
{
    (void)state;
    gn_maker maker = {.context = (gn_context *)device, .unit = 1, .scale = 1};
    gn_shape shape = gn_shape_begin(&maker, GN_NONE);

    gn_shape_box(&shape, (gn_vec){3, -2, 5}, (gn_vec){0.5f, 1, 1.5f}, 0.7f, 1);
    assert_int_equal(shape.index_count, 36);
    assert_between(volume(&shape), 5.999, 6.001, "volume of a box");
    clear(&shape);

    gn_shape_beam(&shape, (gn_vec){1, 1, 1}, (gn_vec){3, 2, -1}, 0.2f, 0.5f, 1);
    assert_between(volume(&shape), 0.2999, 0.3001, "volume of a beam");
    clear(&shape);

    /* A cone: a third of base times height. */
    const float cone[3][2] = {{0, 0}, {2, 0}, {0, 3}};
    gn_shape_lathe(&shape, (gn_vec){1, 1, 1}, cone, 3, 256, 1, 1);
    assert_between(volume(&shape), 4 * 3.13, 4 * 3.1416, "volume of a cone");
    clear(&shape);

    /* Its ends are open: seen from a point of its axis they add nothing. */
    const gn_vec axis[2] = {{0, 0, 0}, {0, 0, 2}};
    const float radii[2] = {0.5f, 0.5f};
    gn_shape_tube(&shape, axis, radii, 2, 256, 1);
    assert_between(volume(&shape), 1.046, 1.0473, "two thirds of the volume of a cylinder");
    clear(&shape);
    assert_int_equal(maker.result, GN_OK);
}

/* The walls of the box look at its middle. */
static void test_leafbox_walls(void **state)
{
    (void)state;
    gn_scene *scene = make("leafbox", 1, 0.1, 1);
    static const char *const walls[] = {"Floor", "Ceiling", "Back", "Left", "Right"};
    uint32_t seen = 0;
    for (uint32_t m = 0; m < scene->mesh_count; m++)
        for (size_t i = 0; i < sizeof walls / sizeof *walls; i++) {
            if (strcmp(scene->meshes[m].name, walls[i]) != 0)
                continue;
            const gn_part *part = &scene->meshes[m].parts[0];
            gn_vec inward = gn_vec_sub((gn_vec){0, 2.5f, 0}, vertex_of(part->positions, 0));
            assert_true(gn_vec_dot(inward, vertex_of(part->normals, 0)) > 0);
            seen++;
        }
    assert_int_equal(seen, 5);
    gn_scene_destroy(&scene);
}

/* Textures ---------------------------------------------------------------------------------- */

static void test_masked_textures(void **state)
{
    (void)state;
    gn_scene *scene = make("grove", 1, 0.01, 1);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const gn_material_desc *desc = &scene->materials[i].desc;
        if (desc->alpha_mode != GN_ALPHA_MASK)
            continue;
        const gn_texture *texture = &scene->textures[desc->texture];
        uint32_t texels = texture->width * texture->height, pass = 0, between = 0, dark = 0;
        assert_true(desc->double_sided);
        assert_true(texture->width >= 256 && texture->width <= 512);
        for (uint32_t k = 0; k < texels; k++) {
            const uint8_t *texel = texture->rgba[0] + 4 * (size_t)k;
            pass += texel[3] >= 128;
            between += texel[3] > 0 && texel[3] < 255;
            /* No dark rims: what is transparent has a leaf's colour, too. */
            dark += texel[3] < 128 && texel[1] < 50;
        }
        assert_between((double)pass / texels, 0.1, 0.8, "share of opaque texels");
        assert_between((double)between / texels, 0.01, 0.3, "share of texels on edges");
        assert_int_equal(dark, 0);
        seen++;
    }
    assert_true(seen >= 6);
    gn_scene_destroy(&scene);
}

/* Cameras ----------------------------------------------------------------------------------- */

static gn_vec transform(const float m[16], gn_vec p)
{
    return (gn_vec){m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                    m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                    m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]};
}

/* The distance from a point down to the nearest opaque triangle; INFINITY if there is none. */
static float height_above_ground(const gn_scene *scene, gn_vec point)
{
    float nearest = INFINITY;
    for (uint32_t n = 0; n < scene->node_count; n++) {
        const gn_node *node = &scene->nodes[n];
        if (node->desc.mesh == GN_NONE)
            continue;
        const gn_mesh *mesh = &scene->meshes[node->desc.mesh];
        for (uint32_t k = 0; k < mesh->part_count; k++) {
            const gn_part *part = &mesh->parts[k];
            for (uint32_t t = 0;
                 t < part->triangle_count && !scene->materials[part->material].masked; t++) {
                gn_vec v[3];
                for (uint32_t i = 0; i < 3; i++)
                    v[i] = transform(node->world,
                                     vertex_of(part->positions, part->indices[3 * (size_t)t + i]));
                float area =
                    (v[1].x - v[0].x) * (v[2].z - v[0].z) - (v[2].x - v[0].x) * (v[1].z - v[0].z);
                float b = ((point.x - v[0].x) * (v[2].z - v[0].z) -
                           (v[2].x - v[0].x) * (point.z - v[0].z)) /
                          area;
                float c = ((v[1].x - v[0].x) * (point.z - v[0].z) -
                           (point.x - v[0].x) * (v[1].z - v[0].z)) /
                          area;
                if (!(b >= 0 && c >= 0 && b + c <= 1))
                    continue;
                float y = v[0].y + b * (v[1].y - v[0].y) + c * (v[2].y - v[0].y);
                if (y < point.y)
                    nearest = fminf(nearest, point.y - y);
            }
        }
    }
    return nearest;
}

static gn_vec eye_of(const gn_scene *scene, uint32_t camera)
{
    const float *world = scene->cameras[camera].world;
    return (gn_vec){world[12], world[13], world[14]};
}

static void test_cameras(void **state)
{
    (void)state;
    static const struct {
        const char *scene, *cameras[4];
        float low, high; /* height over what is below, metres */
    } expected[] = {
        {"grove", {"CamRoad", "CamGlade", "CamWall", "CamWalk"}, 1.4f, 2.0f},
        {"railing", {"CamRailing", "CamUmbrella", "CamTop", "CamWalk"}, 1, 12},
        {"court", {"CamCourt", "CamColonnade", "CamTop", "CamWalk"}, 1.5f, 14},
        {"edges", {"CamEdges", "CamFence", "CamTree", "CamWalk"}, 1.8f, 2.2f},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        gn_scene *scene = make(expected[i].scene, 1, 0.1, 1);
        for (uint32_t k = 0; k < 4; k++) {
            uint32_t camera = gn_scene_find_camera(scene, expected[i].cameras[k]);
            assert_true(camera != GN_NONE);
            for (int time = 0; time <= (k == 3 ? 10 : 0); time += 5) {
                assert_int_equal(gn_scene_set_time(scene, time), GN_OK);
                assert_int_equal(gn_scene_commit(scene), GN_OK);
                float height = height_above_ground(scene, eye_of(scene, camera));
                assert_between((double)height, (double)expected[i].low, (double)expected[i].high,
                               expected[i].cameras[k]);
            }
        }
        gn_scene_destroy(&scene);
    }
}

/* Ten seconds, at walking pace; the orbit comes back to where it began. */
static void test_walks(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        gn_scene *scene = make(kind->name, 1, 0.01, 1);
        bool orbits = strcmp(kind->name, "leafbox") == 0;
        uint32_t camera = gn_scene_find_camera(scene, orbits ? "CamOrbit" : "CamWalk");
        assert_true(camera != GN_NONE);
        gn_vec first = eye_of(scene, camera), before = first, last = first;
        double length = 0;
        for (int step = 1; step <= 100; step++) {
            assert_int_equal(gn_scene_set_time(scene, 0.1 * step), GN_OK);
            assert_int_equal(gn_scene_commit(scene), GN_OK);
            last = eye_of(scene, camera);
            float walked = gn_vec_length(gn_vec_sub(last, before));
            assert_between((double)walked, 0.05, 0.25, "metres in a tenth of a second");
            length += (double)walked;
            before = last;
        }
        double back = (double)gn_vec_length(gn_vec_sub(last, first));
        if (orbits)
            assert_between(back, 0, 1e-4, "metres between the orbit's ends");
        else
            assert_between(length, 13.9, 15, "metres walked");
        assert_true(gn_scene_get_info(scene).duration >= 10);
        gn_scene_destroy(&scene);
    }
}

static void test_lights(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        gn_scene *scene = make(kind->name, 1, 0.01, 1);
        bool box = strcmp(kind->name, "leafbox") == 0;
        uint32_t lamp = gn_scene_find_light(scene, "Lamp"), sun = gn_scene_find_light(scene, "Sun");
        assert_true(lamp != GN_NONE && (sun != GN_NONE) == !box);
        assert_int_equal(gn_scene_get_light(scene, lamp).type, GN_LIGHT_POINT);
        assert_true(gn_scene_get_light(scene, lamp).on == box);
        if (sun != GN_NONE) {
            float down = -scene->lights[sun].direction[1];
            assert_between(asin((double)down) * 180 / 3.14159265358979, 30, 45, "sun's elevation");
        }
        gn_scene_destroy(&scene);
    }
}

/* The court's tower and only it moves. */
static void test_moving_tower(void **state)
{
    (void)state;
    gn_scene *scene = make("court", 1, 0.01, 1);
    uint32_t moving = 0;
    for (uint32_t i = 0; i < scene->node_count; i++)
        if (scene->nodes[i].animated && scene->nodes[i].desc.mesh != GN_NONE) {
            assert_string_equal(scene->nodes[i].name, "Siege tower");
            moving++;
            float start[16];
            memcpy(start, scene->nodes[i].world, sizeof start);
            gn_scene_set_time(scene, 10);
            gn_scene_commit(scene);
            assert_true(fabsf(scene->nodes[i].world[12] - start[12]) > 5);
            gn_scene_set_time(scene, 20);
            gn_scene_commit(scene);
            for (uint32_t k = 0; k < 16; k++)
                assert_between((double)(scene->nodes[i].world[k] - start[k]), -1e-4, 1e-4,
                               "change after one loop");
        }
    assert_int_equal(moving, 1);
    gn_scene_destroy(&scene);
}

/* Units and messages ------------------------------------------------------------------------ */

static void test_unit(void **state)
{
    (void)state;
    for (const gn_procedural *kind = gn_procedurals; kind->name; kind++) {
        gn_scene *metres = make(kind->name, 1, 0.05, 1), *large = make(kind->name, 1, 0.05, 1000);
        gn_scene_info a = gn_scene_get_info(metres), b = gn_scene_get_info(large);
        assert_true(a.instanced_triangles == b.instanced_triangles);
        for (int i = 0; i < 3; i++)
            assert_between((double)(b.bounds_max[i] / a.bounds_max[i]), 999.9, 1000.1, kind->name);
        gn_light_desc lamp = gn_scene_get_light(metres, gn_scene_find_light(metres, "Lamp"));
        gn_light_desc far = gn_scene_get_light(large, gn_scene_find_light(large, "Lamp"));
        assert_between((double)(far.intensity / lamp.intensity), 999e3, 1001e3, "intensity");
        assert_between((double)(far.range / lamp.range), 999, 1001, "range");
        for (uint32_t i = 0; i < metres->camera_count; i++) {
            float near = metres->cameras[i].desc.znear, other = large->cameras[i].desc.znear;
            assert_between((double)(other / near), 999, 1001, "near plane");
        }
        gn_scene_destroy(&metres);
        gn_scene_destroy(&large);
    }
}

static void assert_refused(const char *name, double scale, double unit, const char *words)
{
    gn_procedural_desc desc = gn_procedural_desc_default();
    desc.scale = scale;
    desc.unit = unit;
    gn_scene *scene = (gn_scene *)&desc;
    assert_int_equal(gn_scene_create_procedural(device, name, &desc, &scene),
                     GN_ERROR_INVALID_ARGUMENT);
    assert_null(scene);
    if (!strstr(gn_device_message(device), words))
        fail_msg("the message is \"%s\", expected \"%s\" in it", gn_device_message(device), words);
}

static void test_refusals(void **state)
{
    (void)state;
    assert_refused("forest", 1, 1, "'forest'");
    assert_refused(NULL, 1, 1, "named");
    assert_refused("grove", 0, 1, "scale");
    assert_refused("grove", 1001, 1, "1001");
    assert_refused("grove", (double)NAN, 1, "scale");
    assert_refused("grove", 1, 0, "unit");
    assert_refused("grove", 1, (double)INFINITY, "unit");
    gn_procedural_desc forgotten = {.seed = 1, .scale = 1, .unit = 1};
    gn_scene *scene = NULL;
    assert_int_equal(gn_scene_create_procedural(device, "court", &forgotten, &scene),
                     GN_ERROR_INVALID_DESC);
    assert_int_equal(gn_scene_create_procedural(device, "court", NULL, &scene), GN_OK);
    gn_scene_destroy(&scene);
}

static int set_up(void **state)
{
    (void)state;
    return gn_device_create(NULL, &device) == GN_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    size_t left = gn_device_bytes(device);
    gn_device_destroy(&device);
    return left < 1u << 20 ? 0 : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_scale),
                                       cmocka_unit_test(test_grove_counts),
                                       cmocka_unit_test(test_grove_neighbourhood),
                                       cmocka_unit_test(test_seed),
                                       cmocka_unit_test(test_geometry),
                                       cmocka_unit_test(test_closed_shapes),
                                       cmocka_unit_test(test_leafbox_walls),
                                       cmocka_unit_test(test_masked_textures),
                                       cmocka_unit_test(test_cameras),
                                       cmocka_unit_test(test_walks),
                                       cmocka_unit_test(test_lights),
                                       cmocka_unit_test(test_moving_tower),
                                       cmocka_unit_test(test_unit),
                                       cmocka_unit_test(test_refusals)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
