// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// A crossing of the street grid.
struct Crossing {
  int column = 0;
  int row = 0;
};

/// An irregular grid of streets. Streets along x belong to rows, those along y to columns.
class TownLayout {
 public:
  /// Crossings 0..columns-1 by 0..rows-1, the first near the origin. With `rows_alike` all streets
  /// along x have the same shape and differ by a shift.
  TownLayout(int columns, int rows, bool rows_alike, Random random);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  bool rows_alike() const { return rows_alike_; }
  Eigen::Vector2d crossing(Crossing at) const { return nodes_[at.row * columns_ + at.column]; }
  /// Half the width of the carriageway between its kerbs, m.
  double row_half_width(int row) const { return row_half_widths_[row]; }
  double column_half_width(int column) const { return column_half_widths_[column]; }

  /// Corners of the kerb of the block whose lowest crossing is `at`, counter-clockwise from there.
  /// Edge i runs from corner i to corner i + 1; the street is on its right.
  std::array<Eigen::Vector2d, 4> block(Crossing at) const;
  /// Corners of the path through crossings in the right-hand lane, `lane` metres right of the
  /// middle of the street.
  std::vector<Eigen::Vector2d> lane_corners(const std::vector<Crossing>& route, double lane) const;

 private:
  int columns_;
  int rows_;
  bool rows_alike_;
  std::vector<Eigen::Vector2d> nodes_;
  std::vector<double> row_half_widths_;
  std::vector<double> column_half_widths_;
};

}  // namespace lidar_mapping::simulation
