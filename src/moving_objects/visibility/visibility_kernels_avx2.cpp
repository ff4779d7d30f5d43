// SPDX-License-Identifier: BSD-3-Clause
// Compiled with AVX2 if the compiler supports it; only plain pointers cross its interface.
#include "lidar_mapping/common/instruction_set.hpp"

#include "visibility/visibility_kernels.hpp"

#ifdef LIDAR_MAPPING_HAS_AVX2
#include "visibility/visibility_kernels_body.hpp"
#endif

namespace lidar_mapping::moving_objects {

const VisibilityKernels* avx2_visibility_kernels() {
#ifdef LIDAR_MAPPING_HAS_AVX2
  return processor_has(InstructionSet::kAvx2) ? &kKernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::moving_objects
