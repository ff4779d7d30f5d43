// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "lidar_mapping/common/cloud_source.hpp"

namespace lidar_mapping::moving_objects {

/// How sure removal has to be (doc/map.md).
struct MovingObjectsConfig {
  int neighbours = 30;     ///< key frames before and after that vote; not other passes of the place
  double reach = 40.0;     ///< m, they vote on points this near to them; at most 100
  int min_votes = 2;       ///< a point goes only if so many saw through it ...
  double min_share = 0.7;  ///< ... and they are this share of all that saw its place
  int threads = 0;
};

/// Clouds without the points of objects that moved while they were seen. A point goes when
/// neighbouring key frames look through the place where it was, undisturbed; ground never goes, and
/// neighbours decide together. One thread calls it. Memory is that of the neighbouring key frames.
class StaticClouds : public CloudSource {
 public:
  /// `clouds` must outlive this object. `p_base_sensor`: the LiDAR in base_link, from which rays
  /// start. What was found is put aside in a nameless file in that folder. Throws FileError where
  /// that fails, also later.
  StaticClouds(CloudSource& clouds, const KeyFramePoses& poses,
               const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config = {},
               const std::filesystem::path& directory = std::filesystem::temp_directory_path());
  ~StaticClouds() override;

  PointCloudPtr cloud(KeyFrameIndex index) override;
  /// With the threads of the configuration.
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override;
  /// What cloud() leaves out.
  PointCloudPtr removed(KeyFrameIndex index);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::moving_objects
