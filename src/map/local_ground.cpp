#include "local_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr double kColumn = 0.6;  // m
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
  CellGrid<std::uint32_t> numbers(points, kColumn, kNew, farthest);
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

LocalGround::LocalGround(const PlacedPoints& points, float farthest)
    : columns_(points, kColumn, {kNone, kNone, kNotAsked}, farthest) {}

void LocalGround::add(const std::vector<GroundColumn>& columns) {
  for (const GroundColumn& column : columns) {
    Column* known = columns_.find(column.cell);
    if (known == nullptr) continue;
    lower(column.lowest, known->first, known->second);
    lower(column.second, known->first, known->second);
    known->ground = kNotAsked;
  }
}

float LocalGround::height_above(const PlacedPoints& points, std::size_t i) {
  const CellIndex cell = columns_.cell_of(points.points[i]);
  Column* column = columns_.find(cell);
  if (column == nullptr) return 0.0F;
  if (std::isnan(column->ground)) column->ground = ground_at(cell);
  if (column->ground == kNone) return kNone;
  return static_cast<float>(points.origin.z()) + points.points[i].z() - column->ground;
}

float LocalGround::ground_at(const CellIndex& cell) const {
  std::array<float, 24> around{};
  std::size_t count = 0;
  for (int dx = -2; dx <= 2; ++dx) {
    for (int dy = -2; dy <= 2; ++dy) {
      if (dx == 0 && dy == 0) continue;
      const Column* column = columns_.find({cell.x + dx, cell.y + dy});
      if (column != nullptr && column->second != kNone) around[count++] = column->second;
    }
  }
  const float own = columns_.find(cell)->second;
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
