// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include <Eigen/Geometry>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// The points of a map in parts, which can be read any number of times. Whatever is made of the map
/// needs only the memory of one part. A single cloud is a map of one part; it must outlive this
/// object.
class CloudParts {
 public:
  /// Receives one part after the other; the part is valid during the call only.
  using Sink = std::function<void(const PointCloud& part)>;
  /// A rectangle of the x-y plane, m.
  using Area = Eigen::AlignedBox2f;

  /// `for_each` has to pass all parts of the map to the sink, in the same order at every call.
  explicit CloudParts(std::function<void(const Sink&)> for_each) : for_each_(std::move(for_each)) {}
  /// `for_each_near` may leave out parts without a point in the area, and keeps the order.
  CloudParts(std::function<void(const Sink&)> for_each,
             std::function<void(const Area&, const Sink&)> for_each_near)
      : for_each_(std::move(for_each)), for_each_near_(std::move(for_each_near)) {}
  /// A map of one part.
  CloudParts(const PointCloud& whole) : for_each_([&whole](const Sink& sink) { sink(whole); }) {}

  /// Passes all parts to `sink`, in order.
  void for_each(const Sink& sink) const { for_each_(sink); }
  /// Passes at least all parts with points in an area to `sink`, in order.
  void for_each_near(const Area& area, const Sink& sink) const {
    for_each_near_ ? for_each_near_(area, sink) : for_each_(sink);
  }
  /// Calls visit(point) for all points of all parts, in order.
  template <typename Visit>
  void for_each_point(const Visit& visit) const {
    for_each_([&visit](const PointCloud& part) {
      for (const Point& point : part.points) visit(point);
    });
  }

 private:
  std::function<void(const Sink&)> for_each_;
  std::function<void(const Area&, const Sink&)> for_each_near_;  ///< may be empty
};

/// Builds the tiles once and stores their points in an unnamed temporary file in `directory`, which
/// disappears with the process. The result has one part per tile, in the map frame, and reads only
/// those near an area if that is asked for. Throws FileError, and InputError for points too far
/// from the origin (check_range()).
CloudParts stored_parts(const TileSource& tiles, const std::filesystem::path& directory);

/// Stores the points of `parts` in the same way, each of them transformed by `move`, which maps
/// coordinates in m to coordinates in m.
CloudParts stored_parts(const CloudParts& parts,
                        const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& move,
                        const std::filesystem::path& directory);

}  // namespace lidar_mapping::map
