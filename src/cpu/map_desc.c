/* Settings of shadow maps: defaults, ranges, and what a format needs. */
#include <math.h>

#include "cpu/map.h"

#define LARGEST_NORMAL_BIAS 16.0f

gn_map_desc gn_map_desc_default(void)
{
    return (gn_map_desc){.cookie = GN_COOKIE,
                         .resolution = 2048,
                         .samples = 1,
                         .cascades = 4,
                         .split_weight = -1.0f,
                         .undrawn = GN_NONE,
                         .enlarge = 0.15f,
                         .filter_width = 9,
                         .filter_sigma = 2.4f,
                         .depth_bias = -1.0f,
                         .normal_bias = -1.0f,
                         .minimum_variance = -1.0f,
                         .moment_bias = -1.0f};
}

static const char *kind_name(gn_map_kind kind)
{
    static const char *const names[] = {"none", "depth", "pcf", "vsm",
                                        "esm",  "evsm",  "msm", "nlmsm"};
    return (unsigned)kind < sizeof names / sizeof *names ? names[kind] : "unknown";
}

/* Bits a texel that a kind comes in, ending with 0. */
static const uint32_t *bits_of(const gn_map_format *format)
{
    static const uint32_t plain[] = {32, 0}, two[] = {32, 64, 0}, four[] = {64, 128, 0},
                          one_sided[] = {64, 0};
    switch (format->kind) {
    case GN_MAP_VSM:
    case GN_MAP_NLMSM:
        return two;
    case GN_MAP_EVSM:
        return format->one_sided ? one_sided : four;
    case GN_MAP_MSM:
        return four;
    default:
        return plain;
    }
}

/* The largest exponent whose values the format's numbers hold. */
static float largest_exponent(const gn_map_format *format)
{
    if (format->kind == GN_MAP_ESM)
        return 84.0f;
    return format->bits == 64 && !format->one_sided && !format->single_depth ? 5.54f : 42.0f;
}

static gn_result check_exponent(gn_context *context, const gn_map_format *format, const char *name,
                                float exponent)
{
    const float largest = largest_exponent(format);
    if (exponent > 0.0f && exponent <= largest)
        return GN_OK;
    return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                   "%s with %u bits: %s exponent %g: the range is 0 (not included) to %g",
                   kind_name(format->kind), format->bits, name, (double)exponent, (double)largest);
}

static gn_result check_format(gn_context *context, const gn_map_format *format)
{
    if (format->kind <= GN_MAP_NONE || format->kind > GN_MAP_NLMSM)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "map kind %d does not exist",
                       (int)format->kind);
    const uint32_t *bits = bits_of(format);
    if (format->bits != bits[0] && (bits[1] == 0 || format->bits != bits[1])) {
        if (bits[1])
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "%s with %u bits a texel: it has %u or %u", kind_name(format->kind),
                           format->bits, bits[0], bits[1]);
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s with %u bits a texel: it has %u",
                       kind_name(format->kind), format->bits, bits[0]);
    }
    const bool vectors = format->kind >= GN_MAP_VSM && format->kind <= GN_MAP_MSM;
    if (format->single_depth && !vectors)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s cannot be built from single depths: vsm, esm, evsm and msm can",
                       kind_name(format->kind));
    if (format->kind == GN_MAP_EVSM || format->kind == GN_MAP_ESM)
        GN_TRY(check_exponent(context, format, "positive", format->positive_exponent));
    if (format->kind == GN_MAP_EVSM && !format->one_sided)
        GN_TRY(check_exponent(context, format, "negative", format->negative_exponent));
    const uint32_t w = format->pcf_width;
    if (format->kind == GN_MAP_PCF && w != 2 && (w < 3 || w > 33 || w % 2 == 0))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "pcf with a width of %u: it is 2, or odd from 3 to 33", w);
    return GN_OK;
}

static gn_result check_real(gn_context *context, const char *name, float value, float low,
                            float high)
{
    if (value >= low && value <= high)
        return GN_OK;
    return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%s of %g: the range is %g to %g", name,
                   (double)value, (double)low, (double)high);
}

static gn_result check_splits(gn_context *context, const gn_map_desc *desc)
{
    if (desc->cascades < 1 || desc->cascades > GN_MAX_CASCADES)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%u cascades: the range is 1 to %u",
                       desc->cascades, GN_MAX_CASCADES);
    if (desc->split_count != 0 && desc->split_count != desc->cascades)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%u splits for %u cascades",
                       desc->split_count, desc->cascades);
    float before = 0.0f;
    for (uint32_t i = 0; i < desc->split_count; before = desc->splits[i++])
        if (!(desc->splits[i] > before && desc->splits[i] <= 1.0f))
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "split %u is %g: splits grow from above 0 to 1", i + 1,
                           (double)desc->splits[i]);
    if (desc->split_count != 0 && before != 1.0f)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "the last split is %g: it must be 1",
                       (double)before);
    if (desc->undrawn != GN_NONE && desc->undrawn > desc->cascades)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%u cascades that are not drawn: the range is 0 to %u, the cascades",
                       desc->undrawn, desc->cascades);
    if (!(desc->split_weight < 0.0f)) /* below: the default */
        GN_TRY(check_real(context, "a split weight", desc->split_weight, 0.0f, 1.0f));
    GN_TRY(check_real(context, "an enlargement of cascades", desc->enlarge, 0.0f, 1.0f));
    if (!(desc->distance >= 0.0f && isfinite(desc->distance)))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a shadow distance of %g metres: it must be 0 or more, and finite",
                       (double)desc->distance);
    return GN_OK;
}

/* Negative: the format's own. */
static gn_result check_bias(gn_context *context, const char *name, float value, float high)
{
    if (value < 0.0f)
        return GN_OK;
    return check_real(context, name, value, 0.0f, high);
}

gn_result gn_map_desc_check(gn_context *context, const gn_map_format *format,
                            const gn_map_desc *desc)
{
    GN_CHECK_DESC(context, desc, gn_map_desc);
    GN_TRY(check_format(context, format));
    if (desc->resolution < 16 || desc->resolution > 16384)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a shadow map of %u texels a side: the range is 16 to 16384",
                       desc->resolution);
    if (desc->samples != 1 && desc->samples != 4)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "%u samples a texel: there are 1 or 4",
                       desc->samples);
    if ((int)desc->alpha < 0 || desc->alpha > GN_MAP_ALPHA_OPAQUE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "map alpha rule %d does not exist",
                       (int)desc->alpha);
    if ((int)desc->reading < 0 || desc->reading > GN_READING_BILINEAR)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "map reading %d does not exist",
                       (int)desc->reading);
    if (desc->filter_width < 1 || desc->filter_width > 33 || desc->filter_width % 2 == 0)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a filter of %u texels: the width is odd, from 1 to 33", desc->filter_width);
    if (!(desc->filter_sigma > 0.0f && desc->filter_sigma <= 16.0f))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a filter with a sigma of %g texels: the range is 0 (not included) to 16",
                       (double)desc->filter_sigma);
    if (desc->mip_maps && (format->kind == GN_MAP_NLMSM || !gn_map_has_texels(format)))
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "%s has no mip maps: its texels cannot be averaged",
                       kind_name(format->kind));
    GN_TRY(check_splits(context, desc));
    if (desc->refresh > 64)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "a refresh over %u updates: the range is 1 to 64", desc->refresh);
    GN_TRY(check_bias(context, "a depth bias", desc->depth_bias, 0.1f));
    GN_TRY(check_bias(context, "a normal bias", desc->normal_bias, LARGEST_NORMAL_BIAS));
    GN_TRY(check_bias(context, "a minimum variance", desc->minimum_variance, 1.0f));
    return check_bias(context, "a moment bias", desc->moment_bias, 1.0f);
}

/* Texels beside its own that a texel was filtered from, or that PCF reads. */
static uint32_t filter_reach(const gn_map_format *format, const gn_map_desc *desc)
{
    if (gn_map_has_texels(format))
        return desc->filter_width / 2;
    return format->kind == GN_MAP_PCF && format->pcf_width != 2 ? format->pcf_width / 2 : 0;
}

uint32_t gn_map_margin(const gn_map_format *format, const gn_map_desc *desc)
{
    const bool four = format->kind == GN_MAP_PCF && format->pcf_width == 2;
    const uint32_t between = four || desc->reading != GN_READING_NEAREST ? 1 : 0;
    return filter_reach(format, desc) + between;
}

/* Standard deviation of the filter's weights along an axis, texels. */
static double filter_deviation(uint32_t width, double sigma)
{
    double sum = 0.0, square = 0.0;
    for (uint32_t i = 0; i < width; i++) {
        const double x = i - 0.5 * (width - 1), weight = exp(-0.5 * x * x / (sigma * sigma));
        sum += weight;
        square += weight * x * x;
    }
    return sqrt(square / sum);
}

/* Biases. A plane shadows itself where its depth is read at another place than the receiver's, and
 * where that depth is rounded. The first grows with texels and slope, and is what the normal bias
 * takes away, exactly (place_receivers() in map_place.inc): it is a distance in texels, whatever
 * the scene's size. The second is a property of numbers, and is left to the depth bias. Constants
 * were measured on planes of 0 to 87 degrees whose depth changes by 1e-6 to 1e-3 of the range a
 * texel: with half of any of them surfaces in the light get visibly darker. */

/* Texels from a receiver's place to the centres of what is read for it. */
static double normal_bias(const gn_map_format *format, const gn_map_desc *desc)
{
    const bool linear = format->kind >= GN_MAP_VSM && format->kind <= GN_MAP_MSM;
    const bool four = format->kind == GN_MAP_PCF && format->pcf_width == 2;
    /* To a corner of the texel, or across a square of four; but blended vectors are those of the
     * place itself. Four moments want half of that for curved surfaces: where depths lean to one
     * side, y1 lies farther before their mean. */
    double texels = desc->reading == GN_READING_NEAREST && !four ? sqrt(0.5) : sqrt(2.0);
    if (linear && desc->reading == GN_READING_BILINEAR)
        texels = format->kind == GN_MAP_MSM ? sqrt(0.5) : 0.0;
    /* To the corners of the window, or two standard deviations: 2 % of the weights lie beyond. */
    if (format->kind == GN_MAP_PCF && !four)
        texels += fmin(sqrt(2.0) * filter_reach(format, desc), 2.0 * (double)desc->filter_sigma);
    /* The bound of four moments lights a receiver up to y1, for a plane one standard deviation of
     * the filter before the mean; of two texels of plain depth that is half a texel at most. Those
     * of Chebyshev and Markov reach the mean, which concave edges bring nearer by as much. */
    if (gn_map_has_texels(format))
        texels += filter_deviation(desc->filter_width, (double)desc->filter_sigma);
    else if (format->single_depth)
        texels += 0.5;
    return fmin(texels, (double)LARGEST_NORMAL_BIAS);
}

/* Rounding of what tells a receiver from the first depth, in parts of the range. */
static double depth_bias(const gn_map_format *format)
{
    /* Floats: of depth itself, and of the receiver's. */
    const double floats = 1e-6;
    if (!gn_map_has_texels(format))
        return floats;
    /* Half a step of 1 / 65535. */
    if (format->kind == GN_MAP_NLMSM && format->bits == 64)
        return floats + 0.5 / 65535.0;
    /* Half a step of 1 / 511.5 of z. */
    if (format->kind == GN_MAP_NLMSM)
        return floats + 0.5 / 1023.0;
    return floats;
}

/* Rounding of both moments, as the test of variance.h asks for it. */
static double minimum_variance(const gn_map_format *format)
{
    if (!gn_map_has_texels(format))
        return 1e-10;
    /* Half a step of 1 / 65535, absolute. */
    if (format->kind == GN_MAP_VSM && format->bits == 32)
        return 3.0 * 0.5 / 65535.0;
    /* Half a unit in the last of 11 places, relative, at the smaller exponent. */
    if (format->kind == GN_MAP_EVSM && format->bits == 64 && !format->one_sided) {
        const double c = fmin((double)format->positive_exponent, (double)format->negative_exponent);
        return 3.0 * 0x1p-12 / (4.0 * c * c);
    }
    return 1e-10;
}

gn_map_desc gn_map_desc_resolve(const gn_map_format *format, const gn_map_desc *desc)
{
    gn_map_desc resolved = *desc;
    if (resolved.reading == GN_READING_AUTO)
        resolved.reading = format->kind == GN_MAP_NLMSM   ? GN_READING_BLUE_NOISE
                           : format->kind == GN_MAP_DEPTH ? GN_READING_NEAREST
                                                          : GN_READING_BILINEAR;
    if (resolved.normal_bias < 0.0f)
        resolved.normal_bias = (float)normal_bias(format, &resolved);
    if (resolved.depth_bias < 0.0f)
        resolved.depth_bias = (float)depth_bias(format);
    if (resolved.minimum_variance < 0.0f)
        resolved.minimum_variance = (float)minimum_variance(format);
    if (resolved.moment_bias < 0.0f)
        resolved.moment_bias = format->kind == GN_MAP_MSM && format->bits == 64 ? 6e-5f : 3e-7f;
    return resolved;
}
