// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lidar_mapping/moving_objects/transformed_points.hpp"

namespace lidar_mapping::moving_objects {

/// The columns of 0.6 m by 0.6 m in which some points lie, and those up to two columns away on each
/// side. Only these few columns of the bounding rectangle are numbered: row by row, so that
/// neighbours in a row have consecutive numbers.
class GroundArea {
 public:
  /// Edge of a column, m. Chosen: smaller ones hold no ground point between two rings, larger ones
  /// mix road and pavement.
  static constexpr double kColumnSize = 0.6;
  /// Chosen: the neighbourhood (3 m) then reaches beyond a parked car (1.8 m wide).
  static constexpr std::size_t kMargin = 2;  ///< Columns added on each side of a point.
  /// Columns along an edge of the neighbourhood of a column, by definition: twice kMargin and
  /// itself.
  static constexpr std::size_t kWindow = 2 * kMargin + 1;
  /// Number of everything outside.
  static constexpr std::uint32_t kOutside = CellRectangle::kOutside;

  /// The columns around the points; points further than `max_range` (m) from their origin are left
  /// out.
  explicit GroundArea(const TransformedPoints& points, float max_range = kMaxRange)
      : GroundArea(PointCells(points, kColumnSize, max_range)) {}

  /// Number of columns.
  std::size_t size() const { return cells_.size(); }
  /// Number of the column in which the i-th point lies, or kOutside.
  std::uint32_t column_of(std::size_t i) const { return columns_of_points_[i]; }
  /// Number of the column of this cell, or kOutside.
  std::uint32_t index_of(const CellIndex& cell) const {
    const std::uint32_t number = rectangle_.index_of(cell);
    return number == CellRectangle::kOutside ? kOutside : numbers_[number];
  }
  /// Numbers of the first columns of the five rows of the 5x5 columns around a column in which a
  /// point lies.
  std::array<std::uint32_t, kWindow> rows_around(std::uint32_t column) const;

 private:
  explicit GroundArea(const PointCells& cells);

  CellRectangle rectangle_;
  std::vector<std::uint32_t> numbers_;  ///< Numbers of the cells of the rectangle.
  std::vector<std::uint32_t> cells_;    ///< Cells of the rectangle, by number.
  std::vector<std::uint32_t> columns_of_points_;
};

}  // namespace lidar_mapping::moving_objects
