// SPDX-License-Identifier: BSD-3-Clause
// Compiled with AVX2 if the compiler supports it; only plain pointers are used in its interface.
#include "lidar_mapping/common/instruction_set.hpp"

#include "points/move_kernel.hpp"

#ifdef LIDAR_MAPPING_HAS_AVX2
#include "points/move_kernel_body.hpp"
#endif

namespace lidar_mapping::preprocessing {

MoveKernel avx2_move_kernel() {
#ifdef LIDAR_MAPPING_HAS_AVX2
  return processor_has(InstructionSet::kAvx2) ? move_points : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::preprocessing
