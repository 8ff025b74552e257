#define GN_LANES 8
#define TABLE    gn_lane_functions_8
#include "lanes.inc"
