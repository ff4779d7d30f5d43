// SPDX-License-Identifier: BSD-3-Clause
// Compiled with AVX-512 if the compiler supports it; only plain pointers cross its interface.
#include "lidar_mapping/common/instruction_set.hpp"

#include "visibility/visibility_kernels.hpp"

#ifdef LIDAR_MAPPING_HAS_AVX512
#include "visibility/visibility_kernels_body.hpp"
#endif

namespace lidar_mapping::moving_objects {

const VisibilityKernels* avx512_visibility_kernels() {
#ifdef LIDAR_MAPPING_HAS_AVX512
  return processor_has(InstructionSet::kAvx512) ? &kKernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::moving_objects
