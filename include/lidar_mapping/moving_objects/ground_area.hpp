// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lidar_mapping/moving_objects/placed_points.hpp"

namespace lidar_mapping::moving_objects {

/// The columns of 0.6 m by 0.6 m in which some points lie, and those up to two further on each
/// side. They are few of the rectangle around, and numbered among themselves: row by row, so that
/// neighbours in a row have numbers in a row.
class GroundArea {
 public:
  static constexpr double kColumn = 0.6;  // m
  static constexpr std::size_t kAround = 2;
  static constexpr std::size_t kSide = 2 * kAround + 1;
  static constexpr std::uint32_t kOutside = CellArea::kOutside;

  /// Points further than `farthest` from their origin have no column, m.
  explicit GroundArea(const PlacedPoints& points, float farthest = kFarthest)
      : GroundArea(PointCells(points, kColumn, farthest)) {}

  /// Number of columns.
  std::size_t size() const { return cells_.size(); }
  /// That in which the i-th point lies.
  std::uint32_t column_of(std::size_t i) const { return columns_of_points_[i]; }
  std::uint32_t number_of(const CellIndex& cell) const {
    const std::uint32_t number = rectangle_.number_of(cell);
    return number == CellArea::kOutside ? kOutside : numbers_[number];
  }
  /// Where the rows of the 5x5 columns around one begin in which a point lies.
  std::array<std::uint32_t, kSide> rows_around(std::uint32_t column) const;

 private:
  explicit GroundArea(const PointCells& cells);

  CellArea rectangle_;
  std::vector<std::uint32_t> numbers_;  ///< of the cells of the rectangle
  std::vector<std::uint32_t> cells_;    ///< of the rectangle, by number
  std::vector<std::uint32_t> columns_of_points_;
};

}  // namespace lidar_mapping::moving_objects
