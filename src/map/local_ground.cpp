#include "local_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr double kColumn = 0.6;  // m
constexpr int kAround = 2;       // columns in each direction
constexpr std::size_t kSide = 2 * kAround + 1;
constexpr float kDeeper = 0.2F;  // m; the surroundings are then believed instead
constexpr float kNone = LowestPoints::kNone;
constexpr float kNotAsked = std::numeric_limits<float>::quiet_NaN();

}  // namespace

std::vector<GroundColumn> ground_columns(const PlacedPoints& points, float farthest) {
  CellGrid<LowestPoints> grid(CellArea(points, kColumn, farthest), {});
  for (const Eigen::Vector3f& point : points.points) {
    LowestPoints* column = grid.find(grid.cell_of(point));
    if (column != nullptr) column->take(static_cast<float>(points.origin.z()) + point.z());
  }
  // In the order of the grid, as others are asked for in theirs.
  std::vector<GroundColumn> columns;
  for (std::size_t i = 0; i < grid.area().size(); ++i) {
    if (grid.at(i).lowest != kNone) columns.push_back({grid.area().cell_at(i), grid.at(i)});
  }
  return columns;
}

CellArea ground_area(const PlacedPoints& points, float farthest) {
  return CellArea(points, kColumn, farthest).widened(kAround);
}

LocalGround::LocalGround(const CellArea& area)
    : columns_(area, {}), grounds_(area.size(), kNotAsked) {}

void LocalGround::add(const std::vector<GroundColumn>& columns) {
  for (const GroundColumn& column : columns) {
    LowestPoints* known = columns_.find(column.cell);
    if (known != nullptr) known->join(column.points);
  }
}

float LocalGround::height_above(float z, std::size_t number) {
  if (number == CellArea::kOutside) return 0.0F;
  float& ground = grounds_[number];
  if (std::isnan(ground)) ground = ground_at(number);
  return ground == kNone ? kNone : z - ground;
}

float LocalGround::ground_at(std::size_t column) const {
  const float own = columns_.at(column).second;
  int known = 0;
  int deeper = 0;
  visit_around(column, [&](float height) {
    known += height != kNone ? 1 : 0;
    deeper += height < own - kDeeper ? 1 : 0;
  });
  if (known == 0) return own;
  if (own != kNone && deeper <= known / 4) return own;
  return lower_quartile_around(column);
}

float LocalGround::lower_quartile_around(std::size_t column) const {
  std::array<float, kSide * kSide> around{};
  std::size_t count = 0;
  visit_around(column, [&](float height) {
    if (height != kNone) around[count++] = height;
  });
  const auto quartile = around.begin() + static_cast<std::ptrdiff_t>(count / 4);
  std::nth_element(around.begin(), quartile, around.begin() + static_cast<std::ptrdiff_t>(count));
  return *quartile;
}

/// Second lowest points of the columns around, but not of that one itself.
template <typename Visitor>
void LocalGround::visit_around(std::size_t column, const Visitor& visit) const {
  const std::size_t width = columns_.area().width();
  const std::size_t corner = column - kAround * width - kAround;
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t i = corner + row * width; i < corner + row * width + kSide; ++i) {
      if (i != column) visit(columns_.at(i).second);
    }
  }
}

}  // namespace lidar_mapping::map
