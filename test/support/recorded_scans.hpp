// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/trajectory.hpp"

namespace lidar_mapping::test {

/// Points of a scan in the form of the KITTI benchmark, from FOLDER/velodyne/NNNNNN.bin.
inline PointCloud recorded_scan(const std::filesystem::path& folder, std::size_t index) {
  const std::string digits = std::to_string(index);
  const std::filesystem::path path =
      folder / "velodyne" / (std::string(6 - digits.size(), '0') + digits + ".bin");
  PointCloud cloud;
  cloud.points.resize(std::filesystem::file_size(path) / sizeof(Point));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(cloud.points.data()),
            static_cast<std::streamsize>(cloud.size() * sizeof(Point)));
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return cloud;
}

/// The scans of a set as the clouds of key frames.
class RecordedClouds : public CloudSource {
 public:
  explicit RecordedClouds(std::filesystem::path folder) : folder_(std::move(folder)) {}
  PointCloudPtr cloud(KeyFrameIndex index) override {
    return std::make_shared<PointCloud>(recorded_scan(folder_, index));
  }

 private:
  std::filesystem::path folder_;
};

/// Poses of a set's scans, from FOLDER/poses.txt.
inline std::vector<Pose> recorded_poses(const std::filesystem::path& folder) {
  std::vector<Pose> poses;
  for (const StampedPose& line : read_trajectory((folder / "poses.txt").string()).poses) {
    poses.push_back(line.pose);
  }
  return poses;
}

/// Stamps of a set's scans, from FOLDER/times.txt.
inline std::vector<Stamp> recorded_stamps(const std::filesystem::path& folder) {
  std::ifstream file(folder / "times.txt");
  std::vector<Stamp> stamps;
  for (double seconds = 0.0; file >> seconds;) stamps.push_back(from_seconds(seconds));
  return stamps;
}

}  // namespace lidar_mapping::test
