// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "lidar_mapping/moving_objects/ground_area.hpp"
#include "lidar_mapping/moving_objects/transformed_points.hpp"

namespace lidar_mapping::moving_objects {

/// Heights of the two lowest of some points, m in the map frame; kNone where there are fewer
/// points.
struct LowestPoints {
  /// Height of a missing point; above all others.
  static constexpr float kNone = std::numeric_limits<float>::infinity();

  /// Adds a point of this height.
  void add(float z) { merge({z, kNone}); }
  /// Adds all points of `other`. Written without branches, which would be mispredicted.
  void merge(LowestPoints other) {
    const float higher = lowest > other.lowest ? lowest : other.lowest;
    const float next = second < other.second ? second : other.second;
    lowest = lowest < other.lowest ? lowest : other.lowest;
    second = next < higher ? next : higher;
  }

  float lowest = kNone;  ///< Height of the lowest point.
  float second = kNone;  ///< Height of the second lowest point.
};

/// Lowest points of a column of 0.6 m by 0.6 m.
struct GroundColumn {
  CellIndex cell;       ///< Cell of the grid of columns.
  LowestPoints points;  ///< Its two lowest points.
};

/// Columns of the points that are no further than `max_range` (m) from their origin.
std::vector<GroundColumn> ground_columns(const TransformedPoints& points,
                                         float max_range = kMaxRange);

/// Height of the ground below points. A column that holds nothing but the roof of a car takes the
/// height of the ground from the columns around it. One thread uses it.
class LocalGround {
 public:
  /// For points of this area, which must outlive this object.
  explicit LocalGround(const GroundArea& area);

  /// Adds observed columns; allowed only before the first call of height_above().
  void add(const std::vector<GroundColumn>& columns);
  /// Height above the ground of a point at height z (m in the map frame) in this column of the
  /// area; infinity where no ground is known, 0 outside of the area.
  float height_above(float z, std::uint32_t column);

 private:
  using Heights = std::array<float, GroundArea::kWindow * GroundArea::kWindow>;

  float ground_at(std::uint32_t column) const;
  /// Heights of the second lowest points of the 5x5 columns around; kNone for the column itself.
  Heights heights_around(std::uint32_t column) const;

  const GroundArea& area_;
  std::vector<LowestPoints> columns_;
  std::vector<float> grounds_;  ///< Ground of the columns; NaN where it was not computed yet.
};

}  // namespace lidar_mapping::moving_objects
