/* Leak tracing by the book: one frame of one light, pixel after pixel, from arrays, in the paper's
 * long forms (leak tracing paper, section 3). Takes nothing from gnomon/shadow/leak.h. */
#ifndef GN_TESTS_LEAK_ORACLE_H
#define GN_TESTS_LEAK_ORACLE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <gnomon/view.h>

/* Table 1: a pixel of the mask as booleans. */
typedef struct leak_row {
    bool ltt, st, rs;
} leak_row;

static inline leak_row leak_row_of(gn_leak_class class)
{
    switch (class) {
    case GN_LEAK_GREEN:
        return (leak_row){false, true, false};
    case GN_LEAK_WHITE:
        return (leak_row){true, true, true};
    case GN_LEAK_PURPLE:
        return (leak_row){true, false, true};
    case GN_LEAK_RED:
        return (leak_row){true, false, false};
    case GN_LEAK_YELLOW:
        return (leak_row){true, true, false};
    case GN_LEAK_BLACK:
    case GN_LEAK_NOTHING:
        break;
    }
    return (leak_row){false, false, false};
}

static inline gn_leak_class leak_class_of(bool ltt, bool st, bool rs)
{
    if (!ltt)
        return st ? GN_LEAK_GREEN : GN_LEAK_BLACK;
    if (st)
        return rs ? GN_LEAK_WHITE : GN_LEAK_YELLOW;
    return rs ? GN_LEAK_PURPLE : GN_LEAK_RED;
}

/* Equation 5, and the last term of Equation 6. What faces away from the light has no say. */
static inline bool leak_long_expands(gn_leak_class neighbour, bool st)
{
    if (neighbour == GN_LEAK_NOTHING)
        return false;
    const leak_row m = leak_row_of(neighbour);
    const bool purple = m.ltt && (m.rs && !st);
    const bool yellow = m.ltt && (!m.rs && st);
    const bool changed = (m.st && !st) || (!m.st && st);
    return purple || yellow || changed;
}

/* Equation 7. */
static inline bool leak_long_confirms(gn_leak_class neighbour, bool st)
{
    if (neighbour == GN_LEAK_NOTHING)
        return true;
    const leak_row m = leak_row_of(neighbour);
    const bool white_red = m.ltt && st == m.st && st == m.rs;
    const bool black_green = !m.ltt && st == m.st;
    return white_red || black_green;
}

/* One frame. Arrays have width * height values. */
typedef struct leak_oracle {
    uint32_t width, height;
    bool masked;       /* lt-*, not ltt-* */
    gn_leak_desc desc; /* depth_test ON or OFF */
    uint32_t frame;
    const bool *facing;         /* there is a surface, and the light reaches its front */
    const bool *held;           /* by a layer of the map */
    const bool *moving;         /* a moving caster had a say in the test; NULL: none anywhere */
    const float *test;          /* of the map, where held */
    const float *ray;           /* visibility that a ray finds, where facing */
    const float *motion[3];     /* as in gn_gbuffer */
    const float *depth;         /* as in gn_gbuffer */
    const uint8_t *before;      /* gn_leak_class of the frame before; NULL: there is none */
    const float *depth_before;  /* of the frame before; NULL: not kept */
    float *visibility, *traced; /* out */
    uint8_t *now;               /* out: gn_leak_class */
    gn_leak_counts counts;      /* out */
    uint64_t rays;              /* out */
} leak_oracle;

/* Is a pixel of the mask asked about a place? By the full kernel those around the pixel that the
 * place lies in; by the gather those whose centre is less than a pixel from the moved place. */
static inline bool leak_oracle_asks(const leak_oracle *o, bool full, float place, int32_t column,
                                    bool vertical)
{
    static const float jitter[2][4] = {{-0.25f, 0.25f, -0.25f, 0.25f},
                                       {-0.25f, -0.25f, 0.25f, 0.25f}};
    if (full)
        return fabs((double)column - floor((double)place)) <= 1.0;
    const float moved = place + jitter[vertical][o->frame % 4];
    const double distance = (double)moved - ((double)column + 0.5);
    return distance >= -1.0 && distance < 1.0;
}

typedef struct leak_opinion {
    bool any_expands, all_confirm;
} leak_opinion;

static inline leak_opinion leak_oracle_neighbours(const leak_oracle *o, float x, float y, bool st)
{
    leak_opinion opinion = {false, true};
    const int32_t left = (int32_t)x, top = (int32_t)y;
    for (int32_t row = top - 2; row <= top + 2; row++)
        for (int32_t column = left - 2; column <= left + 2; column++) {
            const bool inside =
                row >= 0 && row < (int32_t)o->height && column >= 0 && column < (int32_t)o->width;
            if (!inside || !leak_oracle_asks(o, true, x, column, false) ||
                !leak_oracle_asks(o, true, y, row, true))
                continue;
            const bool full = o->desc.kernel == GN_LEAK_FULL;
            const gn_leak_class m =
                (gn_leak_class)o->before[(size_t)row * o->width + (size_t)column];
            if (leak_oracle_asks(o, full, x, column, false) &&
                leak_oracle_asks(o, full, y, row, true))
                opinion.any_expands = opinion.any_expands || leak_long_expands(m, st);
            opinion.all_confirm = opinion.all_confirm && leak_long_confirms(m, st);
        }
    return opinion;
}

/* Steps 2 to 5 of section 3.1.3, of a pixel that the map has tested. */
static inline bool leak_oracle_wants_ray(leak_oracle *o, uint32_t column, uint32_t row)
{
    const size_t i = (size_t)row * o->width + column;
    const bool sure = o->test[i] <= o->desc.epsilon || o->test[i] >= 1.0f - o->desc.epsilon;
    const bool st = o->test[i] < 0.5f;
    o->counts.tested++;
    o->counts.unsure += !sure;
    if (!o->masked)
        return !sure;

    const float x = (float)column + 0.5f + o->motion[0][i];
    const float y = (float)row + 0.5f + o->motion[1][i];
    const bool inside = x >= 0.0f && x < (float)o->width && y >= 0.0f && y < (float)o->height;
    const size_t nearest = inside ? (size_t)y * o->width + (size_t)x : 0;
    if (!o->before || !inside || o->before[nearest] == GN_LEAK_NOTHING) {
        o->counts.lost++;
        return true;
    }
    const leak_opinion opinion = leak_oracle_neighbours(o, x, y, st);
    if (sure) {
        const bool expanded = o->desc.expand && opinion.any_expands;
        o->counts.expanded += expanded;
        return expanded;
    }
    const bool near_sure = o->test[i] <= 0.25f || o->test[i] >= 0.75f;
    bool removed =
        o->desc.remove && opinion.all_confirm && near_sure && !(o->moving && o->moving[i]);
    if (o->desc.depth_test == GN_SWITCH_ON) {
        const float expected = o->depth[i] + o->motion[2][i];
        removed = removed && o->depth_before &&
                  fabsf(o->depth_before[nearest] - expected) <= 0.1f * fabsf(expected);
    }
    o->counts.removed += removed;
    return !removed;
}

static inline void leak_oracle_pixel(leak_oracle *o, uint32_t column, uint32_t row)
{
    const size_t i = (size_t)row * o->width + column;
    o->visibility[i] = o->traced[i] = 0.0f;
    o->now[i] = GN_LEAK_NOTHING;
    if (!o->facing[i])
        return;
    o->counts.unheld += !o->held[i];
    const bool ray = !o->held[i] || leak_oracle_wants_ray(o, column, row);
    /* Without a map its test is taken to be right; with one a partial answer contradicts it. */
    const bool st = o->held[i] ? o->test[i] < 0.5f : o->ray[i] < 0.5f;
    const bool rs = !o->held[i] ? st : st ? o->ray[i] < 0.1f : o->ray[i] < 1.0f - 0.1f;
    o->rays += ray;
    o->traced[i] = ray ? 1.0f : 0.0f;
    o->visibility[i] = ray ? o->ray[i] : st ? 0.0f : 1.0f;
    o->now[i] = (uint8_t)leak_class_of(ray, st, rs);
}

static inline void leak_oracle_frame(leak_oracle *o)
{
    o->counts = (gn_leak_counts){0};
    o->rays = 0;
    for (uint32_t row = 0; row < o->height; row++)
        for (uint32_t column = 0; column < o->width; column++)
            leak_oracle_pixel(o, column, row);
}

#endif
