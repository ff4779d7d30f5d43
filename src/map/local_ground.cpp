#include "local_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr double kColumn = 0.6;  // m
constexpr int kAround = 2;       // columns in each direction
constexpr float kDeeper = 0.2F;  // m; the surroundings are then believed instead
constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr float kNotAsked = std::numeric_limits<float>::quiet_NaN();

/// Takes a height into the two lowest.
void lower(float z, float& first, float& second) {
  second = std::min(second, std::max(z, first));
  first = std::min(first, z);
}

}  // namespace

std::vector<GroundColumn> ground_columns(const PlacedPoints& points, float farthest) {
  constexpr std::uint32_t kNew = 0;
  CellGrid<std::uint32_t> numbers(ground_area(points, farthest), kNew);
  std::vector<GroundColumn> columns;
  for (const Eigen::Vector3f& point : points.points) {
    const CellIndex cell = numbers.cell_of(point);
    std::uint32_t* number = numbers.find(cell);
    if (number == nullptr) continue;
    if (*number == kNew) {
      columns.push_back({cell, kNone, kNone});
      *number = static_cast<std::uint32_t>(columns.size());
    }
    GroundColumn& column = columns[*number - 1];
    lower(static_cast<float>(points.origin.z()) + point.z(), column.lowest, column.second);
  }
  return columns;
}

CellArea ground_area(const PlacedPoints& points, float farthest) {
  return CellArea(points, kColumn, farthest).widened(kAround);
}

LocalGround::LocalGround(const CellArea& area) : columns_(area, {kNone, kNone, kNotAsked}) {}

void LocalGround::add(const std::vector<GroundColumn>& columns) {
  for (const GroundColumn& column : columns) {
    Column* known = columns_.find(column.cell);
    if (known == nullptr) continue;
    lower(column.lowest, known->first, known->second);
    lower(column.second, known->first, known->second);
    known->ground = kNotAsked;
  }
}

float LocalGround::height_above(float z, std::size_t number) {
  if (number == CellArea::kOutside) return 0.0F;
  Column& column = columns_.at(number);
  if (std::isnan(column.ground)) column.ground = ground_at(number);
  return column.ground == kNone ? kNone : z - column.ground;
}

float LocalGround::ground_at(std::size_t column) const {
  constexpr std::size_t kSide = 2 * kAround + 1;
  std::array<float, kSide * kSide - 1> around{};
  std::size_t count = 0;
  const std::size_t width = columns_.area().width();
  const std::size_t corner = column - kAround * width - kAround;
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t i = corner + row * width; i < corner + row * width + kSide; ++i) {
      const float height = columns_.at(i).second;
      if (i != column && height != kNone) around[count++] = height;
    }
  }
  const float own = columns_.at(column).second;
  if (count == 0) return own;
  const auto end = around.begin() + static_cast<std::ptrdiff_t>(count);
  const auto quartile = around.begin() + static_cast<std::ptrdiff_t>(count / 4);
  if (own != kNone) {
    const auto is_deeper = [own](float z) { return z < own - kDeeper; };
    if (std::count_if(around.begin(), end, is_deeper) <= quartile - around.begin()) return own;
  }
  std::nth_element(around.begin(), quartile, end);
  return *quartile;
}

}  // namespace lidar_mapping::map
