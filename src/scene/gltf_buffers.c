/* glTF: where bytes come from: files, data: URIs, buffers and buffer views. */
#include "scene/gltf.h"

#include <limits.h>
#include <string.h>

#include "scene/file.h"

/* Files ------------------------------------------------------------------------------------- */

gn_result gn_gltf_read_file(gn_gltf *gltf, const char *path, const char *uri, gn_gltf_bytes *bytes)
{
    uint8_t *data = NULL;
    uint64_t size = 0;
    const char *reason = gn_file_read(gltf->context, path, &data, &size);
    if (reason && !uri)
        return gn_gltf_fail(gltf, GN_ERROR_IO, "it cannot be read: %s", reason);
    if (reason)
        return gn_gltf_fail(gltf, GN_ERROR_IO, "\"%.200s\" cannot be read: %s (%.200s)", uri,
                            reason, path);
    *bytes = (gn_gltf_bytes){.data = data, .size = size, .owned = data};
    return GN_OK;
}

/* URIs -------------------------------------------------------------------------------------- */

static int base64_value(char letter)
{
    if (letter >= 'A' && letter <= 'Z')
        return letter - 'A';
    if (letter >= 'a' && letter <= 'z')
        return letter - 'a' + 26;
    if (letter >= '0' && letter <= '9')
        return letter - '0' + 52;
    return letter == '+' ? 62 : letter == '/' ? 63 : -1;
}

/* "data:[<media type>];base64,<data>" */
static gn_result decode_data_uri(gn_gltf *gltf, const char *uri, gn_gltf_bytes *bytes)
{
    const char *comma = strchr(uri, ',');
    if (!comma || comma - uri < 7 || memcmp(comma - 7, ";base64", 7) != 0)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "its data: URI is not base64");
    const char *text = comma + 1;
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] == '=')
        length--;
    uint8_t *data = gn_alloc(gltf->context, length / 4 * 3 + 3, 1);
    if (!data)
        return gn_gltf_no_memory(gltf);
    size_t size = 0;
    uint32_t bits = 0, pending = 0;
    for (size_t i = 0; i < length; i++) {
        const int value = base64_value(text[i]);
        if (value < 0) {
            gn_free(gltf->context, data);
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "its data: URI is not base64 at letter %zu",
                                (size_t)(text - uri) + i);
        }
        pending = (pending << 6 | (uint32_t)value) & 0xffffu;
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            data[size++] = (uint8_t)(pending >> bits);
        }
    }
    *bytes = (gn_gltf_bytes){.data = data, .size = size, .owned = data};
    return GN_OK;
}

static int hex_value(char letter)
{
    if (letter >= '0' && letter <= '9')
        return letter - '0';
    const char lower = (char)(letter | 0x20);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/* Percent-decodes a URI; false where it is malformed or does not fit. */
static bool decode_percent(const char *uri, char *text, size_t capacity)
{
    size_t size = 0;
    while (*uri) {
        char letter = *uri++;
        if (letter == '%') {
            const int high = hex_value(uri[0]);
            const int low = high < 0 ? -1 : hex_value(uri[1]);
            if (low < 0 || high * 16 + low == 0)
                return false;
            letter = (char)(high * 16 + low);
            uri += 2;
        }
        if (size + 1 >= capacity)
            return false;
        text[size++] = letter;
    }
    text[size] = '\0';
    return true;
}

gn_result gn_gltf_resolve_uri(gn_gltf *gltf, const char *uri, gn_gltf_bytes *bytes)
{
    if (strncmp(uri, "data:", 5) == 0)
        return decode_data_uri(gltf, uri, bytes);
    const char *colon = strchr(uri, ':');
    const char *slash = strchr(uri, '/');
    if (colon && (!slash || colon < slash))
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED,
                            "\"%.200s\": only files beside the scene can be read", uri);
    if (!gltf->external)
        return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED,
                            "\"%.200s\": a scene in memory cannot read files", uri);
    char relative[PATH_MAX], path[PATH_MAX];
    if (!decode_percent(uri, relative, sizeof relative) ||
        !gn_file_beside(gltf->file, relative, path, sizeof path))
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "\"%.200s\" is not a valid URI", uri);
    return gn_gltf_read_file(gltf, path, uri, bytes);
}

/* Buffers ----------------------------------------------------------------------------------- */

static gn_result load_buffer(gn_gltf *gltf, uint32_t index)
{
    const cJSON *buffer = gltf->buffers.items[index];
    gn_gltf_bytes *bytes = &gltf->buffer_data[index];
    const char *uri = NULL;
    GN_TRY(gn_gltf_string(gltf, buffer, "uri", &uri));
    uint64_t length = UINT64_MAX;
    GN_TRY(gn_gltf_integer(gltf, buffer, "byteLength", &length));
    if (uri) {
        GN_TRY(gn_gltf_resolve_uri(gltf, uri, bytes));
    } else if (index == 0 && gltf->chunk.data) {
        *bytes = gltf->chunk;
    } else {
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "buffer %u has neither a URI nor a BIN chunk",
                            index);
    }
    if (length > bytes->size) {
        const uint64_t size = bytes->size;
        gn_free(gltf->context, bytes->owned);
        *bytes = (gn_gltf_bytes){0};
        if (length == UINT64_MAX)
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "buffer %u has no byteLength", index);
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "buffer %u is truncated: byteLength says %llu, there are %llu bytes",
                            index, (unsigned long long)length, (unsigned long long)size);
    }
    bytes->size = length; /* a chunk may be padded */
    return GN_OK;
}

gn_result gn_gltf_view_bytes(gn_gltf *gltf, uint32_t view, gn_gltf_bytes *bytes)
{
    const cJSON *item = gltf->views.items[view];
    uint32_t buffer = GN_NONE;
    uint64_t offset = 0, length = 0;
    GN_TRY(gn_gltf_index(gltf, item, "buffer", &gltf->buffers, &buffer));
    GN_TRY(gn_gltf_integer(gltf, item, "byteOffset", &offset));
    GN_TRY(gn_gltf_integer(gltf, item, "byteLength", &length));
    if (buffer == GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "bufferView %u has no buffer", view);
    if (!gltf->buffer_data[buffer].data)
        GN_TRY(load_buffer(gltf, buffer));
    const gn_gltf_bytes *whole = &gltf->buffer_data[buffer];
    if (offset > whole->size || length > whole->size - offset)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "bufferView %u (bytes %llu to %llu) ends beyond buffer %u (%llu bytes)",
                            view, (unsigned long long)offset, (unsigned long long)(offset + length),
                            buffer, (unsigned long long)whole->size);
    *bytes = (gn_gltf_bytes){.data = whole->data + offset, .size = length};
    return GN_OK;
}
