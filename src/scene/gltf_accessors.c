/* glTF accessors: typed arrays in buffer views. */
#include "scene/gltf.h"

#include <math.h>
#include <string.h>

enum { BYTE = 5120, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, UNSIGNED_INT = 5125, FLOAT };

/* An accessor without data is all zero: nothing in the file's size bounds its count. */
#define MAX_EMPTY_COUNT 65536u

static uint32_t type_size(uint32_t type)
{
    switch (type) {
    case BYTE:
    case UNSIGNED_BYTE:
        return 1;
    case SHORT:
    case UNSIGNED_SHORT:
        return 2;
    case UNSIGNED_INT:
    case FLOAT:
        return 4;
    default:
        return 0;
    }
}

static const char *type_name(uint32_t type)
{
    static const char *const names[] = {"BYTE", "UNSIGNED_BYTE", "SHORT", "UNSIGNED_SHORT",
                                        "?",    "UNSIGNED_INT",  "FLOAT"};
    return names[type - BYTE];
}

/* The bytes of count elements of size bytes, stride apart, from offset of a view. */
static gn_result range(gn_gltf *gltf, uint32_t accessor, const char *part, uint32_t view,
                       uint64_t offset, uint64_t count, uint32_t size, uint32_t stride,
                       const uint8_t **data)
{
    gn_gltf_bytes bytes = {0};
    GN_TRY(gn_gltf_view_bytes(gltf, view, &bytes));
    /* count is below 2^32 and stride at most 252: no overflow. */
    const uint64_t needed = count > 0 ? (count - 1) * stride + size : 0;
    if (offset > bytes.size || needed > bytes.size - offset)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "accessor %u%s: %llu elements at byte %llu end beyond bufferView %u "
                            "(%llu bytes)",
                            accessor, part, (unsigned long long)count, (unsigned long long)offset,
                            view, (unsigned long long)bytes.size);
    *data = bytes.data + offset;
    return GN_OK;
}

static gn_result open_sparse(gn_gltf *gltf, const cJSON *item, gn_gltf_accessor *accessor)
{
    const cJSON *sparse = NULL, *indices = NULL, *values = NULL;
    GN_TRY(gn_gltf_object(gltf, item, "sparse", &sparse));
    if (!sparse)
        return GN_OK;
    uint64_t count = 0, type = 0, index_offset = 0, value_offset = 0;
    uint32_t index_view = GN_NONE, value_view = GN_NONE;
    GN_TRY(gn_gltf_object(gltf, sparse, "indices", &indices));
    GN_TRY(gn_gltf_object(gltf, sparse, "values", &values));
    GN_TRY(gn_gltf_integer(gltf, sparse, "count", &count));
    if (indices) {
        GN_TRY(gn_gltf_index(gltf, indices, "bufferView", &gltf->views, &index_view));
        GN_TRY(gn_gltf_integer(gltf, indices, "byteOffset", &index_offset));
        GN_TRY(gn_gltf_integer(gltf, indices, "componentType", &type));
    }
    if (values) {
        GN_TRY(gn_gltf_index(gltf, values, "bufferView", &gltf->views, &value_view));
        GN_TRY(gn_gltf_integer(gltf, values, "byteOffset", &value_offset));
    }
    if (index_view == GN_NONE || value_view == GN_NONE)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: sparse without indices or values",
                            accessor->index);
    if (type != UNSIGNED_BYTE && type != UNSIGNED_SHORT && type != UNSIGNED_INT)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "accessor %u: sparse indices of componentType %llu", accessor->index,
                            (unsigned long long)type);
    if (count > accessor->count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "accessor %u: sparse has %llu elements, the accessor only %u",
                            accessor->index, (unsigned long long)count, accessor->count);
    const uint32_t index_size = type_size((uint32_t)type);
    const uint32_t size = type_size(accessor->type) * accessor->components;
    GN_TRY(range(gltf, accessor->index, ", sparse indices", index_view, index_offset, count,
                 index_size, index_size, &accessor->sparse_indices));
    GN_TRY(range(gltf, accessor->index, ", sparse values", value_view, value_offset, count, size,
                 size, &accessor->sparse_values));
    accessor->sparse_count = (uint32_t)count;
    accessor->sparse_type = (uint32_t)type;
    return GN_OK;
}

static uint32_t component_count(const char *type)
{
    static const struct {
        const char *name;
        uint32_t components;
    } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    for (size_t i = 0; type && i < sizeof types / sizeof *types; i++) {
        if (strcmp(type, types[i].name) == 0)
            return types[i].components;
    }
    return 0;
}

gn_result gn_gltf_open_accessor(gn_gltf *gltf, uint32_t index, gn_gltf_accessor *accessor)
{
    const cJSON *item = gltf->accessors.items[index];
    uint64_t count = 0, type = 0, offset = 0, stride = 0;
    uint32_t view = GN_NONE;
    const char *shape = NULL;
    *accessor = (gn_gltf_accessor){.index = index};
    GN_TRY(gn_gltf_integer(gltf, item, "count", &count));
    GN_TRY(gn_gltf_integer(gltf, item, "componentType", &type));
    GN_TRY(gn_gltf_integer(gltf, item, "byteOffset", &offset));
    GN_TRY(gn_gltf_bool(gltf, item, "normalized", &accessor->normalized));
    GN_TRY(gn_gltf_string(gltf, item, "type", &shape));
    GN_TRY(gn_gltf_index(gltf, item, "bufferView", &gltf->views, &view));
    accessor->components = component_count(shape);
    if (accessor->components == 0)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: type %.20s cannot be used here",
                            index, shape ? shape : "(missing)");
    if (type > FLOAT || type_size((uint32_t)type) == 0)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: unknown componentType %llu", index,
                            (unsigned long long)type);
    if (count == 0 || count >= UINT32_MAX)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: its count %llu is not usable",
                            index, (unsigned long long)count);
    accessor->type = (uint32_t)type;
    accessor->count = (uint32_t)count;

    const uint32_t size = type_size(accessor->type) * accessor->components;
    if (view == GN_NONE) {
        if (count > MAX_EMPTY_COUNT)
            return gn_gltf_fail(gltf, GN_ERROR_UNSUPPORTED,
                                "accessor %u: %u elements without a bufferView; at most %u can be "
                                "read",
                                index, accessor->count, MAX_EMPTY_COUNT);
    } else {
        GN_TRY(gn_gltf_integer(gltf, gltf->views.items[view], "byteStride", &stride));
        if (stride != 0 && (stride < size || stride > 252))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                                "accessor %u: bufferView %u has the byteStride %llu for elements "
                                "of %u bytes",
                                index, view, (unsigned long long)stride, size);
        accessor->stride = stride != 0 ? (uint32_t)stride : size;
        GN_TRY(
            range(gltf, index, "", view, offset, count, size, accessor->stride, &accessor->data));
    }
    return open_sparse(gltf, item, accessor);
}

static uint32_t read_unsigned(const uint8_t *data, uint32_t type)
{
    uint32_t value = 0; /* glTF is little endian, as are the machines we build for */
    memcpy(&value, data, type_size(type));
    return value;
}

static float read_component(const uint8_t *data, uint32_t type, bool normalized)
{
    float value = 0;
    int8_t byte = 0;
    int16_t word = 0;
    switch (type) {
    case FLOAT:
        memcpy(&value, data, sizeof value);
        return value;
    case BYTE:
        memcpy(&byte, data, sizeof byte);
        return normalized ? fmaxf((float)byte / 127.0f, -1.0f) : (float)byte;
    case SHORT:
        memcpy(&word, data, sizeof word);
        return normalized ? fmaxf((float)word / 32767.0f, -1.0f) : (float)word;
    default:
        value = (float)read_unsigned(data, type);
        return normalized ? value / (type == UNSIGNED_BYTE ? 255.0f : 65535.0f) : value;
    }
}

static void read_element(const gn_gltf_accessor *accessor, const uint8_t *data, float *values)
{
    const uint32_t size = type_size(accessor->type);
    for (uint32_t c = 0; c < accessor->components; c++)
        values[c] = read_component(data + c * size, accessor->type, accessor->normalized);
}

/* The place of the sparse element i; an error where it is beyond the accessor. */
static gn_result sparse_place(gn_gltf *gltf, const gn_gltf_accessor *accessor, uint32_t i,
                              uint32_t *place)
{
    const uint32_t size = type_size(accessor->sparse_type);
    *place = read_unsigned(accessor->sparse_indices + (size_t)i * size, accessor->sparse_type);
    if (*place >= accessor->count)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "accessor %u: sparse index %u is out of range: the count is %u",
                            accessor->index, *place, accessor->count);
    return GN_OK;
}

static gn_result fill_floats(gn_gltf *gltf, const gn_gltf_accessor *accessor, float *values)
{
    const uint32_t components = accessor->components;
    const uint32_t size = type_size(accessor->type) * components;
    if (accessor->data) {
        for (uint32_t i = 0; i < accessor->count; i++)
            read_element(accessor, accessor->data + (size_t)i * accessor->stride,
                         values + (size_t)i * components);
    }
    for (uint32_t i = 0; i < accessor->sparse_count; i++) {
        uint32_t place = 0;
        GN_TRY(sparse_place(gltf, accessor, i, &place));
        read_element(accessor, accessor->sparse_values + (size_t)i * size,
                     values + (size_t)place * components);
    }
    for (size_t i = 0; i < (size_t)accessor->count * components; i++) {
        if (!isfinite(values[i]))
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: element %zu is not finite",
                                accessor->index, i / components);
    }
    return GN_OK;
}

gn_result gn_gltf_read_floats(gn_gltf *gltf, const gn_gltf_accessor *accessor, uint32_t components,
                              gn_gltf_rule rule, float **values)
{
    if (accessor->components != components)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                            "accessor %u has %u components an element instead of %u",
                            accessor->index, accessor->components, components);
    const bool small_integer = accessor->type <= UNSIGNED_SHORT;
    const bool allowed = accessor->type == FLOAT ||
                         (small_integer && rule == GN_GLTF_NORMALIZED && accessor->normalized) ||
                         (small_integer && rule == GN_GLTF_QUANTIZED);
    if (!allowed)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: %s%s cannot be used here",
                            accessor->index, accessor->normalized ? "normalized " : "",
                            type_name(accessor->type));
    float *array =
        gn_alloc_zero(gltf->context, (size_t)accessor->count * components, sizeof *array);
    if (!array)
        return gn_gltf_no_memory(gltf);
    const gn_result result = fill_floats(gltf, accessor, array);
    if (result != GN_OK) {
        gn_free(gltf->context, array);
        return result;
    }
    *values = array;
    return GN_OK;
}

static gn_result fill_indices(gn_gltf *gltf, const gn_gltf_accessor *accessor,
                              uint32_t vertex_count, uint32_t *values)
{
    const uint32_t size = type_size(accessor->type);
    if (accessor->data) {
        for (uint32_t i = 0; i < accessor->count; i++)
            values[i] =
                read_unsigned(accessor->data + (size_t)i * accessor->stride, accessor->type);
    }
    for (uint32_t i = 0; i < accessor->sparse_count; i++) {
        uint32_t place = 0;
        GN_TRY(sparse_place(gltf, accessor, i, &place));
        values[place] = read_unsigned(accessor->sparse_values + (size_t)i * size, accessor->type);
    }
    for (uint32_t i = 0; i < accessor->count; i++) {
        if (values[i] >= vertex_count)
            return gn_gltf_fail(gltf, GN_ERROR_FORMAT,
                                "accessor %u: index %u is out of range: there are %u vertices",
                                accessor->index, values[i], vertex_count);
    }
    return GN_OK;
}

gn_result gn_gltf_read_indices(gn_gltf *gltf, const gn_gltf_accessor *accessor,
                               uint32_t vertex_count, uint32_t **values)
{
    const bool allowed = accessor->components == 1 && !accessor->normalized &&
                         (accessor->type == UNSIGNED_BYTE || accessor->type == UNSIGNED_SHORT ||
                          accessor->type == UNSIGNED_INT);
    if (!allowed)
        return gn_gltf_fail(gltf, GN_ERROR_FORMAT, "accessor %u: %s cannot be used for indices",
                            accessor->index,
                            accessor->components == 1 ? type_name(accessor->type) : "a vector");
    uint32_t *array = gn_alloc_zero(gltf->context, accessor->count, sizeof *array);
    if (!array)
        return gn_gltf_no_memory(gltf);
    const gn_result result = fill_indices(gltf, accessor, vertex_count, array);
    if (result != GN_OK) {
        gn_free(gltf->context, array);
        return result;
    }
    *values = array;
    return GN_OK;
}
