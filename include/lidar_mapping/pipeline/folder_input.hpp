// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/pipeline/input.hpp"

namespace lidar_mapping::pipeline {

/// How the LiDAR sits on the vehicle, where a folder does not say it.
struct FolderOptions {
  double sensor_height = 1.73;  ///< of the LiDAR over base_link, m
  double start = 0.0;           ///< time of the first scan where there are no dates, s since 1970
  /// Reads *.pcd with more than x y z and intensity; by default other fields are ignored.
  std::function<preprocessing::RawScan(const std::string& path, Stamp stamp)> read_pcd = nullptr;
};

/// A drive in a folder:
/// - KITTI's raw recordings: velodyne_points/data/*.bin or *.txt with timestamps.txt, and oxts/
///   (GNSS, IMU, velocity), whose place follows from calib_imu_to_velo.txt in the folder or above;
/// - KITTI's odometry benchmark: see KittiFolder;
/// - scans *.pcd or *.bin in the order of their names; times in seconds from times.txt or from
///   names like 1317617735.250.pcd, else 10 Hz.
class FolderInput : public InputSource {
 public:
  /// The frame_id of its scans, as KITTI calls it.
  static constexpr char kLidarFrame[] = "velo_link";

  /// Throws FileError for a folder without scans or with fewer times than scans.
  explicit FolderInput(const std::string& path, const FolderOptions& options = {});

  std::optional<Input> next() override;
  void skip_to(Stamp stamp) override;
  Stamp begin() const override;
  Stamp end() const override;
  std::optional<Pose> T_base(const std::string& frame_id) const override;

  /// "KITTI raw recording, 108 scans, GNSS and IMU"
  const std::string& description() const { return description_; }
  std::size_t size() const { return inputs_.size(); }
  /// T_base_frame of all frames.
  const std::map<std::string, Pose>& frames() const { return frames_; }

 private:
  void read_raw(const std::string& path, const FolderOptions& options);
  void read_odometry(const std::string& path, const FolderOptions& options);
  void read_scans(const std::string& path, const FolderOptions& options);
  void add_scan(Stamp stamp, std::function<PointCloud()> read);
  void add_pcd(Stamp stamp, const std::string& path, const FolderOptions& options);

  std::vector<std::pair<Stamp, Input>> inputs_;  ///< by the time at which they are complete
  std::map<std::string, Pose> frames_;
  std::string description_;
  std::size_t next_ = 0;
};

}  // namespace lidar_mapping::pipeline
