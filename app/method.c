/* Methods by name and by their parts. */
#include "method.h"

#include <fnmatch.h>
#include <stdio.h>
#include <string.h>

const char *const gn_app_map_names[] = {"none", "depth", "pcf",   "vsm", "esm",
                                        "evsm", "msm",   "nlmsm", NULL};
const char *const gn_app_trace_names[] = {"all", "none", "leak", NULL};
const char *const gn_app_alpha_names[] = {"mip0", "raw", "test", "saturate", "coverage", NULL};
const char *const gn_app_bound_names[] = {"hamburger", "hausdorff", NULL};

static gn_app_method as_found(const gn_method *method)
{
    return (gn_app_method){.name = method->name,
                           .method = *method,
                           .own = {.leak = gn_app_leak_options_default(),
                                   .resolution = GN_NONE,
                                   .refresh = GN_NONE,
                                   .undrawn = GN_NONE,
                                   .tracer = GN_NONE}};
}

static gn_app_method tracing_all(gn_alpha_rule alpha)
{
    uint32_t i = 0;
    while (gn_methods[i]->trace != GN_TRACE_ALL || gn_methods[i]->alpha != alpha)
        i++; /* there is one for each rule */
    return as_found(gn_methods[i]);
}

gn_app_method gn_app_yardstick(void)
{
    return tracing_all(GN_ALPHA_RULE_MIP0);
}

void gn_app_yardstick_of(const gn_app_method *method, gn_app_method *yardstick)
{
    *yardstick = tracing_all(gn_app_has_rays(method) ? method->method.alpha : GN_ALPHA_RULE_MIP0);
    if (method->own.tracer != GN_NONE)
        gn_app_modify_method("bench", ":bvh", yardstick);
}

/* Names ------------------------------------------------------------------------------------- */

static bool find_method(const char *command, const char *name, const char *const *pseudo,
                        gn_app_method *method)
{
    const gn_method *found = gn_method_find(name);
    if (found) {
        *method = as_found(found);
        return true;
    }
    const char *known[GN_APP_MAX_METHODS + 1] = {"ray"};
    uint32_t count = 1;
    for (uint32_t i = 0; pseudo && pseudo[i]; i++) {
        if (strcmp(name, pseudo[i]) == 0) {
            *method =
                (gn_app_method){.name = pseudo[i], .pseudo = true, .own = {.tracer = GN_NONE}};
            return true;
        }
        known[count++] = pseudo[i];
    }
    for (uint32_t i = 0; gn_methods[i] && count < GN_APP_MAX_METHODS; i++)
        known[count++] = gn_methods[i]->name;
    const char *guess = gn_suggest(name, known);
    if (guess) {
        gn_usage_error(command, "no method '%s'; did you mean '%s'? See 'gnomon methods'", name,
                       guess);
        return false;
    }
    char names[1024] = "";
    size_t used = 0;
    for (uint32_t i = 0; i < count && used < sizeof names; i++)
        used +=
            (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", known[i]);
    gn_usage_error(command, "no method '%s'; there are: %s", name, names);
    return false;
}

/* The name before the first colon, and what begins there. */
static const char *split_name(const char *text, char name[128])
{
    const size_t length = strcspn(text, ":");
    snprintf(name, 128, "%.*s", (int)(length < 127 ? length : 127), text);
    return text + length;
}

bool gn_app_parse_method(const char *command, const char *text, const char *const *pseudo,
                         gn_app_method *method)
{
    char name[128];
    const char *modifiers = split_name(text, name);
    return find_method(command, name, pseudo, method) &&
           gn_app_modify_method(command, modifiers, method);
}

/* Groups, in the order of gn_trace_rule; "all" is all. */
static const char *const groups[] = {"rays", "maps", "leaks"};

/* Does a group or a pattern name this method? */
static bool matches(const char *pattern, const gn_method *method)
{
    return strcmp(pattern, "all") == 0 || strcmp(pattern, groups[method->trace]) == 0 ||
           fnmatch(pattern, method->name, 0) == 0;
}

static bool is_pattern(const char *name)
{
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++)
        if (strcmp(name, groups[i]) == 0)
            return true;
    return strcmp(name, "all") == 0 || strpbrk(name, "*?");
}

static bool contains(const gn_app_method *methods, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(methods[i].name, name) == 0)
            return true;
    return false;
}

/* Those that a pattern names and that are not there yet; false: none has such a name. */
static bool add_matches(const char *command, const char *pattern, const char *modifiers,
                        gn_app_method *methods, uint32_t *count)
{
    bool any = false;
    for (uint32_t i = 0; gn_methods[i]; i++) {
        if (!matches(pattern, gn_methods[i]))
            continue;
        any = true;
        if (*count == GN_APP_MAX_METHODS)
            break;
        gn_app_method *method = &methods[*count];
        *method = as_found(gn_methods[i]);
        if (!gn_app_modify_method(command, modifiers, method))
            return false;
        *count += !contains(methods, *count, method->name);
    }
    if (!any)
        gn_usage_error(command, "no method is like '%s'; see 'gnomon methods'", pattern);
    return any;
}

uint32_t gn_app_parse_methods(const char *command, const char *list, const char *const *pseudo,
                              gn_app_method methods[GN_APP_MAX_METHODS])
{
    uint32_t count = 0;
    for (const char *start = list;;) {
        char text[128], name[128];
        const size_t length = strcspn(start, ",");
        snprintf(text, sizeof text, "%.*s", (int)(length < 127 ? length : 127), start);
        const char *modifiers = split_name(text, name);
        if (count == GN_APP_MAX_METHODS) {
            gn_usage_error(command, "more than %d methods", GN_APP_MAX_METHODS);
            return 0;
        }
        if (is_pattern(name)) {
            if (!add_matches(command, name, modifiers, methods, &count))
                return 0;
        } else if (gn_app_parse_method(command, text, pseudo, &methods[count])) {
            count++;
        } else {
            return 0;
        }
        if (!start[length])
            return count;
        start += length + 1;
    }
}

/* Parts ------------------------------------------------------------------------------------- */

gn_app_parts gn_app_parts_default(void)
{
    return (gn_app_parts){.map = GN_NONE,
                          .trace = GN_NONE,
                          .alpha = GN_NONE,
                          .bits = GN_NONE,
                          .pcf_width = GN_NONE,
                          .bound = GN_NONE};
}

/* The first option about what a map stores, or NULL. */
static const char *storage_option(const gn_app_parts *p)
{
    return p->bits != GN_NONE        ? "map-bits"
           : p->pcf_width != GN_NONE ? "pcf-width"
           : p->single_depth         ? "single-depth"
           : p->one_sided            ? "one-sided"
           : p->bound != GN_NONE     ? "bound"
                                     : NULL;
}

bool gn_app_parts_given(const gn_app_parts *p)
{
    return p->map != GN_NONE || p->trace != GN_NONE || p->alpha != GN_NONE || p->no_mask ||
           storage_option(p);
}

/* The first preset of this kind that is most like what is asked for. */
static const gn_method *find_model(const gn_app_parts *p)
{
    const gn_method *model = NULL;
    int most = -1;
    for (uint32_t i = 0; gn_methods[i]; i++) {
        const gn_map_format *map = &gn_methods[i]->map;
        const int alike = 4 * (p->bits == GN_NONE || map->bits == p->bits) +
                          2 * (map->one_sided == p->one_sided) +
                          (map->single_depth == p->single_depth);
        if ((uint32_t)map->kind != p->map || alike <= most)
            continue;
        model = gn_methods[i];
        most = alike;
    }
    return model;
}

static int combine_map(const char *command, const gn_app_parts *p, gn_app_method *method)
{
    const gn_map_kind kind = (gn_map_kind)p->map;
    const char *name = gn_app_map_names[kind];
    if (p->pcf_width != GN_NONE && kind != GN_MAP_PCF)
        return gn_usage_error(command, "--pcf-width goes with --map pcf, not %s", name);
    if (p->one_sided && kind != GN_MAP_EVSM)
        return gn_usage_error(command, "--one-sided goes with --map evsm, not %s", name);
    if (p->bound != GN_NONE && kind != GN_MAP_MSM)
        return gn_usage_error(command, "--bound goes with --map msm, not %s", name);
    const gn_method *model = find_model(p);
    if (!model)
        return gn_usage_error(command, "no method has a map of the kind %s", name);
    *method = as_found(model);
    gn_map_format *map = &method->method.map;
    map->bits = p->bits != GN_NONE ? p->bits : map->bits;
    map->pcf_width = p->pcf_width != GN_NONE ? p->pcf_width : map->pcf_width;
    map->bound = p->bound != GN_NONE ? (gn_moment_bound)p->bound : map->bound;
    map->single_depth = p->single_depth;
    map->one_sided = p->one_sided;
    const int used =
        kind == GN_MAP_PCF
            ? snprintf(method->text, sizeof method->text, "pcf:%u", map->pcf_width)
            : snprintf(method->text, sizeof method->text, "%s:%u%s%s%s", name, map->bits,
                       p->single_depth ? ":single-depth" : "", p->one_sided ? ":one-sided" : "",
                       map->bound == GN_BOUND_HAUSDORFF ? ":hausdorff" : "");
    if (p->trace == GN_TRACE_LEAK) {
        method->method.trace = GN_TRACE_LEAK;
        method->method.mask = !p->no_mask;
        method->method.alpha =
            p->alpha != GN_NONE ? (gn_alpha_rule)p->alpha : GN_ALPHA_RULE_SATURATE;
        snprintf(method->text + used, sizeof method->text - (size_t)used, ":leak:%s%s",
                 gn_app_alpha_names[method->method.alpha], p->no_mask ? ":no-mask" : "");
    }
    method->name = method->method.name = method->text;
    return GN_GO_ON;
}

int gn_app_combine_parts(const char *command, const gn_app_parts *p, gn_app_method *method)
{
    const bool has_map = p->map != GN_NONE && p->map != GN_MAP_NONE;
    const char *storage = storage_option(p);
    if (p->no_mask && p->trace != GN_TRACE_LEAK)
        return gn_usage_error(command, "--no-mask goes with --trace leak");
    if (has_map) {
        const char *map = gn_app_map_names[p->map];
        if (p->trace == GN_TRACE_ALL)
            return gn_usage_error(
                command, "--map %s --trace all: with a ray for every pixel the map is never read",
                map);
        if (p->trace == GN_TRACE_LEAK && p->map == GN_MAP_DEPTH)
            return gn_usage_error(command, "--map depth --trace leak: one depth is never unsure; "
                                           "--map pcf compares four");
        if (p->alpha != GN_NONE && p->trace != GN_TRACE_LEAK)
            return gn_usage_error(command,
                                  "--alpha is about rays, and --map %s traces none; "
                                  "see --map-alpha",
                                  map);
        return combine_map(command, p, method);
    }
    if (storage)
        return gn_usage_error(command, "--%s: no --map is given", storage);
    if (p->trace == GN_TRACE_NONE)
        return gn_usage_error(command, "--trace none without a map: nothing finds the light");
    if (p->trace == GN_TRACE_LEAK)
        return gn_usage_error(
            command, "--trace leak without a map: nothing says where a ray is needed; see --map");
    *method = p->alpha != GN_NONE ? tracing_all((gn_alpha_rule)p->alpha)
                                  : as_found(gn_method_find("ray"));
    return GN_GO_ON;
}

/* JSON -------------------------------------------------------------------------------------- */

cJSON *gn_app_map_json(const gn_map_format *format)
{
    if (format->kind == GN_MAP_NONE)
        return cJSON_CreateNull();
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "kind", gn_app_map_names[format->kind]);
    cJSON_AddNumberToObject(json, "bits", format->single_depth ? 32 : format->bits);
    cJSON_AddBoolToObject(json, "single_depth", format->single_depth);
    if (format->kind == GN_MAP_EVSM || format->kind == GN_MAP_ESM)
        cJSON_AddNumberToObject(json, "positive_exponent", (double)format->positive_exponent);
    if (format->kind == GN_MAP_EVSM) {
        cJSON_AddBoolToObject(json, "one_sided", format->one_sided);
        if (!format->one_sided)
            cJSON_AddNumberToObject(json, "negative_exponent", (double)format->negative_exponent);
    }
    if (format->kind == GN_MAP_PCF)
        cJSON_AddNumberToObject(json, "pcf_width", format->pcf_width);
    if (format->kind == GN_MAP_MSM)
        cJSON_AddStringToObject(json, "bound", gn_app_bound_names[format->bound]);
    return json;
}

void gn_app_add_counts(gn_leak_counts *a, const gn_leak_counts *b)
{
    a->tested += b->tested;
    a->unsure += b->unsure;
    a->expanded += b->expanded;
    a->removed += b->removed;
    a->lost += b->lost;
    a->unheld += b->unheld;
}

cJSON *gn_app_leak_json(const gn_leak_counts *counts, double pixels)
{
    const struct {
        const char *key;
        uint64_t count;
    } parts[] = {{"unsure", counts->unsure},
                 {"expanded", counts->expanded},
                 {"removed", counts->removed},
                 {"lost", counts->lost}};
    const double tested = (double)counts->tested;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "tested", tested / pixels);
    cJSON_AddNumberToObject(json, "unheld", (double)counts->unheld / pixels);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        cJSON_AddNumberToObject(json, parts[i].key,
                                tested > 0 ? (double)parts[i].count / tested : 0);
    return json;
}
