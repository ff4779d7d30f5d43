// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/instruction_set.hpp"

namespace lidar_mapping {

#if defined(__x86_64__) || defined(__i386__)

namespace {

bool has_avx2() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }

bool has_avx512() {
  // The first processors with AVX-512 slow down when it is used; they have no AVX-512 VBMI.
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512vbmi");
}

}  // namespace

bool processor_has(InstructionSet set) {
  return set == InstructionSet::kAvx512 ? has_avx512() : has_avx2();
}

#else

bool processor_has(InstructionSet) { return false; }

#endif

}  // namespace lidar_mapping
