#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output/output.h"
#include "demo.h"

static const char data_mark[] = "/*DATA*/null", images_mark[] = "/*IMAGES*/";

static bool put(gn_file *file, const char *text)
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
        good = gn_file_write(file, c, plain) == GN_OK && (!c[plain] || put(file, "\\u003c"));
        c += plain + (c[plain] != '\0');
    }
    cJSON_free(text);
    return good;
}

/* Copies a file as base64. */
static bool put_image(gn_app *app, gn_file *file, const char *path)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    FILE *image = fopen(path, "rb");
    if (!image)
        return gn_app_error(app, "%s: cannot read: %s", path, strerror(errno));
    bool good = true;
    uint8_t bytes[3 * 1024];
    char text[4 * 1024];
    size_t count;
    while (good && (count = fread(bytes, 1, sizeof bytes, image)) > 0) {
        size_t used = 0;
        for (size_t i = 0; i < count; i += 3) {
            const uint32_t left = (uint32_t)(count - i);
            const uint32_t bits = (uint32_t)bytes[i] << 16 |
                                  (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) |
                                  (left > 2 ? bytes[i + 2] : 0);
            text[used++] = digits[bits >> 18];
            text[used++] = digits[bits >> 12 & 63];
            text[used++] = left > 1 ? digits[bits >> 6 & 63] : '=';
            text[used++] = left > 2 ? digits[bits & 63] : '=';
        }
        good = gn_file_write(file, text, used) == GN_OK;
    }
    if (good && ferror(image))
        good = gn_app_error(app, "%s: cannot read", path);
    fclose(image);
    return good;
}

static bool put_images(gn_app *app, gn_file *file, const char *folder, const cJSON *results)
{
    const cJSON *scene, *method;
    cJSON_ArrayForEach(scene, cJSON_GetObjectItem(results, "scenes"))
    {
        cJSON_ArrayForEach(method, cJSON_GetObjectItem(scene, "methods"))
        {
            const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(method, "file"));
            char path[4096];
            if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
                return gn_app_error(app, "%s: the name is too long", folder);
            if (!put(file, "IMAGES[\"") || !put(file, name) || !put(file, "\"] = \"") ||
                !put_image(app, file, path) || !put(file, "\";\n"))
                return false;
        }
    }
    return true;
}

bool gn_demo_write_page(gn_app *app, const char *folder, const cJSON *results)
{
    char path[4096];
    if (snprintf(path, sizeof path, "%s/index.html", folder) >= (int)sizeof path)
        return gn_app_error(app, "%s: the name is too long", folder);
    const char *data = strstr(gn_demo_page, data_mark);
    const char *images = data ? strstr(data, images_mark) : NULL;
    if (!images)
        return gn_app_error(app, "the page has no place for its data");

    gn_file file;
    if (gn_file_begin(gn_device_context(app->device), path, &file) != GN_OK)
        return false;
    const char *rest = data + strlen(data_mark);
    const bool good = gn_file_write(&file, gn_demo_page, (size_t)(data - gn_demo_page)) == GN_OK &&
                      put_json(app, &file, results) &&
                      gn_file_write(&file, rest, (size_t)(images - rest)) == GN_OK &&
                      put_images(app, &file, folder, results) &&
                      put(&file, images + strlen(images_mark)) && !gn_app_interrupted();
    if (!good) {
        gn_file_abort(&file);
        return false;
    }
    return gn_file_commit(&file) == GN_OK;
}
