// Compiled with AVX-512 where the compiler has it; nothing but plain pointers crosses its border.
#include "sight_kernels.hpp"

#ifdef __AVX512DQ__
#include "sight_kernels_body.hpp"
#endif

namespace lidar_mapping::map {

const SightKernels* avx512_sight_kernels() {
#ifdef __AVX512DQ__
  // The first processors with AVX-512 slow down when it is used; they have no AVX-512 VBMI.
  return __builtin_cpu_supports("avx512vbmi") ? &kKernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::map
