// SPDX-License-Identifier: BSD-3-Clause
// The kernels of ndt_kernels.hpp; included by one file per instruction set.
// Eight lanes as the compiler's vectors: on plain x86-64 each becomes two SSE registers.

#include <cstring>

#include "ndt/ndt_kernels.hpp"

namespace lidar_mapping::registration {
namespace {

using Floats = float __attribute__((vector_size(kNdtLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kNdtLanes * sizeof(std::int32_t))));

#define LIDAR_MAPPING_INLINE inline __attribute__((always_inline))

LIDAR_MAPPING_INLINE void load(const float* from, Floats& to) {
  std::memcpy(&to, from, sizeof(to));
}
LIDAR_MAPPING_INLINE void store(const Floats& from, float* to) {
  std::memcpy(to, &from, sizeof(from));
}

/// floor(u), with u held within [-limit, limit].
LIDAR_MAPPING_INLINE void to_cell(Floats u, int limit, Ints& cell) {
  const Floats bound = Floats{} + static_cast<float>(limit);
  u = u < bound ? u : bound;
  u = u > -bound ? u : -bound;
  const Ints truncated = __builtin_convertvector(u, Ints);
  // A true comparison is -1 in all bits.
  cell = truncated + (__builtin_convertvector(truncated, Floats) > u);
}

void locate(const SweepMotion& motion, float inverse_resolution, const SweepArrays& points,
            std::size_t count, float* qx, float* qy, float* qz, std::int32_t* cells) {
  const float* R = motion.rotation;
  const float* t = motion.translation;
  const float* v = motion.velocity;
  const float* w = motion.angular_velocity;
  for (std::size_t i = 0; i < count; i += kNdtLanes) {
    Floats x, y, z, s;
    load(points.x + i, x);
    load(points.y + i, y);
    load(points.z + i, z);
    load(points.s + i, s);
    const Floats ax = v[0] + (w[1] * z - w[2] * y);
    const Floats ay = v[1] + (w[2] * x - w[0] * z);
    const Floats az = v[2] + (w[0] * y - w[1] * x);
    const Floats h = 0.5F * s;
    x += s * (ax + h * (w[1] * az - w[2] * ay));
    y += s * (ay + h * (w[2] * ax - w[0] * az));
    z += s * (az + h * (w[0] * ay - w[1] * ax));
    const Floats rx = R[0] * x + R[1] * y + R[2] * z;
    const Floats ry = R[3] * x + R[4] * y + R[5] * z;
    const Floats rz = R[6] * x + R[7] * y + R[8] * z;
    store(rx, qx + i);
    store(ry, qy + i);
    store(rz, qz + i);
    Ints cx, cy, cz;
    to_cell((rx + t[0]) * inverse_resolution, kMaxCellXY, cx);
    to_cell((ry + t[1]) * inverse_resolution, kMaxCellXY, cy);
    to_cell((rz + t[2]) * inverse_resolution, kMaxCellZ, cz);
    const Ints packed =
        ((cx + kCellOffsetXY) << 21) | ((cy + kCellOffsetXY) << 10) | (cz + kCellOffsetZ);
    std::memcpy(cells + i, &packed, sizeof(packed));
  }
}

LIDAR_MAPPING_INLINE float sum_of_lanes(const Floats& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

void accumulate(const float* qx, const float* qy, const float* qz, const float* const planes[4],
                const float t[3], float kernel_squared, std::size_t count, NdtSums* sums) {
  Floats hessian[21] = {};
  Floats gradient[6] = {};
  Floats weights = {}, paired = {}, inliers = {}, residuals = {}, squared = {};
  const Floats one = Floats{} + 1.0F;
  const Floats none = {};
  for (std::size_t i = 0; i < count; i += kNdtLanes) {
    Floats x, y, z, nx, ny, nz, d;
    load(qx + i, x);
    load(qy + i, y);
    load(qz + i, z);
    load(planes[0] + i, nx);
    load(planes[1] + i, ny);
    load(planes[2] + i, nz);
    load(planes[3] + i, d);
    const Floats J[6] = {nx, ny, nz, y * nz - z * ny, z * nx - x * nz, x * ny - y * nx};
    const Floats r = nx * (x + t[0]) + ny * (y + t[1]) + nz * (z + t[2]) - d;
    const Floats length = nx * nx + ny * ny + nz * nz;
    const Ints has_plane = length > none;
    // Geman-McClure.
    const Floats g = kernel_squared / (kernel_squared + r * r);
    const Floats weight = has_plane ? g * g : none;
    const Ints believed = weight > 0.25F;
    int k = 0;
    for (int a = 0; a < 6; ++a) {
      const Floats weighted = weight * J[a];
      gradient[a] += weighted * r;
      for (int b = a; b < 6; ++b) hessian[k++] += weighted * J[b];
    }
    weights += weight;
    paired += has_plane ? one : none;
    inliers += believed ? one : none;
    residuals += weight * r * r;
    squared += believed ? r * r / length : none;
  }
  for (int k = 0; k < 21; ++k) sums->hessian[k] = sum_of_lanes(hessian[k]);
  for (int a = 0; a < 6; ++a) sums->gradient[a] = sum_of_lanes(gradient[a]);
  sums->weight = sum_of_lanes(weights);
  sums->paired = sum_of_lanes(paired);
  sums->inliers = sum_of_lanes(inliers);
  sums->squared_residual = sum_of_lanes(residuals);
  sums->squared_distance = sum_of_lanes(squared);
}

#undef LIDAR_MAPPING_INLINE

}  // namespace
}  // namespace lidar_mapping::registration
