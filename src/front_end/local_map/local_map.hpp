// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"

#include "matching/ndt_types.hpp"
#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// Transforms each point to where it was measured, relative to `origin`: R p(s) + t. The times of
/// `transformed_points` are not set.
void transform_points(const SampledPoints& points, const MotionState& state,
                      const Eigen::Vector3d& origin, SampledPoints& transformed_points);

/// The surroundings of the sensor: a fine voxel map for matching and a coarse one for finding the
/// pose again.
class LocalMap {
 public:
  LocalMap(double voxel_size, double radius);

  /// Clears the map and uses voxels of this edge length (m).
  void restart(double voxel_size);
  void clear();
  /// See GaussianVoxelMap. Only the fine map uses it, because only the fine map is matched to the
  /// millimetre.
  void set_ring_spacing(double angle) { fine_.set_ring_spacing(angle); }
  /// Number of points of the scans that follow, as a fraction of a full scan, from 0 to 1.
  void set_scan_density(double density) { scan_density_ = density; }
  double scan_density() const { return scan_density_; }
  bool empty() const { return fine_.size() == 0; }
  /// Inserts points at the sensor's pose at the time of measurement.
  void insert(const SampledPoints& points, const MotionState& state);
  /// To be called once per scan: keeps the origin near the sensor and removes what is far away.
  void set_center(const Eigen::Vector3d& position);

  /// Number of points, over all insertions, that were not inserted because a table was full.
  std::size_t dropped_points() const { return dropped_points_; }
  GaussianVoxelMap& fine() { return fine_; }
  GaussianVoxelMap& coarse() { return coarse_; }
  /// One point per voxel of the fine map, in odom.
  PointCloud cloud() const;

 private:
  void move_origin(const Eigen::Vector3d& position);

  double radius_;
  double scan_density_ = 1.0;
  GaussianVoxelMap fine_;
  GaussianVoxelMap coarse_;
  SampledPoints transformed_points_;
  std::size_t dropped_points_ = 0;
};

}  // namespace lidar_mapping::front_end
