// SPDX-License-Identifier: BSD-3-Clause
#include "ndt/ndt_parts.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::registration {
namespace {

constexpr std::uint8_t kNoPart = kNdtParts;

Matrix6d full(const float (&upper)[21]) {
  Matrix6d matrix;
  int k = 0;
  for (int a = 0; a < 6; ++a) {
    for (int b = a; b < 6; ++b) matrix(a, b) = matrix(b, a) = upper[k++];
  }
  return matrix;
}

/// One of eight of equal angle.
std::uint8_t sector_of(float x, float y) {
  const int south = y < 0.0F ? 1 : 0;
  const int west = x < 0.0F ? 1 : 0;
  const int steep = std::abs(y) > std::abs(x) ? 1 : 0;
  // Counted around: odd quadrants go through the steep half first.
  const int quadrant = 2 * south + (south ^ west);
  return static_cast<std::uint8_t>(2 * quadrant + (steep ^ (quadrant & 1)));
}

}  // namespace

NdtPart part_of(const NdtSums& sums, const Eigen::Matrix3d& R_map_sensor) {
  Matrix6d to_map_axes = Matrix6d::Zero();
  to_map_axes.topLeftCorner<3, 3>() = R_map_sensor;
  to_map_axes.bottomRightCorner<3, 3>() = R_map_sensor;
  return {to_map_axes.transpose() * full(sums.hessian) * to_map_axes,
          to_map_axes.transpose() *
              Eigen::Map<const Eigen::Matrix<float, 6, 1>>(sums.gradient).cast<double>()};
}

std::vector<NdtPart> NdtParts::of(const NdtPoints& points, const RotatedPoints& rotated,
                                  const PlaneArrays& planes, float kernel_squared,
                                  const Eigen::Matrix3d& R_map_sensor) {
  assign_parts(points, planes);
  sort(rotated, planes);
  std::vector<NdtPart> parts;
  for (std::size_t part = 0; part < kNdtParts; ++part) {
    const std::size_t i = begin_[part];
    const float* const arrays[4] = {&sorted_[3][i], &sorted_[4][i], &sorted_[5][i], &sorted_[6][i]};
    NdtSums sums{};
    ndt_kernels().accumulate(&sorted_[0][i], &sorted_[1][i], &sorted_[2][i], arrays,
                             rotated.translation.data(), kernel_squared, begin_[part + 1] - i,
                             &sums);
    parts.push_back(part_of(sums, R_map_sensor));
  }
  return parts;
}

void NdtParts::assign_parts(const NdtPoints& points, const PlaneArrays& planes) {
  const std::size_t size = points.padded_size();
  const Eigen::Vector3f origin = points.viewpoint().value_or(Eigen::Vector3f::Zero());
  part_.assign(size, kNoPart);
  double sum = 0.0;
  std::size_t count = 0;
  const auto squared_range = [&](std::size_t i) {
    const float x = points.x()[i] - origin.x();
    const float y = points.y()[i] - origin.y();
    return x * x + y * y;
  };
  for (std::size_t i = 0; i < size; ++i) {
    if (planes.x[i] == 0.0F && planes.y[i] == 0.0F && planes.z[i] == 0.0F) continue;
    part_[i] = sector_of(points.x()[i] - origin.x(), points.y()[i] - origin.y());
    sum += std::sqrt(squared_range(i));
    ++count;
  }
  const double mean = sum / static_cast<double>(std::max<std::size_t>(1, count));
  const auto limit = static_cast<float>(mean * mean);
  for (std::size_t i = 0; i < size; ++i) {
    if (part_[i] != kNoPart && squared_range(i) > limit) part_[i] += kNdtSectors;
  }
}

void NdtParts::sort(const RotatedPoints& rotated, const PlaneArrays& planes) {
  std::array<std::size_t, kNdtParts + 1> counts{};
  for (const std::uint8_t part : part_) ++counts[part];
  begin_[0] = 0;
  for (std::size_t part = 0; part < kNdtParts; ++part) {
    begin_[part + 1] = begin_[part] + (counts[part] + kNdtLanes - 1) / kNdtLanes * kNdtLanes;
  }
  for (auto& array : sorted_) array.assign(begin_[kNdtParts] + 1, 0.0F);
  const std::array<const float*, kArrays> from = {
      rotated.x.data(), rotated.y.data(), rotated.z.data(),    planes.x.data(),
      planes.y.data(),  planes.z.data(),  planes.offset.data()};
  auto next = begin_;
  for (std::size_t i = 0; i < part_.size(); ++i) {
    if (part_[i] == kNoPart) continue;
    const std::size_t to = next[part_[i]]++;
    for (std::size_t array = 0; array < kArrays; ++array) sorted_[array][to] = from[array][i];
  }
}

}  // namespace lidar_mapping::registration
