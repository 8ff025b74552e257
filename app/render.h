/* gnomon render: its options, and the frames of a sequence. */
#ifndef GN_APP_RENDER_H
#define GN_APP_RENDER_H

#include <string.h>

#include "picture.h"

typedef enum gn_app_antialias { GN_APP_NO_ANTIALIAS, GN_APP_TAA, GN_APP_SMAA_T2X } gn_app_antialias;

extern const char *const gn_app_antialias_names[]; /* in this order, ending with NULL */

typedef struct gn_render_options {
    gn_app_options common;
    const char *output, *method, *aov;
    gn_app_parts parts; /* in place of method */
    const char *history_in, *history_out;
    uint32_t samples, warm_up;
    gn_frames frames;
    double fps;
    bool resume;
    const char *beside; /* methods, separated by commas, perhaps with "+taa" */
    uint32_t antialias; /* gn_app_antialias_names */
} gn_render_options;

static inline bool gn_ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text), b = strlen(end);
    return a > b && strcmp(text + a - b, end) == 0;
}

/* A method at work on a view of its own. */
typedef struct gn_shot {
    gn_frame frame;
    const char *name;           /* of the method, and how it is antialiased */
    gn_antialias *antialias;    /* NULL: none */
    float *smooth;              /* its picture, which is the frame's then */
    gn_visibility_stats *stats; /* one a light */
    gn_app_tracing tracing;     /* of all frames */
    double update_ms;           /* moving the scene to the frame at hand */
    double antialias_ms;
} gn_shot;

/* Opened or not, a shot is to be closed. */
bool gn_shot_open(gn_shot *shot, gn_app *app, const gn_render_options *o,
                  const gn_app_method *method, const char *name, gn_app_antialias antialias,
                  uint32_t aovs);
void gn_shot_close(gn_shot *shot);
/* Seconds; frames before the animation stand still at its start, those of one picture at its time.
 */
double gn_time_of(const gn_render_options *o, int64_t number);
/* Moves the scene to a frame. */
bool gn_shot_move(gn_shot *shot, const gn_render_options *o, int64_t number);
/* Renders it, up to its pictures. */
bool gn_shot_render(gn_shot *shot);
/* The frames that are not shown: those of a history, or before the first. */
bool gn_shot_warm_up(gn_shot *shot, const gn_render_options *o, uint32_t first);
/* Moves to a frame that nobody looks at, for what the next one is measured against. */
bool gn_shot_look_back(gn_shot *shot, const gn_render_options *o, uint32_t number);
/* What there is to say of a frame. */
cJSON *gn_shot_report(const gn_shot *shot, const gn_render_options *o, uint32_t number,
                      double write_ms);

/* Renders what the options ask for into pictures; frames gets a report for each, *skipped how many
 * were there before. */
bool gn_render_sequence(gn_shot *shot, const gn_render_options *o, cJSON *frames,
                        uint32_t *skipped);
/* Renders it into a video, the shots side by side. */
bool gn_render_video(gn_shot *shots, uint32_t count, const gn_render_options *o, cJSON *frames);

/* Writes text into an 8-bit RGB picture of stride pixels a row, on a dark ground, its corner at x,
 * y; each dot of its letters is scale pixels wide. What does not fit into width and height is cut.
 * Knows small letters, digits, and "-+:=.,": what names of methods are made of. */
void gn_draw_label(uint8_t *rgb, uint32_t width, uint32_t height, uint32_t stride, uint32_t x,
                   uint32_t y, uint32_t scale, const char *text);

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
    bool keeps;           /* the method does keep something, or antialiasing does */
    bool saves;           /* and all of it can be saved: antialiasing's cannot */
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
