/* gnomon bench --csv: a line for each method (and value of a sweep), with the JSON's keys as
 * columns, those of objects within behind a dot. Lists are left out, but for the lights. */
#include <stdio.h>
#include <string.h>

#include "output/output.h"
#include "bench.h"

/* Adds what json has, but for its methods, to line: {"passes.trace.ms_median": 1.5, ...}. */
static bool flatten(const cJSON *json, const char *prefix, cJSON *line)
{
    bool good = true;
    for (const cJSON *item = json->child; item && good; item = item->next) {
        char key[256];
        snprintf(key, sizeof key, "%s%s%s", prefix, *prefix ? "." : "", item->string);
        if (cJSON_IsObject(item)) {
            good = flatten(item, key, line);
        } else if (strcmp(key, "lights") == 0) {
            good = cJSON_AddNumberToObject(line, key, cJSON_GetArraySize(item)) != NULL;
        } else if (!cJSON_IsArray(item)) {
            cJSON *copy = cJSON_Duplicate(item, true);
            good = copy && cJSON_AddItemToObject(line, key, copy);
        }
    }
    return good;
}

static bool put(gn_file *file, const char *text)
{
    return gn_file_write(file, text, strlen(text)) == GN_OK;
}

/* A cell after RFC 4180: in quotes where it needs them. null: empty. */
static bool put_cell(gn_file *file, const char *separator, const cJSON *item)
{
    if (!put(file, separator) || !item || cJSON_IsNull(item))
        return item == NULL || cJSON_IsNull(item);
    if (!cJSON_IsString(item)) {
        char number[64];
        return cJSON_PrintPreallocated((cJSON *)item, number, sizeof number, false) &&
               put(file, number);
    }
    const char *text = item->valuestring;
    if (!strpbrk(text, ",\"\r\n"))
        return put(file, text);
    bool good = put(file, "\"");
    for (; *text && good; text++)
        good = (*text != '"' || put(file, "\"")) && gn_file_write(file, text, 1) == GN_OK;
    return good && put(file, "\"");
}

static bool put_table(gn_file *file, const cJSON *lines, const cJSON *columns)
{
    bool good = true;
    const char *separator = "";
    for (const cJSON *column = columns->child; column && good; column = column->next) {
        const cJSON name = {.type = cJSON_String, .valuestring = column->string};
        good = put_cell(file, separator, &name);
        separator = ",";
    }
    for (const cJSON *line = lines->child; line && good; line = line->next) {
        good = put(file, "\r\n");
        separator = "";
        for (const cJSON *column = columns->child; column && good; column = column->next) {
            good =
                put_cell(file, separator, cJSON_GetObjectItemCaseSensitive(line, column->string));
            separator = ",";
        }
    }
    return good && put(file, "\r\n");
}

/* Lines of all methods of all runs; columns: each key once, in the order of its first line. */
static bool make_lines(const cJSON *runs, cJSON *lines, cJSON *columns)
{
    bool good = lines && columns;
    for (const cJSON *run = runs->child; run && good; run = run->next) {
        const cJSON *method, *methods = cJSON_GetObjectItemCaseSensitive(run, "methods");
        cJSON_ArrayForEach(method, methods)
        {
            cJSON *line = cJSON_CreateObject();
            good = good && line && cJSON_AddItemToArray(lines, line) && flatten(run, "", line) &&
                   flatten(method, "", line);
            for (const cJSON *item = line ? line->child : NULL; item && good; item = item->next)
                good = cJSON_HasObjectItem(columns, item->string) ||
                       cJSON_AddNullToObject(columns, item->string);
        }
    }
    return good;
}

bool gn_bench_write_csv(gn_app *app, const cJSON *runs, const char *path)
{
    cJSON *lines = cJSON_CreateArray(), *columns = cJSON_CreateObject();
    gn_file file;
    bool good = make_lines(runs, lines, columns) || gn_app_error(app, "%s: out of memory", path);
    if (good && (good = gn_file_begin(gn_device_context(app->device), path, &file) == GN_OK)) {
        good = put_table(&file, lines, columns);
        if (good)
            good = gn_file_commit(&file) == GN_OK;
        else
            gn_file_abort(&file);
    }
    cJSON_Delete(lines);
    cJSON_Delete(columns);
    return good;
}
