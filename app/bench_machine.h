/* What the machine did meanwhile: hardware counters, and how busy it was with other things. */
#ifndef GN_APP_BENCH_MACHINE_H
#define GN_APP_BENCH_MACHINE_H

#include <stdbool.h>
#include <stdint.h>

typedef enum gn_counter {
    GN_COUNTER_INSTRUCTIONS,
    GN_COUNTER_CYCLES,
    GN_COUNTER_CACHE_MISSES,
    GN_COUNTER_BRANCH_MISSES,
    GN_COUNTER_COUNT
} gn_counter;

extern const char *const gn_counter_names[GN_COUNTER_COUNT]; /* "instructions", ... */

typedef struct gn_machine {
    int files[GN_COUNTER_COUNT]; /* -1: not counted */
    bool counts;                 /* any is */
    char reason[160];            /* why not */
    double busy, total;          /* processor time since the machine started, and at all */
    double own;                  /* of this process */
} gn_machine;

/* Before the threads whose work is to be counted exist: they inherit the counters. Counts what the
 * process does outside the kernel. What cannot be counted is not, and reason says why. */
void gn_machine_open(gn_machine *machine);
void gn_machine_close(gn_machine *machine);

/* Counts since open of all threads; NaN where not counted. Where the processor has fewer counters
 * than are asked for they take turns, and are scaled. */
void gn_machine_read(const gn_machine *machine, double counts[GN_COUNTER_COUNT]);

/* Share of the processors' time since open that others used; NaN where the system does not tell. */
double gn_machine_others(const gn_machine *machine);

#endif
