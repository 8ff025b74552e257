/* glTF 2.0: the container, the JSON and the order of reading. */
#include "scene/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Messages ---------------------------------------------------------------------------------- */

gn_result gn_gltf_fail(gn_gltf *gltf, gn_result result, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return gn_fail(gltf->context, result, "%s: %s%s%s", gltf->file, gltf->where,
                   gltf->where[0] ? ": " : "", text);
}

gn_result gn_gltf_no_memory(gn_gltf *gltf)
{
    return gn_gltf_fail(gltf, GN_ERROR_OUT_OF_MEMORY, "out of memory");
}

gn_result gn_gltf_refail(gn_gltf *gltf, gn_result result)
{
    char text[sizeof gltf->context->message];
    pthread_mutex_lock(&gltf->context->mutex);
    memcpy(text, gltf->context->message, sizeof text);
    pthread_mutex_unlock(&gltf->context->mutex);
    return gn_gltf_fail(gltf, result, "%s", text);
}

const char *gn_gltf_name(const cJSON *item)
{
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "name"));
    return name ? name : "";
}

void gn_gltf_at(gn_gltf *gltf, const gn_gltf_list *list, uint32_t index)
{
    const char *name = gn_gltf_name(list->items[index]);
    if (name[0])
        snprintf(gltf->where, sizeof gltf->where, "%s %u \"%.100s\"", list->noun, index, name);
    else
        snprintf(gltf->where, sizeof gltf->where, "%s %u", list->noun, index);
}

/* JSON -------------------------------------------------------------------------------------- */

static gn_result wrong_type(gn_gltf *gltf, const char *key, const char *wanted)
{
    return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s is not %s", key, wanted);
}

gn_result gn_gltf_object(gn_gltf *gltf, const cJSON *parent, const char *key, const cJSON **out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, key);
    if (item && !cJSON_IsObject(item))
        return wrong_type(gltf, key, "an object");
    *out = item;
    return GN_OK;
}

gn_result gn_gltf_array(gn_gltf *gltf, const cJSON *parent, const char *key, const cJSON **out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, key);
    if (item && !cJSON_IsArray(item))
        return wrong_type(gltf, key, "an array");
    *out = item;
    return GN_OK;
}

gn_result gn_gltf_string(gn_gltf *gltf, const cJSON *parent, const char *key, const char **out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, key);
    if (item && !cJSON_IsString(item))
        return wrong_type(gltf, key, "a string");
    if (item)
        *out = item->valuestring;
    return GN_OK;
}

gn_result gn_gltf_bool(gn_gltf *gltf, const cJSON *parent, const char *key, bool *out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, key);
    if (item && !cJSON_IsBool(item))
        return wrong_type(gltf, key, "true or false");
    if (item)
        *out = cJSON_IsTrue(item);
    return GN_OK;
}

static gn_result number(gn_gltf *gltf, const cJSON *item, const char *key, float *out)
{
    if (!cJSON_IsNumber(item) || !isfinite((float)item->valuedouble))
        return wrong_type(gltf, key, "a finite number");
    *out = (float)item->valuedouble;
    return GN_OK;
}

gn_result gn_gltf_float(gn_gltf *gltf, const cJSON *parent, const char *key, float *out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, key);
    return item ? number(gltf, item, key, out) : GN_OK;
}

gn_result gn_gltf_floats(gn_gltf *gltf, const cJSON *parent, const char *key, uint32_t count,
                         float *out)
{
    const cJSON *array = NULL;
    GN_TRY(gn_gltf_array(gltf, parent, key, &array));
    if (!array)
        return GN_OK;
    if ((uint32_t)cJSON_GetArraySize(array) != count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s has %d numbers instead of %u", key,
                            cJSON_GetArraySize(array), count);
    const cJSON *item = NULL;
    uint32_t i = 0;
    cJSON_ArrayForEach(item, array) GN_TRY(number(gltf, item, key, &out[i++]));
    return GN_OK;
}

static gn_result integer(gn_gltf *gltf, const cJSON *item, const char *key, uint64_t *out)
{
    if (!cJSON_IsNumber(item) || !(item->valuedouble >= 0 && item->valuedouble <= 0x1p53) ||
        item->valuedouble != floor(item->valuedouble))
        return wrong_type(gltf, key, "a non-negative integer");
    *out = (uint64_t)item->valuedouble;
    return GN_OK;
}

gn_result gn_gltf_integer(gn_gltf *gltf, const cJSON *parent, const char *key, uint64_t *out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(parent, key);
    return item ? integer(gltf, item, key, out) : GN_OK;
}

gn_result gn_gltf_index(gn_gltf *gltf, const cJSON *parent, const char *key,
                        const gn_gltf_list *list, uint32_t *out)
{
    /* An item of an array is an index as well: then parent is that item and key names it. */
    const cJSON *item =
        cJSON_IsObject(parent) ? cJSON_GetObjectItemCaseSensitive(parent, key) : parent;
    if (!item)
        return GN_OK;
    uint64_t index = 0;
    GN_TRY(integer(gltf, item, key, &index));
    if (index >= list->count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s: there is no %s %llu, the count is %u", key,
                            list->noun, (unsigned long long)index, list->count);
    *out = (uint32_t)index;
    return GN_OK;
}

const cJSON *gn_gltf_extension(const cJSON *item, const char *name)
{
    const cJSON *extensions = cJSON_GetObjectItemCaseSensitive(item, "extensions");
    const cJSON *extension = cJSON_GetObjectItemCaseSensitive(extensions, name);
    return cJSON_IsObject(extension) ? extension : NULL;
}

/* The document ------------------------------------------------------------------------------ */

gn_result gn_gltf_make_list(gn_gltf *gltf, const cJSON *parent, const char *key, const char *noun,
                            gn_gltf_list *list)
{
    list->noun = noun;
    const cJSON *array = NULL;
    GN_TRY(gn_gltf_array(gltf, parent, key, &array));
    const uint32_t count = array ? (uint32_t)cJSON_GetArraySize(array) : 0;
    if (count == 0)
        return GN_OK;
    list->items = gn_alloc(gltf->context, count, sizeof *list->items);
    if (!list->items)
        return gn_gltf_no_memory(gltf);
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, array)
    {
        if (!cJSON_IsObject(item))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s %u is not an object", noun, list->count);
        list->items[list->count++] = item;
    }
    return GN_OK;
}

static gn_result flatten_all(gn_gltf *gltf)
{
    const cJSON *root = gltf->root;
    GN_TRY(gn_gltf_make_list(gltf, root, "accessors", "accessor", &gltf->accessors));
    GN_TRY(gn_gltf_make_list(gltf, root, "animations", "animation", &gltf->animations));
    GN_TRY(gn_gltf_make_list(gltf, root, "buffers", "buffer", &gltf->buffers));
    GN_TRY(gn_gltf_make_list(gltf, root, "bufferViews", "bufferView", &gltf->views));
    GN_TRY(gn_gltf_make_list(gltf, root, "cameras", "camera", &gltf->cameras));
    GN_TRY(gn_gltf_make_list(gltf, root, "images", "image", &gltf->images));
    GN_TRY(gn_gltf_make_list(gltf, root, "materials", "material", &gltf->materials));
    GN_TRY(gn_gltf_make_list(gltf, root, "meshes", "mesh", &gltf->meshes));
    GN_TRY(gn_gltf_make_list(gltf, root, "nodes", "node", &gltf->nodes));
    GN_TRY(gn_gltf_make_list(gltf, root, "samplers", "sampler", &gltf->samplers));
    GN_TRY(gn_gltf_make_list(gltf, root, "scenes", "scene", &gltf->scenes));
    GN_TRY(gn_gltf_make_list(gltf, root, "skins", "skin", &gltf->skins));
    GN_TRY(gn_gltf_make_list(gltf, root, "textures", "texture", &gltf->textures));
    return gn_gltf_make_list(gltf, gn_gltf_extension(root, "KHR_lights_punctual"), "lights",
                             "light", &gltf->lights);
}

/* Memory for what is remembered of each thing; none where the file has none of them. */
static gn_result make_tables(gn_gltf *gltf)
{
    gn_context *context = gltf->context;
    const uint32_t images = gltf->images.count, meshes = gltf->meshes.count;
    const uint32_t nodes = gltf->nodes.count;
    gltf->buffer_data = gn_alloc_zero(context, gltf->buffers.count, sizeof *gltf->buffer_data);
    gltf->image_textures = gn_alloc(context, images, sizeof *gltf->image_textures);
    gltf->mesh_indices = gn_alloc(context, meshes, sizeof *gltf->mesh_indices);
    gltf->node_indices = gn_alloc(context, nodes, sizeof *gltf->node_indices);
    gltf->node_paths = gn_alloc_zero(context, nodes, sizeof *gltf->node_paths);
    if (!gltf->buffer_data || !gltf->image_textures || !gltf->mesh_indices || !gltf->node_indices ||
        !gltf->node_paths)
        return gn_gltf_no_memory(gltf);
    memset(gltf->image_textures, 0xff, images * sizeof *gltf->image_textures);
    memset(gltf->mesh_indices, 0xff, meshes * sizeof *gltf->mesh_indices);
    memset(gltf->node_indices, 0xff, nodes * sizeof *gltf->node_indices);
    return GN_OK;
}

static gn_result check_version(gn_gltf *gltf)
{
    const cJSON *asset = NULL;
    GN_TRY(gn_gltf_object(gltf, gltf->root, "asset", &asset));
    const char *version = NULL, *minimum = "2.0";
    GN_TRY(gn_gltf_string(gltf, asset, "version", &version));
    GN_TRY(gn_gltf_string(gltf, asset, "minVersion", &minimum));
    if (!version)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "not glTF: asset.version is missing");
    if (strncmp(version, "2.", 2) != 0 || strcmp(minimum, "2.0") != 0)
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED, "glTF version %.20s is not supported",
                            strcmp(minimum, "2.0") != 0 ? minimum : version);
    return GN_OK;
}

static bool is_known_extension(const char *name)
{
    static const char *const known[] = {"EXT_mesh_gpu_instancing", "EXT_texture_webp",
                                        "KHR_lights_punctual", "KHR_mesh_quantization",
                                        "KHR_texture_transform"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (strcmp(name, known[i]) == 0)
            return true;
    }
    return false;
}

static gn_result check_extensions(gn_gltf *gltf)
{
    const cJSON *array = NULL, *item = NULL;
    GN_TRY(gn_gltf_array(gltf, gltf->root, "extensionsRequired", &array));
    cJSON_ArrayForEach(item, array)
    {
        if (!cJSON_IsString(item))
            return wrong_type(gltf, "extensionsRequired", "an array of strings");
        if (!is_known_extension(item->valuestring))
            return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED,
                                "the file requires the extension %.60s, which is not supported",
                                item->valuestring);
    }
    GN_TRY(gn_gltf_array(gltf, gltf->root, "extensionsUsed", &array));
    cJSON_ArrayForEach(item, array)
    {
        if (!cJSON_IsString(item))
            return wrong_type(gltf, "extensionsUsed", "an array of strings");
        if (!is_known_extension(item->valuestring))
            gn_scene_warn(gltf->scene, "extension %.60s is not supported and was left out",
                          item->valuestring);
    }
    return GN_OK;
}

static gn_result read_document(gn_gltf *gltf, const char *text, uint64_t size)
{
    const char *end = NULL;
    gltf->root = cJSON_ParseWithLengthOpts(text, size, &end, 0);
    if (!gltf->root)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "not valid JSON at byte %lld",
                            end ? (long long)(end - text) : 0);
    for (; end && end < text + size; end++) {
        if (!strchr(" \t\r\n", *end))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "not valid JSON at byte %lld",
                                (long long)(end - text));
    }
    if (!cJSON_IsObject(gltf->root))
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "the JSON is not an object");
    GN_TRY(check_version(gltf));
    GN_TRY(check_extensions(gltf));
    GN_TRY(flatten_all(gltf));
    GN_TRY(make_tables(gltf));
    GN_TRY(gn_gltf_read_materials(gltf));
    GN_TRY(gn_gltf_read_meshes(gltf));
    GN_TRY(gn_gltf_read_nodes(gltf));
    return gn_gltf_read_animations(gltf);
}

/* The container ----------------------------------------------------------------------------- */

static uint32_t read_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static gn_result read_glb(gn_gltf *gltf, const uint8_t *data, uint64_t size)
{
    if (size < 20)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "truncated: %llu bytes are too few for a .glb",
                            (unsigned long long)size);
    const uint32_t version = read_u32(data + 4), length = read_u32(data + 8);
    if (version != 2)
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED, "GLB version %u is not supported", version);
    if (length != size)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "%s: the header says %u bytes, there are %llu",
                            length > size ? "truncated" : "wrong length", length,
                            (unsigned long long)size);

    /* JSON comes first, BIN second; chunks of other kinds may follow. */
    const uint8_t *json = NULL;
    uint32_t json_size = 0, nth = 0;
    for (uint64_t offset = 12; offset < size; nth++) {
        if (size - offset < 8)
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "chunk %u: its header is truncated", nth);
        const uint32_t chunk_size = read_u32(data + offset), kind = read_u32(data + offset + 4);
        offset += 8;
        if (chunk_size % 4 != 0 || chunk_size > size - offset)
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                                "chunk %u: wrong length %u, %llu bytes are left", nth, chunk_size,
                                (unsigned long long)(size - offset));
        if ((nth == 0) != (kind == 0x4e4f534au))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                                "chunk %u: the first chunk, and no other, must be JSON", nth);
        if (nth == 0) {
            json = data + offset;
            json_size = chunk_size;
        } else if (nth == 1 && kind == 0x004e4942u) {
            gltf->chunk.data = data + offset;
            gltf->chunk.size = chunk_size;
        }
        offset += chunk_size;
    }
    return read_document(gltf, (const char *)json, json_size);
}

static void free_list(gn_gltf *gltf, gn_gltf_list *list)
{
    gn_free(gltf->context, list->items);
}

static gn_result read_bytes(gn_gltf *gltf, const uint8_t *data, uint64_t size)
{
    gn_result result = size >= 4 && memcmp(data, "glTF", 4) == 0
                           ? read_glb(gltf, data, size)
                           : read_document(gltf, (const char *)data, size);
    gn_context *context = gltf->context;
    for (uint32_t i = 0; gltf->buffer_data && i < gltf->buffers.count; i++)
        gn_free(context, gltf->buffer_data[i].owned);
    gn_free(context, gltf->buffer_data);
    gn_free(context, gltf->image_textures);
    gn_free(context, gltf->mesh_indices);
    gn_free(context, gltf->node_indices);
    gn_free(context, gltf->node_paths);
    free_list(gltf, &gltf->accessors);
    free_list(gltf, &gltf->animations);
    free_list(gltf, &gltf->buffers);
    free_list(gltf, &gltf->views);
    free_list(gltf, &gltf->cameras);
    free_list(gltf, &gltf->images);
    free_list(gltf, &gltf->lights);
    free_list(gltf, &gltf->materials);
    free_list(gltf, &gltf->meshes);
    free_list(gltf, &gltf->nodes);
    free_list(gltf, &gltf->samplers);
    free_list(gltf, &gltf->scenes);
    free_list(gltf, &gltf->skins);
    free_list(gltf, &gltf->textures);
    cJSON_Delete(gltf->root);
    return result;
}

gn_result gn_import_gltf(gn_scene *scene, const char *path)
{
    gn_gltf gltf = {.context = scene->context, .scene = scene, .file = path, .external = true};
    gn_gltf_bytes bytes = {0};
    GN_TRY(gn_gltf_read_file(&gltf, path, NULL, &bytes));
    const gn_result result = read_bytes(&gltf, bytes.data, bytes.size);
    gn_free(scene->context, bytes.owned);
    return result;
}

gn_result gn_import_gltf_memory(gn_scene *scene, const void *data, size_t size)
{
    gn_gltf gltf = {.context = scene->context, .scene = scene, .file = "(memory)"};
    return read_bytes(&gltf, data, size);
}
