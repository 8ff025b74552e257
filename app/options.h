/* Command-line options as tables: parsing and --help come from the same lines. */
#ifndef GN_APP_OPTIONS_H
#define GN_APP_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

typedef enum gn_option_kind {
    GN_OPTION_FLAG,   /* bool */
    GN_OPTION_TEXT,   /* const char *, not empty */
    GN_OPTION_COUNT,  /* uint32_t in [min, max] */
    GN_OPTION_REAL,   /* double in [min, max] */
    GN_OPTION_CHOICE, /* uint32_t: the number of a word in choices */
    GN_OPTION_SIZE,   /* uint32_t[2]: WxH, each in [min, max] */
    GN_OPTION_FRAMES, /* gn_frames: A:B */
    GN_OPTION_SUN,    /* gn_sun: AZIMUTH,ELEVATION in degrees */
    GN_OPTION_REALS   /* gn_reals: A,B,...: min to max of them */
} gn_option_kind;

typedef struct gn_frames {
    bool given;
    uint32_t first, last; /* both are part of the range */
} gn_frames;

typedef struct gn_sun {
    bool given;
    double azimuth, elevation; /* degrees */
} gn_sun;

#define GN_MAX_REALS 8

typedef struct gn_reals {
    uint32_t count; /* 0: not given */
    double values[GN_MAX_REALS];
} gn_reals;

typedef struct gn_option {
    const char *name; /* without the dashes; NULL ends a table */
    char letter;      /* short form, or 0 */
    gn_option_kind kind;
    const char *argument; /* what --help calls its value */
    const char *help;
    void *value; /* where the value goes; holds the default before */
    double min, max;
    const char *const *choices; /* words, ending with NULL */
} gn_option;

/* Lines of a table (an array with automatic storage). letter: 0 where there is none. */
#define GN_FLAG(name, letter, value, help)                                                         \
    ((gn_option){name, letter, GN_OPTION_FLAG, NULL, help, value, 0, 0, NULL})
#define GN_TEXT(name, letter, argument, value, help)                                               \
    ((gn_option){name, letter, GN_OPTION_TEXT, argument, help, value, 0, 0, NULL})
#define GN_COUNT(name, letter, argument, value, min, max, help)                                    \
    ((gn_option){name, letter, GN_OPTION_COUNT, argument, help, value, min, max, NULL})
#define GN_REAL(name, letter, argument, value, min, max, help)                                     \
    ((gn_option){name, letter, GN_OPTION_REAL, argument, help, value, min, max, NULL})
#define GN_CHOICE(name, letter, argument, value, choices, help)                                    \
    ((gn_option){name, letter, GN_OPTION_CHOICE, argument, help, value, 0, 0, choices})
#define GN_SIZE(name, letter, value, help)                                                         \
    ((gn_option){name, letter, GN_OPTION_SIZE, "WxH", help, value, 1, 16384, NULL})
#define GN_FRAMES(name, letter, value, help)                                                       \
    ((gn_option){name, letter, GN_OPTION_FRAMES, "A:B", help, value, 0, 0, NULL})
#define GN_SUN(name, letter, value, help)                                                          \
    ((gn_option){name, letter, GN_OPTION_SUN, "AZIMUTH,ELEVATION", help, value, 0, 0, NULL})
/* From `least` to `most` numbers, at most GN_MAX_REALS. */
#define GN_REALS(name, letter, argument, value, least, most, help)                                 \
    ((gn_option){name, letter, GN_OPTION_REALS, argument, help, value, least, most, NULL})
#define GN_OPTIONS_END ((gn_option){0})

/* One command as a person sees it. */
typedef struct gn_usage {
    const char *command;  /* "render" */
    const char *summary;  /* one line */
    const char *synopsis; /* "SCENE -o OUT [options]" */
    const char *const
        *words; /* what the arguments that are no options are called, ending with NULL */
    const char *const *notes; /* lines below the options, ending with NULL; may be NULL */
    const char *examples[2];
} gn_usage;

#define GN_GO_ON (-1)

/* Reads argv[1..]. words gets one entry for each of usage->words; the last ones are NULL where
 * optional (usage->words entry in brackets) and absent. Returns GN_GO_ON, 0 after --help, or 2
 * after saying what is wrong. */
int gn_options_parse(const gn_usage *usage, const gn_option *options, int argc, char **argv,
                     const char **words);

/* Says "gnomon COMMAND: message" with a pointer to --help; returns 2. */
int gn_usage_error(const char *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The word of choices (ending with NULL) that text may have meant, or NULL. */
const char *gn_suggest(const char *text, const char *const *choices);

#endif
