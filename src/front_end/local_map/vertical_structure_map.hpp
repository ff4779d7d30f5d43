// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <unordered_map>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// The points of a scan that lie above other points of it: on trees, posts and walls, not on the
/// ground, where the rings of a sensor look the same at every place. z points up.
std::vector<Eigen::Vector3f> vertical_structure_points(const SampledPoints& points);

/// A set of keys that may report a key that was not inserted, but never misses an inserted one
/// (Bloom 1970, with one hash function). It uses a quarter of a megabyte, and a query costs one
/// cache access.
class VoxelKeyFilter {
 public:
  void insert(VoxelKey key);
  bool may_contain(VoxelKey key) const;

 private:
  std::vector<bool> bits_;
};

/// Map of points on vertical structures, and the fit of later points to it: point to point, because
/// leaves and posts do not form planes.
class VerticalStructureMap {
 public:
  /// The fit of points at a pose.
  struct Fit {
    Pose T_map_sensor;
    std::size_t matched_points = 0;  ///< number of points close to points of the map
    int evidence = 0;                ///< number of these points, with a limit in each direction
    int directions = 0;              ///< number of the 36 directions with such points
  };

  bool empty() const { return cells_.empty(); }
  void insert(const std::vector<Eigen::Vector3f>& points, const Pose& T_map_sensor);
  /// Evaluates the fit of the points at this pose.
  Fit evaluate(const std::vector<Eigen::Vector3f>& points, const Pose& T_map_sensor) const;
  /// Number of points in or next to an occupied voxel. This is fast and coarse, and sometimes a
  /// little too large.
  std::size_t count_near(const std::vector<Eigen::Vector3f>& points,
                         const Pose& T_map_sensor) const;
  /// The pose near `start` with the best fit. Only the position along the sensor's x and y and the
  /// rotation about its z are changed.
  Fit fit(const std::vector<Eigen::Vector3f>& points, const Pose& start) const;

 private:
  struct Cell {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
  };
  /// Finds the voxel mean that is nearest to `p`; false if there is none.
  bool nearest(const Eigen::Vector3f& p, Eigen::Vector3f& mean) const;

  std::unordered_map<VoxelKey, Cell, VoxelKeyHash> cells_;
  VoxelKeyFilter occupied_;
  VoxelKeyFilter occupied_or_adjacent_;  ///< voxels that are occupied or next to an occupied one
};

}  // namespace lidar_mapping::front_end
