// SPDX-License-Identifier: BSD-3-Clause
#include "ndt/ndt_kernels.hpp"

#include "ndt/ndt_kernels_body.hpp"

namespace lidar_mapping::registration {

const NdtKernels& portable_ndt_kernels() {
  static const NdtKernels kernels{locate, accumulate};
  return kernels;
}

const NdtKernels& ndt_kernels() {
  static const NdtKernels& chosen =
      avx2_ndt_kernels() != nullptr ? *avx2_ndt_kernels() : portable_ndt_kernels();
  return chosen;
}

}  // namespace lidar_mapping::registration
