// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "lidar_mapping/map/map_builder.hpp"

namespace lidar_mapping::ros_border {

/// The map as it is displayed: that of map::MapBuilder as long as it has no more points than rviz
/// shows fluently. Beyond, its voxels become larger by powers of two, so that neither the messages
/// nor the memory grow with the drive. One thread calls it.
class DisplayMap {
 public:
  /// Chosen: 64 MB in a message every ten seconds.
  static constexpr std::size_t kMostPoints = 4'000'000;

  /// `clouds` must outlive this object.
  DisplayMap(const map::MapConfig& config, CloudSource& clouds,
             std::size_t most_points = kMostPoints);

  /// Takes the poses of all key frames. True if the result of build() changes by them.
  bool update(const KeyFramePoses& poses);
  /// Builds the map in the map frame.
  PointCloud build();
  /// Edge of the voxels, m.
  double resolution() const { return config_.resolution; }
  /// Number of key frames that the last build() left out because their clouds were missing.
  std::size_t missing_clouds() const { return builder_->missing_clouds(); }

 private:
  void give_poses();
  void begin_with_larger_voxels();

  map::MapConfig config_;
  CloudSource& clouds_;
  const std::size_t most_points_;
  KeyFramePoses poses_;
  std::size_t given_ = 0;  ///< of the poses, from the first one on, to the builder
  std::optional<map::MapBuilder> builder_;
};

}  // namespace lidar_mapping::ros_border
