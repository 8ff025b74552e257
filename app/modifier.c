/* What a method's name says behind colons: "lt-vsm:mip0:no-remove:size=512". */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method.h"

/* What a modifier belongs to. */
typedef enum scope { OF_MAPS, OF_LEAKS, OF_MASKS, OF_RAYS } scope;

/* Settings: a method takes each once. */
typedef enum setting {
    ALPHA = 1 << 0,
    MASK = 1 << 1,
    EXPAND = 1 << 2,
    REMOVE = 1 << 3,
    REUSE = 1 << 4,
    REFRESH = 1 << 5,
    DEPTH_TEST = 1 << 6,
    KERNEL = 1 << 7,
    TEXELS = 1 << 8,
    UNDRAWN = 1 << 9,
    SIZE = 1 << 10,
    EPSILON = 1 << 11,
    TRACER = 1 << 12
} setting;

static const struct modifier {
    const char *name;
    scope scope;
    unsigned settings;
    uint32_t choice;
    const char *range; /* NULL: it takes no number */
    double min, max;
} modifiers[] = {
    {"mip0", OF_LEAKS, ALPHA, GN_ALPHA_RULE_MIP0, NULL, 0, 0},
    {"raw", OF_LEAKS, ALPHA, GN_ALPHA_RULE_RAW, NULL, 0, 0},
    {"test", OF_LEAKS, ALPHA, GN_ALPHA_RULE_TEST, NULL, 0, 0},
    {"saturate", OF_LEAKS, ALPHA, GN_ALPHA_RULE_SATURATE, NULL, 0, 0},
    {"coverage", OF_LEAKS, ALPHA, GN_ALPHA_RULE_COVERAGE, NULL, 0, 0},
    {"filtered", OF_LEAKS, TEXELS, 0, NULL, 0, 0},
    {"epsilon", OF_LEAKS, EPSILON, 0, "a number from 0 to 0.49", 0, 0.49},
    {"no-mask", OF_LEAKS, MASK, 0, NULL, 0, 0},
    {"no-expand", OF_MASKS, EXPAND, 0, NULL, 0, 0},
    {"no-remove", OF_MASKS, REMOVE, 0, NULL, 0, 0},
    {"full", OF_MASKS, KERNEL, GN_LEAK_FULL, NULL, 0, 0},
    {"depth-test", OF_MASKS, DEPTH_TEST, GN_SWITCH_ON, NULL, 0, 0},
    {"no-depth-test", OF_MASKS, DEPTH_TEST, GN_SWITCH_OFF, NULL, 0, 0},
    {"no-reuse", OF_MAPS, REUSE | REFRESH, 0, NULL, 0, 0},
    {"refresh", OF_MAPS, REFRESH, 0, "a whole number from 1 to 64", 1, 64},
    {"undrawn", OF_MAPS, UNDRAWN, 0, "a whole number from 0 to 8", 0, GN_MAX_CASCADES},
    {"size", OF_MAPS, SIZE, 0, "a whole number from 16 to 16384", 16, 16384},
    {"bvh", OF_RAYS, TRACER, GN_TRACER_BVH, NULL, 0, 0},
    {"light-buffer", OF_RAYS, TRACER, GN_TRACER_LIGHT_BUFFER, NULL, 0, 0},
};

enum { MODIFIER_COUNT = sizeof modifiers / sizeof *modifiers };

static void set(const struct modifier *modifier, double value, gn_app_method *method)
{
    gn_app_modifiers *own = &method->own;
    switch ((setting)(modifier->settings & ~(modifier->settings - 1))) { /* the first */
    case ALPHA:
        method->method.alpha = (gn_alpha_rule)modifier->choice;
        break;
    case MASK:
        method->method.mask = false;
        break;
    case EXPAND:
        own->leak.no_expand = true;
        break;
    case REMOVE:
        own->leak.no_remove = true;
        break;
    case REUSE:
        own->no_reuse = true;
        break;
    case REFRESH:
        own->refresh = (uint32_t)value;
        break;
    case DEPTH_TEST:
        own->leak.depth_test = modifier->choice;
        break;
    case KERNEL:
        own->leak.kernel = modifier->choice;
        break;
    case TEXELS:
        method->method.map.single_depth = false;
        break;
    case UNDRAWN:
        own->undrawn = (uint32_t)value;
        break;
    case SIZE:
        own->resolution = (uint32_t)value;
        break;
    case EPSILON:
        own->leak.epsilon = value;
        break;
    case TRACER:
        own->tracer = modifier->choice;
        break;
    }
}

static const struct modifier *find(const char *name)
{
    for (uint32_t i = 0; i < MODIFIER_COUNT; i++)
        if (strcmp(modifiers[i].name, name) == 0)
            return &modifiers[i];
    return NULL;
}

static bool unknown(const char *command, const char *name)
{
    const char *names[MODIFIER_COUNT + 1] = {NULL};
    char list[512] = "";
    size_t used = 0;
    for (uint32_t i = 0; i < MODIFIER_COUNT; i++) {
        names[i] = modifiers[i].name;
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s%s", i ? ", " : "", names[i],
                                 modifiers[i].range ? "=N" : "");
    }
    const char *guess = gn_suggest(name, names);
    if (guess)
        gn_usage_error(command, "no modifier '%s' of methods; did you mean '%s'?", name, guess);
    else
        gn_usage_error(command, "no modifier '%s' of methods; there are: %s", name, list);
    return false;
}

/* The number behind "size="; text: what stands behind the name, "" or "=512". */
static bool parse_value(const char *command, const struct modifier *m, const char *text,
                        double *value)
{
    char *end;
    if (!m->range && *text) {
        gn_usage_error(command, "':%s' takes no number", m->name);
        return false;
    }
    if (!m->range)
        return true;
    *value = *text ? strtod(text + 1, &end) : NAN;
    const bool whole = m->max >= 1;
    if (*text && end != text + 1 && !*end && *value >= m->min && *value <= m->max &&
        (!whole || *value == floor(*value)))
        return true;
    gn_usage_error(command, "':%s' needs %s, as in ':%s=%g'", m->name, m->range, m->name,
                   whole ? fmax(m->min, 1) : 0.01);
    return false;
}

/* Is it of use to this method? If not, says why. */
static bool fits(const char *command, const struct modifier *m, const gn_app_method *method)
{
    const gn_method *preset = &method->method;
    const char *name = preset->name;
    if (m->scope == OF_RAYS && gn_app_has_rays(method))
        return true;
    if (m->scope == OF_RAYS)
        gn_usage_error(command, "'%s:%s': %s %s", method->name, m->name, method->name,
                       method->pseudo ? "takes no modifiers" : "traces no rays");
    else if (method->pseudo || preset->trace == GN_TRACE_ALL)
        gn_usage_error(command, "'%s:%s': %s has no map%s", method->name, m->name, method->name,
                       m->settings == ALPHA ? "; the alpha rule of a ray is in its name" : "");
    else if (m->scope != OF_MAPS && preset->trace != GN_TRACE_LEAK)
        gn_usage_error(command, "'%s:%s': %s traces no rays; lt-*, ltt-* and hybrid-pcf do", name,
                       m->name, name);
    else if (m->settings == MASK && !preset->mask)
        gn_usage_error(command, "'%s:%s': %s has no mask", name, m->name, name);
    else if (m->settings == TEXELS && !preset->map.single_depth)
        gn_usage_error(command, "'%s:%s': %s %s", name, m->name, name,
                       preset->map.kind == GN_MAP_PCF ? "compares depths, which cannot be filtered"
                                                      : "reads filtered texels already");
    else
        return true;
    return false;
}

bool gn_app_modify_method(const char *command, const char *text, gn_app_method *method)
{
    if (!*text)
        return true;
    unsigned given = 0;
    const char *of_mask = NULL; /* one that only a mask has a use for */
    for (const char *start = text; *start;) {
        char name[128];
        const size_t length = strcspn(++start, ":");
        snprintf(name, sizeof name, "%.*s", (int)(length < 127 ? length : 127), start);
        char *equals = strchr(name, '=');
        char value_text[128] = "";
        if (equals) {
            snprintf(value_text, sizeof value_text, "%s", equals);
            *equals = '\0';
        }
        const struct modifier *m = find(name);
        double value = 0;
        if (!m)
            return unknown(command, name);
        if (!fits(command, m, method) || !parse_value(command, m, value_text, &value))
            return false;
        if (given & m->settings) {
            gn_usage_error(command, "'%s%s': ':%s' and what stands before it exclude each other",
                           method->method.name, text, name);
            return false;
        }
        given |= m->settings;
        of_mask = m->scope == OF_MASKS ? m->name : of_mask;
        set(m, value, method);
        start += length;
    }
    if (of_mask && !method->method.mask) {
        gn_usage_error(command, "'%s%s': ':%s' is about a mask, and there is none",
                       method->method.name, text, of_mask);
        return false;
    }
    snprintf(method->text, sizeof method->text, "%s%s", method->method.name, text);
    method->name = method->method.name = method->text;
    return true;
}
