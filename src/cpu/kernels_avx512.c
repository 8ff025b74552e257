/* Inner loops for avx512. CMake sets the compiler's flags for this file. */
#if defined(__AVX512F__)

#define GN_KERNELS      gn_kernels_avx512
#define GN_KERNELS_NAME "avx512"
#include "cpu/kernels.inc"

#endif
