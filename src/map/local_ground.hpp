#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

/// The two lowest points of a column of 0.5 m by 0.5 m.
struct GroundColumn {
  std::int64_t key = 0;
  float lowest = 0.0F;
  float second = 0.0F;
};

/// The columns of some points in the map frame.
std::vector<GroundColumn> ground_columns(const std::vector<Eigen::Vector3d>& points_map);

/// Height of the ground below a point. A column that holds nothing but the roof of a car takes its
/// ground from the columns around.
class LocalGround {
 public:
  void add(const std::vector<GroundColumn>& columns);
  /// Infinity where nothing is known.
  float height_above(const Eigen::Vector3d& p_map) const;

 private:
  struct Lowest {
    float first;
    float second;
  };
  std::unordered_map<std::int64_t, Lowest> columns_;
};

}  // namespace lidar_mapping::map
