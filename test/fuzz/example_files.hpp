// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include <rosbag/bag.h>

/// Small whole files of every kind that the package reads, to be spoilt.
namespace lidar_mapping::test {

/// Seconds with a LiDAR, an IMU, a velocity and fixes, and where the sensors are.
void write_bag(const std::filesystem::path& path, rosbag::compression::CompressionType compression);
/// The same with the other types of message that are read: NMEA sentences, velocities with their
/// covariance, moving frames.
void write_bag_of_other_types(const std::filesystem::path& path);
/// The same with clouds as drivers publish them: livox, velodyne, hesai, pandar, ouster,
/// point_cloud1 or split_times.
void write_bag_of_driver(const std::filesystem::path& path, const std::string& driver);
/// A recording of ROS 2 with clouds, an IMU and frames.
void write_ros2_recording(const std::filesystem::path& path);
/// The same as MCAP file: plain, "lz4", or "zstd" and without a summary.
void write_mcap_recording(const std::filesystem::path& path, const std::string& compression);
/// A calibration file of velodyne_pointcloud.
void write_velodyne_calibration(const std::filesystem::path& path);
/// A calibration file of Hesai's driver.
void write_hesai_calibration(const std::filesystem::path& path);
/// Key frames, loops, verdicts, measurements and poses.
void write_session(const std::filesystem::path& folder);
/// The folder of localize_bag for a drive in the map of write_session(), which is at `session`.
void write_localized_drive(const std::filesystem::path& folder,
                           const std::filesystem::path& session);
void write_hdl_dump(const std::filesystem::path& folder);
/// Raw: velodyne_points/ and oxts/.
void write_kitti_raw(const std::filesystem::path& folder);
/// The same with scans as text and without oxts/.
void write_kitti_raw_text(const std::filesystem::path& folder);
/// Scans as PCD and as plain numbers, with times.txt.
void write_scan_folder(const std::filesystem::path& folder);
/// velodyne/, point_times/ and times.txt.
void write_kitti_odometry(const std::filesystem::path& folder);
/// A point cloud; `data` is ascii, binary or binary_compressed. With `times` the points have them.
void write_pcd(const std::filesystem::path& path, const std::string& data, bool times);
void write_g2o(const std::filesystem::path& path, bool planar);
void write_binary_graph(const std::filesystem::path& path, bool planar);
/// TUM's lines, or KITTI's.
void write_trajectory(const std::filesystem::path& path, bool kitti);
/// doubt.csv of a session.
void write_doubtful_stretches(const std::filesystem::path& path);
void write_loop_list(const std::filesystem::path& path);

}  // namespace lidar_mapping::test
