#include "local_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr double kColumn = 0.5;  // m
constexpr float kDeeper = 0.3F;  // m; the surroundings are then believed instead
constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr std::int64_t kStride = std::int64_t{1} << 32;

std::int64_t cell(double coordinate) {
  return static_cast<std::int64_t>(std::floor(coordinate / kColumn));
}

std::int64_t key_of(std::int64_t x, std::int64_t y) { return x * kStride + y; }

/// Takes a height into the two lowest.
void lower(float z, float& first, float& second) {
  second = std::min(second, std::max(z, first));
  first = std::min(first, z);
}

}  // namespace

std::vector<GroundColumn> ground_columns(const std::vector<Eigen::Vector3d>& points_map) {
  std::unordered_map<std::int64_t, std::size_t> positions;
  std::vector<GroundColumn> columns;
  for (const Eigen::Vector3d& point : points_map) {
    const std::int64_t key = key_of(cell(point.x()), cell(point.y()));
    const auto [position, is_new] = positions.try_emplace(key, columns.size());
    if (is_new) columns.push_back({key, kNone, kNone});
    GroundColumn& column = columns[position->second];
    lower(static_cast<float>(point.z()), column.lowest, column.second);
  }
  return columns;
}

void LocalGround::add(const std::vector<GroundColumn>& columns) {
  for (const GroundColumn& column : columns) {
    Lowest& known = columns_.try_emplace(column.key, Lowest{kNone, kNone}).first->second;
    lower(column.lowest, known.first, known.second);
    lower(column.second, known.first, known.second);
  }
}

float LocalGround::height_above(const Eigen::Vector3d& p_map) const {
  const std::int64_t x = cell(p_map.x());
  const std::int64_t y = cell(p_map.y());
  std::array<float, 24> around{};
  std::size_t count = 0;
  float own = kNone;
  for (std::int64_t dx = -2; dx <= 2; ++dx) {
    for (std::int64_t dy = -2; dy <= 2; ++dy) {
      const auto column = columns_.find(key_of(x + dx, y + dy));
      if (column == columns_.end() || column->second.second == kNone) continue;
      if (dx == 0 && dy == 0) {
        own = column->second.second;
      } else {
        around[count++] = column->second.second;
      }
    }
  }
  if (count > 0) {
    const auto quartile = around.begin() + static_cast<std::ptrdiff_t>(count / 4);
    std::nth_element(around.begin(), quartile, around.begin() + static_cast<std::ptrdiff_t>(count));
    if (own == kNone || *quartile < own - kDeeper) own = *quartile;
  }
  return own == kNone ? kNone : static_cast<float>(p_map.z()) - own;
}

}  // namespace lidar_mapping::map
