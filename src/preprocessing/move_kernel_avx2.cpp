// Compiled with AVX2 and FMA where the compiler has it; nothing but plain pointers crosses its
// border.
#include "move_kernel.hpp"

#ifdef __AVX2__
#include "move_kernel_body.hpp"
#endif

namespace lidar_mapping::preprocessing {

MoveKernel avx2_move_kernel() {
#ifdef __AVX2__
  const bool can = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return can ? move_points : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::preprocessing
