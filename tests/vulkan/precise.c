#include <stdio.h>
#include <stdlib.h>

#include "precise.h"

/* SPIR-V's numbers: specification, section 3.32. */
enum {
    HEADER = 5, /* words */
    OP_DECORATE = 71,
    OP_MEMBER_DECORATE = 72,
    OP_TYPE_VOID = 19,
    OP_FNEGATE = 127,
    OP_FADD = 129,
    OP_FSUB = 131,
    OP_FMUL = 133,
    OP_FDIV = 136,
    NO_CONTRACTION = 42
};

static uint32_t operation(uint32_t word)
{
    return word & 0xffffu;
}

/* Words of an instruction, or the end of the program where that cannot be. */
static size_t length(const uint32_t *spirv, size_t at, size_t words)
{
    const size_t count = spirv[at] >> 16;
    if (count == 0 || at + count > words) {
        fprintf(stderr, "SPIR-V: word %zu begins no instruction\n", at);
        exit(1);
    }
    return count;
}

uint32_t *gn_spirv_precise(const uint32_t *spirv, size_t bytes, size_t *precise_bytes)
{
    const size_t words = bytes / sizeof *spirv;
    size_t instructions = 0, types = 0; /* types: where decorations end */
    for (size_t at = HEADER; at < words; at += length(spirv, at, words)) {
        instructions++;
        if (types == 0 && operation(spirv[at]) >= OP_TYPE_VOID && operation(spirv[at]) < 40)
            types = at;
    }
    uint32_t *out = malloc((words + 3 * instructions) * sizeof *out);
    if (!out || types == 0) {
        fprintf(stderr, "SPIR-V: no memory, or no types\n");
        exit(1);
    }
    size_t count = 0;
    for (size_t i = 0; i < types; i++)
        out[count++] = spirv[i];
    for (size_t at = types; at < words; at += length(spirv, at, words))
        switch (operation(spirv[at])) {
        case OP_FNEGATE:
        case OP_FADD:
        case OP_FSUB:
        case OP_FMUL:
        case OP_FDIV:
            out[count++] = 3u << 16 | OP_DECORATE;
            out[count++] = spirv[at + 2]; /* the result; its type is at + 1 */
            out[count++] = NO_CONTRACTION;
            break;
        default:
            break;
        }
    for (size_t i = types; i < words; i++)
        out[count++] = spirv[i];
    *precise_bytes = count * sizeof *out;
    return out;
}
