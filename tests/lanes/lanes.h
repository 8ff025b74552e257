/* The functions of include/gnomon/shadow/ as array functions, compiled for 1, 8 and 16 lanes. */
#ifndef GN_TESTS_LANES_H
#define GN_TESTS_LANES_H

#include <stddef.h>
#include <stdint.h>

/* What inputs a function is given. */
typedef enum gn_lane_domain {
    GN_LANE_ANY,          /* any 32 bits: NaNs, infinities, denormals */
    GN_LANE_NOT_NEGATIVE, /* any bits without a sign: NaNs, infinity, denormals, zero */
    GN_LANE_INT,          /* (-2^31, 2^31) */
    GN_LANE_EXPONENT,     /* [-130, 130] */
    GN_LANE_LENGTH,       /* 2^-20 to 2^20 */
    GN_LANE_UNIT          /* [0,1] with both ends */
} gn_lane_domain;

#define GN_LANE_INPUTS  3
#define GN_LANE_OUTPUTS 4

typedef struct gn_lane_function {
    const char *name;
    gn_lane_domain domain;
    /* count values (a multiple of 16) a plane; a function of one value leaves out[1] and up alone.
     */
    void (*run)(const float *const in[GN_LANE_INPUTS], float *const out[GN_LANE_OUTPUTS],
                size_t count);
} gn_lane_function;

/* The same functions in the same order, ending with a NULL name. */
extern const gn_lane_function gn_lane_functions_1[];
extern const gn_lane_function gn_lane_functions_8[];
extern const gn_lane_function gn_lane_functions_16[];

/* Fills count values of each plane, the same for the same seed. */
void gn_lane_inputs(gn_lane_domain domain, uint32_t seed, float *const in[GN_LANE_INPUTS],
                    size_t count);

#endif
