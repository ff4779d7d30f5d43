#include "sight_kernels.hpp"

#include <initializer_list>

#include "sight_kernels_body.hpp"

namespace lidar_mapping::map {

const SightKernels& portable_sight_kernels() { return kKernels; }

const SightKernels& sight_kernels() {
  static const SightKernels& chosen = []() -> const SightKernels& {
    for (const SightKernels* wide : {avx512_sight_kernels(), avx2_sight_kernels()}) {
      if (wide != nullptr) return *wide;
    }
    return portable_sight_kernels();
  }();
  return chosen;
}

}  // namespace lidar_mapping::map
