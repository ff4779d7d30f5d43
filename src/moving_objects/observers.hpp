// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"

#include "moving_points.hpp"
#include "observing_scan.hpp"

namespace lidar_mapping::moving_objects {

/// The key frames of a map as observers. Only those that were asked for are in memory. One thread
/// calls the functions that are not const.
class Observers {
 public:
  using Position = std::size_t;  ///< place of a key frame in the list of poses
  using Clouds = std::map<Position, PointCloudPtr>;

  /// `clouds` must outlive this object; `p_base_sensor` is the position of the LiDAR in base_link,
  /// m.
  Observers(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::Vector3d& p_base_sensor,
            const MovingObjectsConfig& config);

  const std::vector<KeyFramePose>& poses() const { return poses_; }
  /// Position of a key frame; empty if it has no pose.
  std::optional<Position> position_of(KeyFrameIndex index) const;

  /// The clouds of these key frames in base_link, without missing ones.
  Clouds load(const std::vector<Position>& positions);
  /// Keeps the observers at these positions and no others. Those that are new are made of `loaded`
  /// or of the source's clouds.
  void keep(const std::set<Position>& positions, const Clouds& loaded);

  /// The observer at this position; null if it is not kept or its cloud is missing.
  const ObservingScan* at(Position position) const;
  /// Positions of the drive up to `distance` before and after this one.
  std::pair<Position, Position> range_around(Position position, int distance) const;
  /// Layers of the points of a key frame that is kept, by the ground that it and those around it in
  /// the drive have observed.
  std::vector<Layer> layers(Position position, const TransformedPoints& points) const;

 private:
  void add(const Clouds& clouds);
  ObservingScan observing_scan_of(Position position, const PointCloud& cloud) const;

  CloudSource& clouds_;
  const std::vector<KeyFramePose> poses_;
  const Eigen::Vector3d p_base_sensor_;
  const MovingObjectsConfig config_;
  std::map<KeyFrameIndex, Position> positions_;
  std::map<Position, std::unique_ptr<ObservingScan>> observers_;
};

}  // namespace lidar_mapping::moving_objects
