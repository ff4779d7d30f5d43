// SPDX-License-Identifier: BSD-3-Clause
#include "ground_raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::map {

namespace {

constexpr int kSteps = 5;  // columns that what is known is carried on

moving_objects::PointCells cells_of(const moving_objects::PlacedPoints& points) {
  return {points, moving_objects::GroundArea::kColumn, std::numeric_limits<float>::infinity()};
}

}  // namespace

GroundRaster::GroundRaster(const moving_objects::PlacedPoints& points,
                           const moving_objects::GroundArea& area,
                           moving_objects::LocalGround& ground)
    // One more on each side, so that every column that is filled has eight around it.
    : rectangle_(moving_objects::CellArea(cells_of(points)).widened(kSteps + 1)),
      heights_(rectangle_.size(), kUnknown) {
  const std::vector<std::uint32_t> numbers = rectangle_.numbers_of(cells_of(points));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    float& height = heights_[numbers[i]];
    if (height == kUnknown) height = -ground.height_above(0.0F, area.column_of(i));
    if (height == -kUnknown) height = kUnknown;  // no ground at all
  }
  fill_holes();
  find_limits();
}

int GroundRaster::cell_of(double coordinate) {
  return static_cast<int>(std::floor(coordinate / moving_objects::GroundArea::kColumn));
}

void GroundRaster::fill_holes() {
  const std::size_t width = rectangle_.width();
  for (int step = 0; step < kSteps; ++step) {
    std::vector<float> filled = heights_;
    for (std::size_t i = width + 1; i + width + 1 < heights_.size(); ++i) {
      const std::size_t column = i % width;
      if (column == 0 || column + 1 == width || heights_[i] != kUnknown) continue;
      filled[i] = guess(i);
    }
    heights_ = std::move(filled);
  }
}

/// Their lower quartile: a roof beside the street is not its ground.
float GroundRaster::guess(std::size_t number) const {
  const std::size_t width = rectangle_.width();
  std::array<float, 8> around{};
  around.fill(kUnknown);  // which is above all others
  std::size_t known = 0;
  for (const std::size_t row : {number - width, number, number + width}) {
    for (const std::size_t i : {row - 1, row, row + 1}) {
      if (heights_[i] != kUnknown) around[known++] = heights_[i];
    }
  }
  return known == 0 ? kUnknown : quantile_of_range(around.begin(), around.begin() + known, 0.25);
}

void GroundRaster::find_limits() {
  for (const float height : heights_) {
    if (height == kUnknown) continue;
    lowest_ = std::min(lowest_, height);
    highest_ = std::max(highest_, height);
  }
}

}  // namespace lidar_mapping::map
