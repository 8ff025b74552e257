#include "progress.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/base.h"

#define BAR_WIDTH 24

void gn_bar_start(gn_bar *bar, bool quiet)
{
    *bar = (gn_bar){.quiet = quiet, .terminal = isatty(STDERR_FILENO) != 0, .span = 1};
    bar->start = bar->shown = gn_milliseconds();
}

static void format_duration(double seconds, char *text, size_t size)
{
    if (seconds < 60)
        snprintf(text, size, "%.0f s", seconds);
    else if (seconds < 3600)
        snprintf(text, size, "%d min %02d s", (int)seconds / 60, (int)seconds % 60);
    else
        snprintf(text, size, "%d h %02d min", (int)(seconds / 3600), (int)(seconds / 60) % 60);
}

static void show(gn_bar *bar, double whole)
{
    const double now = gn_milliseconds();
    const double elapsed = (now - bar->start) * 1e-3;
    char left[40] = "";
    /* A guess from the first moments would only mislead. */
    if (whole > 0.02 && whole < 1 && elapsed > 0.5) {
        char duration[24];
        format_duration(elapsed * (1 - whole) / whole, duration, sizeof duration);
        snprintf(left, sizeof left, ", %s left", duration);
    }
    bar->shown = now;
    if (!bar->terminal) {
        fprintf(stderr, "%3.0f %%  %s%s\n", whole * 100, bar->step, left);
        return;
    }
    char blocks[BAR_WIDTH + 1];
    for (int i = 0; i < BAR_WIDTH; i++)
        blocks[i] = i < whole * BAR_WIDTH ? '#' : '-';
    blocks[BAR_WIDTH] = '\0';
    fprintf(stderr, "\r[%s] %3.0f %%  %s%s\033[K", blocks, whole * 100, bar->step, left);
    fflush(stderr);
    bar->drawn = true;
}

void gn_bar_step(gn_bar *bar, double base, double span, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(bar->step, sizeof bar->step, format, arguments);
    va_end(arguments);
    bar->base = base;
    bar->span = span;
    gn_bar_update(bar, 0);
}

void gn_bar_update(gn_bar *bar, double fraction)
{
    /* Short work is over before anyone reads; plain lines come slowly, for logs. */
    const double now = gn_milliseconds();
    if (bar->quiet || now - bar->shown < (bar->terminal ? (bar->drawn ? 100 : 300) : 5000))
        return;
    show(bar, bar->base + bar->span * fraction);
}

void gn_bar_clear(gn_bar *bar)
{
    if (bar->drawn)
        fprintf(stderr, "\r\033[K");
    bar->drawn = false;
}
