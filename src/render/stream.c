#include "render/stream.h"

#include <string.h>

void gn_stream_refuse(gn_stream *s, const char *reason)
{
    if (s->result == GN_OK)
        s->result = gn_fail(s->context, GN_ERROR_FORMAT, "%s: %s %s", s->name, s->what, reason);
}

void gn_stream_blame(gn_stream *s, gn_result result)
{
    if (s->result != GN_OK || result == GN_OK)
        return;
    char reason[sizeof s->context->message];
    memcpy(reason, s->context->message, sizeof reason);
    s->result = gn_fail(s->context, result == GN_ERROR_INVALID_ARGUMENT ? GN_ERROR_FORMAT : result,
                        "%s: %s: %s", s->name, s->what, reason);
}

uint64_t gn_checksum(uint64_t sum, const void *data, size_t size)
{
    const uint8_t *bytes = data;
    for (size_t i = 0; i < size; i++)
        sum = (sum ^ bytes[i]) * 1099511628211u;
    return sum;
}

bool gn_stream_has(gn_stream *s, uint64_t count, uint64_t size)
{
    if (!s->file && count > (s->size - s->at) / size)
        gn_stream_refuse(s, "is more than the file holds");
    return s->result == GN_OK;
}

void gn_stream_bytes(gn_stream *s, uint8_t *data, size_t size)
{
    if (!gn_stream_has(s, size, 1))
        return;
    if (s->file) {
        s->sum = gn_checksum(s->sum, data, size);
        s->result = gn_file_write(s->file, data, size);
    } else {
        memcpy(data, s->data + s->at, size);
        s->at += size;
    }
}

void gn_stream_number(gn_stream *s, uint64_t *value, size_t size)
{
    uint8_t raw[8] = {0};
    for (size_t i = 0; i < size; i++)
        raw[i] = (uint8_t)(*value >> 8 * i);
    gn_stream_bytes(s, raw, size);
    *value = 0;
    for (size_t i = 0; i < size; i++)
        *value |= (uint64_t)raw[i] << 8 * i;
}

void gn_stream_word(gn_stream *s, uint32_t *value)
{
    uint64_t wide = *value;
    gn_stream_number(s, &wide, 4);
    *value = (uint32_t)wide;
}

void gn_stream_flag(gn_stream *s, bool *value)
{
    uint64_t wide = *value;
    gn_stream_number(s, &wide, 1);
    if (wide > 1)
        gn_stream_refuse(s, "has a flag that is neither 0 nor 1");
    *value = wide == 1;
}

uint32_t gn_stream_choice(gn_stream *s, uint32_t value, uint32_t count)
{
    gn_stream_word(s, &value);
    if (value >= count)
        gn_stream_refuse(s, "has a value that does not exist");
    return s->result == GN_OK ? value : 0;
}

void gn_stream_reals(gn_stream *s, float *values, size_t count)
{
    uint8_t raw[4096];
    const size_t step = sizeof raw / 4;
    for (size_t first = 0; first < count && s->result == GN_OK; first += step) {
        const size_t part = count - first < step ? count - first : step;
        for (size_t i = 0; s->file && i < part; i++) {
            uint32_t bits;
            memcpy(&bits, values + first + i, sizeof bits);
            for (size_t k = 0; k < 4; k++)
                raw[4 * i + k] = (uint8_t)(bits >> 8 * k);
        }
        gn_stream_bytes(s, raw, 4 * part);
        for (size_t i = 0; !s->file && s->result == GN_OK && i < part; i++) {
            uint32_t bits = 0;
            for (size_t k = 0; k < 4; k++)
                bits |= (uint32_t)raw[4 * i + k] << 8 * k;
            memcpy(values + first + i, &bits, sizeof bits);
        }
    }
}

void gn_stream_doubles(gn_stream *s, double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, values + i, sizeof bits);
        gn_stream_number(s, &bits, 8);
        memcpy(values + i, &bits, sizeof bits);
    }
}
