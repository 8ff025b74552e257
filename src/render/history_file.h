/* Histories in files. */
#ifndef GN_RENDER_HISTORY_FILE_H
#define GN_RENDER_HISTORY_FILE_H

#include "cpu/kernels.h"
#include "render/history.h"

/* What a view's next frame is measured against. */
typedef struct gn_last_frame {
    bool valid;
    uint64_t scene;         /* its number */
    uint32_t width, height; /* of the picture */
    gn_rays rays;
    float *world; /* 16 a node */
    uint32_t node_count;
} gn_last_frame;

/* Writes a history, and a view's last frame where last is not NULL. */
gn_result gn_history_write(const gn_history *history, const gn_last_frame *last, const char *path);

/* Makes the history that a file holds. last: NULL, or width and height of a view; it is filled in
 * then, or refused where the file has no frame of that size. After an error *history is NULL, and
 * last holds nothing. */
gn_result gn_history_read(const gn_scene *scene, const char *path, gn_history **history,
                          gn_last_frame *last);

/* The same of a file in memory; name is for messages. */
gn_result gn_history_read_memory(const gn_scene *scene, const char *name, const uint8_t *data,
                                 size_t size, gn_history **history, gn_last_frame *last);

#endif
