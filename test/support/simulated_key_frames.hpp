// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::test {

/// Key frames of a simulated drive whose turns are taken in an instant, with true poses: what a
/// perfect mapping would have made of it. Clouds are computed when asked for and then kept.
class SimulatedKeyFrames : public CloudSource {
 public:
  /// A key frame every `spacing` metres between two instants of the drive (seconds after its
  /// beginning), with every `thinning`-th point.
  SimulatedKeyFrames(const simulation::Drive& drive, double begin_s, double end_s, double spacing,
                     std::size_t thinning = 1)
      : drive_(drive), thinning_(thinning) {
    add(begin_s, end_s, spacing);
  }

  /// Another part of the drive behind what is there.
  void add(double begin_s, double end_s, double spacing) {
    for (std::size_t i = 0; i < drive_.scan_count(); ++i) {
      const double at = to_seconds(drive_.scan_stamp(i) - drive_.trajectory().begin());
      if (at < begin_s || at > end_s) continue;
      const Pose pose = drive_.trajectory().pose(drive_.scan_stamp(i));
      if (!poses.poses.empty() && is_near(poses.poses.back().T_map_base, pose, spacing)) continue;
      const auto index = static_cast<KeyFrameIndex>(scans_.size());
      scans_.push_back(i);
      poses.poses.push_back({index, drive_.scan_stamp(i), pose});
    }
  }

  PointCloudPtr cloud(KeyFrameIndex index) override { return made(index).cloud; }
  /// Per point of cloud(): 1 on a moving object.
  const std::vector<std::uint8_t>& moving(KeyFrameIndex index) { return made(index).moving; }

  KeyFramePoses poses;  ///< true ones, for the test to change

 private:
  struct Made {
    PointCloudPtr cloud;
    std::vector<std::uint8_t> moving;
  };

  static bool is_near(const Pose& a, const Pose& b, double spacing) {
    return (a.translation - b.translation).norm() < spacing;
  }

  const Made& made(KeyFrameIndex index) {
    const auto known = made_.find(index);
    if (known != made_.end()) return known->second;
    const simulation::SimulatedScan scan = drive_.scan(scans_.at(index));
    const PointCloud in_base = transformed(scan.cloud, drive_.mounting().T_base_lidar);
    auto cloud = std::make_shared<PointCloud>();
    Made made;
    for (std::size_t i = index % thinning_; i < in_base.size(); i += thinning_) {
      cloud->points.push_back(in_base.points[i]);
      made.moving.push_back(scan.moving[i]);
    }
    made.cloud = cloud;
    return made_[index] = made;
  }

  const simulation::Drive& drive_;
  std::size_t thinning_;
  std::vector<std::size_t> scans_;
  std::map<KeyFrameIndex, Made> made_;
};

}  // namespace lidar_mapping::test
