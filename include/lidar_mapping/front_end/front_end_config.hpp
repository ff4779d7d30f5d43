// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/config/schema.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::front_end {

/// Where the motion comes from.
enum class OdometrySource {
  kLidar,    ///< scan matching
  kExternal  ///< MotionPrior::T_external_base
};
/// The target that NDT matches against.
enum class LocalMapMethod {
  kVoxels,        ///< voxels that are never rebuilt
  kSlidingWindow  ///< the clouds of the last key frames
};

/// Parameters of the stage; each is described once, in schema().
struct FrontEndConfig {
  /// Where the motion comes from: scan matching, or an odometry from outside.
  OdometrySource odometry = OdometrySource::kLidar;
  /// [m and rad: x y z roll pitch yaw] Pose of base_link at the first scan; zeros: what GNSS and
  /// IMU say, or else the origin.
  std::vector<double> initial_pose = std::vector<double>(6, 0.0);
  /// Method of scan matching, and its parameters.
  registration::RegistrationConfig registration;

  /// [m] A key frame is made after this distance, Euclidean.
  double key_frame_distance = 2.0;
  /// [rad] A key frame is made after this rotation; above pi never because of rotation.
  double key_frame_angle = 0.5;
  /// [s] A key frame is made after this time, also at rest; 0 switches it off.
  double key_frame_interval = 0.0;
  /// [m] Edge of the voxels that thin out the clouds of key frames; 0 keeps all points.
  double key_frame_cloud_resolution = 0.1;

  /// What NDT matches against: voxels that are never rebuilt, or the clouds of the last
  /// local_frame_num key frames, as all other methods do.
  LocalMapMethod local_map_method = LocalMapMethod::kVoxels;
  // The sequential NDT.
  /// [m] Edge of the voxels of the NDT's local map.
  double voxel_size = 1.0;
  /// [m] What is farther away leaves the NDT's local map.
  double local_map_radius = 110.0;
  /// [m] Points farther away are not used for odometry.
  double max_range = 100.0;
  /// [m] One point per cube of this edge is matched.
  double scan_resolution = 0.8;
  /// [m] One point per cube of this edge is put into the NDT's local map.
  double insertion_resolution = 0.4;
  /// [m/s^2] Standard deviation of the acceleration between scans.
  double acceleration_sigma = 10.0;
  /// [rad/s^2] Standard deviation of the angular acceleration between scans.
  double angular_acceleration_sigma = 5.0;
  /// [m/s] A faster motion is taken for a failed match.
  double max_speed = 50.0;
  /// [s] After being lost for this long a new local map and a new segment are begun.
  double max_lost_time = 3.0;
  /// Find out whether all elevations of the sensor are off by the same angle, and turn its points
  /// by that once it is sure.
  bool calibrate_elevation = true;
  /// Find out whether points without times were motion-compensated before, and whether times have
  /// the right sign, and correct the times if not.
  bool check_point_times = true;

  // The sliding window of the other methods.
  /// [key frames] Size of the sliding window: of NDT with local_map_method: sliding_window, and of
  /// all other methods.
  int local_frame_num = 20;
  /// [m] Edge of the voxels that thin out a scan for the sliding window; 0 keeps all points.
  double frame_filter_resolution = 1.3;
  /// [m] Edge of the voxels that thin out the sliding window's cloud; 0 keeps all points.
  double local_map_filter_resolution = 0.6;

  /// Upper limit of threads; 0 takes all cores. The result does not depend on it.
  int threads = 1;

  /// All fields, and checks between them.
  static const config::Schema<FrontEndConfig>& schema();
};

}  // namespace lidar_mapping::front_end
