// SPDX-License-Identifier: BSD-3-Clause
#include "candidates/position_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// m. Chosen: twice the default radius of a search (LoopClosingConfig::detect_area), so that it
// visits few cells.
constexpr double kCellSize = 20.0;

std::int64_t cell_of(double coordinate) { return floor_to_int(coordinate / kCellSize); }

}  // namespace

PositionGrid::Key PositionGrid::key_of(const Eigen::Vector2d& position) {
  return square_key(cell_of(position.x()), cell_of(position.y()));
}

void PositionGrid::set_position(std::size_t node, const Eigen::Vector2d& position) {
  if (node >= positions_.size()) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    positions_.resize(node + 1, Eigen::Vector2d::Constant(none));
  }
  Eigen::Vector2d& stored = positions_[node];
  const bool is_new = stored.hasNaN();
  if (is_new || key_of(stored) != key_of(position)) {
    if (!is_new) {
      auto& old_cell = cells_[key_of(stored)];
      old_cell.erase(std::find(old_cell.begin(), old_cell.end(), node));
    }
    cells_[key_of(position)].push_back(node);
  }
  stored = position;
}

std::vector<std::size_t> PositionGrid::nodes_around(const Eigen::Vector2d& centre,
                                                    double radius) const {
  std::vector<std::size_t> result;
  const double cells = std::pow(2.0 * radius / kCellSize + 2.0, 2);
  if (cells > static_cast<double>(positions_.size())) {
    result.resize(positions_.size());
    std::iota(result.begin(), result.end(), std::size_t{0});
    return result;
  }
  for (auto x = cell_of(centre.x() - radius); x <= cell_of(centre.x() + radius); ++x) {
    for (auto y = cell_of(centre.y() - radius); y <= cell_of(centre.y() + radius); ++y) {
      const auto cell = cells_.find(square_key(x, y));
      if (cell == cells_.end()) continue;
      result.insert(result.end(), cell->second.begin(), cell->second.end());
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::vector<std::size_t> PositionGrid::within(const Eigen::Vector2d& centre, double radius) const {
  std::vector<std::size_t> result = nodes_around(centre, radius);
  const auto outside = [&](std::size_t node) {
    return !((positions_[node] - centre).norm() <= radius);
  };
  result.erase(std::remove_if(result.begin(), result.end(), outside), result.end());
  return result;
}

}  // namespace lidar_mapping::loop_closing
