/* Pages that need nothing but a browser: a template whose marks are filled in. */
#ifndef GN_APP_PAGE_H
#define GN_APP_PAGE_H

#include "app.h"
#include "output/output.h"

/* What takes the place of the comment with this name, as STYLE; one of the three below. */
typedef struct gn_page_part {
    const char *mark;
    const char *text;
    const cJSON *json;
    bool (*write)(gn_app *app, gn_file *file, const void *data);
    const void *data;
} gn_page_part;

/* Writes the page, whole or not at all. Every part has its mark in the template. */
bool gn_page_write(gn_app *app, const char *path, const char *page, const gn_page_part *parts,
                   size_t count);

/* Text into a page's file. */
bool gn_page_put(gn_file *file, const char *text);

/* Embedded by the build: shared style, the viewer of pictures. */
extern const char gn_page_style[], gn_page_viewer[];

#endif
