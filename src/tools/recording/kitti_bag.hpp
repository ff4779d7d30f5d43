// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <rosbag/bag.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"

// What the bags of simulate_drive and kitti_to_bag have in common: the topics that mapping.launch
// expects, and frames.
namespace lidar_mapping::tools {

inline constexpr char kCloudTopic[] = "/kitti/velo/pointcloud";
inline constexpr char kImuTopic[] = "/kitti/oxts/imu";
inline constexpr char kFixTopic[] = "/kitti/oxts/gps/fix";
inline constexpr char kVelocityTopic[] = "/kitti/oxts/gps/vel";
inline constexpr char kBaseFrame[] = "base_link";
inline constexpr char kLidarFrame[] = "velo_link";
inline constexpr char kImuFrame[] = "imu_link";
inline constexpr char kAntennaFrame[] = "gnss_link";

/// The pose of a sensor on the vehicle.
inline geometry_msgs::TransformStamped transform_message(const Pose& T_base_sensor,
                                                         const std::string& frame, Stamp stamp) {
  return ros_border::stamped_transform(T_base_sensor, stamp, kBaseFrame, frame);
}

/// Sets the variances of a covariance of 3x3 numbers, row by row.
template <typename Array>
void fill_diagonal(Array& covariance, double sigma) {
  for (std::size_t i = 0; i < 9; i += 4) covariance[i] = sigma * sigma;
}

/// Writes a bag whose messages are written by `fill`. It has its name only when it is whole. Throws
/// FileError.
template <typename Fill>
void write_whole_bag(const std::string& path, const Fill& fill) {
  const std::string unfinished = path + ".active";
  auto bag = std::make_unique<rosbag::Bag>();
  try {
    bag->open(unfinished, rosbag::bagmode::Write);
    bag->setCompression(rosbag::compression::LZ4);
    fill(*bag);
    bag->close();
  } catch (const rosbag::BagException& error) {
    // The destructor would write again. On a full disk it would throw, which ends the program.
    static_cast<void>(bag.release());
    throw FileError("cannot write " + unfinished + ": " + error.what());
  }
  std::filesystem::rename(unfinished, path);
}

}  // namespace lidar_mapping::tools
