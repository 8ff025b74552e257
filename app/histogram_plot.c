/* Histograms as SVG: text, with nothing outside itself. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "output/output.h"
#include "histogram.h"

/* Pixels. */
enum { PANEL = 260, GAP = 56, LEFT = 64, TOP = 64, HEIGHT = 150, ROW = 250, BOTTOM = 0 };

static bool put(gn_file *file, const char *format, ...) __attribute__((format(printf, 2, 3)));
static bool put(gn_file *file, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    const int used = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return gn_file_write(file, text, (size_t)used < sizeof text ? (size_t)used : sizeof text - 1) ==
           GN_OK;
}

static double share(uint64_t part, const gn_histogram *h)
{
    return h->texels > 0 ? (double)part / (double)h->texels : 0;
}

/* Texels that hold nothing fill the first bin: the scale is of the others, and it is cut off. */
static double highest(const uint64_t counts[GN_HISTOGRAM_BINS], uint64_t texels)
{
    uint64_t most = 0;
    for (uint32_t i = 1; i < GN_HISTOGRAM_BINS; i++)
        most = counts[i] > most ? counts[i] : most;
    return most > 0 ? (double)most / (double)texels : 1;
}

/* A tick and its text below the axis, at a share of the panel's width. */
static bool put_tick(gn_file *file, double x, int y, double at, const char *text)
{
    return put(file,
               "<path d=\"M%.1f %dv5\" stroke=\"#333\"/>"
               "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n",
               x + at * PANEL, y + HEIGHT, x + at * PANEL, y + HEIGHT + 18, text);
}

/* A dashed line at a value of xi4, named above. */
static bool put_line(gn_file *file, double x, int y, double at, const char *text)
{
    return put(file,
               "<path d=\"M%.1f %dv%d\" stroke=\"#b35c00\" stroke-dasharray=\"4 3\"/>"
               "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\" fill=\"#b35c00\">%s</text>\n",
               x + at * PANEL, y - 2, HEIGHT + 2, x + at * PANEL, y - 6, text);
}

static bool put_bars(gn_file *file, double x, int y, const uint64_t counts[GN_HISTOGRAM_BINS],
                     uint64_t texels)
{
    const double top = highest(counts, texels);
    bool good = put(file,
                    "<path d=\"M%.1f %dv%dh%d\" fill=\"none\" stroke=\"#333\"/>"
                    "<text x=\"%.1f\" y=\"%d\" text-anchor=\"end\">%.2g %%</text>"
                    "<text x=\"%.1f\" y=\"%d\" text-anchor=\"end\">0</text>\n",
                    x, y, HEIGHT, PANEL, x - 6, y + 5, top * 100, x - 6, y + HEIGHT + 4);
    for (uint32_t i = 0; i < GN_HISTOGRAM_BINS && good; i++) {
        const double share = (double)counts[i] / (double)texels;
        const double height = fmin(share / top, 1) * HEIGHT;
        const double width = (double)PANEL / GN_HISTOGRAM_BINS;
        if (counts[i] > 0)
            good = put(file,
                       "<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"%s\">"
                       "<title>%.4g %%</title></rect>\n",
                       x + i * width, y + HEIGHT - height, width - 0.6, height,
                       share > top ? "#9db8d2" : "#2f6da8", share * 100);
    }
    return good;
}

static bool put_column(gn_file *file, const gn_histogram *h, uint32_t column)
{
    static const int powers[] = {-6, -5, -4, -3, -2, -1};
    const double x = LEFT + column * (double)(PANEL + GAP);
    const double low = log10(GN_XI4_LEAST), span = log10(GN_XI4_MOST) - low;
    char title[64] = "not filtered";
    if (h->sigma > 0)
        snprintf(title, sizeof title, "&#963; = %g texels, %u&#215;%u", h->sigma, h->width,
                 h->width);
    bool good =
        put(file, "<text x=\"%.1f\" y=\"%d\" font-weight=\"600\">%s</text>\n", x, TOP - 16,
            title) &&
        put_bars(file, x, TOP, h->warped, h->texels) && put_tick(file, x, TOP, 0, "0") &&
        put_tick(file, x, TOP, 0.5, "0.5") && put_tick(file, x, TOP, 1, "1") &&
        put(file,
            "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">&#936;&#8324;(&#958;"
            "&#8324;), as stored</text>\n",
            x + PANEL / 2.0, TOP + HEIGHT + 36) &&
        put_bars(file, x, TOP + ROW, h->logarithmic, h->texels) &&
        put_line(file, x, TOP + ROW, (log10(GN_XI4_RARE) - low) / span, "10&#8315;&#8310;") &&
        put_line(file, x, TOP + ROW, (log10(GN_XI4_BIAS) - low) / span, "6&#183;10&#8315;&#8309;");
    for (size_t i = 0; i < sizeof powers / sizeof *powers && good; i++) {
        char text[24];
        snprintf(text, sizeof text, "%d", powers[i]);
        good = put_tick(file, x, TOP + ROW, (powers[i] - low) / span, text);
    }
    return good &&
           put(file,
               "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">log&#8321;&#8320; &#958;&#8324;"
               "</text><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.2f %% below the first "
               "line, %.2f %% above the second</text>\n",
               x + PANEL / 2.0, TOP + ROW + HEIGHT + 36, x + PANEL / 2.0, TOP + ROW + HEIGHT + 54,
               share(h->below, h) * 100, share(h->above, h) * 100);
}

/* Text of the user's that may hold what XML does not. */
static bool put_escaped(gn_file *file, const char *text)
{
    bool good = true;
    for (; *text && good; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '<' || c == '>' || c == '&' || c < 0x20)
            good = put(file, c < 0x20 ? " " : "&#%d;", c);
        else
            good = gn_file_write(file, text, 1) == GN_OK;
    }
    return good;
}

bool gn_histogram_write_svg(gn_app *app, const char *path, const gn_histogram *histograms,
                            uint32_t count)
{
    const int width = LEFT + (int)count * (PANEL + GAP), height = TOP + 2 * ROW + BOTTOM;
    gn_file file;
    if (gn_file_begin(gn_device_context(app->device), path, &file) != GN_OK)
        return false;
    char camera[32];
    bool good =
        put(&file,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" "
            "viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" font-size=\"12\" "
            "fill=\"#222\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n"
            "<text x=\"%d\" y=\"24\" font-size=\"15\">&#958;&#8324; of the shadow maps of ",
            width, height, width, height, LEFT) &&
        put_escaped(&file, app->scene_name) && put(&file, ", camera ") &&
        put_escaped(&file, gn_app_camera_name(app, camera)) &&
        put(&file, ", %u&#178; texels; bars: share of the texels</text>\n", app->map.resolution);
    for (uint32_t i = 0; i < count && good; i++)
        good = put_column(&file, &histograms[i], i);
    good = good && put(&file, "</svg>\n") && !gn_app_interrupted();
    if (!good) {
        gn_file_abort(&file);
        return false;
    }
    return gn_file_commit(&file) == GN_OK;
}
