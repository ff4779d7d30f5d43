#pragma once

#include <cstdint>
#include <vector>

#include "placed_points.hpp"

namespace lidar_mapping::map {

/// The two lowest points of a column of 0.6 m by 0.6 m.
struct GroundColumn {
  CellIndex cell;
  float lowest = 0.0F;  ///< m, in the map frame
  float second = 0.0F;
};

/// The columns of the points that are no further than `farthest` from their origin, m.
std::vector<GroundColumn> ground_columns(const PlacedPoints& points, float farthest = kFarthest);

/// The columns in which points lie that are no further than `farthest` from their origin, m, and
/// those around.
CellArea ground_area(const PlacedPoints& points, float farthest = kFarthest);

/// Height of the ground below points. A column that holds nothing but the roof of a car takes its
/// ground from the columns around. One thread uses it.
class LocalGround {
 public:
  /// For points in that ground_area().
  explicit LocalGround(const CellArea& area);

  void add(const std::vector<GroundColumn>& columns);
  /// Height above the ground of what is at z, m in the map frame, in that column of the area;
  /// infinity where no ground is known, 0 for what is outside.
  float height_above(float z, std::size_t column);

 private:
  struct Column {
    float first;
    float second;
    float ground;  ///< NaN if not asked for yet
  };
  float ground_at(std::size_t column) const;

  CellGrid<Column> columns_;
};

}  // namespace lidar_mapping::map
