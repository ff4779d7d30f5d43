// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Angle between neighbouring rings of a spinning sensor, rad, as its own scan shows it; 0 where no
/// rings can be told apart: many beams, a cloud thinned out, a sensor that does not spin about the
/// z axis of the cloud's frame. Points were seen from `p_base_sensor` (m, the cloud's frame).
double ring_spacing(const PointCloud& cloud, const Eigen::Vector3d& p_base_sensor);

/// The spacing that a map is to heed, see GaussianVoxelMap: none in open fields, where planes leave
/// a direction open and those of leaves are needed as they are.
class RingSpacingGate {
 public:
  explicit RingSpacingGate(double spacing = 0.0) : spacing_(spacing) {}
  /// The planes left a direction open there.
  void mark_open_field(const Pose& T_map_sensor) { open_field_ = T_map_sensor.translation; }
  /// rad; 0 for none.
  double spacing_at(const Pose& T_map_sensor) const;

 private:
  double spacing_;
  std::optional<Eigen::Vector3d> open_field_;  ///< m, where last
};

}  // namespace lidar_mapping::front_end
