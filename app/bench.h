/* The benchmark: methods side by side on the frames of one camera. */
#ifndef GN_APP_BENCH_H
#define GN_APP_BENCH_H

#include "method.h"

#include "measure/measure.h"
#include "bench_machine.h"

#define GN_BENCH_BASELINE "naive" /* the pseudo-method */

typedef struct gn_bench_options {
    uint32_t frames, warm_up;  /* measured frames, and frames before them */
    uint32_t repeats;          /* runs of the path; of each frame the fastest counts */
    double fps, start;         /* frame f is at start + f / fps seconds */
    uint32_t reference;        /* samples a pixel of the reference; 0: none */
    uint32_t reference_frames; /* how many frames get one, spread over the path */
    const gn_machine *machine; /* opened before the app */
    uint32_t profile_row;      /* of pixels, whose visibility over time is kept; GN_NONE: none */
} gn_bench_options;

/* Milliseconds, over the frames. Most frames may keep all of their maps: the mean tells more then.
 */
typedef struct gn_bench_part {
    gn_spread spread;
    double mean;
} gn_bench_part;

/* What one method did in one frame. */
typedef struct gn_bench_frame {
    gn_app_cost cost;                /* of the fastest repeat */
    double slowest;                  /* repeat, milliseconds */
    double counts[GN_COUNTER_COUNT]; /* of the fastest repeat; NaN where not counted */
    double wrong, mean_abs;          /* against its yardstick */
    double flicker;                  /* since the frame before; NaN in the first */
} gn_bench_frame;

/* What one method did, over all frames. */
typedef struct gn_bench_row {
    const char *name;
    bool timed;                   /* false: the reference */
    const gn_app_method *method;  /* NULL: the reference */
    gn_trace_rule trace;          /* NONE: a map alone */
    const char *yardstick;        /* tracing all; itself for a plain ray */
    const gn_bench_frame *frames; /* NULL: the reference */
    gn_bench_part visibility;     /* a frame, each the fastest of its repeats */
    gn_bench_part shadow_map, filter, test, trace_rays; /* of it */
    double noise;            /* the slowest repeat over the fastest, median over the frames */
    gn_spread speedup_naive; /* the baseline's time over this one's, frame by frame; 0 without */
    gn_bench_part speedup;   /* the same of its yardstick; 0 without */
    double wrong, mean_abs;  /* against its yardstick, mean over the frames */
    double wrong_max, mean_abs_max;  /* worst frame */
    double rays;                     /* a frame, mean */
    double counts[GN_COUNTER_COUNT]; /* a frame, mean; NaN where not counted */
    gn_leak_counts leak;             /* all frames together */
    gn_app_tracing tracing;          /* all frames together; no lights where none was traced */
    gn_bench_part build;             /* of light buffers, part of the visibility stage */
    gn_app_tracing before;           /* the warm-up's */
    uint32_t map_layers;             /* of all lights; 0 without maps */
    double map_fits, map_pending;    /* layers placed anew, being drawn, a frame, mean */
    size_t map_bytes, mask_bytes;
    bool steady;             /* flicker and toggles were measured */
    double flicker, toggles; /* docs/metrics.md */
    /* The same after the reference's change is taken off, where every frame has a reference. */
    double residual_flicker, residual_toggles;
    double mse, mean; /* against the reference; mean visibility of the same frames */
} gn_bench_row;

typedef struct gn_bench_result {
    gn_bench_row rows[GN_APP_MAX_METHODS + 1]; /* the reference, if on every frame, comes last */
    uint32_t count;
    uint32_t frame_count, light_count, repeats; /* repeats: those that were finished */
    double others; /* share of the processors' time that other programs used; NaN: not known */
    gn_bench_frame *frames; /* frame_count for each method */
    float *profile; /* of each row in turn (the reference last): width values for each frame, the
                       mean visibility of the lights, NaN where no surface is; NULL: none */
    gn_spread gbuffer, update; /* milliseconds a frame */
    uint32_t referenced;       /* frames that had a reference */
    bool residual;             /* every frame had one: residual flicker was measured */
    double reference_mean;     /* mean visibility */
    uint64_t rays;             /* of tracing all, a frame, mean */
} gn_bench_result;

/* Runs it. methods: real ones, or the pseudo-method "naive". result holds what was found until
 * gn_bench_free(), whatever is returned: after an interrupt the repeats that were finished, if any
 * (count > 0). */
bool gn_bench_run(gn_app *app, const gn_bench_options *options, gn_app_method *methods,
                  uint32_t method_count, gn_bench_result *result);
void gn_bench_free(gn_app *app, gn_bench_result *result);

/* Was the machine busy with other things? text: a sentence about it. */
bool gn_bench_busy(const gn_bench_result *result, char text[256]);

/* The row with that name, or NULL. */
const gn_bench_row *gn_bench_find(const gn_bench_result *result, const char *name);
/* What steadiness and error are held against: the plain ray, or NULL. */
const gn_bench_row *gn_bench_rival(const gn_bench_result *result);
/* value / rival, or -1 where there is nothing to divide by. */
double gn_bench_ratio(double value, double rival);
/* Reading the map: nanoseconds a pixel of the picture, all lights. */
double gn_bench_ns_per_pixel(const gn_bench_row *row, double pixels);

/* Everything as tables on standard output; as JSON. */
void gn_bench_print(const gn_app *app, const gn_bench_options *o, const gn_bench_result *result);
cJSON *gn_bench_json(const gn_app *app, const gn_bench_options *o, const gn_bench_result *result);

/* One row of pixels over time (docs/metrics.md) as a .png: a strip a method, frames downwards. */
bool gn_bench_write_profile(gn_app *app, const gn_bench_options *options,
                            const gn_bench_result *result, const char *path);

/* runs: a list of gn_bench_json(). */
bool gn_bench_write_csv(gn_app *app, const cJSON *runs, const char *path);

/* Point lights in place of those chosen: a disc of them around a lamp of the scene's. */
bool gn_bench_hang_lamps(gn_app *app, uint32_t count);

/* The table of tracers; width: of names. */
void gn_bench_print_tracing(const gn_app *app, const gn_bench_result *result, int width);
/* The same, and series, added to a method that has its "series". */
void gn_bench_add_tracing(cJSON *json, const gn_app *app, const gn_bench_result *result,
                          const gn_bench_row *row);

/* gnomon bench --filter: the filter of shadow maps, without a scene (bench_filter.c). */
int gn_app_bench_filter(int argc, char **argv);
/* gnomon bench --maps: the drawing of shadow maps, against ray packets (bench_maps.c). */
int gn_app_bench_maps(int argc, char **argv);
/* gnomon bench --evaluate: the reading of shadow maps (bench_evaluate.c). */
int gn_app_bench_evaluate(int argc, char **argv);
/* gnomon bench --compare: two files of results (bench_compare.c). */
int gn_app_bench_compare(int argc, char **argv);

#endif
