// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/moving_objects/visits.hpp"

#include "visibility/observing_scan.hpp"
#include "votes/moving_points.hpp"

namespace lidar_mapping::moving_objects {

/// The key frames of a map as observers. Only those that were asked for are in memory. One thread
/// calls the functions that are not const.
class Observers {
 public:
  using Position = std::size_t;  ///< place of a key frame in the list of poses
  /// Key frames that are processed together, one per thread.
  struct Batch {
    Position begin;
    Position end;  ///< behind the last one
    std::vector<KeyFrameIndex> indices;
  };

  /// `clouds` must outlive this object; `p_base_sensor` is the position of the LiDAR in base_link,
  /// m.
  Observers(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::Vector3d& p_base_sensor,
            const MovingObjectsConfig& config);

  const std::vector<KeyFramePose>& poses() const { return poses_; }
  /// Position of a key frame; empty if it has no pose.
  std::optional<Position> position_of(KeyFrameIndex index) const;

  /// The batch to which a key frame belongs.
  Batch batch_of(Position position) const;
  /// The first neighbour that votes on the points of a key frame, and the position behind the last
  /// one. They end with its visit: what was there on another day tells nothing of what moves.
  std::pair<Position, Position> neighbours_of(Position position) const;
  /// Adds the neighbours of a key frame that vote on its points, and itself.
  void insert_neighbours(Position position, std::set<Position>& positions) const;

  /// Makes the observers at these positions that are missing, and deletes all at others.
  void keep(const std::set<Position>& positions);

  /// The observer at this position; null if it is not kept or its cloud is missing.
  const ObservingScan* at(Position position) const;
  /// Layers of the points of a key frame that is kept, by the ground that it and those around it in
  /// the drive have observed.
  std::vector<Layer> layers(Position position, const TransformedPoints& points) const;

 private:
  void add(const std::vector<Position>& positions);
  ObservingScan observing_scan_of(Position position, const PointCloud& cloud) const;

  CloudSource& clouds_;
  const std::vector<KeyFramePose> poses_;
  const Visits visits_;
  const Eigen::Vector3d p_base_sensor_;
  const MovingObjectsConfig config_;
  std::map<KeyFrameIndex, Position> positions_;
  std::map<Position, std::unique_ptr<ObservingScan>> observers_;
};

}  // namespace lidar_mapping::moving_objects
