// SPDX-License-Identifier: BSD-3-Clause
#include "free_space_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Columns of 1.5 degrees over a turn, rows of 2 degrees over half a turn. Chosen: a row holds a
// ring of 16 beams (2 degrees apart), and thinned clouds still have a return in most cells.
constexpr int kColumns = 240;
constexpr int kRows = 90;
constexpr auto kHalfTurn = static_cast<float>(lidar_mapping::kPi);  // rad
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
  const float elevation = std::atan2(d.z(), std::hypot(d.x(), d.y()));
  const float azimuth = std::atan2(d.y(), d.x());
  Cell cell;
  cell.row = std::clamp(static_cast<int>((elevation / kHalfTurn + 0.5F) * kRows), 0, kRows - 1);
  cell.column =
      std::clamp(static_cast<int>((azimuth / kHalfTurn + 1.0F) * 0.5F * kColumns), 0, kColumns - 1);
  cell.range = d.norm();
  return cell;
}

FreeSpaceImage::FreeSpaceTest FreeSpaceImage::test_free_space(const Eigen::Vector3f& p) const {
  if (ranges_.empty()) return FreeSpaceTest::kUntested;
  const Cell cell = cell_of(p);
  if (ranges_[cell.row * kColumns + cell.column] == kEmpty) return FreeSpaceTest::kUntested;
  float nearest = kEmpty;
  int returns = 0;
  for (int row = std::max(cell.row - 1, 0); row <= std::min(cell.row + 1, kRows - 1); ++row) {
    for (const int step : {kColumns - 1, 0, 1}) {
      const float range = ranges_[row * kColumns + (cell.column + step) % kColumns];
      if (range == kEmpty) continue;
      nearest = std::min(nearest, range);
      ++returns;
    }
  }
  if (returns < kMinReturns) return FreeSpaceTest::kUntested;
  return nearest > cell.range + kViolationMargin ? FreeSpaceTest::kViolation
                                                 : FreeSpaceTest::kConsistent;
}

}  // namespace lidar_mapping::loop_closing
