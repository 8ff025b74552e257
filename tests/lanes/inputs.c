#include <math.h>
#include <string.h>

#include "lanes.h"

static uint32_t next(uint32_t *state)
{
    /* Marsaglia's xorshift. */
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static float from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static float make(gn_lane_domain domain, uint32_t r, uint32_t choice)
{
    static const float special[] = {
        0.0f,   -0.0f,   INFINITY, -INFINITY,       NAN,         1.0f,        -1.0f,  0.5f,
        1e-40f, -1e-40f, 1e38f,    1.17549435e-38f, 0.41421356f, 2.41421356f, 126.5f, -126.5f};
    const float unit = (float)(r >> 8) * (1.0f / 16777216.0f);
    switch (domain) {
    case GN_LANE_ANY:
    case GN_LANE_NOT_NEGATIVE: {
        const float x = choice % 16 == 0 ? special[r % 16]
                        : choice % 2     ? from_bits(r)
                                         : (unit - 0.5f) * 200.0f;
        return domain == GN_LANE_ANY ? x : fabsf(x);
    }
    case GN_LANE_INT:
        return (unit - 0.5f) * 4294967040.0f;
    case GN_LANE_EXPONENT:
        return (unit - 0.5f) * 260.0f;
    case GN_LANE_LENGTH:
        return from_bits((107u << 23) + r % (40u << 23));
    default:
        return choice % 16 == 0 ? 0.0f : choice % 16 == 1 ? 1.0f : unit;
    }
}

void gn_lane_inputs(gn_lane_domain domain, uint32_t seed, float *const in[GN_LANE_INPUTS],
                    size_t count)
{
    uint32_t state = seed * 2654435761u + 1u;
    for (size_t i = 0; i < count; i++)
        for (int plane = 0; plane < GN_LANE_INPUTS; plane++) {
            const uint32_t r = next(&state);
            in[plane][i] = make(domain, r, next(&state));
        }
}
