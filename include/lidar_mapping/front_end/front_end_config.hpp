#pragma once

#include <vector>

#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::front_end {

enum class OdometrySource { kLidar, kExternal };
/// What NDT matches against.
enum class LocalMapMethod { kVoxels, kSlidingWindow };

/// Parameters of the stage; each is described once, in schema().
struct FrontEndConfig {
  OdometrySource odometry = OdometrySource::kLidar;
  /// x, y, z in m; roll, pitch, yaw in rad; zeros: not given.
  std::vector<double> initial_pose = std::vector<double>(6, 0.0);
  registration::RegistrationConfig registration;

  double key_frame_distance = 2.0;
  double key_frame_angle = 0.5;
  double key_frame_interval = 0.0;
  double key_frame_cloud_resolution = 0.1;

  LocalMapMethod local_map_method = LocalMapMethod::kVoxels;
  // The sequential NDT.
  double voxel_size = 1.0;
  double local_map_radius = 110.0;
  double max_range = 100.0;
  double scan_resolution = 0.8;
  double insertion_resolution = 0.4;
  double acceleration_sigma = 10.0;
  double angular_acceleration_sigma = 5.0;
  double max_speed = 50.0;
  double max_lost_time = 3.0;
  bool calibrate_elevation = true;

  // The sliding window of the other methods.
  int local_frame_num = 20;
  double frame_filter_resolution = 1.3;
  double local_map_filter_resolution = 0.6;

  int threads = 1;

  static const config::Schema<FrontEndConfig>& schema();
};

}  // namespace lidar_mapping::front_end
