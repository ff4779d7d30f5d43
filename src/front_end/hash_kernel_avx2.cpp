// Compiled with AVX2 where the compiler has it; nothing but plain pointers crosses its border.
#include "hash_kernel.hpp"

#ifdef __AVX2__
#include "hash_kernel_body.hpp"
#endif

namespace lidar_mapping::front_end {

HashKernel avx2_hash_kernel() {
#ifdef __AVX2__
  return __builtin_cpu_supports("avx2") ? hash_points : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::front_end
