/* The dialect: one text for scalar C, SIMD C and GLSL.
 *
 * Algorithm headers include this file first and dialect_end.h last. In between they may use
 *   real, lint, luint, mask   a float, an int, an unsigned int, a truth value: of one lane, of
 *                             GN_LANES lanes, or of a shader invocation
 *   GN_FN                     before each function
 *   GN_STRUCT(name) {...};    declares a struct; GN_MAKE2(name, a, b) makes one of two members,
 *                             GN_MAKE3 and GN_MAKE4 of three and four
 *   K(x)                      a constant that stands alone (argument, select arm, return value);
 *                             beside a real a plain constant promotes by itself
 *   gn_splat_int(i)           the same for a lint
 *   gn_select(m, a, b)        m ? a : b, lane by lane; there is no `if`
 *   gn_select_int(m, a, b)    the same of lints
 *   gn_and, gn_or, gn_not     on masks; comparisons give masks, and of masks != is exclusive or
 *   gn_bits, gn_from_bits     a real's bits as a lint, and back
 *   gn_to_int, gn_to_real     conversions of a number; gn_to_signed, gn_to_unsigned keep the bits
 *   gn_abs, gn_min, gn_max, gn_clamp, gn_clamp_positive, gn_sqrt, gn_floor, gn_log2,
 *   gn_exp2, gn_exp2_inside, gn_atan, gn_tan
 *                             the last five are polynomials of our own: they vectorise, and give
 *                             the same bits on every processor
 * and leave only gn_ names behind; macros of these names that a program has made before are lost,
 * so include first and define then. Compile C with -ffp-contract=off: then every lane count gives
 * the same bits as the scalar build (a NaN is a NaN, whatever its payload).
 *
 * GN_LANES (define it before the first include; the same for a whole translation unit):
 *   1 (default), 8 or 16; more than 1 needs the vector extensions of GCC or clang. */

#if defined(__STDC__) || defined(__cplusplus)
#define GN_DIALECT_C 1
#else
#define GN_DIALECT_C 0
#endif

#ifndef GN_LANES
#define GN_LANES 1
#endif

/* Definitions that stay: once a translation unit. ---------------------------------------------*/

#ifndef GNOMON_SHADOW_DIALECT_H
#define GNOMON_SHADOW_DIALECT_H

#if GN_DIALECT_C

#include <math.h>
#include <stdint.h>
#include <string.h>

#if GN_LANES == 1
typedef float gn_real;
typedef int32_t gn_lint;
typedef uint32_t gn_luint;
typedef int gn_mask;
#else
typedef float gn_real __attribute__((vector_size(4 * GN_LANES)));
typedef int32_t gn_lint __attribute__((vector_size(4 * GN_LANES)));
typedef uint32_t gn_luint __attribute__((vector_size(4 * GN_LANES)));
typedef gn_lint gn_mask;
#endif

#if GN_LANES == 1

static inline float gn_splat(float x)
{
    return x;
}
static inline int32_t gn_splat_int(int32_t i)
{
    return i;
}
static inline float gn_select(int m, float a, float b)
{
    return m ? a : b;
}
static inline int32_t gn_select_int(int m, int32_t a, int32_t b)
{
    return m ? a : b;
}
static inline int gn_not(int m)
{
    return !m;
}
static inline int32_t gn_bits(float x)
{
    int32_t i;
    memcpy(&i, &x, sizeof i);
    return i;
}
static inline float gn_from_bits(int32_t i)
{
    float x;
    memcpy(&x, &i, sizeof x);
    return x;
}
static inline float gn_to_real(int32_t i)
{
    return (float)i;
}
static inline int32_t gn_to_int(float x) /* toward zero; |x| < 2^31 */
{
    return (int32_t)x;
}
static inline float gn_sqrt(float x)
{
    return sqrtf(x);
}
static inline float gn_floor(float x)
{
    return floorf(x);
}

#else

static inline gn_real gn_splat(float x)
{
    return x - (gn_real){0};
}
static inline gn_lint gn_splat_int(int32_t i)
{
    return i - (gn_lint){0};
}
static inline gn_real gn_select(gn_mask m, gn_real a, gn_real b)
{
    return (gn_real)(((gn_lint)a & m) | ((gn_lint)b & ~m));
}
static inline gn_lint gn_select_int(gn_mask m, gn_lint a, gn_lint b)
{
    return (a & m) | (b & ~m);
}
static inline gn_mask gn_not(gn_mask m)
{
    return ~m;
}
static inline gn_lint gn_bits(gn_real x)
{
    return (gn_lint)x;
}
static inline gn_real gn_from_bits(gn_lint i)
{
    return (gn_real)i;
}
static inline gn_real gn_to_real(gn_lint i)
{
    return __builtin_convertvector(i, gn_real);
}
static inline gn_lint gn_to_int(gn_real x) /* toward zero; |x| < 2^31 */
{
    return __builtin_convertvector(x, gn_lint);
}
static inline gn_real gn_sqrt(gn_real x)
{
    for (int i = 0; i < GN_LANES; i++)
        x[i] = sqrtf(x[i]);
    return x;
}
static inline gn_real gn_floor(gn_real x)
{
    for (int i = 0; i < GN_LANES; i++)
        x[i] = floorf(x[i]);
    return x;
}

#endif

static inline gn_luint gn_to_unsigned(gn_lint i)
{
    return (gn_luint)i;
}
static inline gn_lint gn_to_signed(gn_luint i)
{
    return (gn_lint)i;
}
static inline gn_mask gn_and(gn_mask a, gn_mask b)
{
    return a & b;
}
static inline gn_mask gn_or(gn_mask a, gn_mask b)
{
    return a | b;
}

#else /* GLSL */

#define gn_real  float
#define gn_lint  int
#define gn_luint uint
#define gn_mask  bool

float gn_splat(float x)
{
    return x;
}
int gn_splat_int(int i)
{
    return i;
}
float gn_select(bool m, float a, float b)
{
    return m ? a : b;
}
int gn_select_int(bool m, int a, int b)
{
    return m ? a : b;
}
bool gn_not(bool m)
{
    return !m;
}
bool gn_and(bool a, bool b)
{
    return a && b;
}
bool gn_or(bool a, bool b)
{
    return a || b;
}
int gn_bits(float x)
{
    return floatBitsToInt(x);
}
float gn_from_bits(int i)
{
    return intBitsToFloat(i);
}
float gn_to_real(int i)
{
    return float(i);
}
int gn_to_int(float x)
{
    return int(x);
}
uint gn_to_unsigned(int i)
{
    return uint(i);
}
int gn_to_signed(uint i)
{
    return int(i);
}
float gn_sqrt(float x)
{
    return sqrt(x);
}
float gn_floor(float x)
{
    return floor(x);
}

#endif /* GN_DIALECT_C */

#endif /* GNOMON_SHADOW_DIALECT_H */

/* Words that dialect_end.h takes back. ---------------------------------------------------------*/

#define real  gn_real
#define lint  gn_lint
#define luint gn_luint
#define mask  gn_mask
#define K(x)  gn_splat(x)

#if GN_DIALECT_C
/* Always: a call left in a loop keeps the loop from being vectorized. */
#ifdef __GNUC__
#define GN_FN static inline __attribute__((always_inline))
#else
#define GN_FN static inline
#endif
#define GN_STRUCT(name)                                                                            \
    typedef struct name name;                                                                      \
    struct name
#ifdef __cplusplus
#define GN_MAKE2(name, a, b)                                                                       \
    name                                                                                           \
    {                                                                                              \
        a, b                                                                                       \
    }
#define GN_MAKE3(name, a, b, c)                                                                    \
    name                                                                                           \
    {                                                                                              \
        a, b, c                                                                                    \
    }
#define GN_MAKE4(name, a, b, c, d)                                                                 \
    name                                                                                           \
    {                                                                                              \
        a, b, c, d                                                                                 \
    }
#else
#define GN_MAKE2(name, a, b)       ((name){(a), (b)})
#define GN_MAKE3(name, a, b, c)    ((name){(a), (b), (c)})
#define GN_MAKE4(name, a, b, c, d) ((name){(a), (b), (c), (d)})
#endif
#else
#define GN_FN
#define GN_STRUCT(name)            struct name
#define GN_MAKE2(name, a, b)       name(a, b)
#define GN_MAKE3(name, a, b, c)    name(a, b, c)
#define GN_MAKE4(name, a, b, c, d) name(a, b, c, d)
#endif

/* Functions in the dialect itself: once a translation unit. ------------------------------------*/

#ifndef GNOMON_SHADOW_DIALECT_FUNCTIONS
#define GNOMON_SHADOW_DIALECT_FUNCTIONS

GN_FN real gn_abs(real x)
{
    return gn_from_bits(gn_bits(x) & 0x7fffffff);
}

/* Of a NaN and a number, and of equal zeros, both return b. */
GN_FN real gn_min(real a, real b)
{
    return gn_select(a < b, a, b);
}

GN_FN real gn_max(real a, real b)
{
    return gn_select(a > b, a, b);
}

/* NaN gives low. */
GN_FN real gn_clamp(real x, real low, real high)
{
    return gn_min(gn_max(x, low), high);
}

/* gn_clamp for 0 <= low <= high, and the same to the bit. After two comparisons of one real
 * compilers tell all cases apart, with eight instructions; the second by the order of bits makes it
 * three. */
GN_FN real gn_clamp_positive(real x, real low, real high)
{
    lint i = gn_bits(gn_max(x, low));
    return gn_from_bits(gn_select_int(i < gn_bits(high), i, gn_bits(high)));
}

/* Binary logarithm for normal x > 0, |error| < 1e-7 + 6e-8 |log2 x| and < 2.4e-7 |log2 x|. Below
 * the normal numbers it stays in [-127, -126], with -127 at 0; of infinity it is 128. Splits
 * x = m 2^e with m in [sqrt(1/2), sqrt(2)), then sums the series of the inverse hyperbolic tangent
 * of s = (m - 1) / (m + 1): log2 m = 2 / ln 2 (s + s^3/3 + s^5/5 + ...). */
GN_FN real gn_log2(real x)
{
    lint e = (gn_bits(x) - 0x3f3504f3) >> 23;
    real m = gn_from_bits(gn_bits(x) - e * 0x800000); /* e << 23, defined for negative e as well */
    real s = (m - 1.0f) / (m + 1.0f);
    real s2 = s * s;
    real series = s2 * (s2 * (s2 * (s2 * 0.32059890f + 0.41219858f) + 0.57707801f) + 0.96179670f);
    return gn_to_real(e) + s * (series + 2.88539008f);
}

/* 2^x for x in [-126, 127], relative error < 2.5e-7, exact for whole x; clamped outside. The
 * polynomial is the Taylor series of 2^f on [-1/2, 1/2]. */
GN_FN real gn_exp2(real x)
{
    real y = gn_clamp(x, K(-126.0f), K(127.0f));
    real whole = gn_floor(y + 0.5f);
    real f = y - whole;
    real p = f * 1.5403530e-4f + 1.3333558e-3f;
    p = p * f + 9.6181291e-3f;
    p = p * f + 5.5504109e-2f;
    p = p * f + 2.4022651e-1f;
    p = p * f + 6.9314718e-1f;
    p = p * f + 1.0f;
    return p * gn_from_bits((gn_to_int(whole) + 127) << 23);
}

/* 2^x for x in [-126, 127], not clamped (beyond it any number, up to |x| < 2^31); relative error <
 * 2e-7, exact for whole x. The polynomial is the best on [-1/2, 1/2]. */
GN_FN real gn_exp2_inside(real x)
{
    real whole = gn_floor(x + 0.5f);
    real f = x - whole;
    real p = f * 1.3264726e-3f + 9.6715128e-3f;
    p = p * f + 5.5507337e-2f;
    p = p * f + 2.4022242e-1f;
    p = p * f + 6.9314698e-1f;
    p = p * f + 1.0f;
    /* Unsigned, so that any x gives some number. */
    luint shift = gn_to_unsigned(gn_to_int(whole)) << 23;
    return gn_from_bits(gn_to_signed(gn_to_unsigned(gn_bits(p)) + shift));
}

/* Arc tangent, |error| < 1.5e-7, relative error < 2.1e-7 for normal x. Reduced to |z| <= tan(pi/8)
 * by atan x = pi/4 + atan((x-1)/(x+1)) and atan x = pi/2 - atan(1/x); the polynomial has the form
 * of Cephes' atanf. */
GN_FN real gn_atan(real x)
{
    real a = gn_abs(x);
    mask large = a > 2.41421356f;
    mask medium = gn_and(a > 0.41421356f, gn_not(large));
    real z = gn_select(large, -1.0f / a, gn_select(medium, (a - 1.0f) / (a + 1.0f), a));
    real base = gn_select(large, K(1.57079633f), gn_select(medium, K(0.78539816f), K(0.0f)));
    real z2 = z * z;
    real p = ((8.05374449538e-2f * z2 - 1.38776856032e-1f) * z2 + 1.99777106478e-1f) * z2 -
             3.33329491539e-1f;
    real result = base + (z + z * z2 * p);
    return gn_select(x < 0.0f, -result, result);
}

/* Tangent for |x| <= pi/4, relative error < 2.5e-7 (a continued fraction). */
GN_FN real gn_tan(real x)
{
    real x2 = x * x;
    return x * (945.0f - 105.0f * x2 + x2 * x2) / (945.0f - 420.0f * x2 + 15.0f * x2 * x2);
}

#endif /* GNOMON_SHADOW_DIALECT_FUNCTIONS */
