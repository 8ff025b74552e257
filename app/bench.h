/* The benchmark: methods side by side on the frames of one camera. */
#ifndef GN_APP_BENCH_H
#define GN_APP_BENCH_H

#include "app.h"

#include "measure/measure.h"

typedef struct gn_bench_options {
    uint32_t frames, warm_up; /* measured frames, and frames before them */
    uint32_t repeats;         /* runs a frame and method; the fastest counts */
    double fps, start;        /* frame f is at start + f / fps seconds */
    uint32_t reference;       /* samples a pixel of the reference; 0: none */
    uint32_t reference_frames; /* how many frames get one, spread over the path */
} gn_bench_options;

/* What one method did. Index 0 .. method_count - 1, then the reference. */
typedef struct gn_bench_row {
    const char *name;
    gn_spread visibility, per_frame_speedup; /* milliseconds; times the naive baseline's time */
    double nanoseconds_per_ray, rays_per_pixel;
    double wrong, mean_abs;   /* against tracing all with the same alpha rule */
    double flicker, toggles;  /* docs/metrics.md */
    double mse, mean;         /* against the reference; mean visibility of the same frames */
    double noise;             /* median over frames of the slowest repeat over the fastest */
    bool timed, steadiness;   /* false: not measured for this row */
} gn_bench_row;

typedef struct gn_bench_result {
    gn_bench_row rows[GN_APP_MAX_METHODS + 1];
    uint32_t count;
    gn_spread gbuffer, shade, update; /* milliseconds a frame */
    double reference_mean;
    uint64_t rays; /* of one frame on average */
} gn_bench_result;

/* Runs it. methods: real ones, or the pseudo-method "naive". */
bool gn_bench_run(gn_app *app, const gn_bench_options *options, const gn_app_method *methods,
                  uint32_t method_count, gn_bench_result *result);

/* The row with that name, or NULL. */
const gn_bench_row *gn_bench_find(const gn_bench_result *result, const char *name);

#endif
