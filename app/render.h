/* gnomon render: its options, and the frames of a sequence. */
#ifndef GN_APP_RENDER_H
#define GN_APP_RENDER_H

#include <string.h>

#include "picture.h"

typedef struct gn_render_options {
    gn_app_options common;
    const char *output, *method, *aov;
    gn_app_parts parts; /* in place of method */
    const char *history_in, *history_out;
    uint32_t samples, warm_up;
    gn_frames frames;
    double fps;
    bool resume;
} gn_render_options;

static inline bool gn_ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text), b = strlen(end);
    return a > b && strcmp(text + a - b, end) == 0;
}

/* Renders what the options ask for and writes it; frames and tracing get what there is to report,
 * *skipped how many frames were there before. */
bool gn_render_sequence(gn_app *app, const gn_render_options *o, const gn_app_method *method,
                        uint32_t aovs, cJSON *frames, gn_app_tracing *tracing, uint32_t *skipped);

/* The file of one frame of a sequence: its number in place of "####" or "%04d", or else before the
 * extension. */
bool gn_frame_path(gn_app *app, const char *pattern, uint32_t frame, char *out, size_t size);
/* The same with a word for all frames: "walk.resume.png". */
bool gn_sequence_path(gn_app *app, const char *pattern, const char *word, char *out, size_t size);

/* A sequence that is taken up again (--resume). What a method keeps from frame to frame is saved
 * after each frame, in one file beside the pictures ("walk.resume.png.history"), with the number of
 * the frame and the settings that it was made with. It is removed when the last picture is there.
 */
typedef struct gn_resume {
    const gn_render_options *options;
    const gn_frame *frame;
    char state[4096];     /* the file's name */
    bool keeps;           /* the method does keep something */
    uint32_t first, last; /* the frames that are missing, and those between that are there */
    uint32_t from;        /* the first to be rendered, perhaps without a picture */
    bool loaded;          /* the view goes on behind frame from - 1 */
    uint32_t there;       /* pictures that are there */
} gn_resume;

/* Looks what there is, and loads the state into frame->view. Without a state that fits, a method
 * that keeps something starts again from the sequence's first frame, and its pictures that are
 * there are not written again. A state of other settings is an error. first > last: all is there.
 */
bool gn_resume_begin(gn_resume *resume, const gn_render_options *o, const gn_frame *frame);
/* Is the picture of that frame there? */
bool gn_resume_has(const gn_resume *resume, uint32_t frame);
/* After each frame. */
bool gn_resume_save(const gn_resume *resume, uint32_t frame);
/* After the last. */
void gn_resume_end(const gn_resume *resume);

#endif
