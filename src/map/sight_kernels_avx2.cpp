// Compiled with AVX2 where the compiler has it; nothing but plain pointers crosses its border.
#include "sight_kernels.hpp"

#ifdef __AVX2__
#include "sight_kernels_body.hpp"
#endif

namespace lidar_mapping::map {

const SightKernels* avx2_sight_kernels() {
#ifdef __AVX2__
  return __builtin_cpu_supports("avx2") ? &kKernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::map
