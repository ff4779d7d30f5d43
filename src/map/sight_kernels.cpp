#include "sight_kernels.hpp"

#include "sight_kernels_body.hpp"

namespace lidar_mapping::map {

const SightKernels& portable_sight_kernels() { return kKernels; }

const SightKernels& sight_kernels() {
  static const SightKernels& chosen =
      avx2_sight_kernels() != nullptr ? *avx2_sight_kernels() : portable_sight_kernels();
  return chosen;
}

}  // namespace lidar_mapping::map
