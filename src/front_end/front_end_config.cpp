// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/front_end_config.hpp"

namespace lidar_mapping::front_end {
namespace {

using Config = FrontEndConfig;

void describe_key_frames(config::Schema<Config>& schema) {
  schema
      .real("key_frame_distance", &Config::key_frame_distance, {0.01, 1000.0}, "m",
            "A key frame is made after this distance, Euclidean.")
      .real("key_frame_angle", &Config::key_frame_angle, {0.01, 10.0}, "rad",
            "A key frame is made after this rotation; above pi never because of rotation.")
      .real("key_frame_interval", &Config::key_frame_interval, {0.0, 1e6}, "s",
            "A key frame is made after this time, also at rest; 0 switches it off.")
      .real("key_frame_cloud_resolution", &Config::key_frame_cloud_resolution, {0.0, 10.0}, "m",
            "Edge of the voxels that thin out the clouds of key frames; 0 keeps all points.");
}

void describe_sequential_ndt(config::Schema<Config>& schema) {
  schema
      .choice(
          "local_map_method", &Config::local_map_method,
          {{"voxels", LocalMapMethod::kVoxels}, {"sliding_window", LocalMapMethod::kSlidingWindow}},
          "What NDT matches against: voxels that are never rebuilt, or the clouds of the last "
          "local_frame_num key frames, as all other methods do.")
      .real("voxel_size", &Config::voxel_size, {0.2, 10.0}, "m",
            "Edge of the voxels of the NDT's local map.")
      .real("local_map_radius", &Config::local_map_radius, {5.0, 400.0}, "m",
            "What is farther away leaves the NDT's local map.")
      .real("max_range", &Config::max_range, {1.0, 400.0}, "m",
            "Points farther away are not used for odometry.")
      .real("scan_resolution", &Config::scan_resolution, {0.05, 10.0}, "m",
            "One point per cube of this edge is matched.")
      .real("insertion_resolution", &Config::insertion_resolution, {0.02, 10.0}, "m",
            "One point per cube of this edge is put into the NDT's local map.")
      .real("acceleration_sigma", &Config::acceleration_sigma, {0.01, 1000.0}, "m/s^2",
            "Standard deviation of the acceleration between scans.")
      .real("angular_acceleration_sigma", &Config::angular_acceleration_sigma, {0.01, 1000.0},
            "rad/s^2", "Standard deviation of the angular acceleration between scans.")
      .real("max_speed", &Config::max_speed, {0.1, 1000.0}, "m/s",
            "A faster motion is taken for a failed match.")
      .real("max_lost_time", &Config::max_lost_time, {0.0, 60.0}, "s",
            "After being lost for this long a new local map and a new segment are begun.")
      .boolean("calibrate_elevation", &Config::calibrate_elevation,
               "Find out whether all elevations of the sensor are off by the same angle, and turn "
               "its points by that once it is sure.")
      .boolean("check_point_times", &Config::check_point_times,
               "Find out whether points without times were motion-compensated before, and whether "
               "times have the right sign, and correct the times if not.");
}

config::Schema<Config> make_schema() {
  config::Schema<Config> schema("front_end", "Odometry of the LiDAR, and the choice of key frames");
  schema
      .choice("odometry", &Config::odometry,
              {{"lidar", OdometrySource::kLidar}, {"external", OdometrySource::kExternal}},
              "Where the motion comes from: scan matching, or an odometry from outside.")
      .reals(
          "initial_pose", &Config::initial_pose, 6, "m and rad: x y z roll pitch yaw",
          "Pose of base_link at the first scan; zeros: what GNSS and IMU say, or else the origin.")
      .include(&Config::registration, registration::RegistrationConfig::schema());
  describe_key_frames(schema);
  schema.alias("keyframe_delta_trans", "key_frame_distance")
      .alias("keyframe_delta_angle", "key_frame_angle")
      .alias("keyframe_delta_time", "key_frame_interval");
  describe_sequential_ndt(schema);
  schema
      .integer("local_frame_num", &Config::local_frame_num, {1, 1000}, "key frames",
               "Size of the sliding window: of NDT with local_map_method: sliding_window, and of "
               "all other methods.")
      .real("frame_filter_resolution", &Config::frame_filter_resolution, {0.0, 10.0}, "m",
            "Edge of the voxels that thin out a scan for the sliding window; 0 keeps all points.")
      .real("local_map_filter_resolution", &Config::local_map_filter_resolution, {0.0, 10.0}, "m",
            "Edge of the voxels that thin out the sliding window's cloud; 0 keeps all points.")
      .integer("threads", &Config::threads, {0, 256}, "",
               "Upper limit of threads; 0 takes all cores. The result does not depend on it.");
  return schema;
}

}  // namespace

const config::Schema<FrontEndConfig>& FrontEndConfig::schema() {
  static const auto schema = make_schema();
  return schema;
}

}  // namespace lidar_mapping::front_end
