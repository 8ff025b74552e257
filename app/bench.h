/* The benchmark: methods side by side on the frames of one camera. */
#ifndef GN_APP_BENCH_H
#define GN_APP_BENCH_H

#include "method.h"

#include "measure/measure.h"

typedef struct gn_bench_options {
    uint32_t frames, warm_up;  /* measured frames, and frames before them */
    uint32_t repeats;          /* runs a frame and method; the fastest counts */
    double fps, start;         /* frame f is at start + f / fps seconds */
    uint32_t reference;        /* samples a pixel of the reference; 0: none */
    uint32_t reference_frames; /* how many frames get one, spread over the path */
} gn_bench_options;

/* Milliseconds, over the frames. Most frames may keep all of their maps: the mean tells more then.
 */
typedef struct gn_bench_part {
    gn_spread spread;
    double mean;
} gn_bench_part;

/* What one method did, over all frames. */
typedef struct gn_bench_row {
    const char *name;
    bool timed;                                    /* false: the reference */
    gn_bench_part visibility;                      /* a frame, each the fastest of its repeats */
    gn_bench_part shadow_map, filter, test, trace; /* of it */
    double noise;            /* the slowest repeat over the fastest, median over the frames */
    gn_spread speedup_naive; /* the baseline's time over this one's, frame by frame; 0 without */
    gn_spread speedup;       /* the same of its yardstick: tracing all; 0 without */
    double wrong, mean_abs;  /* against its yardstick */
    double rays;             /* a frame, mean */
    uint32_t map_layers;     /* of all lights; 0 without maps */
    double map_fits;         /* layers placed anew, a frame, mean */
    size_t map_bytes;
    bool steady;             /* flicker and toggles were measured */
    double flicker, toggles; /* docs/metrics.md */
    double mse, mean;        /* against the reference; mean visibility of the same frames */
} gn_bench_row;

typedef struct gn_bench_result {
    gn_bench_row rows[GN_APP_MAX_METHODS + 1]; /* the reference, if on every frame, comes last */
    uint32_t count;
    gn_spread gbuffer, update; /* milliseconds a frame */
    uint32_t referenced;       /* frames that had a reference */
    double reference_mean;     /* mean visibility */
    uint64_t rays;             /* a frame, mean */
} gn_bench_result;

/* Runs it. methods: real ones, or the pseudo-method "naive". */
bool gn_bench_run(gn_app *app, const gn_bench_options *options, gn_app_method *methods,
                  uint32_t method_count, gn_bench_result *result);

/* The row with that name, or NULL. */
const gn_bench_row *gn_bench_find(const gn_bench_result *result, const char *name);

/* gnomon bench --filter: the filter of shadow maps, without a scene (bench_filter.c). */
int gn_app_bench_filter(int argc, char **argv);
/* gnomon bench --maps: the drawing of shadow maps, against ray packets (bench_maps.c). */
int gn_app_bench_maps(int argc, char **argv);
/* gnomon bench --evaluate: the reading of shadow maps (bench_evaluate.c). */
int gn_app_bench_evaluate(int argc, char **argv);

#endif
