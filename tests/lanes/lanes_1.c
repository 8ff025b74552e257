#define GN_LANES 1
#define TABLE    gn_lane_functions_1
#include "lanes.inc"
