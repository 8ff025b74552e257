#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "demo.h"
#include "page.h"

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

typedef struct image_list {
    const char *folder;
    const cJSON *results;
} image_list;

static bool put_images(gn_app *app, gn_file *file, const void *data)
{
    const image_list *list = data;
    const cJSON *scene, *method;
    cJSON_ArrayForEach(scene, cJSON_GetObjectItem(list->results, "scenes"))
    {
        cJSON_ArrayForEach(method, cJSON_GetObjectItem(scene, "methods"))
        {
            const char *name = cJSON_GetStringValue(cJSON_GetObjectItem(method, "file"));
            char path[4096];
            if (snprintf(path, sizeof path, "%s/%s", list->folder, name) >= (int)sizeof path)
                return gn_app_error(app, "%s: the name is too long", list->folder);
            if (!gn_page_put(file, "IMAGES[\"") || !gn_page_put(file, name) ||
                !gn_page_put(file, "\"] = \"") || !put_image(app, file, path) ||
                !gn_page_put(file, "\";\n"))
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
    const image_list list = {folder, results};
    const gn_page_part parts[] = {{.mark = "STYLE", .text = gn_page_style},
                                  {.mark = "VIEWER", .text = gn_page_viewer},
                                  {.mark = "DATA", .json = results},
                                  {.mark = "IMAGES", .write = put_images, .data = &list}};
    return gn_page_write(app, path, gn_demo_page, parts, sizeof parts / sizeof *parts);
}
