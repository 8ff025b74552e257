/* How xi4, the offset of the fourth moment, spreads over the texels of a map (moment paper, section
 * 3.3 and Figure 4). */
#ifndef GN_APP_HISTOGRAM_H
#define GN_APP_HISTOGRAM_H

#include "app.h"

#define GN_HISTOGRAM_BINS 64u
#define GN_XI4_LEAST      1.2e-7 /* what smaller ones are taken for */
#define GN_XI4_MOST       0.25
#define GN_XI4_RARE       1e-6 /* the paper: most texels are below */
#define GN_XI4_BIAS       6e-5 /* the paper: few are above; what biasing to 64 bits makes of all */

typedef struct gn_histogram {
    double sigma;                            /* texels; 0: no filter */
    uint32_t width;                          /* of the filter, texels */
    uint64_t warped[GN_HISTOGRAM_BINS];      /* even parts of Psi4 in [0,1] */
    uint64_t logarithmic[GN_HISTOGRAM_BINS]; /* even parts of log10 xi4 from least to most */
    uint64_t texels, below, above;           /* all; < GN_XI4_RARE; > GN_XI4_BIAS */
} gn_histogram;

void gn_histogram_add(gn_histogram *histogram, const float *xi4, size_t count);

/* One column of plots for each histogram. */
bool gn_histogram_write_svg(gn_app *app, const char *path, const gn_histogram *histograms,
                            uint32_t count);

#endif
