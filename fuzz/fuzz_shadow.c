/* Feeds arbitrary words to the decoders and tests of every format of shadow map, to leak tracing
 * and to the light buffer, and arbitrary floats to the formats' encoders. Built like fuzz_scene.c;
 * its seeds are in fuzz/corpus/shadow. */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <gnomon/shadow/bilinear.h>
#include <gnomon/shadow/depth.h>
#include <gnomon/shadow/exponential.h>
#include <gnomon/shadow/leak.h>
#include <gnomon/shadow/light_buffer.h>
#include <gnomon/shadow/moments.h>
#include <gnomon/shadow/moments_nonlinear.h>
#include <gnomon/shadow/texel.h>
#include <gnomon/shadow/variance.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct input {
    uint32_t texel[4];
    float receiver;
    float values[4];
} input;

#define CHECK(visibility)                                                                          \
    do {                                                                                           \
        const float check_value = (visibility);                                                    \
        if (!(check_value >= 0.0f && check_value <= 1.0f)) {                                       \
            fprintf(stderr, "%s is %a\n", #visibility, (double)check_value);                       \
            __builtin_trap();                                                                      \
        }                                                                                          \
    } while (0)

/* Texels of 16 bits a number: any. */
static void read_small(const input *in)
{
    const uint32_t low = in->texel[0], high = in->texel[1];
    const float receiver = in->receiver;

    const gn_variance vsm = {gn_unorm16_low(low), gn_unorm16_high(low)};
    CHECK(gn_vsm_visibility(vsm, 1e-5f, receiver));
    CHECK(gn_vsm_visibility(vsm, 0.0f, receiver));

    const gn_evsm evsm = {gn_half_low(low), gn_half_high(low), gn_half_low(high),
                          gn_half_high(high)};
    CHECK(gn_evsm_visibility(evsm, 5.5f, 5.5f, 1e-3f, receiver));
    CHECK(gn_evsm_visibility(evsm, 5.5f, 5.5f, 0.0f, receiver));

    const gn_moments_fixed fixed = {gn_unorm16_low(low), gn_unorm16_high(low), gn_unorm16_low(high),
                                    gn_unorm16_high(high)};
    const gn_moments moments = gn_moments_bias_fixed(gn_moments_dequantize(fixed), 6e-5f);
    CHECK(gn_hamburger_visibility(moments, receiver));
    CHECK(gn_hausdorff_visibility(moments, receiver));

    const gn_nonlinear wide = gn_nonlinear_unpack64(low, high);
    const gn_nonlinear narrow = gn_nonlinear_unpack32(low);
    CHECK(gn_nonlinear_visibility(wide, receiver));
    CHECK(gn_nonlinear_visibility(narrow, receiver));
}

/* Texels of floats: any finite ones in the range of what they keep. */
static float word_in(uint32_t word, float low, float high)
{
    return gn_clamp(gn_word_real(word), low, high);
}

static void read_floats(const input *in)
{
    const uint32_t *texel = in->texel;
    const float receiver = in->receiver;
    CHECK(gn_depth_test(gn_word_real(texel[0]), receiver));
    CHECK(gn_esm_visibility(word_in(texel[0], 0.0f, FLT_MAX), 80.0f, receiver));

    const gn_variance vsm = {word_in(texel[0], -1.0f, 1.0f), word_in(texel[1], -1.0f, 1.0f)};
    CHECK(gn_vsm_visibility(vsm, 1e-10f, receiver));

    const float most = gn_exponential_warp(1.0f, 40.0f);
    const gn_evsm evsm = {word_in(texel[0], 0.0f, most), word_in(texel[1], 0.0f, most * most),
                          word_in(texel[2], -most, 0.0f), word_in(texel[3], 0.0f, most * most)};
    CHECK(gn_evsm_visibility(evsm, 40.0f, 5.5f, 1e-10f, receiver));
    CHECK(gn_evsm_visibility(evsm, 40.0f, 40.0f, 0.0f, receiver));
    const gn_variance positive = {evsm.positive, evsm.positive_square};
    CHECK(gn_evsm_positive_visibility(positive, 40.0f, 1e-10f, receiver));

    const gn_moments any = {word_in(texel[0], -1.0f, 1.0f), word_in(texel[1], -1.0f, 1.0f),
                            word_in(texel[2], -1.0f, 1.0f), word_in(texel[3], -1.0f, 1.0f)};
    CHECK(gn_hamburger_visibility(any, receiver));
    CHECK(gn_hausdorff_visibility(any, receiver));
    CHECK(gn_nonlinear_visibility(gn_nonlinear_of(any), receiver));
}

/* Leak tracing: any words, as neighbours and as tests, are answered with 0 or 1. */
static void read_leak(const input *in)
{
    const int32_t neighbour = (int32_t)in->texel[0];
    const float test = gn_word_real(in->texel[1]), epsilon = word_in(in->texel[2], 0.0f, 0.49f);
    const int unsure = gn_leak_unsure(test, epsilon), shadow = gn_leak_shadowed(test);
    CHECK((float)unsure);
    CHECK((float)shadow);
    CHECK((float)gn_leak_expands(neighbour, shadow));
    CHECK((float)gn_leak_confirms(neighbour, shadow));
    CHECK((float)gn_leak_state(unsure, shadow, gn_leak_shadowed(in->receiver)) / 7.0f);
    CHECK(gn_leak_jitter_x(in->texel[3]) + gn_leak_jitter_y(in->texel[3]) + 0.5f);
}

/* Light buffer: any corners, whose edges have one side; any point has a face. */
static void read_light(const input *in)
{
    const float *v = in->values;
    const gn_light_corner a = gn_light_corner_parallel(v[0], v[1], v[2], v[3]),
                          b = gn_light_corner_central(v[0], v[1], in->receiver, v[2], v[3]),
                          c = {gn_word_real(in->texel[0]), gn_word_real(in->texel[1])};
    const gn_light_weights w = gn_light_weigh(a, b, c), back = gn_light_weigh(c, b, a);
    CHECK((float)(gn_light_side(w.a, b, c) + gn_light_side(back.c, c, b)));
    CHECK((float)gn_light_covers(a, b, c, w));
    CHECK((float)(gn_light_inside(w) + gn_light_on_edge(w)));
    CHECK((float)gn_light_face(v[0], v[1], v[2]) / 5.0f);
    CHECK((float)(gn_light_level(in->receiver) + 375) / 512.0f);
}

/* Encoders take any floats at all, and make words that can be read. */
static void write_texels(const input *in)
{
    const float *v = in->values;
    const gn_nonlinear any = {v[0], v[1], v[2], v[3]};
    const gn_moments moments = {v[0], v[1], v[2], v[3]};
    const gn_nonlinear_words words[] = {
        {gn_unorm16_pack(v[0], v[1]), gn_half_pack(v[2], v[3])},
        gn_nonlinear_pack64(any),
        gn_nonlinear_pack64(gn_nonlinear_of(moments)),
        {gn_nonlinear_pack32(any), gn_nonlinear_pack32(gn_nonlinear_of(moments))},
    };
    input written = *in;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        written.texel[0] = words[i].low;
        written.texel[1] = words[i].high;
        read_small(&written);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = {0};
    memcpy(&in, data, size < sizeof in ? size : sizeof in);
    read_small(&in);
    read_floats(&in);
    read_leak(&in);
    read_light(&in);
    write_texels(&in);
    return 0;
}
