// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidar_mapping::front_end {

/// Rule for the hash of a point, which is equal for all points of its cube: cubes of edge 1 /
/// inverse_resolution, hashed to 32 - shift bits. Points that are not finite or out of range get
/// `rejected`.
struct HashRule {
  float inverse_resolution;
  float min_range_squared;
  float max_range_squared;
  std::uint32_t shift;
  std::uint32_t rejected;
};

/// Hashes of `count` points of four floats, the k-th at points + 4 * stride * k.
using HashKernel = void (*)(const float* points, std::size_t stride, std::size_t count,
                            const HashRule& rule, std::uint32_t* hashes);

/// The fastest kernel that this processor can run; all kernels give the same hashes.
HashKernel hash_kernel();
HashKernel portable_hash_kernel();
/// Null if the compiler or the processor does not support AVX2.
HashKernel avx2_hash_kernel();

}  // namespace lidar_mapping::front_end
