// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"

namespace lidar_mapping::pipeline {

/// Properties of a recording that its folder does not hold.
struct FolderOptions {
  double sensor_height = 1.73;  ///< Height of the LiDAR above base_link, m.
  double start = 0.0;  ///< Time of the first scan if the folder has no dates, s since 1970.
  /// Reads *.pcd files that have more fields than x y z and intensity; without it other fields are
  /// ignored.
  std::function<preprocessing::RawScan(const std::string& path, Stamp stamp)> read_pcd = nullptr;
};

/// A drive recorded in a folder, in one of three forms:
/// - KITTI's raw recordings: velodyne_points/data/*.bin or *.txt with timestamps.txt, and oxts/
///   (GNSS, IMU, velocity), whose pose on the vehicle follows from calib_imu_to_velo.txt in the
///   folder or in the one above it;
/// - KITTI's odometry benchmark: see KittiFolder;
/// - scans *.pcd or *.bin in the order of their names, with times in seconds from times.txt or from
///   names like 1317617735.250.pcd, else at 10 Hz.
class FolderInput : public InputSource {
 public:
  /// The frame_id of its scans, as KITTI's tools name it.
  static constexpr char kLidarFrame[] = "velo_link";

  /// Throws FileError for a folder without scans or with fewer times than scans.
  explicit FolderInput(const std::string& path, const FolderOptions& options = {});

  /// See InputSource::next().
  std::optional<Input> next() override;
  /// See InputSource::skip_to().
  void skip_to(Stamp stamp) override;
  /// See InputSource::begin().
  Stamp begin() const override;
  /// See InputSource::end().
  Stamp end() const override;
  /// See InputSource::T_base().
  std::optional<Pose> T_base(const std::string& frame_id) const override;

  /// What was found, such as "KITTI raw recording, 108 scans, GNSS and IMU".
  const std::string& description() const { return description_; }
  /// Number of all data: scans and samples of the other sensors.
  std::size_t size() const { return inputs_.size(); }
  /// T_base_frame of all frames, by frame_id.
  const std::map<std::string, Pose>& frames() const { return frames_; }

 private:
  void read_raw(const std::string& path);
  void read_odometry(const std::string& path, const FolderOptions& options);
  void read_scans(const std::string& path, const FolderOptions& options);
  void add_scan(Stamp stamp, std::function<PointCloud()> read);
  void add_pcd(Stamp stamp, const std::string& path, const FolderOptions& options);

  /// With the time at which they are complete, in its order.
  std::vector<std::pair<Stamp, Input>> inputs_;
  std::map<std::string, Pose> frames_;
  std::string description_;
  std::size_t next_ = 0;
};

}  // namespace lidar_mapping::pipeline
