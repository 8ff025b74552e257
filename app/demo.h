/* What the demonstration measures, and the page that shows it. */
#ifndef GN_APP_DEMO_H
#define GN_APP_DEMO_H

#include "method.h"

/* The page; the marks where data and images go are in it as comments. Made from demo.html. */
extern const char gn_demo_page[];

/* Writes the page with results in it, and the PNGs that they name, which lie in folder. */
bool gn_demo_write_page(gn_app *app, const char *folder, const cJSON *results);

#endif
