// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/visibility_kernels.hpp"

#include <initializer_list>

#include "visibility/visibility_kernels_body.hpp"

namespace lidar_mapping::moving_objects {

const VisibilityKernels& portable_visibility_kernels() { return kKernels; }

const VisibilityKernels& visibility_kernels() {
  static const VisibilityKernels& chosen = []() -> const VisibilityKernels& {
    for (const VisibilityKernels* wide : {avx512_visibility_kernels(), avx2_visibility_kernels()}) {
      if (wide != nullptr) return *wide;
    }
    return portable_visibility_kernels();
  }();
  return chosen;
}

}  // namespace lidar_mapping::moving_objects
