// SPDX-License-Identifier: BSD-3-Clause
#include "grid/ground_raster.hpp"

#include <algorithm>
#include <array>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::map {

namespace {

// Columns by which known ground is extended, 3 m. Chosen: the gap between the rings of 16 beams at
// 15 m; ground may change its height beyond.
constexpr int kFillSteps = 5;

moving_objects::PointCells cells_of(const moving_objects::TransformedPoints& points) {
  return {points, moving_objects::GroundArea::kColumnSize, std::numeric_limits<float>::infinity()};
}

}  // namespace

GroundRaster::GroundRaster(const moving_objects::TransformedPoints& points,
                           const moving_objects::GroundArea& area,
                           moving_objects::LocalGround& ground)
    // With one more column on each side, so that every column that is filled has eight neighbours.
    : rectangle_(moving_objects::CellRectangle(cells_of(points)).expanded(kFillSteps + 1)),
      heights_(rectangle_.size(), kUnknown) {
  const std::vector<std::uint32_t> indices = rectangle_.indices_of(cells_of(points));
  for (std::size_t i = 0; i < indices.size(); ++i) {
    float& height = heights_[indices[i]];
    if (height == kUnknown) height = -ground.height_above(0.0F, area.column_of(i));
    if (height == -kUnknown) height = kUnknown;  // no ground is known
  }
  fill_holes();
  update_height_range();
}

int GroundRaster::cell_of(double coordinate) {
  return static_cast<int>(floor_to_int(coordinate / moving_objects::GroundArea::kColumnSize));
}

void GroundRaster::fill_holes() {
  const std::size_t width = rectangle_.width();
  for (int step = 0; step < kFillSteps; ++step) {
    std::vector<float> filled = heights_;
    for (std::size_t i = width + 1; i + width + 1 < heights_.size(); ++i) {
      const std::size_t column = i % width;
      if (column == 0 || column + 1 == width || heights_[i] != kUnknown) continue;
      filled[i] = extrapolated_height(i);
    }
    heights_ = std::move(filled);
  }
}

/// The lower quartile of the neighbours, because the roof beside a street is not its ground.
float GroundRaster::extrapolated_height(std::size_t index) const {
  const std::size_t width = rectangle_.width();
  std::array<float, 8> neighbours{};
  neighbours.fill(kUnknown);  // which is greater than all heights
  std::size_t known = 0;
  for (const std::size_t row : {index - width, index, index + width}) {
    for (const std::size_t i : {row - 1, row, row + 1}) {
      if (heights_[i] != kUnknown) neighbours[known++] = heights_[i];
    }
  }
  return known == 0 ? kUnknown
                    : quantile_of_range(neighbours.begin(), neighbours.begin() + known, 0.25);
}

void GroundRaster::update_height_range() {
  for (const float height : heights_) {
    if (height == kUnknown) continue;
    lowest_ = std::min(lowest_, height);
    highest_ = std::max(highest_, height);
  }
}

}  // namespace lidar_mapping::map
