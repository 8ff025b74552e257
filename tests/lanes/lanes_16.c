#define GN_LANES 16
#define TABLE    gn_lane_functions_16
#include "lanes.inc"
