// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::preprocessing {

/// Parameters of the stage; each is described once, in schema().
struct FloorDetectionConfig {
  /// [rad] Rotation of the clouds about y that makes the floor level.
  double tilt = 0.0;
  /// [m] Height above the floor of the origin of base_link, in which the clouds are.
  double sensor_height = 0.0;
  /// [m] Points this much above and below the expected floor are looked at.
  double height_clip_range = 1.0;
  /// [m] Points this near are looked at: farther off the ground is another plane.
  double floor_radius = 20.0;
  /// [points] Least number of points on the plane, of the strip that the vehicle drives on.
  int floor_pts_thresh = 200;
  /// [rad] A floor leans at most this much.
  double floor_normal_thresh = 10.0 * kRadPerDeg;
  /// [m] Points this near to a plane belong to it (RANSAC).
  double floor_distance_thresh = 0.1;
  /// Leave out places whose own surface is not level.
  bool use_normal_filtering = true;
  /// [rad] Places leaning more are no floor.
  double normal_filter_thresh = 20.0 * kRadPerDeg;

  /// All fields.
  static const config::Schema<FloorDetectionConfig>& schema();
};

}  // namespace lidar_mapping::preprocessing
