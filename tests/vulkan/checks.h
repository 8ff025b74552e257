/* What is compared. Each prints what it finds, and says whether it is what must be: the same bits
 * where the shader's arithmetic is precise, else within bounds. */
#ifndef GN_TESTS_VULKAN_CHECKS_H
#define GN_TESTS_VULKAN_CHECKS_H

#include "compute.h"

bool gn_check_functions(const gn_compute *compute, const uint32_t *spirv, size_t bytes,
                        bool precise);
bool gn_check_chain(const gn_compute *compute, const uint32_t *spirv, size_t bytes, bool precise);

#endif
