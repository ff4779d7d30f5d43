// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

#include "scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// The points that stand above others of their scan: of trees, posts and walls, not of the ground,
/// on which the rings of a sensor look alike wherever it stands. z is up.
std::vector<Eigen::Vector3f> vertical_structure_points(const SampledPoints& points);

/// A set of keys that now and then takes in one too many, but never loses one (Bloom 1970, with one
/// hash): a quarter of a megabyte that answers in the time of one look at the cache.
class VoxelKeyFilter {
 public:
  void insert(VoxelKey key);
  bool may_contain(VoxelKey key) const;

 private:
  std::vector<bool> bits_;
};

/// Where upright points were seen, and how later ones fit: point to point, as leaves and posts make
/// no planes.
class VerticalStructureMap {
 public:
  /// How points fit at a pose.
  struct Fit {
    Pose T_map_sensor;
    std::size_t matched_points = 0;  ///< so many points are beside points of the map
    int evidence = 0;                ///< of them, at most a few in each direction
    int directions = 0;              ///< in so many of 36
  };

  bool empty() const { return cells_.empty(); }
  void insert(const std::vector<Eigen::Vector3f>& points, const Pose& T_map_sensor);
  /// How the points fit there.
  Fit evaluate(const std::vector<Eigen::Vector3f>& points, const Pose& T_map_sensor) const;
  /// Number of points in or beside a voxel of the map: quick, coarse, and now and then some too
  /// many.
  std::size_t count_near(const std::vector<Eigen::Vector3f>& points,
                         const Pose& T_map_sensor) const;
  /// The pose near `start` where the points fit best: moved along the sensor's x and y and turned
  /// about its z, all else as it is there.
  Fit fit(const std::vector<Eigen::Vector3f>& points, const Pose& start) const;

 private:
  struct Cell {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
  };
  /// The mean of the voxel that is nearest to `p`; false if there is none.
  bool nearest(const Eigen::Vector3f& p, Eigen::Vector3f& mean) const;

  std::unordered_map<VoxelKey, Cell, VoxelKeyHash> cells_;
  VoxelKeyFilter occupied_;
  VoxelKeyFilter occupied_or_adjacent_;  ///< in or beside an occupied one
};

}  // namespace lidar_mapping::front_end
