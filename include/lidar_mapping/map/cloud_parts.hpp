// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// The points of a map, part by part, as often as one asks: what is made of it needs the memory of
/// a part. A cloud is a map of one part; it must outlive this.
class CloudParts {
 public:
  using Sink = std::function<void(const PointCloud& part)>;

  explicit CloudParts(std::function<void(const Sink&)> each) : each_(std::move(each)) {}
  CloudParts(const PointCloud& whole) : each_([&whole](const Sink& sink) { sink(whole); }) {}

  void each(const Sink& sink) const { each_(sink); }

 private:
  std::function<void(const Sink&)> each_;
};

/// Builds the tiles once and keeps their points in a file without a name, which is gone with the
/// process: points in the map frame, a part per tile. Throws FileError, and InputError for points
/// too far from the origin (check_range()).
CloudParts stored_parts(const TileSource& tiles, const std::filesystem::path& directory);

/// The same with each point moved as `move` says, from and to m.
CloudParts stored_parts(const CloudParts& parts,
                        const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& move,
                        const std::filesystem::path& directory);

}  // namespace lidar_mapping::map
