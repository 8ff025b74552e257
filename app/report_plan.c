/* What a report shows, as data: report_figures.json with scenes, cameras and sizes filled in, and
 * the commands that it takes, each once. */
#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report.h"

/* A scene, as the commands are given it. */
typedef struct scene {
    const char *given;
    char label[64]; /* of files */
    bool built_in;
    const cJSON *info; /* of gnomon info */
} scene;

/* What braces stand for. Lists take the place of a whole word of a command. */
typedef struct filling {
    gn_app_report *report;
    const scene *scene;
    const char *camera, *path; /* "" where the scene has none */
    const char *method, *aovs; /* and what is drawn over its pictures */
    bool settles;              /* it has maps that are drawn over frames, or a mask */
} filling;

/* A name that a file may have. */
static void make_label(const char *name, char *label, size_t size)
{
    size_t i = 0;
    for (; name[i] && i + 1 < size; i++) {
        const char c = name[i];
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') || c == '-' || c == '_';
        label[i] = plain ? c : '-';
    }
    label[i] = '\0';
}

/* The text of a key in braces, or NULL. */
static const char *find_value(const filling *f, const char *key, size_t length, char text[128])
{
    const gn_app_options *o = &f->report->app.options;
    const uint32_t frames = f->report->frames, few = frames < 5 ? frames : 5,
                   some = frames < 16 ? frames : 16;
    const struct {
        const char *key, *value;
        bool label;
    } texts[] = {{"name", f->scene->label, false},
                 {"camera", f->camera, true},
                 {"walk", f->path, true},
                 {"method", f->method, false},
                 {"label", f->method, true},
                 {"aovs", f->aovs, false},
                 {"methods", f->report->methods, false}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if (strlen(texts[i].key) == length && !strncmp(texts[i].key, key, length)) {
            if (!texts[i].label)
                return texts[i].value;
            make_label(*texts[i].value ? texts[i].value : "overview", text, 128);
            return text;
        }
    const struct {
        const char *key;
        uint32_t first, second;
    } counts[] = {{"size", o->size[0], o->size[1]},
                  {"half", (o->size[0] + 1) / 2, (o->size[1] + 1) / 2},
                  {"larger", o->size[0] * 3 / 2, o->size[1] * 3 / 2},
                  {"double", o->size[0] * 2, o->size[1] * 2},
                  {"frames", frames, 0},
                  {"some", some, 0},
                  {"few", few, 0}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        if (strlen(counts[i].key) == length && !strncmp(counts[i].key, key, length)) {
            if (counts[i].second)
                snprintf(text, 128, "%ux%u", counts[i].first, counts[i].second);
            else
                snprintf(text, 128, "%u", counts[i].first);
            return text;
        }
    return NULL;
}

/* A text with its braces filled in, {out} and what is unknown excepted. */
static char *fill(const filling *f, const char *text)
{
    size_t size = strlen(text) + 1, used = 0;
    char *filled = malloc(size);
    while (filled && *text) {
        char made[128];
        const size_t length = *text == '{' ? strcspn(text + 1, "}") : 0;
        const char *value = length > 0 ? find_value(f, text + 1, length, made) : NULL;
        const size_t count = value ? strlen(value) : 1;
        size += value ? count : 0;
        char *more = realloc(filled, size);
        if (!more) {
            free(filled);
            return NULL;
        }
        filled = more;
        memcpy(filled + used, value ? value : text, count);
        used += count;
        text += value ? length + 2 : 1;
    }
    if (filled)
        filled[used] = '\0';
    return filled;
}

static void add_word(cJSON *argv, const char *word)
{
    cJSON_AddItemToArray(argv, cJSON_CreateString(word));
}

static void add_pair(cJSON *argv, const char *option, const char *value)
{
    add_word(argv, option);
    add_word(argv, value);
}

static void add_number(cJSON *argv, const char *option, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.9g", value);
    add_pair(argv, option, text);
}

/* {scene}, {file}: a scene with its options, and without those of its light; {view}, {path}: a
 * camera, that of the path; {settle}, {refresh}: whole maps and settled masks after few frames. */
static bool add_list(const filling *f, cJSON *argv, const char *word)
{
    const gn_app_options *o = &f->report->app.options;
    const bool whole = !strcmp(word, "{scene}");
    if (whole || !strcmp(word, "{file}")) {
        add_word(argv, f->scene->given);
        if (o->seed != 1)
            add_number(argv, "--seed", o->seed);
        if (o->scale < 1 || o->scale > 1)
            add_number(argv, "--scale", o->scale);
        if (whole && o->lights)
            add_pair(argv, "--light", o->lights);
        if (whole && o->sun.given) {
            char text[64];
            snprintf(text, sizeof text, "%.9g,%.9g", o->sun.azimuth, o->sun.elevation);
            add_pair(argv, "--sun", text);
        }
        return true;
    }
    if (!strcmp(word, "{settle}")) {
        if (f->settles)
            add_pair(argv, "--warm-up", "8");
        if (f->settles)
            add_pair(argv, "--refresh", "1");
        return true;
    }
    if (!strcmp(word, "{refresh}")) {
        if (f->report->has_maps)
            add_pair(argv, "--refresh", "1");
        return true;
    }
    const bool view = !strcmp(word, "{view}");
    if (!view && strcmp(word, "{path}") != 0)
        return false;
    const char *camera = view ? f->camera : f->path;
    if (*camera)
        add_pair(argv, "--camera", camera);
    return true;
}

/* The number of the run of a command, which is added unless it is there. -1 without memory. */
static int add_run(const filling *f, const char *command)
{
    const gn_app_options *o = &f->report->app.options;
    cJSON *argv = cJSON_CreateArray();
    for (const char *c = command + strspn(command, " "); *c; c += strspn(c, " ")) {
        char word[1024];
        const size_t length = strcspn(c, " ");
        snprintf(word, sizeof word, "%.*s", (int)length, c);
        c += length;
        if (add_list(f, argv, word))
            continue;
        char *filled = fill(f, word);
        if (filled)
            add_word(argv, filled);
        free(filled);
    }
    if (o->threads > 0)
        add_number(argv, "--threads", o->threads);
    if (o->isa > 0)
        add_pair(argv, "--isa", gn_app_isa_names[o->isa]);
    add_word(argv, "--json");
    int number = 0;
    const cJSON *run;
    cJSON_ArrayForEach(run, f->report->runs)
    {
        if (cJSON_Compare(cJSON_GetObjectItem(run, "argv"), argv, true)) {
            cJSON_Delete(argv);
            return number;
        }
        number++;
    }
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddItemToObject(entry, "argv", argv);
    return cJSON_AddItemToArray(f->report->runs, entry) ? number : -1;
}

/* Fills in all texts of an item and those below it. */
static void fill_all(const filling *f, cJSON *item)
{
    if (cJSON_IsString(item)) {
        char *filled = fill(f, item->valuestring);
        if (filled)
            cJSON_SetValuestring(item, filled);
        free(filled);
    }
    for (cJSON *child = item->child; child; child = child->next)
        fill_all(f, child);
}

static const char *text_of(const cJSON *item, const char *key)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItem(item, key));
    return text ? text : "";
}

static void use_method(filling *f, const gn_app_method *method)
{
    f->method = method->name;
    f->settles = method->method.trace == GN_TRACE_LEAK;
    f->aovs = f->settles               ? "class,rays,cascade"
              : gn_app_has_map(method) ? "cascade"
                                       : "lod,lookups";
}

/* "each" of a figure: a command and a picture for each of some methods, before its others. */
static void add_each(filling *f, const cJSON *each, cJSON *runs, cJSON *pictures)
{
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    const uint32_t count = gn_app_parse_methods("report", text_of(each, "methods"), NULL, methods);
    for (uint32_t i = 0; i < count; i++) {
        use_method(f, &methods[i]);
        cJSON_AddItemToArray(runs, cJSON_CreateNumber(add_run(f, text_of(each, "command"))));
        char *file = fill(f, text_of(each, "file"));
        cJSON *picture = cJSON_CreateObject();
        cJSON_AddItemToArray(pictures, picture);
        cJSON_AddStringToObject(picture, "file", file ? file : "");
        cJSON_AddStringToObject(picture, "caption", f->method);
        cJSON_AddStringToObject(picture, "method", f->method);
        free(file);
    }
}

/* "commands" of a figure become "runs", their numbers; all other texts are filled in. */
static void add_figure(filling *f, const cJSON *model)
{
    cJSON *figure = cJSON_Duplicate(model, true);
    cJSON *commands = cJSON_DetachItemFromObject(figure, "commands");
    cJSON *runs = cJSON_AddArrayToObject(figure, "runs");
    const cJSON *command;
    cJSON_ArrayForEach(command, commands)
        cJSON_AddItemToArray(runs, cJSON_CreateNumber(add_run(f, command->valuestring)));
    cJSON_Delete(commands);
    cJSON *each = cJSON_DetachItemFromObject(figure, "each");
    if (each) {
        cJSON *others = cJSON_DetachItemFromObject(figure, "pictures");
        cJSON *pictures = cJSON_AddArrayToObject(figure, "pictures");
        add_each(f, each, runs, pictures);
        while (others && others->child)
            cJSON_AddItemToArray(pictures, cJSON_DetachItemFromArray(others, 0));
        cJSON_Delete(others);
        cJSON_Delete(each);
    }
    fill_all(f, figure);
    cJSON_DeleteItemFromObject(figure, "scene");
    cJSON_AddStringToObject(figure, "scene", f->scene->given);
    cJSON_AddItemToArray(f->report->figure_list, figure);
}

/* Comparisons ---------------------------------------------------------------------------------- */

static bool add_comparison(filling *f, const cJSON *models, const char *camera)
{
    f->camera = camera;
    f->method = "reference";
    cJSON *comparison = cJSON_CreateObject();
    cJSON_AddItemToArray(f->report->comparisons, comparison);
    cJSON_AddStringToObject(comparison, "scene", f->scene->given);
    cJSON_AddStringToObject(comparison, "camera", *camera ? camera : "overview");
    cJSON_AddNumberToObject(comparison, "times", add_run(f, text_of(models, "times")));
    cJSON *reference = cJSON_AddObjectToObject(comparison, "reference");
    cJSON_AddNumberToObject(reference, "run", add_run(f, text_of(models, "reference")));
    cJSON *list = cJSON_AddArrayToObject(comparison, "methods");
    gn_app_method methods[GN_APP_MAX_METHODS] = {0};
    const uint32_t count = gn_app_parse_methods("report", f->report->methods, NULL, methods);
    for (uint32_t i = 0; i < count; i++) {
        use_method(f, &methods[i]);
        cJSON *item = cJSON_CreateObject();
        cJSON_AddItemToArray(list, item);
        cJSON_AddStringToObject(item, "name", f->method);
        cJSON_AddNumberToObject(item, "run", add_run(f, text_of(models, "method")));
        cJSON_AddNumberToObject(item, "flip", add_run(f, text_of(models, "flip")));
    }
    return count > 0;
}

/* Scenes --------------------------------------------------------------------------------------- */

/* Runs "gnomon info" for it. */
static bool look_at(gn_app_report *report, const char *given, uint32_t number, scene *s)
{
    gn_app *app = &report->app;
    *s = (scene){.given = given};
    const char *slash = strrchr(given, '/'), *name = slash ? slash + 1 : given;
    const char *dot = strrchr(name, '.');
    char stem[64];
    snprintf(stem, sizeof stem, "%.*s", dot && dot > name ? (int)(dot - name) : 50, name);
    make_label(stem, s->label, sizeof s->label - 12);
    for (const gn_procedural *p = gn_procedurals; p->name; p++)
        s->built_in |= strcmp(p->name, given) == 0;
    if (!s->built_in) { /* files in two folders may have one name */
        const size_t used = strlen(s->label);
        snprintf(s->label + used, sizeof s->label - used, "-%u", number);
    }
    const filling f = {.report = report, .scene = s, .camera = "", .path = ""};
    cJSON *run = cJSON_GetArrayItem(report->runs, add_run(&f, "info {file}"));
    if (!gn_report_run(report, run, 0, 0))
        return false;
    s->info = cJSON_GetObjectItem(run, "result");
    return s->info || gn_app_error(app, "%s", text_of(run, "error"));
}

static bool is_moving(const cJSON *camera)
{
    return cJSON_IsTrue(cJSON_GetObjectItem(camera, "moving"));
}

/* The last camera that moves, or the first; "" where there is none. */
static const char *find_path(const cJSON *cameras)
{
    const char *path = cJSON_GetArraySize(cameras) > 0 ? text_of(cameras->child, "name") : "";
    const cJSON *camera;
    cJSON_ArrayForEach(camera, cameras)
    {
        if (is_moving(camera))
            path = text_of(camera, "name");
    }
    return path;
}

/* The cameras of the comparisons: the one asked for, or those that stand still, or all. */
static bool add_comparisons(filling *f, const cJSON *models, const char **first)
{
    const cJSON *cameras = cJSON_GetObjectItem(f->scene->info, "camera_list"), *camera;
    const char *wanted = f->report->app.options.camera;
    *first = NULL;
    if (wanted || cJSON_GetArraySize(cameras) == 0) {
        *first = wanted ? wanted : "";
        return add_comparison(f, models, *first);
    }
    bool still = false, good = true;
    cJSON_ArrayForEach(camera, cameras) still |= !is_moving(camera);
    cJSON_ArrayForEach(camera, cameras)
    {
        if (!good || (still && is_moving(camera)))
            continue;
        *first = *first ? *first : text_of(camera, "name");
        good = add_comparison(f, models, text_of(camera, "name"));
    }
    return good;
}

/* Does a list of patterns name it? */
static bool is_listed(const char *list, const char *name)
{
    for (const char *c = list;; c++) {
        char pattern[64];
        const size_t length = strcspn(c, ",");
        snprintf(pattern, sizeof pattern, "%.*s", (int)(length < 63 ? length : 63), c);
        if (fnmatch(pattern, name, 0) == 0)
            return true;
        c += length;
        if (!*c)
            return false;
    }
}

static bool add_scene(gn_app_report *report, const cJSON *models, const scene *s, bool all)
{
    filling f = {.report = report, .scene = s, .method = "", .aovs = ""};
    const char *wanted = report->app.options.camera, *first = "";
    f.path = wanted ? wanted : find_path(cJSON_GetObjectItem(s->info, "camera_list"));
    if (!add_comparisons(&f, cJSON_GetObjectItem(models, "comparison"), &first))
        return false;
    const cJSON *figure;
    cJSON_ArrayForEach(figure, cJSON_GetObjectItem(models, "figures"))
    {
        const bool own = s->built_in && !strcmp(text_of(figure, "scene"), s->given);
        const bool any = cJSON_IsTrue(cJSON_GetObjectItem(figure, "any"));
        const bool sequence = !*text_of(figure, "scene");
        if ((!own && !sequence && (all || !any)) ||
            !is_listed(report->figures, text_of(figure, "id")))
            continue;
        const char *camera = text_of(figure, "camera");
        f.camera = own && *camera && !wanted ? camera : first;
        add_figure(&f, figure);
    }
    return true;
}

bool gn_report_plan(gn_app_report *report, const char *const *scenes, int count)
{
    cJSON *models = cJSON_Parse(gn_report_figures);
    report->runs = cJSON_CreateArray();
    report->comparisons = cJSON_CreateArray();
    report->figure_list = cJSON_CreateArray();
    report->papers = cJSON_DetachItemFromObject(models, "papers");
    if (!models)
        return gn_app_error(&report->app, "the list of figures cannot be read");
    const bool all = count == 0;
    for (const gn_procedural *p = gn_procedurals; all && p->name; p++)
        count++;
    bool good = true;
    for (int i = 0; i < count && good; i++) {
        scene s;
        good = look_at(report, all ? gn_procedurals[i].name : scenes[i], (uint32_t)i + 1, &s) &&
               add_scene(report, models, &s, all);
    }
    cJSON_Delete(models);
    return good;
}
