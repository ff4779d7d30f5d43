// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/registration/gaussian_voxel_map.hpp"

namespace lidar_mapping::localization {

/// Farthest points that are used, of the map and of scans, m. Chosen: beyond it, rings lie so far
/// apart that voxels are lines, and the memory of the map would double.
constexpr float kMaxRange = 80.0F;

/// The surfaces of a whole map as Gaussians in voxels: fine ones for matching, and coarse ones that
/// attract from further away.
class MapSurfaces {
 public:
  /// Room for so many voxels.
  explicit MapSurfaces(std::size_t capacity);

  /// Adds a cloud in base_link, measured from `p_base_lidar` (m).
  void insert(const PointCloud& cloud, const Pose& T_map_base, const Eigen::Vector3d& p_base_lidar);
  /// The room was too small: some points are missing.
  bool is_overfull() const { return fine_.dropped_points() + coarse_.dropped_points() > 0; }

  /// Moves the origins near to a position (m), so that floats around it are exact.
  void set_center(const Eigen::Vector3d& position);
  registration::GaussianVoxelMap& fine() { return fine_; }
  registration::GaussianVoxelMap& coarse() { return coarse_; }
  const registration::GaussianVoxelMap& fine() const { return fine_; }
  /// Memory of the tables, bytes.
  std::size_t bytes() const { return bytes_; }

 private:
  std::size_t bytes_;
  registration::GaussianVoxelMap fine_;
  registration::GaussianVoxelMap coarse_;
};

}  // namespace lidar_mapping::localization
