/* Inner loops for scalar. CMake sets the compiler's flags for this file. */
#define GN_KERNELS      gn_kernels_scalar
#define GN_KERNELS_NAME "scalar"
#include "cpu/kernels.inc"
