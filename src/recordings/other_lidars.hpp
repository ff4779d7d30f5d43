// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"

namespace lidar_mapping::recordings {

/// A cloud of another LiDAR than the main one. It is decoded at most once, by the first of the
/// scans that may have points of it; any thread may ask for it.
class OtherCloud {
 public:
  OtherCloud(ros_border::RecordedCloud recorded, Stamp stamp, const Pose& T_main_other)
      : recorded_(std::move(recorded)), stamp_(stamp), T_main_other_(T_main_other) {}

  Stamp stamp() const { return stamp_; }
  const Pose& T_main_other() const { return T_main_other_; }
  /// Without points if they cannot be read.
  const preprocessing::RawScan& decoded(const ros_border::CloudReader& reader);

 private:
  ros_border::RecordedCloud recorded_;
  Stamp stamp_;
  Pose T_main_other_;
  std::once_flag once_;
  preprocessing::RawScan scan_;
};

using OtherClouds = std::vector<std::shared_ptr<OtherCloud>>;

/// Keeps the clouds of the other LiDARs of a vehicle until the scans of the main one that they were
/// measured with have come.
class OtherLidars {
 public:
  /// `reach`: how far from a scan's stamp that of a cloud with points of the same time may lie, s.
  explicit OtherLidars(double reach) : reach_(from_seconds(reach)) {}

  /// A LiDAR with its place, or one whose clouds are left out.
  void add_lidar(const std::string& topic, const Pose& T_main_other);
  bool has(const std::string& topic) const { return lidars_.count(topic) > 0; }
  bool empty() const { return lidars_.empty(); }

  void add(const std::string& topic, const ros_border::RecordedCloud& cloud, Stamp stamp);
  /// The clouds that may have points of the scan. Older ones are forgotten.
  OtherClouds around(Stamp scan);

  /// How many scans had no cloud of a LiDAR around them, by its topic.
  const std::map<std::string, std::size_t>& missed() const { return missed_; }

 private:
  struct Lidar {
    Pose T_main_other;
    std::deque<std::shared_ptr<OtherCloud>> clouds;
  };

  Stamp reach_;
  std::map<std::string, Lidar> lidars_;
  std::map<std::string, std::size_t> missed_;
};

}  // namespace lidar_mapping::recordings
