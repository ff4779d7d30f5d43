// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/local_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping::moving_objects {

namespace {

constexpr std::size_t kWindow = GroundArea::kWindow;  // columns
// m; if the surroundings are deeper by more, the column has no ground (a car, a bush) and theirs is
// used. Chosen above the height of a kerb (0.15 m) and below the floor of a car.
constexpr float kDeeper = 0.2F;
constexpr float kNone = LowestPoints::kNone;  // no point
constexpr float kNotComputed = std::numeric_limits<float>::quiet_NaN();

/// Lower quartile of the known heights.
template <typename Heights>
float lower_quartile(Heights heights) {
  const auto end = std::remove(heights.begin(), heights.end(), kNone);
  return end == heights.begin() ? kNone : quantile_of_range(heights.begin(), end, 0.25);
}

}  // namespace

std::vector<GroundColumn> ground_columns(const TransformedPoints& points, float max_range) {
  const PointCells cells(points, GroundArea::kColumnSize, max_range);
  const CellRectangle area(cells);
  const std::vector<std::uint32_t> numbers = area.indices_of(cells);
  std::vector<LowestPoints> grid(area.size());
  const auto origin_z = static_cast<float>(points.origin.z());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != CellRectangle::kOutside) grid[numbers[i]].add(origin_z + points.z[i]);
  }
  // In the order of the grid, in which they are looked up later.
  std::vector<GroundColumn> columns;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (grid[i].lowest != kNone) columns.push_back({area.cell_at(i), grid[i]});
  }
  return columns;
}

LocalGround::LocalGround(const GroundArea& area)
    : area_(area), columns_(area.size()), grounds_(area.size(), kNotComputed) {}

void LocalGround::add(const std::vector<GroundColumn>& columns) {
  for (const GroundColumn& column : columns) {
    const std::uint32_t number = area_.index_of(column.cell);
    if (number != GroundArea::kOutside) columns_[number].merge(column.points);
  }
}

float LocalGround::height_above(float z, std::uint32_t number) {
  if (number == GroundArea::kOutside) return 0.0F;
  float& ground = grounds_[number];
  if (std::isnan(ground)) ground = ground_at(number);
  return ground == kNone ? kNone : z - ground;
}

float LocalGround::ground_at(std::uint32_t column) const {
  const float own = columns_[column].second;
  const Heights around = heights_around(column);
  const float deep = own - kDeeper;
  int known = 0;
  int deeper = 0;
  for (const float height : around) {
    known += height != kNone ? 1 : 0;
    deeper += height < deep ? 1 : 0;
  }
  if (known == 0) return own;
  if (own != kNone && deeper <= known / 4) return own;
  return lower_quartile(around);
}

LocalGround::Heights LocalGround::heights_around(std::uint32_t column) const {
  Heights heights{};
  std::size_t count = 0;
  for (const std::uint32_t first : area_.rows_around(column)) {
    for (std::size_t i = 0; i < kWindow; ++i) heights[count++] = columns_[first + i].second;
  }
  heights[kWindow * kWindow / 2] = kNone;
  return heights;
}

}  // namespace lidar_mapping::moving_objects
