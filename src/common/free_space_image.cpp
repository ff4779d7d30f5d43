// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/free_space_image.hpp"

#include <algorithm>
#include <limits>

#include "lidar_mapping/common/spherical_projection.hpp"

namespace lidar_mapping {

namespace {

// Columns of 1.5 degrees over a turn, rows of 2 degrees over half a turn. Chosen: a row holds a
// ring of 16 beams (2 degrees apart), and thinned clouds still have a return in most cells.
constexpr int kColumns = 240;
constexpr int kRows = 90;
constexpr float kEmpty = std::numeric_limits<float>::infinity();
// Metres; a block has to be this much behind a point to contradict it. Chosen: more than the error
// of a match, less than a room or a car is deep.
constexpr float kViolationMargin = 1.5F;
// Of the nine cells of a block; chosen: with more, sparse scans test nothing.
constexpr int kMinReturns = 4;

}  // namespace

FreeSpaceImage::FreeSpaceImage(const std::vector<Eigen::Vector3f>& points,
                               const Eigen::Vector3f& sensor)
    : sensor_(sensor), ranges_(kRows * kColumns, kEmpty) {
  for (const auto& p : points) {
    const Cell cell = cell_of(p);
    float& range = ranges_[cell.row * kColumns + cell.column];
    range = std::min(range, cell.range);
  }
}

FreeSpaceImage::Cell FreeSpaceImage::cell_of(const Eigen::Vector3f& p) const {
  const Eigen::Vector3f d = p - sensor_;
  const SphericalPixel pixel = spherical_pixel(d, kRows, kColumns);
  return {pixel.row, pixel.column, d.norm()};
}

FreeSpaceImage::Block FreeSpaceImage::block_around(const Cell& cell) const {
  Block block;
  block.nearest = kEmpty;
  for (int row = std::max(cell.row - 1, 0); row <= std::min(cell.row + 1, kRows - 1); ++row) {
    const int returns_before = block.returns;
    for (const int step : {kColumns - 1, 0, 1}) {
      const float range = ranges_[row * kColumns + (cell.column + step) % kColumns];
      if (range == kEmpty) continue;
      block.nearest = std::min(block.nearest, range);
      ++block.returns;
    }
    block.rows += block.returns > returns_before ? 1 : 0;
  }
  return block;
}

FreeSpaceImage::FreeSpaceTest FreeSpaceImage::test_free_space(const Eigen::Vector3f& p) const {
  const Cell cell = cell_of(p);
  if (ranges_.empty() || ranges_[cell.row * kColumns + cell.column] == kEmpty)
    return FreeSpaceTest::kUntested;
  const Block block = block_around(cell);
  if (block.returns < kMinReturns) return FreeSpaceTest::kUntested;
  return block.nearest > cell.range + kViolationMargin ? FreeSpaceTest::kViolation
                                                       : FreeSpaceTest::kConsistent;
}

/// Most points are where a return is, so their own cell is asked before those around it.
bool FreeSpaceImage::is_certain_violation(const Eigen::Vector3f& p) const {
  if (ranges_.empty()) return false;
  const Cell cell = cell_of(p);
  const float free = cell.range + kViolationMargin;
  const float range = ranges_[cell.row * kColumns + cell.column];
  if (range == kEmpty || !(range > free)) return false;
  const Block block = block_around(cell);
  return block.returns >= kMinReturns && block.nearest > free && block.rows == 3;
}

}  // namespace lidar_mapping
