/* The report: what is to be run, running it, and the page. */
#ifndef GN_APP_REPORT_H
#define GN_APP_REPORT_H

#include "method.h"

/* Embedded by the build: the page, its script and style, the figures, the plotting library. */
extern const char gn_report_page[], gn_report_style[], gn_report_script[], gn_report_plots[],
    gn_report_figures[], gn_chart_library[];

typedef struct gn_app_report {
    gn_app app;
    const char *folder;  /* where the page goes */
    const char *methods; /* of comparisons and sequences: "a,b,c" */
    const char *figures; /* names of figures, with * and ?: "a,b,c" */
    bool has_maps;       /* one of them does */
    uint32_t frames;     /* of a sequence */
    char work[4096];     /* a folder of our own in it, where pictures are until all is done; "" */
    bool made_folder;    /* it was not there */
    char *page_text;     /* while pictures are moved: the page's data */
    uint32_t failed;     /* commands that went wrong */
    cJSON *runs;         /* commands: argv; when run line, seconds, result or error */
    cJSON *comparisons;  /* of the methods on one view */
    cJSON *figure_list;  /* the papers', and sequences */
    cJSON *papers;
} gn_app_report;

/* Fills runs, comparisons and figure_list for the scenes, or the built-in ones if count is 0. What
 * a command has in braces is filled in but for {out}, the folder of the pictures. */
bool gn_report_plan(gn_app_report *report, const char *const *scenes, int count);

/* Runs one of the runs, in a process of its own: what it keeps and breaks goes with it. Its part of
 * the progress is [base, base + span]. False after an interrupt or where no process can be made. */
bool gn_report_run(gn_app_report *report, cJSON *run, double base, double span);

/* What a command line would be called in a shell. */
char *gn_report_line(const cJSON *argv, const char *out);

/* {"processor": ..., "cores": ..., "system": ...} */
cJSON *gn_report_machine(void);
/* Of the sources that this program was made from. */
extern const char gn_build_commit[];

#endif
