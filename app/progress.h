/* How far it is: a bar with the time left on a terminal, plain lines otherwise, on stderr. */
#ifndef GN_APP_PROGRESS_H
#define GN_APP_PROGRESS_H

#include <stdbool.h>

typedef struct gn_bar {
    bool quiet, terminal, drawn;
    double start, shown; /* milliseconds */
    double base, span;   /* the step in hand is [base, base + span] of the whole */
    char step[96];
} gn_bar;

void gn_bar_start(gn_bar *bar, bool quiet);

/* Begins the step that takes the whole from base by span, both in [0,1]. */
void gn_bar_step(gn_bar *bar, double base, double span, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* fraction of the step in [0,1]. */
void gn_bar_update(gn_bar *bar, double fraction);

/* Takes the bar off the terminal, so that something else can be printed. */
void gn_bar_clear(gn_bar *bar);

#endif
