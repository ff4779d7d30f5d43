// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping {

/// Instructions that a kernel may be compiled for a second time; cmake/LidarMappingKernels.cmake
/// has the compiler's flags for each.
enum class InstructionSet {
  kAvx2,    ///< AVX2 and FMA
  kAvx512,  ///< AVX-512 F, BW, DQ and VL, and FMA, on a processor that does not slow down with them
};

/// Whether the processor that runs this program has all instructions of the set and is fast with
/// them. False on processors other than x86.
bool processor_has(InstructionSet set);

}  // namespace lidar_mapping
