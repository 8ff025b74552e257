/* Many texels from depths to visibility by chain.h, in scalar C and in GLSL. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "chain.h"
#include "checks.h"

enum {
    TEXELS = 1 << 18,
    DEPTHS = 16, /* of a texel */
    GROUP = 64,
    VISIBILITIES = 6, /* of the outputs; the others are words */
    OUTPUTS = 9
};

/* What may differ where arithmetic is not precise. Of words: the share of texels where they do. */
static const struct {
    const char *name;
    double mean, worst;
} outputs[OUTPUTS] = {
    {"Hamburger", 1e-6, 1e-3},
    {"Hausdorff", 1e-6, 1e-3},
    /* Moments near a rounding edge fall on its other side: a whole step of 16 bits. */
    {"64 bits, affine", 2e-5, 0.3},
    {"non-linear", 1e-6, 1e-3},
    {"64 bits, non-linear", 1e-6, 1e-4},
    {"32 bits, non-linear", 1e-6, 1e-4},
    {"low word", 1e-4, 1},
    {"high word", 1e-4, 1},
    {"one word", 1e-4, 1},
};

static float depths[DEPTHS + 1][TEXELS]; /* the last plane: receivers */
static uint32_t expected[OUTPUTS][TEXELS];

static float random_unit(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216.0f;
}

/* Distributions of 2 to 16 places; half of them are a few slopes, as in maps, with a receiver close
 * behind one of them. */
static void make_texel(uint32_t texel, uint32_t *state)
{
    float places[DEPTHS];
    const uint32_t count = 2 + (uint32_t)(random_unit(state) * (DEPTHS - 1));
    const bool slopes = random_unit(state) < 0.5f;
    for (uint32_t i = 0; i < count; i++) {
        places[i] = random_unit(state);
        if (slopes && i >= 3)
            places[i] = fminf(places[i % 3] + 0.002f * places[i], 1.0f);
    }
    for (uint32_t i = 0; i < DEPTHS; i++)
        depths[i][texel] = places[i < count ? i : (uint32_t)(random_unit(state) * (float)count)];
    depths[DEPTHS][texel] =
        slopes ? fminf(places[0] + 0.01f * random_unit(state), 1.0f) : random_unit(state);
}

static void run_in_c(uint32_t texel)
{
    gn_moments sum = {0, 0, 0, 0};
    for (int i = 0; i < DEPTHS; i++)
        sum = gn_chain_add(sum, gn_moments_of(depths[i][texel]));
    const float receiver = depths[DEPTHS][texel];
    const gn_moments mean = gn_chain_mean(sum, DEPTHS);
    const gn_nonlinear n = gn_chain_encode(mean);
    const gn_nonlinear_words words64 = gn_nonlinear_pack64(n);
    const uint32_t word32 = gn_nonlinear_pack32(n);
    const uint32_t words[OUTPUTS] = {gn_real_word(gn_chain_hamburger(mean, receiver)),
                                     gn_real_word(gn_chain_hausdorff(mean, receiver)),
                                     gn_real_word(gn_chain_fixed(mean, receiver)),
                                     gn_real_word(gn_nonlinear_visibility(n, receiver)),
                                     gn_real_word(gn_chain_visibility64(words64, receiver)),
                                     gn_real_word(gn_chain_visibility32(word32, receiver)),
                                     words64.low,
                                     words64.high,
                                     word32};
    for (int i = 0; i < OUTPUTS; i++)
        expected[i][texel] = words[i];
}

bool gn_check_chain(const gn_compute *compute, const uint32_t *spirv, size_t bytes, bool precise)
{
    uint32_t state = 1;
    for (uint32_t texel = 0; texel < TEXELS; texel++) {
        make_texel(texel, &state);
        run_in_c(texel);
    }
    gn_compute_program program;
    gn_compute_program_make(compute, spirv, bytes, sizeof depths, sizeof expected, &program);
    memcpy(program.in, depths, sizeof depths);
    memset(program.out, 0, sizeof expected);
    gn_compute_program_run(compute, &program, (const uint32_t[4]){DEPTHS, TEXELS}, TEXELS / GROUP);

    bool good = true;
    for (int output = 0; output < OUTPUTS; output++) {
        const uint32_t *words = (const uint32_t *)program.out + (size_t)output * TEXELS;
        uint32_t different = 0;
        double mean = 0, worst = 0;
        for (uint32_t i = 0; i < TEXELS; i++) {
            if (words[i] == expected[output][i])
                continue;
            different++;
            const double d = output < VISIBILITIES ? fabs((double)gn_word_real(words[i]) -
                                                          (double)gn_word_real(expected[output][i]))
                                                   : 1;
            mean += d / TEXELS;
            worst = d <= worst ? worst : d; /* a NaN stays */
        }
        const bool ok = precise ? different == 0
                                : mean <= outputs[output].mean && worst <= outputs[output].worst;
        printf("%-28s %6u differ, on the average by %.3g, at most by %.3g\n", outputs[output].name,
               different, mean, worst);
        if (!ok)
            printf("FAILED: %s, beyond %g on the average or %g\n", outputs[output].name,
                   precise ? 0 : outputs[output].mean, precise ? 0 : outputs[output].worst);
        good = good && ok;
    }
    printf("%d texels\n", TEXELS);
    gn_compute_program_free(compute, &program);
    return good;
}
