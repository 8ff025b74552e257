/* Methods by name and by their parts. */
#include "method.h"

#include <fnmatch.h>
#include <stdio.h>
#include <string.h>

const char *const gn_app_map_names[] = {"none", "depth", "pcf",   "vsm", "esm",
                                        "evsm", "msm",   "nlmsm", NULL};
const char *const gn_app_trace_names[] = {"all", "none", NULL};
const char *const gn_app_alpha_names[] = {"mip0", "raw", "test", "saturate", "coverage", NULL};
const char *const gn_app_bound_names[] = {"hamburger", "hausdorff", NULL};

static gn_app_method as_found(const gn_method *method)
{
    return (gn_app_method){.name = method->name, .method = *method};
}

gn_app_method gn_app_yardstick(void)
{
    return as_found(gn_method_find("ray-mip0"));
}

/* Names ------------------------------------------------------------------------------------- */

bool gn_app_parse_method(const char *command, const char *name, const char *const *pseudo,
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
            *method = (gn_app_method){.name = pseudo[i], .pseudo = true};
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

/* Does a group or a pattern name this method? */
static bool matches(const char *pattern, const gn_method *method)
{
    const bool map = method->map.kind != GN_MAP_NONE;
    if (strcmp(pattern, "all") == 0)
        return true;
    if (strcmp(pattern, "rays") == 0 || strcmp(pattern, "maps") == 0)
        return map == (pattern[0] == 'm');
    return fnmatch(pattern, method->name, 0) == 0;
}

static bool is_pattern(const char *name)
{
    return strcmp(name, "all") == 0 || strcmp(name, "rays") == 0 || strcmp(name, "maps") == 0 ||
           strpbrk(name, "*?");
}

static bool contains(const gn_app_method *methods, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(methods[i].name, name) == 0)
            return true;
    return false;
}

/* Those that a pattern names and that are not there yet; false: none has such a name. */
static bool add_matches(const char *command, const char *pattern, gn_app_method *methods,
                        uint32_t *count)
{
    bool any = false;
    for (uint32_t i = 0; gn_methods[i]; i++) {
        if (!matches(pattern, gn_methods[i]))
            continue;
        any = true;
        if (*count < GN_APP_MAX_METHODS && !contains(methods, *count, gn_methods[i]->name))
            methods[(*count)++] = as_found(gn_methods[i]);
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
        char name[64];
        const size_t length = strcspn(start, ",");
        snprintf(name, sizeof name, "%.*s", (int)(length < 63 ? length : 63), start);
        if (count == GN_APP_MAX_METHODS) {
            gn_usage_error(command, "more than %d methods", GN_APP_MAX_METHODS);
            return 0;
        }
        if (is_pattern(name)) {
            if (!add_matches(command, name, methods, &count))
                return 0;
        } else if (gn_app_parse_method(command, name, pseudo, &methods[count])) {
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
    return p->map != GN_NONE || p->trace != GN_NONE || p->alpha != GN_NONE || storage_option(p);
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

static int combine_map(const char *command, gn_app_parts *p, gn_app_method *method)
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
    snprintf(p->name, sizeof p->name, "%s:%u%s%s%s", name, map->bits,
             p->single_depth ? ":single-depth" : "", p->one_sided ? ":one-sided" : "",
             map->bound == GN_BOUND_HAUSDORFF ? ":hausdorff" : "");
    if (kind == GN_MAP_PCF)
        snprintf(p->name, sizeof p->name, "pcf:%u", map->pcf_width);
    method->name = method->method.name = p->name;
    return GN_GO_ON;
}

int gn_app_combine_parts(const char *command, gn_app_parts *p, gn_app_method *method)
{
    const bool has_map = p->map != GN_NONE && p->map != GN_MAP_NONE;
    const char *storage = storage_option(p);
    if (has_map) {
        const char *map = gn_app_map_names[p->map];
        if (p->trace == GN_TRACE_ALL)
            return gn_usage_error(
                command, "--map %s --trace all: with a ray for every pixel the map is never read",
                map);
        if (p->alpha != GN_NONE)
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
    snprintf(p->name, sizeof p->name, "ray%s%s", p->alpha != GN_NONE ? "-" : "",
             p->alpha != GN_NONE ? gn_app_alpha_names[p->alpha] : "");
    return gn_app_parse_method(command, p->name, NULL, method) ? GN_GO_ON : GN_EXIT_USAGE;
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
