/* Textures of the procedural scenes: noise, strokes and leaves with antialiased edges. */
#include "scene/procedural.h"

gn_canvas gn_canvas_begin(gn_maker *maker, uint32_t size, uint32_t color)
{
    gn_canvas canvas = {.maker = maker, .size = size};
    if (maker->result != GN_OK)
        return canvas;
    canvas.rgba = gn_alloc(maker->context, (size_t)size * size, 4);
    if (!canvas.rgba) {
        maker->result = gn_fail(maker->context, GN_ERROR_OUT_OF_MEMORY,
                                "no memory for a texture of a procedural scene");
        return canvas;
    }
    for (size_t i = 0; i < (size_t)size * size; i++) {
        uint8_t *texel = canvas.rgba + 4 * i;
        texel[0] = (uint8_t)(color >> 16);
        texel[1] = (uint8_t)(color >> 8);
        texel[2] = (uint8_t)color;
        texel[3] = 0;
    }
    return canvas;
}

uint32_t gn_make_texture(gn_maker *maker, const char *name, gn_canvas *canvas)
{
    uint32_t index = GN_NONE;
    gn_texture_desc desc = gn_texture_desc_default();
    desc.name = name;
    desc.width = desc.height = canvas->size;
    desc.rgba = canvas->rgba;
    if (maker->result == GN_OK)
        maker->result = gn_scene_add_texture(maker->scene, &desc, &index);
    gn_free(maker->context, canvas->rgba);
    canvas->rgba = NULL;
    return index;
}

uint32_t gn_color_mix(uint32_t a, uint32_t b, float t)
{
    uint32_t mixed = 0;
    for (unsigned shift = 0; shift < 24; shift += 8) {
        float value = gn_mix((float)(a >> shift & 0xff), (float)(b >> shift & 0xff), t);
        mixed |= (uint32_t)(value + 0.5f) << shift;
    }
    return mixed;
}

uint32_t gn_color_shade(uint32_t color, float factor)
{
    uint32_t shaded = 0;
    for (unsigned shift = 0; shift < 24; shift += 8)
        shaded |= (uint32_t)gn_clamp((float)(color >> shift & 0xff) * factor + 0.5f, 0, 255)
                  << shift;
    return shaded;
}

/* Paints a share of one texel. Where nothing was painted before, the colour replaces the
 * background whole, so that edges keep the colour of the leaf. */
static void paint(gn_canvas *canvas, int x, int y, float coverage, uint32_t color)
{
    uint8_t *texel = canvas->rgba + 4 * ((size_t)y * canvas->size + (size_t)x);
    float before = (float)texel[3] / 255, after = coverage + before * (1 - coverage);
    float share = coverage / after;
    for (unsigned i = 0; i < 3; i++) {
        float painted = (float)(color >> (16 - 8 * i) & 0xff);
        texel[i] = (uint8_t)(gn_mix((float)texel[i], painted, share) + 0.5f);
    }
    texel[3] = (uint8_t)(after * 255 + 0.5f);
}

/* The texels within reach of a segment, clipped to the canvas. */
typedef struct extent {
    int x0, y0, x1, y1;
} extent;

static extent find_extent(const gn_canvas *canvas, float ax, float ay, float bx, float by,
                          float reach)
{
    float last = (float)canvas->size - 1;
    return (extent){(int)gn_clamp(floorf(fminf(ax, bx) - reach), 0, last),
                    (int)gn_clamp(floorf(fminf(ay, by) - reach), 0, last),
                    (int)gn_clamp(ceilf(fmaxf(ax, bx) + reach), 0, last),
                    (int)gn_clamp(ceilf(fmaxf(ay, by) + reach), 0, last)};
}

void gn_canvas_stroke(gn_canvas *canvas, float x0, float y0, float r0, float x1, float y1, float r1,
                      uint32_t color)
{
    if (canvas->maker->result != GN_OK)
        return;
    float size = (float)canvas->size;
    float ax = x0 * size, ay = y0 * size, dx = x1 * size - ax, dy = y1 * size - ay;
    float squared = dx * dx + dy * dy, inverse = squared > 0 ? 1 / squared : 0;
    extent box = find_extent(canvas, ax, ay, ax + dx, ay + dy, fmaxf(r0, r1) * size + 1);
    for (int y = box.y0; y <= box.y1; y++) {
        for (int x = box.x0; x <= box.x1; x++) {
            float px = (float)x + 0.5f - ax, py = (float)y + 0.5f - ay;
            float t = gn_clamp((px * dx + py * dy) * inverse, 0, 1);
            float ex = px - t * dx, ey = py - t * dy;
            float distance = sqrtf(ex * ex + ey * ey) - gn_mix(r0, r1, t) * size;
            if (distance < 0.5f)
                paint(canvas, x, y, gn_clamp(0.5f - distance, 0, 1), color);
        }
    }
}

/* 0 at both ends of [0,1], 1 in the middle; skew moves the middle, power fills the ends. */
static float bow(float t, float skew, float power)
{
    return powf(fmaxf(sinf(GN_PI * powf(t, skew)), 0), power);
}

/* Half the width of a leaf at t along its axis, in leaf lengths. */
static float leaf_width(gn_leaf kind, float t)
{
    t = gn_clamp(t, 0, 1);
    switch (kind) {
    case GN_LEAF_LOBED:
        return 0.31f * bow(t, 1.2f, 0.65f) * (0.8f + 0.2f * cosf(2 * GN_PI * (4 * t - 0.15f)));
    case GN_LEAF_NARROW:
        return 0.15f * bow(t, 0.8f, 0.9f);
    case GN_LEAF_BROAD:
        return 0.44f * bow(t, 0.62f, 0.8f) * (0.93f + 0.07f * cosf(2 * GN_PI * 5 * t));
    case GN_LEAF_OVATE:
        break;
    }
    return 0.3f * bow(t, 0.72f, 0.95f);
}

void gn_canvas_leaf(gn_canvas *canvas, gn_leaf kind, float x0, float y0, float angle, float length,
                    uint32_t color)
{
    enum { STEPS = 64 };
    if (canvas->maker->result != GN_OK)
        return;
    float width[STEPS + 2], size = (float)canvas->size, texels = length * size;
    for (int i = 0; i < STEPS + 2; i++)
        width[i] = leaf_width(kind, (float)i / STEPS);
    float ax = x0 * size, ay = y0 * size, dx = cosf(angle), dy = sinf(angle);
    uint32_t light = gn_color_shade(color, 1.12f), dark = gn_color_shade(color, 0.90f);
    uint32_t vein = gn_color_mix(color, 0xd8e0a0, 0.35f);
    extent box =
        find_extent(canvas, ax, ay, ax + dx * texels, ay + dy * texels, 0.46f * texels + 1);
    for (int y = box.y0; y <= box.y1; y++) {
        for (int x = box.x0; x <= box.x1; x++) {
            float px = ((float)x + 0.5f - ax) / texels, py = ((float)y + 0.5f - ay) / texels;
            float along = px * dx + py * dy, across = py * dx - px * dy;
            float t = gn_clamp(along, 0, 1), k = t * STEPS;
            int i = (int)k;
            float slope = (width[i + 1] - width[i]) * STEPS;
            float half = width[i] + (width[i + 1] - width[i]) * (k - (float)i);
            /* The distance to the outline, to first order; past the ends, to the end. */
            float beyond = along - t, outside = fabsf(across) - half;
            float distance = beyond != 0 ? sqrtf(beyond * beyond + across * across)
                                         : outside / sqrtf(1 + slope * slope);
            float coverage = gn_clamp(0.5f - distance * texels, 0, 1);
            if (coverage <= 0)
                continue;
            float middle = gn_clamp(1.2f - fabsf(across) * texels, 0, 1);
            float side = gn_smooth(0.8f, 1, sinf(40 * (t - 0.7f * fabsf(across))));
            uint32_t shade = gn_color_mix(across > 0 ? dark : light, vein, 0.35f * side);
            paint(canvas, x, y, coverage, gn_color_mix(shade, vein, middle));
        }
    }
}

/* Noise ------------------------------------------------------------------------------------- */

static float lattice(uint32_t x, uint32_t y, uint32_t seed)
{
    uint32_t hash = (x * 0x8da6b343u) ^ (y * 0xd8163841u) ^ (seed * 0xcb1ab31fu);
    hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
    return (float)(hash >> 8) * 0x1p-24f;
}

float gn_noise(float x, float y, uint32_t period, uint32_t seed)
{
    int32_t column = (int32_t)x, row = (int32_t)y;
    uint32_t last = period - 1;
    uint32_t x0 = (uint32_t)column & last, x1 = (x0 + 1) & last;
    uint32_t y0 = (uint32_t)row & last, y1 = (y0 + 1) & last;
    float u = x - (float)column, v = y - (float)row;
    u = u * u * (3 - 2 * u);
    v = v * v * (3 - 2 * v);
    return gn_mix(gn_mix(lattice(x0, y0, seed), lattice(x1, y0, seed), u),
                  gn_mix(lattice(x0, y1, seed), lattice(x1, y1, seed), u), v);
}

float gn_noise_octaves(float u, float v, uint32_t period, uint32_t octaves, uint32_t seed)
{
    float sum = 0, weight = 0.5f, total = 0;
    for (uint32_t i = 0; i < octaves; i++, period *= 2, weight *= 0.5f) {
        sum += weight * gn_noise(u * (float)period, v * (float)period, period, seed + i);
        total += weight;
    }
    return sum / total;
}
