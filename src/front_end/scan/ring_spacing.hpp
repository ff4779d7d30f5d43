// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::front_end {

/// Angle between neighbouring rings of a spinning sensor, rad, as found from its own scan. It is 0
/// if the rings cannot be separated: a sensor with many beams, a cloud that was thinned out, or a
/// sensor that does not spin about the z axis of the cloud's frame. The points were measured from
/// `p_base_sensor` (m, in the cloud's frame).
double ring_spacing(const PointCloud& cloud, const Eigen::Vector3d& p_base_sensor);

/// The ring spacing that a map has to use, see GaussianVoxelMap. It is none in open fields: there
/// the planes do not observe a direction, and the planes of leaves are needed unchanged.
class RingSpacingGate {
 public:
  explicit RingSpacingGate(double spacing = 0.0) : spacing_(spacing) {}
  /// To be called where the planes did not observe a direction.
  void mark_open_field(const Pose& T_map_sensor) { open_field_ = T_map_sensor.translation; }
  /// The spacing, rad; 0 for none.
  double spacing_at(const Pose& T_map_sensor) const;

 private:
  double spacing_;
  std::optional<Eigen::Vector3d> open_field_;  ///< m, the last place without an observed direction
};

}  // namespace lidar_mapping::front_end
