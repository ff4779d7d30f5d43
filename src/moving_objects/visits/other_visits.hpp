// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <unordered_map>
#include <vector>

#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/moving_objects/visits.hpp"

namespace lidar_mapping::moving_objects {

/// Which key frames of other visits look at the surroundings of a key frame.
class OtherVisits {
 public:
  using Position = std::size_t;  ///< place of a key frame in the list of poses

  /// Key frames further away than this are not asked, m. Chosen: their votes reach 40 m, so points
  /// up to 90 m away are judged.
  static constexpr double kRadius = 50.0;
  /// Least distance of two observers of the same visit, m. Chosen: two of them see any location
  /// within their range from directions that differ, and twenty visits stay affordable.
  static constexpr double kSpacing = 2.0;

  OtherVisits(const std::vector<KeyFramePose>& poses, const Visits& visits);

  /// For each other visit that passed by, its observers, the nearest first.
  std::map<std::uint32_t, std::vector<Position>> near(Position position) const;

 private:
  VoxelKey cell_of(Position position) const;
  /// The key frames of other visits within the radius, by visit and distance.
  std::map<std::uint32_t, std::vector<Position>> candidates(Position position) const;

  std::vector<Eigen::Vector3d> places_;  ///< of the key frames in the map frame, m
  std::vector<std::uint32_t> visits_;
  std::unordered_map<VoxelKey, std::vector<Position>, VoxelKeyHash> cells_;
};

}  // namespace lidar_mapping::moving_objects
