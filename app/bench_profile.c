/* gnomon bench --profile: one row of pixels over time. Where nothing flickers, what is on a surface
 * makes smooth lines; flicker shows as dots and broken lines. */
#include <math.h>
#include <stdio.h>

#include "bench.h"
#include "picture.h"

#define GAP 3u /* lines between strips */

static const uint8_t gap_color[3] = {230, 140, 30}, sky_color[3] = {45, 60, 90};

static void paint_line(const float *values, uint32_t width, uint8_t *rgb)
{
    for (uint32_t x = 0; x < width; x++)
        for (uint32_t c = 0; c < 3; c++)
            rgb[3 * x + c] = isnan(values[x])
                                 ? sky_color[c]
                                 : (uint8_t)lroundf(fminf(fmaxf(values[x], 0), 1) * 255.0f);
}

bool gn_bench_write_profile(gn_app *app, const gn_bench_options *options,
                            const gn_bench_result *result, const char *path)
{
    gn_context *context = gn_device_context(app->device);
    const uint32_t width = app->options.size[0], frames = result->frame_count;
    const uint32_t height = result->count * (frames + GAP) - GAP;
    uint8_t *rgb = gn_alloc(context, (size_t)width * height, 3);
    if (!rgb)
        return gn_app_error(app, "%s: out of memory", path);
    char names[2048] = "", row[32];
    size_t used = 0;
    uint8_t *line = rgb;
    for (uint32_t m = 0; m < result->count; m++) {
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", m ? ", " : "",
                                     result->rows[m].name);
        for (uint32_t f = 0; f < frames; f++, line += 3 * (size_t)width)
            paint_line(result->profile + ((size_t)m * frames + f) * width, width, line);
        for (uint32_t x = 0; x < GAP * width && m + 1 < result->count; x++, line += 3)
            for (uint32_t c = 0; c < 3; c++)
                line[c] = gap_color[c];
    }
    gn_settings settings;
    gn_settings_fill(&settings, app, names, 1, options->start);
    snprintf(row, sizeof row, "%u", options->profile_row);
    settings.attributes[settings.count++] = (gn_attribute){"row", row};
    const bool good = gn_write_png(app->device, path, width, height, 3, rgb, settings.attributes,
                                   settings.count) == GN_OK;
    gn_free(context, rgb);
    if (good)
        gn_app_note(app, "%s: row %u, %u frames downwards; from top to bottom: %s", path,
                    options->profile_row, frames, names);
    return good;
}
