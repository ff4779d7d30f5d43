// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/moving_objects/change_list.hpp"
#include "lidar_mapping/moving_objects/moving_objects.hpp"

namespace lidar_mapping::moving_objects {

/// Clouds without the points of what is not there any more: a later visit has looked through their
/// locations, and none after it has observed anything there. Neighbouring points are decided
/// together, and points of the ground stay, as with moving objects (doc/map.md). One thread calls
/// it. It needs the memory of the observers around the key frames of a batch.
class CurrentClouds : public CloudSource {
 public:
  /// `observed` are the clouds as the LiDAR observed them, `clouds` those to clean, without moving
  /// objects; both must outlive this object. `p_base_sensor`: the LiDAR in base_link, m. Marks are
  /// stored in an unnamed temporary file in `directory`. Throws FileError.
  CurrentClouds(CloudSource& observed, CloudSource& clouds, const KeyFramePoses& poses,
                const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config,
                const std::filesystem::path& directory);
  ~CurrentClouds() override;

  PointCloudPtr cloud(KeyFrameIndex index) override;
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override;

  /// The visits of the map.
  const Visits& visits() const;
  /// The changes between the visits. Looks at all key frames that were not asked for yet.
  std::vector<Change> changes();
  /// Number of points that were left out so far.
  std::size_t outdated() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::moving_objects
