#pragma once

#include "lidar_mapping/config/schema.hpp"

namespace lidar_mapping::preprocessing {

/// Parameters of the stage; each is described once, in schema().
struct FloorDetectionConfig {
  double tilt_deg = 0.0;
  double sensor_height = 0.0;
  double height_clip_range = 1.0;
  double floor_radius = 20.0;
  int floor_pts_thresh = 200;
  double floor_normal_thresh = 10.0;
  double floor_distance_thresh = 0.1;
  bool use_normal_filtering = true;
  double normal_filter_thresh = 20.0;

  static const config::Schema<FloorDetectionConfig>& schema();
};

}  // namespace lidar_mapping::preprocessing
