/* Inner loops for avx2. CMake sets the compiler's flags for this file. */
#if defined(__AVX2__)

#define GN_KERNELS      gn_kernels_avx2
#define GN_KERNELS_NAME "avx2"
#include "cpu/kernels.inc"

#endif
