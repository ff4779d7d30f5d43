// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/vertical_structure_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Edge length of the vertical columns, and height above the lowest point of a column from which on
/// a point belongs to a vertical structure (m). Chosen: slopes of up to one half have no such
/// points.
constexpr float kColumnEdge = 1.0F;
constexpr float kMinHeightAboveLowest = 0.5F;
/// Edge length of the voxels, m. Chosen: that of kKernelWidth, so that neighbours hold all pairs.
constexpr float kVoxelEdge = 0.3F;
/// Distance at which a pair loses most of its weight, and within which a point counts as matched,
/// m. Chosen: twice the standard deviation of a point on a trunk or a leaf (15 cm).
constexpr float kKernelWidth = 0.3F;
/// Two million bits of the filter, 256 kB. Chosen: few of them are set, so that few voxels without
/// points are looked up.
constexpr int kFilterBits = 21;
constexpr int kIterations = 10;  // chosen: bounds the time
/// The iteration ends with a smaller step than this (m, rad). Chosen: far below kKernelWidth.
constexpr double kConverged = 1e-3;
/// Number of directions. In each direction at most this number of points counts, or this fraction
/// of all points. Chosen: a single object beside the sensor, which fills some 10 degrees, must not
/// outweigh all others; where points are even, each direction has half of the fraction.
constexpr int kDirections = 36;
constexpr int kMinPointsPerDirection = 4;
constexpr int kDirectionDivisor = 18;
/// Weight of the prior at the start pose, in units of the squared standard deviation of a point (15
/// cm). Chosen: it corresponds to half a metre and two degrees.
constexpr double kPriorPositionWeight = 0.1;
constexpr double kPriorAngleWeight = 20.0;

VoxelKey key_at(const Eigen::Vector3f& p, float edge) { return voxel_key(voxel_index(p / edge)); }

std::size_t bit_of(VoxelKey key) { return fibonacci_hash(key) >> (64 - kFilterBits); }

int direction_of(const Eigen::Vector3f& p) {
  const double turns = std::atan2(p.y(), p.x()) / (2.0 * kPi) + 0.5;
  return std::min(kDirections - 1, static_cast<int>(turns * kDirections));
}

}  // namespace

std::vector<Eigen::Vector3f> vertical_structure_points(const SampledPoints& points) {
  const auto column_of = [&](std::size_t i) {
    return key_at({points.x[i], points.y[i], 0.0F}, kColumnEdge);
  };
  std::unordered_map<VoxelKey, float, VoxelKeyHash> lowest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [column, is_new] = lowest.try_emplace(column_of(i), points.z[i]);
    if (!is_new) column->second = std::min(column->second, points.z[i]);
  }
  std::vector<Eigen::Vector3f> vertical;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.z[i] < lowest[column_of(i)] + kMinHeightAboveLowest) continue;
    vertical.emplace_back(points.x[i], points.y[i], points.z[i]);
  }
  return vertical;
}

void VoxelKeyFilter::insert(VoxelKey key) {
  bits_.resize(std::size_t{1} << kFilterBits);
  bits_[bit_of(key)] = true;
}

bool VoxelKeyFilter::may_contain(VoxelKey key) const {
  return !bits_.empty() && bits_[bit_of(key)];
}

void VerticalStructureMap::insert(const std::vector<Eigen::Vector3f>& points,
                                  const Pose& T_map_sensor) {
  const Eigen::Isometry3f T(T_map_sensor.matrix().cast<float>());
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3f p = T * point;
    const VoxelKey key = key_at(p, kVoxelEdge);
    Cell& cell = cells_[key];
    cell.sum += p;
    if (cell.count++ > 0) continue;
    occupied_.insert(key);
    for_voxels_around(key, [&](VoxelKey near) { occupied_or_adjacent_.insert(near); });
  }
}

bool VerticalStructureMap::nearest(const Eigen::Vector3f& p, Eigen::Vector3f& mean) const {
  const VoxelKey own_key = key_at(p, kVoxelEdge);
  if (!occupied_or_adjacent_.may_contain(own_key)) return false;
  float nearest_squared = std::numeric_limits<float>::max();
  for_voxels_around(own_key, [&](VoxelKey key) {
    if (!occupied_.may_contain(key)) return;
    const auto found = cells_.find(key);
    if (found == cells_.end()) return;
    const Eigen::Vector3f m = found->second.sum / static_cast<float>(found->second.count);
    const float distance = (m - p).squaredNorm();
    if (distance >= nearest_squared) return;
    nearest_squared = distance;
    mean = m;
  });
  return nearest_squared < std::numeric_limits<float>::max();
}

std::size_t VerticalStructureMap::count_near(const std::vector<Eigen::Vector3f>& points,
                                             const Pose& T_map_sensor) const {
  const Eigen::Isometry3f T(T_map_sensor.matrix().cast<float>());
  std::size_t count = 0;
  for (const Eigen::Vector3f& p : points) {
    count += occupied_or_adjacent_.may_contain(key_at(T * p, kVoxelEdge)) ? 1U : 0U;
  }
  return count;
}

VerticalStructureMap::Fit VerticalStructureMap::evaluate(const std::vector<Eigen::Vector3f>& points,
                                                         const Pose& T_map_sensor) const {
  const Eigen::Isometry3f T(T_map_sensor.matrix().cast<float>());
  Fit fit;
  fit.T_map_sensor = T_map_sensor;
  std::array<int, kDirections> matched_per_direction{};
  Eigen::Vector3f mean;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3f p = T * point;
    if (!nearest(p, mean) || (p - mean).norm() > kKernelWidth) continue;
    ++fit.matched_points;
    ++matched_per_direction[direction_of(point)];
  }
  const int limit =
      std::max(kMinPointsPerDirection, static_cast<int>(points.size()) / kDirectionDivisor);
  for (const int count : matched_per_direction) {
    fit.evidence += std::min(count, limit);
    fit.directions += count > 0 ? 1 : 0;
  }
  return fit;
}

VerticalStructureMap::Fit VerticalStructureMap::fit(const std::vector<Eigen::Vector3f>& points,
                                                    const Pose& start) const {
  Pose pose = start;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::Matrix3f R = pose.rotation_matrix().cast<float>();
    const Eigen::Vector3f t = pose.translation.cast<float>();
    const Vector6d offset = difference(start, pose);
    const Eigen::Vector3d prior_weight(kPriorPositionWeight, kPriorPositionWeight,
                                       kPriorAngleWeight);
    Eigen::Matrix3d H = prior_weight.asDiagonal();
    Eigen::Vector3d b = prior_weight.cwiseProduct(Eigen::Vector3d(offset[0], offset[1], offset[5]));
    Eigen::Vector3f mean;
    for (const Eigen::Vector3f& p : points) {
      if (!nearest(R * p + t, mean)) continue;
      const Eigen::Vector3f r = p - R.transpose() * (mean - t);
      const float g = 1.0F / (1.0F + r.squaredNorm() / (kKernelWidth * kKernelWidth));
      Eigen::Matrix3f J = Eigen::Matrix3f::Zero();
      J.col(0) = Eigen::Vector3f::UnitX();
      J.col(1) = Eigen::Vector3f::UnitY();
      J.col(2) = Eigen::Vector3f(-p.y(), p.x(), 0.0F);
      H += (g * g * J.transpose() * J).cast<double>();
      b += (g * g * J.transpose() * r).cast<double>();
    }
    const Eigen::Vector3d d = -H.ldlt().solve(b);
    Vector6d step = Vector6d::Zero();
    step << d[0], d[1], 0.0, 0.0, 0.0, d[2];
    pose = perturbed(pose, step);
    if (d.norm() < kConverged) break;
  }
  return evaluate(points, pose);
}

}  // namespace lidar_mapping::front_end
