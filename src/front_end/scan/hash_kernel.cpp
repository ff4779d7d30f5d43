// SPDX-License-Identifier: BSD-3-Clause
#include "scan/hash_kernel.hpp"

#include "scan/hash_kernel_body.hpp"

namespace lidar_mapping::front_end {

HashKernel portable_hash_kernel() { return hash_points; }

HashKernel hash_kernel() {
  static const HashKernel chosen =
      avx2_hash_kernel() != nullptr ? avx2_hash_kernel() : portable_hash_kernel();
  return chosen;
}

}  // namespace lidar_mapping::front_end
