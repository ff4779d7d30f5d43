// SPDX-License-Identifier: BSD-3-Clause
// Compiled with AVX2 where the compiler has it; nothing but plain pointers crosses its border.
#include "lidar_mapping/common/instruction_set.hpp"

#include "ndt/ndt_kernels.hpp"

#ifdef LIDAR_MAPPING_HAS_AVX2
#include "ndt/ndt_kernels_body.hpp"
#endif

namespace lidar_mapping::registration {

const NdtKernels* avx2_ndt_kernels() {
#ifdef LIDAR_MAPPING_HAS_AVX2
  static const NdtKernels kernels{locate, accumulate};
  return processor_has(InstructionSet::kAvx2) ? &kernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::registration
