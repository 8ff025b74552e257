/* A camera that follows key frames of a JSON file (docs/cli.md). */
#ifndef GN_APP_CAMERA_PATH_H
#define GN_APP_CAMERA_PATH_H

#include "app.h"

/* Adds it to the scene, animated as glTF animates: positions linearly, rotations spherically.
 * camera: its index. Commit the scene after. False after saying which file and field is wrong. */
bool gn_app_add_camera_path(gn_app *app, const char *file, uint32_t *camera);

#endif
