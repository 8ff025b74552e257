#include "page.h"

#include <stdio.h>
#include <string.h>

bool gn_page_put(gn_file *file, const char *text)
{
    return gn_file_write(file, text, strlen(text)) == GN_OK;
}

/* JSON inside a script element: "<" could end the element. */
static bool put_json(gn_app *app, gn_file *file, const cJSON *json)
{
    char *text = cJSON_PrintUnformatted(json);
    if (!text)
        return gn_app_error(app, "out of memory");
    bool good = true;
    for (const char *c = text; *c && good;) {
        const size_t plain = strcspn(c, "<");
        good =
            gn_file_write(file, c, plain) == GN_OK && (!c[plain] || gn_page_put(file, "\\u003c"));
        c += plain + (c[plain] != '\0');
    }
    cJSON_free(text);
    return good;
}

static bool put_part(gn_app *app, gn_file *file, const gn_page_part *part)
{
    if (part->text)
        return gn_page_put(file, part->text);
    return part->json ? put_json(app, file, part->json) : part->write(app, file, part->data);
}

/* The first mark in text that a part has, or NULL. */
static const char *next_mark(const char *text, const gn_page_part *parts, size_t count,
                             const gn_page_part **part)
{
    const char *first = NULL;
    for (size_t i = 0; i < count; i++) {
        char mark[32];
        snprintf(mark, sizeof mark, "/*%s*/", parts[i].mark);
        const char *found = strstr(text, mark);
        if (!found || (first && found > first))
            continue;
        first = found;
        *part = &parts[i];
    }
    return first;
}

bool gn_page_write(gn_app *app, const char *path, const char *page, const gn_page_part *parts,
                   size_t count)
{
    gn_file file;
    if (gn_file_begin(gn_device_context(app->device), path, &file) != GN_OK)
        return false;
    const gn_page_part *part = NULL;
    const char *mark;
    bool good = true;
    while (good && (mark = next_mark(page, parts, count, &part))) {
        good = gn_file_write(&file, page, (size_t)(mark - page)) == GN_OK &&
               put_part(app, &file, part);
        page = mark + strlen(part->mark) + strlen("/**/");
    }
    good = good && gn_page_put(&file, page) && !gn_app_interrupted();
    if (!good) {
        gn_file_abort(&file);
        return false;
    }
    return gn_file_commit(&file) == GN_OK;
}
