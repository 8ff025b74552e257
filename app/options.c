#include "options.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int gn_usage_error(const char *command, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fprintf(stderr, "gnomon %s: %s\nTry 'gnomon %s --help'.\n", command, text, command);
    return 2;
}

/* Edits (insert, remove, replace) that turn a into b. */
static unsigned edit_distance(const char *a, const char *b)
{
    unsigned row[64];
    const size_t length = strlen(b);
    if (length + 1 > sizeof row / sizeof *row)
        return 64;
    for (unsigned j = 0; j <= length; j++)
        row[j] = j;
    for (unsigned i = 1; a[i - 1]; i++) {
        unsigned diagonal = row[0];
        row[0] = i;
        for (unsigned j = 1; j <= length; j++) {
            unsigned best = diagonal + (a[i - 1] != b[j - 1]);
            if (row[j] + 1 < best)
                best = row[j] + 1;
            if (row[j - 1] + 1 < best)
                best = row[j - 1] + 1;
            diagonal = row[j];
            row[j] = best;
        }
    }
    return row[length];
}

const char *gn_suggest(const char *text, const char *const *choices)
{
    const char *best = NULL;
    unsigned least = 1 + (unsigned)strlen(text) / 3;
    for (; *choices; choices++) {
        unsigned distance = edit_distance(text, *choices);
        if (distance <= least) {
            least = distance - (distance > 0);
            best = *choices;
        }
    }
    if (!best) {
        return NULL;
    }
    return best;
}

/* Values ------------------------------------------------------------------------------------ */

static bool parse_count(const char *text, const char **end, double min, double max, uint32_t *value)
{
    if (*text < '0' || *text > '9')
        return false;
    char *after;
    errno = 0;
    unsigned long long number = strtoull(text, &after, 10);
    if (errno || (double)number < min || (double)number > max || number > UINT32_MAX)
        return false;
    *value = (uint32_t)number;
    *end = after;
    return true;
}

static bool parse_real(const char *text, const char **end, double min, double max, double *value)
{
    char *after;
    double number = strtod(text, &after);
    if (after == text || !isfinite(number) || number < min || number > max)
        return false;
    *value = number;
    *end = after;
    return true;
}

static bool parse_value(const gn_option *option, const char *text)
{
    const char *end = text;
    switch (option->kind) {
    case GN_OPTION_FLAG:
        return false;
    case GN_OPTION_TEXT:
        *(const char **)option->value = text;
        return *text != '\0';
    case GN_OPTION_COUNT:
        return parse_count(text, &end, option->min, option->max, option->value) && !*end;
    case GN_OPTION_REAL:
        return parse_real(text, &end, option->min, option->max, option->value) && !*end;
    case GN_OPTION_CHOICE:
        for (uint32_t i = 0; option->choices[i]; i++) {
            if (strcmp(text, option->choices[i]) == 0) {
                *(uint32_t *)option->value = i;
                return true;
            }
        }
        return false;
    case GN_OPTION_SIZE: {
        uint32_t *size = option->value;
        return parse_count(text, &end, option->min, option->max, &size[0]) && *end == 'x' &&
               parse_count(end + 1, &end, option->min, option->max, &size[1]) && !*end;
    }
    case GN_OPTION_FRAMES: {
        gn_frames *frames = option->value;
        frames->given = true;
        return parse_count(text, &end, 0, 1e6, &frames->first) && *end == ':' &&
               parse_count(end + 1, &end, 0, 1e6, &frames->last) && !*end &&
               frames->first <= frames->last;
    }
    case GN_OPTION_SUN: {
        gn_sun *sun = option->value;
        sun->given = true;
        return parse_real(text, &end, -360, 360, &sun->azimuth) && *end == ',' &&
               parse_real(end + 1, &end, -90, 90, &sun->elevation) && !*end;
    }
    case GN_OPTION_REALS: {
        gn_reals *reals = option->value;
        for (reals->count = 0; reals->count < (uint32_t)option->max; end++) {
            if (!parse_real(end, &end, -HUGE_VAL, HUGE_VAL, &reals->values[reals->count]))
                return false;
            if (++reals->count >= (uint32_t)option->min && !*end)
                return true;
            if (*end != ',')
                return false;
        }
        return false;
    }
    }
    return false;
}

/* What a value should have looked like. */
static void describe(const gn_option *option, char *text, size_t size)
{
    switch (option->kind) {
    case GN_OPTION_FLAG:
    case GN_OPTION_TEXT:
        snprintf(text, size, "%s, not empty", option->argument);
        break;
    case GN_OPTION_COUNT:
        snprintf(text, size, "a whole number from %.0f to %.0f", option->min, option->max);
        break;
    case GN_OPTION_REAL:
        snprintf(text, size, "a number from %g to %g", option->min, option->max);
        break;
    case GN_OPTION_CHOICE: {
        int used = snprintf(text, size, "one of");
        for (uint32_t i = 0; option->choices[i] && used > 0 && (size_t)used < size; i++)
            used += snprintf(text + used, size - (size_t)used, "%s %s", i ? "," : "",
                             option->choices[i]);
        break;
    }
    case GN_OPTION_SIZE:
        snprintf(text, size, "WIDTHxHEIGHT, such as 1920x1080, each from %.0f to %.0f", option->min,
                 option->max);
        break;
    case GN_OPTION_FRAMES:
        snprintf(text, size, "FIRST:LAST, such as 0:59, two whole numbers in order");
        break;
    case GN_OPTION_SUN:
        snprintf(text, size,
                 "AZIMUTH,ELEVATION in degrees, such as 140,35; the azimuth from -360 to 360, "
                 "the elevation from -90 to 90");
        break;
    case GN_OPTION_REALS:
        if (option->min == option->max)
            snprintf(text, size, "%s: %.0f numbers", option->argument, option->min);
        else
            snprintf(text, size, "%s: %.0f to %.0f numbers, separated by commas", option->argument,
                     option->min, option->max);
        break;
    }
}

/* Help -------------------------------------------------------------------------------------- */

static void print_option(char letter, const char *name, const char *argument, const char *help)
{
    enum { COLUMN = 30 };
    char left[64];
    int used = letter ? snprintf(left, sizeof left, "  -%c, --%s %s", letter, name, argument)
                      : snprintf(left, sizeof left, "      --%s %s", name, argument);
    if (used >= COLUMN)
        printf("%s\n%*s%s\n", left, COLUMN, "", help);
    else
        printf("%-*s%s\n", COLUMN, left, help);
}

static void print_help(const gn_usage *usage, const gn_option *options)
{
    printf("gnomon %s: %s\n\nUsage: gnomon %s %s\n\nOptions:\n", usage->command, usage->summary,
           usage->command, usage->synopsis);
    for (const gn_option *option = options; option->name; option++)
        print_option(option->letter, option->name, option->argument ? option->argument : "",
                     option->help);
    print_option('h', "help", "", "this text");
    if (usage->notes) {
        printf("\n");
        for (const char *const *note = usage->notes; *note; note++)
            printf("%s\n", *note);
    }
    printf("\nExamples:\n  %s\n  %s\n", usage->examples[0], usage->examples[1]);
}

/* Parsing ----------------------------------------------------------------------------------- */

static const gn_option *find_long(const gn_option *options, const char *name, size_t length)
{
    for (; options->name; options++) {
        if (strlen(options->name) == length && strncmp(options->name, name, length) == 0)
            return options;
    }
    return NULL;
}

static const gn_option *find_short(const gn_option *options, char letter)
{
    for (; options->name; options++) {
        if (options->letter == letter)
            return options;
    }
    return NULL;
}

static int unknown_option(const gn_usage *usage, const gn_option *options, const char *text)
{
    const char *names[64] = {"help"};
    unsigned count = 1;
    for (; options->name && count < 63; options++)
        names[count++] = options->name;
    const char *guess = strncmp(text, "--", 2) == 0 ? gn_suggest(text + 2, names) : NULL;
    if (guess)
        return gn_usage_error(usage->command, "no option '%s'; did you mean '--%s'?", text, guess);
    return gn_usage_error(usage->command, "no option '%s'", text);
}

/* One option at argv[*index], and its value. */
static int parse_option(const gn_usage *usage, const gn_option *options, int argc, char **argv,
                        int *index)
{
    char *text = argv[*index];
    const char *value = NULL;
    const gn_option *option;
    if (strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0) {
        print_help(usage, options);
        return 0;
    }
    if (text[1] == '-') {
        const char *equals = strchr(text, '=');
        option =
            find_long(options, text + 2, equals ? (size_t)(equals - text - 2) : strlen(text + 2));
        value = equals ? equals + 1 : NULL;
    } else {
        option = find_short(options, text[1]);
        if (option && text[2])
            value = text + 2;
    }
    if (!option)
        return unknown_option(usage, options, text);

    if (option->kind == GN_OPTION_FLAG) {
        if (value)
            return gn_usage_error(usage->command, "--%s takes no value", option->name);
        *(bool *)option->value = true;
        return GN_GO_ON;
    }
    char expected[256];
    describe(option, expected, sizeof expected);
    if (!value && *index + 1 < argc)
        value = argv[++*index];
    if (!value)
        return gn_usage_error(usage->command, "--%s needs a value: %s", option->name, expected);
    if (!parse_value(option, value))
        return gn_usage_error(usage->command, "--%s: '%s' is not %s", option->name, value,
                              expected);
    return GN_GO_ON;
}

int gn_options_parse(const gn_usage *usage, const gn_option *options, int argc, char **argv,
                     const char **words)
{
    int expected = 0, found = 0;
    for (; usage->words[expected]; expected++)
        words[expected] = NULL;

    bool only_words = false;
    for (int i = 1; i < argc; i++) {
        if (!only_words && strcmp(argv[i], "--") == 0) {
            only_words = true;
        } else if (!only_words && argv[i][0] == '-' && argv[i][1]) {
            int code = parse_option(usage, options, argc, argv, &i);
            if (code != GN_GO_ON)
                return code;
        } else if (found == expected) {
            return gn_usage_error(usage->command, "'%s' is one argument too many", argv[i]);
        } else {
            words[found++] = argv[i];
        }
    }
    if (found < expected && usage->words[found][0] != '[')
        return gn_usage_error(usage->command, "%s is missing", usage->words[found]);
    return GN_GO_ON;
}
