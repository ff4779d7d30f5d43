// Compiled with AVX-512 (F and DQ) where the compiler has it; nothing but plain pointers crosses
// its border.
#include "move_kernel.hpp"

#ifdef __AVX512DQ__
#include "move_kernel_body.hpp"
#endif

namespace lidar_mapping::preprocessing {

MoveKernel avx512_move_kernel() {
#ifdef __AVX512DQ__
  const bool can = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
  return can ? move_points : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace lidar_mapping::preprocessing
