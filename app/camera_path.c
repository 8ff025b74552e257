#include "camera_path.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "scene/file.h"

#define DEGREE (3.14159265358979323846 / 180)

typedef struct camera_path {
    gn_app *app;
    const char *file;
    uint32_t count;
    float *times, *positions, *rotations; /* 1, 3, 4 a key */
} camera_path;

/* "walk.json: keys[3].up: ..."; false. */
static bool refuse(const camera_path *path, uint32_t key, const char *field, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));
static bool refuse(const camera_path *path, uint32_t key, const char *field, const char *format,
                   ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return gn_app_error(path->app, "%s: keys[%u]%s%s: %s", path->file, key, *field ? "." : "",
                        field, text);
}

/* Three finite numbers. */
static bool read_vector(const camera_path *path, uint32_t key, const cJSON *object,
                        const char *field, double vector[3])
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, field);
    bool good = cJSON_IsArray(list) && cJSON_GetArraySize(list) == 3;
    for (int i = 0; i < 3; i++) {
        const cJSON *number = good ? cJSON_GetArrayItem(list, i) : NULL;
        good = cJSON_IsNumber(number) && fabs(number->valuedouble) <= 1e9;
        vector[i] = good ? number->valuedouble : 0;
    }
    return good || refuse(path, key, field, "%s",
                          list ? "is not [x, y, z], three numbers of metres" : "is missing");
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++)
        c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static bool normalize(double a[3])
{
    const double length = sqrt(dot(a, a));
    for (int i = 0; i < 3 && length > 1e-9; i++)
        a[i] /= length;
    return length > 1e-9;
}

/* The rotation whose axes are the columns, as a quaternion x y z w. The largest of the four is
 * found first: the others are divided by it. */
static void to_quaternion(double axes[3][3], float q[4])
{
    const double x = axes[0][0], y = axes[1][1], z = axes[2][2];
    const double squares[4] = {1 + x - y - z, 1 - x + y - z, 1 - x - y + z, 1 + x + y + z};
    int largest = 0;
    for (int i = 1; i < 4; i++)
        largest = squares[i] > squares[largest] ? i : largest;
    const double root = sqrt(squares[largest]), scale = 0.5 / root;
    q[largest] = (float)(0.5 * root);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double less = (axes[j][k] - axes[k][j]) * scale; /* with w */
        if (largest == 3)
            q[i] = (float)less;
        else if (largest == i)
            q[3] = (float)less;
        else
            q[i] = (float)((axes[i][largest] + axes[largest][i]) * scale);
    }
}

/* A camera looks along its -Z, its +Y is up. */
static bool read_rotation(const camera_path *path, uint32_t key, const cJSON *object,
                          const double position[3], float rotation[4])
{
    double axes[3][3] = {{0}}, up[3] = {0, 1, 0}, forward[3];
    const bool target = cJSON_HasObjectItem(object, "look_at");
    if (target == cJSON_HasObjectItem(object, "direction"))
        return refuse(path, key, "", "needs either look_at or direction");
    if (!read_vector(path, key, object, target ? "look_at" : "direction", forward) ||
        (cJSON_HasObjectItem(object, "up") && !read_vector(path, key, object, "up", up)))
        return false;
    for (int i = 0; i < 3 && target; i++)
        forward[i] -= position[i];
    if (!normalize(forward))
        return refuse(path, key, target ? "look_at" : "direction", "%s",
                      target ? "is the position" : "has no length");
    for (int i = 0; i < 3; i++)
        axes[2][i] = -forward[i];
    if (!normalize(up))
        return refuse(path, key, "up", "has no length");
    cross(up, axes[2], axes[0]);
    if (!normalize(axes[0]))
        return refuse(path, key, "up", "points where the camera looks%s",
                      cJSON_HasObjectItem(object, "up") ? "" : " (it is 0, 1, 0 where not given)");
    cross(axes[2], axes[0], axes[1]);
    to_quaternion(axes, rotation);
    return true;
}

static bool read_key(const camera_path *path, uint32_t key, const cJSON *object)
{
    static const char *const fields[] = {"time", "position", "look_at", "direction", "up", NULL};
    if (!cJSON_IsObject(object))
        return refuse(path, key, "", "is not an object");
    for (const cJSON *field = object->child; field; field = field->next) {
        const char *guess;
        int i = 0;
        while (fields[i] && strcmp(fields[i], field->string) != 0)
            i++;
        if (!fields[i] && (guess = gn_suggest(field->string, fields)))
            return refuse(path, key, field->string, "no such field; did you mean '%s'?", guess);
        if (!fields[i])
            return refuse(path, key, field->string,
                          "no such field; there are time, position, look_at, direction, up");
    }
    const cJSON *time = cJSON_GetObjectItemCaseSensitive(object, "time");
    if (!cJSON_IsNumber(time) || !(time->valuedouble >= 0 && time->valuedouble <= 1e6))
        return refuse(path, key, "time", "%s",
                      time ? "is not a number of seconds from 0 to 1e6" : "is missing");
    path->times[key] = (float)time->valuedouble;
    if (key > 0 && !(path->times[key] > path->times[key - 1]))
        return refuse(path, key, "time", "%g is not later than the %g of the key before",
                      time->valuedouble, (double)path->times[key - 1]);
    double position[3];
    if (!read_vector(path, key, object, "position", position))
        return false;
    for (int i = 0; i < 3; i++)
        path->positions[3 * key + (uint32_t)i] = (float)position[i];
    return read_rotation(path, key, object, position, path->rotations + 4 * (size_t)key);
}

/* A camera on a node with a channel for its position and one for its rotation. */
static bool add_camera(const camera_path *path, double fov, uint32_t *camera)
{
    gn_scene *scene = path->app->scene;
    gn_camera_desc lens = gn_camera_desc_default();
    lens.name = path->file;
    lens.yfov = (float)(fov * DEGREE);
    gn_node_desc node = gn_node_desc_default();
    gn_channel_desc channel = gn_channel_desc_default();
    if (gn_scene_add_camera(scene, &lens, &node.camera) != GN_OK ||
        gn_scene_add_node(scene, &node, &channel.node) != GN_OK)
        return false;
    *camera = node.camera;
    channel.key_count = path->count;
    channel.times = path->times;
    channel.path = GN_PATH_TRANSLATION;
    channel.values = path->positions;
    if (gn_scene_add_channel(scene, &channel) != GN_OK)
        return false;
    channel.path = GN_PATH_ROTATION;
    channel.values = path->rotations;
    return gn_scene_add_channel(scene, &channel) == GN_OK &&
           gn_scene_set_time(scene, path->app->options.time) == GN_OK;
}

static bool read_path(camera_path *path, const cJSON *json, uint32_t *camera)
{
    gn_app *app = path->app;
    gn_context *context = gn_device_context(app->device);
    if (!cJSON_IsObject(json))
        return gn_app_error(app, "%s: is not a JSON object with a list of keys", path->file);
    double fov = 60;
    const cJSON *keys = NULL;
    for (const cJSON *field = json->child; field; field = field->next) {
        if (strcmp(field->string, "keys") == 0)
            keys = field;
        else if (strcmp(field->string, "fov") != 0)
            return gn_app_error(app, "%s: %s: no such field; there are fov and keys", path->file,
                                field->string);
        else if (!cJSON_IsNumber(field) || !(field->valuedouble >= 1 && field->valuedouble <= 179))
            return gn_app_error(app, "%s: fov: is not a number of degrees from 1 to 179",
                                path->file);
        else
            fov = field->valuedouble;
    }
    if (!cJSON_IsArray(keys) || cJSON_GetArraySize(keys) == 0)
        return gn_app_error(app, "%s: keys: %s", path->file,
                            keys ? "is not a list of at least one key" : "is missing");
    const size_t count = (size_t)cJSON_GetArraySize(keys);
    path->count = (uint32_t)count;
    path->times = gn_alloc(context, count, sizeof *path->times);
    path->positions = gn_alloc(context, count, 3 * sizeof *path->positions);
    path->rotations = gn_alloc(context, count, 4 * sizeof *path->rotations);
    bool good = (path->times && path->positions && path->rotations) ||
                gn_app_error(app, "%s: out of memory", path->file);
    const cJSON *key = keys->child;
    for (uint32_t i = 0; i < path->count && good; i++, key = key->next)
        good = read_key(path, i, key);
    good = good && add_camera(path, fov, camera);
    gn_free(context, path->times);
    gn_free(context, path->positions);
    gn_free(context, path->rotations);
    return good;
}

bool gn_app_add_camera_path(gn_app *app, const char *file, uint32_t *camera)
{
    gn_context *context = gn_device_context(app->device);
    uint8_t *data;
    uint64_t size;
    const char *reason = gn_file_read(context, file, &data, &size);
    if (reason)
        return gn_app_error(app, "%s: %s", file, reason);
    const char *end = NULL;
    cJSON *json = cJSON_ParseWithLengthOpts((const char *)data, (size_t)size, &end, false);
    size_t line = 1;
    for (const char *c = (const char *)data; !json && end && c < end; c++)
        line += *c == '\n';
    bool good = json || gn_app_error(app, "%s: line %zu: not JSON", file, line);
    camera_path path = {.app = app, .file = file};
    good = good && read_path(&path, json, camera);
    cJSON_Delete(json);
    gn_free(context, data);
    return good;
}
