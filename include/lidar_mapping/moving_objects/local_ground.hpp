// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "lidar_mapping/moving_objects/ground_area.hpp"
#include "lidar_mapping/moving_objects/placed_points.hpp"

namespace lidar_mapping::moving_objects {

/// The two lowest of some points, m in the map frame; kNone where there are fewer.
struct LowestPoints {
  static constexpr float kNone = std::numeric_limits<float>::infinity();

  void take(float z) { join({z, kNone}); }
  /// Without branches: nobody could foresee them.
  void join(LowestPoints other) {
    const float higher = lowest > other.lowest ? lowest : other.lowest;
    const float next = second < other.second ? second : other.second;
    lowest = lowest < other.lowest ? lowest : other.lowest;
    second = next < higher ? next : higher;
  }

  float lowest = kNone;
  float second = kNone;
};

/// A column of 0.6 m by 0.6 m.
struct GroundColumn {
  CellIndex cell;
  LowestPoints points;
};

/// The columns of the points that are no further than `farthest` from their origin, m.
std::vector<GroundColumn> ground_columns(const PlacedPoints& points, float farthest = kFarthest);

/// Height of the ground below points. A column that holds nothing but the roof of a car takes its
/// ground from the columns around. One thread uses it.
class LocalGround {
 public:
  /// For points of that area, which must outlive this.
  explicit LocalGround(const GroundArea& area);

  /// Before the first question.
  void add(const std::vector<GroundColumn>& columns);
  /// Height above the ground of what is at z, m in the map frame, in that column of the area;
  /// infinity where no ground is known, 0 for what is outside.
  float height_above(float z, std::uint32_t column);

 private:
  using Heights = std::array<float, GroundArea::kSide * GroundArea::kSide>;

  float ground_at(std::uint32_t column) const;
  /// Second lowest points of the 5x5 columns around, kNone in the place of that one itself.
  Heights heights_around(std::uint32_t column) const;

  const GroundArea& area_;
  std::vector<LowestPoints> columns_;
  std::vector<float> grounds_;  ///< of the columns, NaN where nobody asked yet
};

}  // namespace lidar_mapping::moving_objects
