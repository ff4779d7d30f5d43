// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "lidar_mapping/map/map_builder.hpp"

namespace lidar_mapping::map {

/// Most points of a map on display. Chosen: 64 MB, which rviz shows fluently; in a message every
/// ten seconds, which the network takes.
constexpr std::size_t kMostDisplayPoints = 4'000'000;

/// Edge of the voxels (m) with which a finished map of that many Gaussians is displayed: 0.5 m, and
/// larger by powers of two where the points would be more than kMostDisplayPoints.
double display_resolution(std::size_t gaussians);

/// The map of a drive as it is displayed: that of MapBuilder as long as it has no more points than
/// rviz shows fluently. Beyond, its voxels become larger by powers of two, so that neither the
/// messages nor the memory grow with the drive. One thread calls it.
class DisplayMap {
 public:
  /// `clouds` must outlive this object. The map is built with `config`, but for the edge of its
  /// voxels if its points would be more than `most_points`.
  DisplayMap(const MapConfig& config, CloudSource& clouds,
             std::size_t most_points = kMostDisplayPoints);

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

  MapConfig config_;
  CloudSource& clouds_;
  const std::size_t most_points_;
  KeyFramePoses poses_;
  std::size_t given_ = 0;  ///< Of the poses, from the first one on, to the builder.
  std::optional<MapBuilder> builder_;
};

}  // namespace lidar_mapping::map
