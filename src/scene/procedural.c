/* The table of procedural scenes, and the maker that hands their parts to the scene. */
#include "scene/procedural.h"

#include <string.h>

const gn_procedural gn_procedurals[] = {
    {"grove", "trees with leaf cards, bushes, grass, fences and a house along a road"},
    {"railing",
     "railing, banner and ground close together; umbrella, roof and railing over a line"},
    {"leafbox", "a Cornell box with a tree and a point light"},
    {"court", "opaque architecture with one moving object"},
    {"edges",
     "what a map's texels miss: surfaces along the light, gaps, a thin fence, small holes"},
    {NULL, NULL},
};

static void (*const recipes[])(gn_maker *) = {gn_make_grove, gn_make_railing, gn_make_leafbox,
                                              gn_make_court, gn_make_edges};

gn_procedural_desc gn_procedural_desc_default(void)
{
    return (gn_procedural_desc){.cookie = GN_COOKIE, .seed = 1, .scale = 1, .unit = 1};
}

gn_result gn_scene_create_procedural(gn_device *device, const char *name,
                                     const gn_procedural_desc *desc, gn_scene **scene)
{
    *scene = NULL;
    gn_context *context = (gn_context *)device;
    gn_procedural_desc defaults = gn_procedural_desc_default();
    if (!desc)
        desc = &defaults;
    GN_CHECK_DESC(context, desc, gn_procedural_desc);
    if (!(desc->scale >= 0.001 && desc->scale <= 1000))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "scale of a procedural scene is %g, not in [0.001, 1000]", desc->scale);
    if (!(desc->unit >= 1e-6 && desc->unit <= 1e6))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "unit of a procedural scene is %g, not in [1e-6, 1e6]", desc->unit);
    size_t which = 0;
    while (gn_procedurals[which].name && (!name || strcmp(gn_procedurals[which].name, name) != 0))
        which++;
    if (!gn_procedurals[which].name)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "there is no procedural scene named '%s'", name ? name : "(null)");

    gn_maker maker = {
        .context = context, .unit = (float)desc->unit, .scale = desc->scale, .seed = desc->seed};
    maker.result = gn_scene_create(device, &maker.scene);
    if (maker.result == GN_OK)
        recipes[which](&maker);
    if (maker.result == GN_OK)
        maker.result = gn_scene_commit(maker.scene);
    if (maker.result == GN_OK)
        *scene = maker.scene;
    else
        gn_scene_destroy(&maker.scene);
    return maker.result;
}

/* Random numbers: PCG32, XSH RR (O'Neill 2014) ------------------------------------------------ */

gn_random gn_random_make(uint64_t seed, uint64_t stream)
{
    gn_random random = {.state = 0, .increment = stream << 1 | 1};
    gn_random_bits(&random);
    random.state += seed;
    gn_random_bits(&random);
    return random;
}

uint32_t gn_random_bits(gn_random *random)
{
    uint64_t state = random->state;
    random->state = state * 6364136223846793005u + random->increment;
    uint32_t shifted = (uint32_t)((state >> 18 ^ state) >> 27), turn = (uint32_t)(state >> 59);
    return shifted >> turn | shifted << (-turn & 31);
}

float gn_random_range(gn_random *random, float low, float high)
{
    return low + (high - low) * (float)(gn_random_bits(random) >> 8) * 0x1p-24f;
}

gn_vec gn_random_direction(gn_random *random)
{
    float y = gn_random_range(random, -1, 1), turn = gn_random_range(random, 0, 2 * GN_PI);
    float radius = sqrtf(1 - y * y);
    return (gn_vec){radius * cosf(turn), y, radius * sinf(turn)};
}

gn_vec gn_vec_beside(gn_vec a)
{
    gn_vec other = fabsf(a.y) < 0.9f ? (gn_vec){0, 1, 0} : (gn_vec){1, 0, 0};
    return gn_vec_unit(gn_vec_cross(other, a));
}

/* Maker ------------------------------------------------------------------------------------- */

/* Remembers the first error. */
static bool made(gn_maker *maker, gn_result result)
{
    if (maker->result == GN_OK)
        maker->result = result;
    return maker->result == GN_OK;
}

static float linear_from_srgb(uint32_t byte)
{
    float value = (float)byte / 255;
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

static void set_color(float linear[3], uint32_t color)
{
    for (unsigned i = 0; i < 3; i++)
        linear[i] = linear_from_srgb(color >> (16 - 8 * i) & 0xff);
}

uint32_t gn_refine(const gn_maker *maker, uint32_t cells, uint32_t least)
{
    const uint32_t refined = (uint32_t)((double)cells * sqrt(fmin(maker->scale, 1)));
    return refined > least ? refined : least;
}

uint32_t gn_make_material(gn_maker *maker, const char *name, gn_surface_kind kind, uint32_t texture,
                          uint32_t color)
{
    uint32_t index = GN_NONE;
    gn_material_desc desc = gn_material_desc_default();
    desc.name = name;
    desc.texture = texture;
    set_color(desc.base_color, color);
    bool masked = kind == GN_SURFACE_CUTOUT || kind == GN_SURFACE_NETTING;
    desc.alpha_mode = masked ? GN_ALPHA_MASK : GN_ALPHA_OPAQUE;
    desc.double_sided = kind != GN_SURFACE_SOLID;
    if (kind == GN_SURFACE_CUTOUT)
        desc.wrap_u = desc.wrap_v = GN_WRAP_CLAMP;
    if (maker->result == GN_OK)
        made(maker, gn_scene_add_material(maker->scene, &desc, &index));
    return index;
}

static void set_vec(float values[3], gn_vec vec, float scale)
{
    values[0] = vec.x * scale;
    values[1] = vec.y * scale;
    values[2] = vec.z * scale;
}

/* Adds a node whose translation is still in metres. */
static uint32_t add_node(gn_maker *maker, gn_node_desc *desc)
{
    uint32_t index = GN_NONE;
    if (maker->result != GN_OK)
        return index;
    for (unsigned i = 0; i < 3; i++)
        desc->translation[i] *= maker->unit;
    if (made(maker, gn_scene_add_node(maker->scene, desc, &index)) && desc->mesh != GN_NONE)
        maker->triangles += maker->mesh_triangles[desc->mesh];
    return index;
}

uint32_t gn_make_node(gn_maker *maker, const char *name, uint32_t parent, uint32_t mesh,
                      gn_place place)
{
    gn_node_desc desc = gn_node_desc_default();
    desc.name = name;
    desc.parent = parent;
    desc.mesh = mesh;
    set_vec(desc.translation, place.position, 1);
    desc.rotation[1] = sinf(place.yaw / 2);
    desc.rotation[3] = cosf(place.yaw / 2);
    desc.scale[0] = desc.scale[1] = desc.scale[2] = place.scale;
    return add_node(maker, &desc);
}

/* The rotation that takes +Z to forward and +Y near to up (Shepperd's method). */
static void facing(gn_vec forward, float quaternion[4])
{
    gn_vec z = gn_vec_unit(forward);
    gn_vec x = gn_vec_cross((gn_vec){0, 1, 0}, z);
    x = gn_vec_length(x) > 1e-5f ? gn_vec_unit(x) : (gn_vec){1, 0, 0};
    gn_vec y = gn_vec_cross(z, x);
    float q[4] = {y.z - z.y, z.x - x.z, x.y - y.x, 1 + x.x + y.y + z.z};
    if (q[3] < 0.5f) {
        if (x.x >= y.y && x.x >= z.z)
            memcpy(q, (float[]){1 + x.x - y.y - z.z, x.y + y.x, z.x + x.z, y.z - z.y}, sizeof q);
        else if (y.y >= z.z)
            memcpy(q, (float[]){x.y + y.x, 1 - x.x + y.y - z.z, y.z + z.y, z.x - x.z}, sizeof q);
        else
            memcpy(q, (float[]){z.x + x.z, y.z + z.y, 1 - x.x - y.y + z.z, x.y - y.x}, sizeof q);
    }
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (unsigned i = 0; i < 4; i++)
        quaternion[i] = q[i] / length;
}

uint32_t gn_make_node_facing(gn_maker *maker, const char *name, uint32_t mesh, gn_vec position,
                             gn_vec forward, float scale)
{
    gn_node_desc desc = gn_node_desc_default();
    desc.name = name;
    desc.mesh = mesh;
    set_vec(desc.translation, position, 1);
    facing(forward, desc.rotation);
    desc.scale[0] = desc.scale[1] = desc.scale[2] = scale;
    return add_node(maker, &desc);
}

/* Lights and cameras look along -Z: their +Z looks backward. */
static uint32_t add_looker(gn_maker *maker, const char *name, gn_vec position, gn_vec backward,
                           uint32_t light, uint32_t camera)
{
    gn_node_desc desc = gn_node_desc_default();
    desc.name = name;
    desc.light = light;
    desc.camera = camera;
    set_vec(desc.translation, position, 1);
    facing(backward, desc.rotation);
    return add_node(maker, &desc);
}

void gn_make_sun(gn_maker *maker, gn_vec toward, float intensity)
{
    uint32_t light = GN_NONE;
    gn_light_desc desc = gn_light_desc_default();
    desc.name = "Sun";
    set_color(desc.color, 0xfff4e0);
    desc.intensity = intensity;
    if (maker->result == GN_OK && made(maker, gn_scene_add_light(maker->scene, &desc, &light)))
        add_looker(maker, "Sun", gn_vec_scale(gn_vec_unit(toward), 30), toward, light, GN_NONE);
}

void gn_make_lamp(gn_maker *maker, gn_vec position, uint32_t color, float intensity, float range,
                  bool on)
{
    uint32_t light = GN_NONE;
    gn_light_desc desc = gn_light_desc_default();
    desc.name = "Lamp";
    desc.type = GN_LIGHT_POINT;
    set_color(desc.color, color);
    desc.intensity = intensity * maker->unit * maker->unit;
    desc.range = range * maker->unit;
    desc.on = on;
    if (maker->result == GN_OK && made(maker, gn_scene_add_light(maker->scene, &desc, &light)))
        add_looker(maker, "Lamp", position, (gn_vec){0, 0, 1}, light, GN_NONE);
}

static uint32_t add_camera(gn_maker *maker, const char *name, gn_vec eye, gn_vec target,
                           float degrees)
{
    uint32_t camera = GN_NONE;
    gn_camera_desc desc = gn_camera_desc_default();
    desc.name = name;
    desc.yfov = degrees * GN_PI / 180;
    desc.znear = 0.1f * maker->unit;
    if (maker->result != GN_OK || !made(maker, gn_scene_add_camera(maker->scene, &desc, &camera)))
        return GN_NONE;
    return add_looker(maker, name, eye, gn_vec_sub(eye, target), GN_NONE, camera);
}

void gn_make_camera(gn_maker *maker, const char *name, gn_vec eye, gn_vec target, float degrees)
{
    add_camera(maker, name, eye, target, degrees);
}

/* Chooses the sign of q that is nearer to the quaternion before, for the shorter way. */
static void keep_sign(float q[4], const float before[4])
{
    if (q[0] * before[0] + q[1] * before[1] + q[2] * before[2] + q[3] * before[3] < 0)
        for (unsigned i = 0; i < 4; i++)
            q[i] = -q[i];
}

static void add_channel(gn_maker *maker, uint32_t node, gn_animation_path path,
                        gn_interpolation interpolation, uint32_t count, const float *times,
                        const float *values)
{
    gn_channel_desc desc = gn_channel_desc_default();
    desc.node = node;
    desc.path = path;
    desc.interpolation = interpolation;
    desc.key_count = count;
    desc.times = times;
    desc.values = values;
    if (maker->result == GN_OK)
        made(maker, gn_scene_add_channel(maker->scene, &desc));
}

void gn_make_moving_camera(gn_maker *maker, const char *name, const gn_vec *eyes,
                           const gn_vec *targets, uint32_t count, float seconds, float degrees)
{
    uint32_t node = add_camera(maker, name, eyes[0], targets[0], degrees);
    float *keys = gn_alloc(maker->context, count, 8 * sizeof *keys);
    if (!keys)
        made(maker, gn_fail(maker->context, GN_ERROR_OUT_OF_MEMORY, "no memory for a camera path"));
    if (maker->result == GN_OK) {
        float *times = keys, *positions = times + count, *rotations = positions + 3 * count;
        for (uint32_t i = 0; i < count; i++) {
            times[i] = seconds * (float)i / (float)(count - 1);
            set_vec(positions + 3 * i, eyes[i], maker->unit);
            facing(gn_vec_sub(eyes[i], targets[i]), rotations + 4 * i);
            if (i > 0)
                keep_sign(rotations + 4 * i, rotations + 4 * i - 4);
        }
        add_channel(maker, node, GN_PATH_TRANSLATION, GN_INTERPOLATION_LINEAR, count, times,
                    positions);
        add_channel(maker, node, GN_PATH_ROTATION, GN_INTERPOLATION_LINEAR, count, times,
                    rotations);
    }
    gn_free(maker->context, keys);
}

void gn_make_loop(gn_maker *maker, uint32_t node, const gn_vec *positions, uint32_t count,
                  float seconds)
{
    uint32_t keys = count + 1;
    float *data = gn_alloc(maker->context, keys, 14 * sizeof *data);
    if (!data)
        made(maker, gn_fail(maker->context, GN_ERROR_OUT_OF_MEMORY, "no memory for an animation"));
    if (maker->result == GN_OK) {
        float *times = data, *moves = times + keys, *turns = moves + 9 * keys;
        float step = seconds / (float)count;
        for (uint32_t i = 0; i < keys; i++) {
            gn_vec before = positions[(i + count - 1) % count];
            gn_vec after = positions[(i + 1) % count];
            gn_vec tangent = gn_vec_scale(gn_vec_sub(after, before), 0.5f / step);
            times[i] = step * (float)i;
            set_vec(moves + 9 * i, tangent, maker->unit);
            set_vec(moves + 9 * i + 3, positions[i % count], maker->unit);
            set_vec(moves + 9 * i + 6, tangent, maker->unit);
            facing(tangent, turns + 4 * i);
            if (i > 0)
                keep_sign(turns + 4 * i, turns + 4 * i - 4);
        }
        add_channel(maker, node, GN_PATH_TRANSLATION, GN_INTERPOLATION_CUBICSPLINE, keys, times,
                    moves);
        add_channel(maker, node, GN_PATH_ROTATION, GN_INTERPOLATION_LINEAR, keys, times, turns);
    }
    gn_free(maker->context, data);
}
