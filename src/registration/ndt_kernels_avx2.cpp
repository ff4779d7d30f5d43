// Compiled with AVX2 where the compiler has it; nothing but plain pointers crosses its border.
#include "ndt_kernels.hpp"

#ifdef __AVX2__
#include "ndt_kernels_body.hpp"
#endif

namespace lidar_mapping::registration {

const NdtKernels* avx2_ndt_kernels() {
#ifdef __AVX2__
  static const NdtKernels kernels{place, accumulate};
  return __builtin_cpu_supports("avx2") ? &kernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::registration
