/* The textures of the procedural scenes: twigs, grass and netting with alpha, and what walls,
 * trunks and ground are made of. */
#include "scene/procedural.h"

/* Twigs ------------------------------------------------------------------------------------- */

typedef struct twig {
    gn_leaf leaf;
    uint32_t size;       /* texels */
    float length;        /* of a leaf */
    float spread;        /* how far leaves stand off their stalk, radians */
    float step;          /* between leaves */
    float side_step;     /* between side stalks */
    float side_length;   /* of the longest side stalk */
    uint32_t young, old; /* colours of leaves */
    uint32_t stalk;
} twig;

/* Whether a leaf that ends here keeps clear of the canvas' edge. */
static bool fits(float x, float y)
{
    return x > 0.03f && x < 0.97f && y > 0.03f && y < 0.97f;
}

static void draw_leaf(gn_canvas *canvas, const twig *kind, gn_random *random, float x, float y,
                      float angle)
{
    float length = kind->length * gn_random_range(random, 0.75f, 1.15f);
    uint32_t color = gn_color_mix(kind->old, kind->young, gn_random_range(random, 0, 1));
    color = gn_color_shade(color, gn_random_range(random, 0.86f, 1.1f));
    float ex = x + 1.05f * length * cosf(angle), ey = y + 1.05f * length * sinf(angle);
    if (!fits(ex, ey) || !fits(x, y))
        return;
    /* A short stalk of its own, then the blade. */
    float sx = x + 0.12f * length * cosf(angle), sy = y + 0.12f * length * sinf(angle);
    gn_canvas_stroke(canvas, x, y, 0.0022f, sx, sy, 0.0016f, kind->stalk);
    gn_canvas_leaf(canvas, kind->leaf, sx, sy, angle, length, color);
}

/* A stalk with leaves on both sides and one at its tip. */
static void draw_stalk(gn_canvas *canvas, const twig *kind, gn_random *random, float x, float y,
                       float angle, float length, float radius, bool bare)
{
    float bend = gn_random_range(random, -0.35f, 0.35f), walked = 0, until = kind->step;
    const float stride = 0.02f;
    int side = 1;
    while (walked < length) {
        float t = walked / length, turned = angle + bend * t;
        float nx = x + stride * cosf(turned), ny = y + stride * sinf(turned);
        if (!fits(nx, ny < 0.9f ? ny : 0.5f))
            break;
        gn_canvas_stroke(canvas, x, y, radius * (1 - 0.7f * t), nx, ny, radius * (1 - 0.7f * t),
                         kind->stalk);
        x = nx;
        y = ny;
        walked += stride;
        until -= stride;
        if (until <= 0 && !bare) {
            float off = kind->spread * gn_random_range(random, 0.7f, 1.25f);
            draw_leaf(canvas, kind, random, x, y, turned + (float)side * off);
            if (kind->leaf == GN_LEAF_NARROW) /* opposite leaflets */
                draw_leaf(canvas, kind, random, x, y, turned - (float)side * off);
            side = -side;
            until += kind->step;
        }
    }
    if (!bare)
        draw_leaf(canvas, kind, random, x, y, angle + bend);
}

static gn_canvas draw_twig(gn_maker *maker, const twig *kind, uint64_t stream)
{
    gn_random random = gn_random_make(maker->seed, stream);
    gn_canvas canvas =
        gn_canvas_begin(maker, kind->size, gn_color_mix(kind->old, kind->young, 0.5f));
    float up = -GN_PI / 2;
    /* The main stalk, straight, then side stalks from the far end back to the near one, so that
     * the nearer lie on top. */
    gn_canvas_stroke(&canvas, 0.5f, 1, 0.008f, 0.5f, 0.2f, 0.004f, kind->stalk);
    draw_stalk(&canvas, kind, &random, 0.5f, 0.62f, up, 0.5f, 0.004f, false);
    int count = (int)(0.72f / kind->side_step);
    for (int i = count; i >= 0; i--) {
        float t = (float)i / (float)count, y = 0.93f - 0.72f * t;
        float reach = kind->side_length * (0.55f + 0.45f * sinf(GN_PI * (0.15f + 0.7f * t)));
        for (int side = -1; side <= 1; side += 2) {
            float angle =
                up + (float)side * gn_mix(1.15f, 0.55f, t) * gn_random_range(&random, 0.85f, 1.15f);
            float at = y + gn_random_range(&random, -0.02f, 0.02f);
            draw_stalk(&canvas, kind, &random, 0.5f, gn_clamp(at, 0.1f, 0.96f), angle,
                       reach * gn_random_range(&random, 0.8f, 1.1f), 0.0035f, false);
        }
    }
    return canvas;
}

static gn_canvas draw_fir(gn_maker *maker)
{
    gn_random random = gn_random_make(maker->seed, 40);
    gn_canvas canvas = gn_canvas_begin(maker, 512, 0x2f4a2a);
    for (int i = 15; i >= 0; i--) {
        float t = (float)i / 15, y = 0.95f - 0.8f * t;
        for (int side = -1; side <= 1; side += 2) {
            float angle = -GN_PI / 2 + (float)side * gn_random_range(&random, 0.75f, 1.05f);
            float length = gn_mix(0.42f, 0.12f, t) * gn_random_range(&random, 0.8f, 1.1f);
            if (i == 15 && side == 1) {
                angle = -GN_PI / 2;
                length = 0.12f;
            }
            float x = 0.5f, dx = cosf(angle), dy = sinf(angle);
            for (float s = 0; s < length && fits(x + s * dx, y + s * dy); s += 0.007f) {
                float px = x + s * dx, py = y + s * dy;
                for (int edge = -1; edge <= 1; edge += 2) {
                    float turn = angle + (float)edge * gn_random_range(&random, 0.5f, 0.9f);
                    float needle = 0.045f * gn_random_range(&random, 0.7f, 1.1f);
                    uint32_t color =
                        gn_color_mix(0x2c4728, 0x51713a, gn_random_range(&random, 0, 1));
                    gn_canvas_stroke(&canvas, px, py, 0.0026f, px + needle * cosf(turn),
                                     py + needle * sinf(turn), 0.0016f, color);
                }
            }
            gn_canvas_stroke(&canvas, x, y, 0.004f, x + 0.97f * length * dx,
                             y + 0.97f * length * dy, 0.002f, 0x5d4a33);
        }
    }
    gn_canvas_stroke(&canvas, 0.5f, 1, 0.008f, 0.5f, 0.1f, 0.003f, 0x5d4a33);
    return canvas;
}

/* Blades that bend outward from the lower edge; some end in a flower. */
static gn_canvas draw_grass(gn_maker *maker, bool flowers)
{
    gn_random random = gn_random_make(maker->seed, flowers ? 42 : 41);
    gn_canvas canvas = gn_canvas_begin(maker, 256, 0x86964a);
    int blades = flowers ? 34 : 60;
    for (int i = 0; i < blades; i++) {
        float foot = gn_random_range(&random, 0.3f, 0.7f), lean = (foot - 0.5f) * 2.2f;
        lean += gn_random_range(&random, -0.25f, 0.25f);
        float height = gn_random_range(&random, 0.4f, 0.93f) * (1 - 0.35f * fabsf(lean));
        float width = gn_random_range(&random, 0.006f, 0.011f), x = foot, y = 1;
        uint32_t color = gn_color_mix(0x6c8238, 0xa8b060, gn_random_range(&random, 0, 1));
        for (int k = 1; k <= 10; k++) {
            float t = (float)k / 10, nx = foot + 0.55f * lean * t * t, ny = 1 - height * t;
            if (nx < 0.03f || nx > 0.97f)
                break;
            gn_canvas_stroke(&canvas, x, y, width * (1.05f - t + 0.1f), nx, ny, width * (1.05f - t),
                             gn_color_shade(color, 0.8f + 0.25f * t));
            x = nx;
            y = ny;
        }
        if (flowers && i % 4 == 0 && fits(x, y - 0.03f)) {
            uint32_t petal = i % 8 == 0 ? 0xe8dcc0 : 0xd9b23a;
            for (int k = 0; k < 6; k++) {
                float turn = GN_PI / 3 * (float)k;
                gn_canvas_stroke(&canvas, x, y, 0.008f, x + 0.024f * cosf(turn),
                                 y + 0.024f * sinf(turn), 0.009f, petal);
            }
            gn_canvas_stroke(&canvas, x, y, 0.009f, x, y, 0.009f, 0xb8802a);
        }
    }
    return canvas;
}

/* Diamonds of wire; the texture repeats. */
static gn_canvas draw_wire(gn_maker *maker)
{
    gn_canvas canvas = gn_canvas_begin(maker, 256, 0x8c9094);
    for (int i = -4; i <= 8; i++) {
        float start = 0.25f * (float)i;
        gn_canvas_stroke(&canvas, start, -0.05f, 0.016f, start + 1.1f, 1.05f, 0.016f, 0x9aa0a4);
        gn_canvas_stroke(&canvas, start, 1.05f, 0.016f, start + 1.1f, -0.05f, 0.016f, 0x858a8e);
    }
    return canvas;
}

/* Opaque materials -------------------------------------------------------------------------- */

/* The colour of a material at (u, v) in [0,1)^2; periodic. */
typedef uint32_t (*material_color)(float u, float v);

static uint32_t bark(float u, float v)
{
    float wander = 0.08f * gn_noise(u * 4, v * 4, 4, 3);
    float ridge = gn_noise_octaves(u + wander, v * 0.25f, 16, 3, 7);
    float fine = gn_noise_octaves(u, v, 32, 2, 9);
    float depth = fabsf(ridge - 0.5f) * 3.2f;
    return gn_color_shade(gn_color_mix(0x3a2c20, 0x85705a, gn_clamp(depth, 0, 1)),
                          0.8f + 0.35f * fine);
}

static uint32_t birch_bark(float u, float v)
{
    float tone = gn_noise_octaves(u, v, 4, 4, 21);
    float dash = gn_noise(u * 4, v * 32, 32, 23), patch = gn_noise_octaves(u, v, 4, 3, 29);
    uint32_t color = gn_color_mix(0xb9b2a4, 0xe9e4da, tone);
    color = gn_color_mix(color, 0x4a443e, gn_smooth(0.74f, 0.84f, dash));
    return gn_color_mix(color, 0x3c3631, gn_smooth(0.66f, 0.74f, patch));
}

static uint32_t meadow(float u, float v)
{
    float patch = gn_noise_octaves(u, v, 4, 2, 31), fine = gn_noise_octaves(u, v, 64, 3, 37);
    float dry = gn_smooth(0.5f, 0.8f, gn_noise_octaves(u, v, 8, 3, 41));
    uint32_t color = gn_color_mix(0x5b6b33, 0x86904a, patch);
    color = gn_color_mix(color, 0x9a8a5c, 0.6f * dry);
    return gn_color_shade(color, 0.72f + 0.5f * fine);
}

static uint32_t gravel(float u, float v)
{
    float patch = gn_noise_octaves(u, v, 4, 2, 51), stone = gn_noise(u * 64, v * 64, 64, 53);
    float fine = gn_noise_octaves(u, v, 64, 2, 57);
    uint32_t color = gn_color_mix(0x8f8268, 0xb9ab8c, patch);
    color = gn_color_mix(color, 0xcfc7b4, 0.5f * gn_smooth(0.62f, 0.8f, stone));
    color = gn_color_mix(color, 0x6d6250, 0.5f * gn_smooth(0.62f, 0.8f, 1 - stone));
    return gn_color_shade(color, 0.82f + 0.32f * fine);
}

static uint32_t stone(float u, float v)
{
    float tone = gn_noise_octaves(u, v, 4, 4, 61), moss = gn_noise_octaves(u, v, 4, 3, 67);
    uint32_t color = gn_color_mix(0x6f6d68, 0xb4b0a8, tone);
    return gn_color_mix(color, 0x7d8558, 0.6f * gn_smooth(0.55f, 0.75f, moss));
}

/* Rows of blocks with joints between them, each block a little different. */
static uint32_t blocks(float u, float v, float columns, float rows, float joint, uint32_t dark,
                       uint32_t bright, uint32_t mortar)
{
    float row = floorf(v * rows), shift = 0.5f * fmodf(row, 2);
    float column = floorf(u * columns + shift);
    float x = u * columns + shift - column, y = v * rows - row;
    float rough = 0.6f * joint * gn_noise_octaves(u, v, 32, 2, 71);
    float edge = fminf(fminf(x, 1 - x) * rows / columns, fminf(y, 1 - y));
    float tone = gn_noise(fmodf(column, columns) + 0.5f * row, row, 64, 73);
    uint32_t color = gn_color_mix(dark, bright, tone);
    color = gn_color_shade(color, 0.82f + 0.36f * gn_noise_octaves(u, v, 16, 4, 79));
    return gn_color_mix(mortar, color, gn_smooth(joint - rough, joint + 0.05f - rough, edge));
}

static uint32_t masonry(float u, float v)
{
    return blocks(u, v, 4, 8, 0.06f, 0xa79c86, 0xd2c8b0, 0x8d8370);
}

static uint32_t paving(float u, float v)
{
    return blocks(u, v, 4, 4, 0.025f, 0xa8a294, 0xc9c3b4, 0x7c776b);
}

static uint32_t planks(float u, float v)
{
    float board = floorf(u * 4), x = u * 4 - board;
    float grain = gn_noise_octaves(u, v * 0.125f + 0.17f * board, 32, 3, 83);
    float tone = gn_noise(board, 0, 4, 89);
    uint32_t color = gn_color_mix(0x6e5236, 0x9c7a52, 0.5f * tone + 0.5f * grain);
    return gn_color_mix(0x3a2a1c, color, gn_smooth(0.01f, 0.05f, fminf(x, 1 - x)));
}

static uint32_t shingles(float u, float v)
{
    float row = floorf(v * 8), shift = 0.5f * fmodf(row, 2);
    float column = floorf(u * 8 + shift), x = u * 8 + shift - column, y = v * 8 - row;
    float tone = gn_noise(fmodf(column, 8) + 0.31f * row, row, 64, 97);
    uint32_t color = gn_color_mix(0x7c4a36, 0xb07052, tone);
    color = gn_color_shade(color,
                           (0.7f + 0.35f * y) * (0.85f + 0.3f * gn_noise_octaves(u, v, 32, 2, 99)));
    return gn_color_mix(0x3d261c, color, gn_smooth(0.01f, 0.07f, fminf(x, 1 - x)));
}

/* A banner: a border, a field and a sun with rays. */
static uint32_t cloth(float u, float v)
{
    float weave = 0.94f + 0.06f * sinf(2 * GN_PI * 64 * u) * sinf(2 * GN_PI * 64 * v);
    float x = u - 0.5f, y = v - 0.5f, radius = sqrtf(x * x + y * y);
    float edge = fminf(fminf(u, 1 - u), fminf(v, 1 - v));
    float rays = 0.245f + 0.055f * cosf(12 * atan2f(y, x));
    uint32_t color = gn_color_mix(0xd9a832, 0x9c2a26, gn_smooth(-0.006f, 0.006f, radius - rays));
    color = gn_color_mix(0x7a1d1c, color, gn_smooth(0.006f, 0.014f, fabsf(radius - 0.15f)));
    color = gn_color_mix(0xd9a832, color, gn_smooth(0.004f, 0.012f, fabsf(edge - 0.06f) - 0.014f));
    return gn_color_shade(color, weave);
}

typedef struct drawing {
    gn_canvas canvas;
    material_color color;
} drawing;

static void draw_row(uint32_t y, uint32_t thread, void *user)
{
    (void)thread;
    const drawing *work = user;
    float size = (float)work->canvas.size;
    uint8_t *texel = work->canvas.rgba + 4 * (size_t)y * work->canvas.size;
    for (uint32_t x = 0; x < work->canvas.size; x++, texel += 4) {
        uint32_t color = work->color(((float)x + 0.5f) / size, ((float)y + 0.5f) / size);
        texel[0] = (uint8_t)(color >> 16);
        texel[1] = (uint8_t)(color >> 8);
        texel[2] = (uint8_t)color;
        texel[3] = 255;
    }
}

static gn_canvas draw_material(gn_maker *maker, uint32_t size, material_color color)
{
    drawing work = {gn_canvas_begin(maker, size, 0), color};
    if (maker->result == GN_OK)
        gn_parallel_for(maker->context, size, draw_row, &work);
    return work.canvas;
}

/* Everything by number ---------------------------------------------------------------------- */

static const twig oak_twig = {GN_LEAF_LOBED, 512,   0.155f,   0.95f,    0.06f,
                              0.10f,         0.40f, 0x7f9440, 0x4f6a2c, 0x5a4630};
static const twig lime_twig = {GN_LEAF_BROAD, 512,   0.105f,   1.0f,     0.065f,
                               0.11f,         0.40f, 0x8fa54a, 0x587a30, 0x64503a};
static const twig birch_twig = {GN_LEAF_OVATE, 512,   0.085f,   0.85f,    0.075f,
                                0.13f,         0.42f, 0xa5b455, 0x71903a, 0x6a5648};
static const twig ash_twig = {GN_LEAF_NARROW, 256,   0.13f,    0.85f,    0.065f,
                              0.24f,          0.40f, 0x93a648, 0x5f7d36, 0x5f5238};
static const twig bush_twig = {GN_LEAF_OVATE, 256,   0.12f,    0.9f,     0.06f,
                               0.12f,         0.38f, 0x6f8a3c, 0x3f5c2a, 0x52422e};

uint32_t gn_make_texture_kind(gn_maker *maker, gn_texture_kind kind)
{
    static const struct {
        const char *name;
        const twig *twig;
        material_color color;
        uint32_t size;
    } kinds[] = {
        [GN_TEXTURE_OAK] = {"oak twig", .twig = &oak_twig},
        [GN_TEXTURE_LIME] = {"lime twig", .twig = &lime_twig},
        [GN_TEXTURE_BIRCH] = {"birch twig", .twig = &birch_twig},
        [GN_TEXTURE_ASH] = {"ash twig", .twig = &ash_twig},
        [GN_TEXTURE_FIR] = {.name = "fir twig"},
        [GN_TEXTURE_BUSH] = {"bush twig", .twig = &bush_twig},
        [GN_TEXTURE_GRASS] = {.name = "grass"},
        [GN_TEXTURE_FLOWER] = {.name = "flowers"},
        [GN_TEXTURE_WIRE] = {.name = "wire netting"},
        [GN_TEXTURE_BARK] = {"bark", .color = bark, .size = 256},
        [GN_TEXTURE_BIRCH_BARK] = {"birch bark", .color = birch_bark, .size = 256},
        [GN_TEXTURE_MEADOW] = {"meadow", .color = meadow, .size = 512},
        [GN_TEXTURE_GRAVEL] = {"gravel", .color = gravel, .size = 512},
        [GN_TEXTURE_STONE] = {"stone", .color = stone, .size = 256},
        [GN_TEXTURE_MASONRY] = {"masonry", .color = masonry, .size = 256},
        [GN_TEXTURE_PLANKS] = {"planks", .color = planks, .size = 256},
        [GN_TEXTURE_SHINGLES] = {"shingles", .color = shingles, .size = 256},
        [GN_TEXTURE_PAVING] = {"paving", .color = paving, .size = 256},
        [GN_TEXTURE_CLOTH] = {"cloth", .color = cloth, .size = 512},
    };
    gn_canvas canvas;
    if (kinds[kind].twig)
        canvas = draw_twig(maker, kinds[kind].twig, kind);
    else if (kinds[kind].color)
        canvas = draw_material(maker, kinds[kind].size, kinds[kind].color);
    else if (kind == GN_TEXTURE_FIR)
        canvas = draw_fir(maker);
    else if (kind == GN_TEXTURE_WIRE)
        canvas = draw_wire(maker);
    else
        canvas = draw_grass(maker, kind == GN_TEXTURE_FLOWER);
    return gn_make_texture(maker, kinds[kind].name, &canvas);
}
