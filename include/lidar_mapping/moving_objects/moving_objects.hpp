// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "lidar_mapping/common/cloud_source.hpp"

namespace lidar_mapping::moving_objects {

/// Conditions under which points of moving objects are removed (doc/map.md).
struct MovingObjectsConfig {
  /// Number of key frames of the same visit before and after that vote; other passes of the
  /// location do not vote.
  int neighbours = 30;
  /// Largest distance of a point from a voting key frame, m; at most 100.
  double max_range = 40.0;
  /// A point is removed only if at least so many key frames saw through its location ...
  int min_votes = 2;
  /// ... and they are at least this fraction of all that observed the location.
  double min_fraction = 0.7;
  int threads = 0;  ///< Upper limit of threads; 0: all cores.
};

/// Clouds without the points of objects that moved while they were observed. A point is removed if
/// neighbouring key frames looked through its location; points of the ground are never removed, and
/// neighbouring points are decided together. One thread calls it. It needs the memory of the
/// neighbouring key frames.
class StaticClouds : public CloudSource {
 public:
  /// `clouds` must outlive this object. `p_base_sensor` is the position of the LiDAR in base_link,
  /// from which the rays start (m). The results are stored in an unnamed temporary file in
  /// `directory`. Throws FileError if that fails, also in later calls.
  StaticClouds(CloudSource& clouds, const KeyFramePoses& poses,
               const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config = {},
               const std::filesystem::path& directory = std::filesystem::temp_directory_path());
  ~StaticClouds() override;

  /// The cloud without moving points; null if the source has none.
  PointCloudPtr cloud(KeyFrameIndex index) override;
  /// Uses the number of threads of the configuration instead of `threads`.
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override;
  /// The points that cloud() leaves out; null if the source has no cloud.
  PointCloudPtr removed(KeyFrameIndex index);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::moving_objects
