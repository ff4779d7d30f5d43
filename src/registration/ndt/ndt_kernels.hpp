// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidar_mapping::registration {

/// Arrays given to the kernels hold a multiple of this number of elements: the floats of a register
/// of 256 bits (AVX2).
constexpr std::size_t kNdtLanes = 8;

/// Motion of the sensor during a sweep: p_map = R p(s) + t, p(s) = exp(s twist) p, row-major R.
struct SweepMotion {
  float rotation[9];
  float translation[3];
  float velocity[3];
  float angular_velocity[3];
};

/// Points in the sensor's frame and their seconds after the reference time.
struct SweepArrays {
  const float* x;
  const float* y;
  const float* z;
  const float* s;
};

/// What accumulate() adds up over the points of one time slice.
struct NdtSums {
  float hessian[21];  ///< upper triangle, row by row: translation, rotation; axes of the map
  float gradient[6];
  float weight;            ///< sum of the robust weights
  float paired;            ///< points with a plane
  float inliers;           ///< points that the robust kernel believes
  float squared_residual;  ///< of all, weighted
  float squared_distance;  ///< of the inliers to their planes, m^2
};

/// The inner loops of the NDT, compiled once for every processor and once for AVX2. Both do the
/// same operations in the same order and give the same bits.
struct NdtKernels {
  /// Rotated points q = R p(s) and the packed cells of q + t. Cells are packed by pack_cell().
  void (*locate)(const SweepMotion& motion, float inverse_resolution, const SweepArrays& points,
                 std::size_t count, float* qx, float* qy, float* qz, std::int32_t* cells);
  /// Adds up the normal equations of r = normal . (q + t) - offset over count points.
  /// planes: normal x, y, z and offset, four arrays.
  void (*accumulate)(const float* qx, const float* qy, const float* qz,
                     const float* const planes[4], const float translation[3], float kernel_squared,
                     std::size_t count, NdtSums* sums);
};

/// The fastest kernels that this processor can run.
const NdtKernels& ndt_kernels();
const NdtKernels& portable_ndt_kernels();
/// Null where the compiler or the processor knows no AVX2.
const NdtKernels* avx2_ndt_kernels();

/// Cells are packed into 32 bits, chosen so that a key is one word. By this layout x and y have 11
/// bits, z has 10, each plus its offset. Points beyond the largest cell are put into it, so no cell
/// packs to -1.
constexpr int kCellOffsetXY = 1024;
constexpr int kCellOffsetZ = 512;
constexpr int kMaxCellXY = 1022;
constexpr int kMaxCellZ = 510;

}  // namespace lidar_mapping::registration
