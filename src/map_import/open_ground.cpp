// SPDX-License-Identifier: BSD-3-Clause
#include "open_ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "lidar_mapping/common/plane_fit.hpp"

namespace lidar_mapping::map_import {

namespace {

// m from a cell to the next one. Chosen: twice as steep as the ramps of car parks (15 %), less than
// a step that stops a car.
constexpr double kLargestStep = 0.3;
// Of the eight cells around. Chosen: the ground of a map has holes, the top of a wall of two metres
// has five.
constexpr int kLeastAround = 7;
// m^2. Chosen: more than trucks and bus stops have on top, less than a yard.
constexpr std::size_t kLeastArea = 40;
// m below, and cells around, where another ground makes a ceiling of an area. Chosen: higher than
// storeys, and beyond a parked car, which covers the ground.
constexpr double kHighestStorey = 6.0;
constexpr int kBeside = 2;
// Of the cells of an area. Chosen: storeys that ramps connect are one area, whose lowest one has no
// ground below it.
constexpr double kCeiling = 0.9;

constexpr std::size_t kSides = 4;   // the first of kDirections, by geometry
constexpr std::size_t kAround = 8;  // cells around a cell, by geometry
struct Direction {
  int column;
  int row;
};
constexpr std::array<Direction, kAround> kDirections = {
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};

/// The grounds with their neighbours.
class GroundGraph {
 public:
  explicit GroundGraph(const std::vector<GroundCell>& cells)
      : cells_(cells), is_open_(cells.size(), false) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      int around = 0;
      for (const Direction& direction : kDirections) around += neighbour(i, direction) < 0 ? 0 : 1;
      is_open_[i] = around >= kLeastAround;
    }
  }

  /// Closes the areas that are too small, and those that lie above others and are not connected to
  /// them: ceilings that were seen from below.
  void keep_large_areas() {
    std::vector<bool> is_seen(cells_.size(), false);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (!is_open_[i] || is_seen[i]) continue;
      const std::vector<std::size_t> area = area_of(i, is_seen);
      if (area.size() >= kLeastArea && !is_ceiling(area)) continue;
      for (const std::size_t cell : area) is_open_[cell] = false;
    }
  }

  /// Steps to the border of the open ground; 0 where it is not open.
  std::vector<int> clearances() const {
    std::vector<int> clearances(cells_.size(), 0);
    std::vector<std::size_t> ring;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (!is_open_[i] || open_sides(i).size() == kSides) continue;
      clearances[i] = 1;
      ring.push_back(i);
    }
    for (int step = 2; !ring.empty(); ++step) {
      std::vector<std::size_t> next;
      for (const std::size_t i : ring) {
        for (const std::size_t side : open_sides(i)) {
          if (clearances[side] != 0) continue;
          clearances[side] = step;
          next.push_back(side);
        }
      }
      ring.swap(next);
    }
    return clearances;
  }

  bool is_open(std::size_t i) const { return is_open_[i]; }

  Eigen::Vector3d position(std::size_t i) const {
    return {(cells_[i].column + 0.5) * kGroundCell, (cells_[i].row + 0.5) * kGroundCell,
            cells_[i].height};
  }

  /// Of the plane through a cell and those around it.
  Eigen::Vector3d normal(std::size_t i) const {
    PointMoments moments;  // about the cell
    moments.add(Eigen::Vector3d::Zero());
    for (const Direction& direction : kDirections) {
      const std::ptrdiff_t other = neighbour(i, direction);
      if (other < 0) continue;
      moments.add(position(static_cast<std::size_t>(other)) - position(i));
    }
    const Eigen::Vector3d normal = PlaneFit(moments).normal;
    return normal.z() < 0.0 ? Eigen::Vector3d(-normal) : normal;
  }

 private:
  /// The lowest ground between two heights (m) relative to a cell, in a column beside it; -1 if
  /// there is none.
  std::ptrdiff_t ground_between(std::size_t i, const Direction& direction, double low,
                                double high) const {
    const int column = cells_[i].column + direction.column;
    const int row = cells_[i].row + direction.row;
    const double lowest = cells_[i].height + low;
    const auto found = std::lower_bound(cells_.begin(), cells_.end(), std::tie(column, row, lowest),
                                        [](const GroundCell& cell, const auto& key) {
                                          return std::tie(cell.column, cell.row, cell.height) < key;
                                        });
    if (found == cells_.end() || found->column != column || found->row != row ||
        found->height > cells_[i].height + high) {
      return -1;
    }
    return found - cells_.begin();
  }

  /// The ground beside a cell at about its height; -1 if there is none. Grounds of a column are
  /// farther apart than the largest step, so there is one at most.
  std::ptrdiff_t neighbour(std::size_t i, const Direction& direction) const {
    return ground_between(i, direction, -kLargestStep, kLargestStep);
  }

  bool has_ground_below(std::size_t i) const {
    for (int column = -kBeside; column <= kBeside; ++column) {
      for (int row = -kBeside; row <= kBeside; ++row) {
        const auto below = ground_between(i, {column, row}, -kHighestStorey, -2.0 * kLargestStep);
        if (below >= 0) return true;
      }
    }
    return false;
  }

  bool is_ceiling(const std::vector<std::size_t>& area) const {
    const auto above =
        std::count_if(area.begin(), area.end(), [&](std::size_t i) { return has_ground_below(i); });
    return static_cast<double>(above) >= kCeiling * static_cast<double>(area.size());
  }

  std::vector<std::size_t> open_sides(std::size_t i) const {
    std::vector<std::size_t> sides;
    for (std::size_t side = 0; side < kSides; ++side) {
      const std::ptrdiff_t other = neighbour(i, kDirections[side]);
      if (other >= 0 && is_open_[other]) {
        sides.push_back(static_cast<std::size_t>(other));
      }
    }
    return sides;
  }

  std::vector<std::size_t> area_of(std::size_t first, std::vector<bool>& is_seen) const {
    std::vector<std::size_t> area = {first};
    is_seen[first] = true;
    for (std::size_t next = 0; next < area.size(); ++next) {
      for (const std::size_t side : open_sides(area[next])) {
        if (is_seen[side]) continue;
        is_seen[side] = true;
        area.push_back(side);
      }
    }
    return area;
  }

  const std::vector<GroundCell>& cells_;
  std::vector<bool> is_open_;
};

}  // namespace

std::vector<OpenCell> find_open_ground(const std::vector<GroundCell>& cells) {
  GroundGraph graph(cells);
  graph.keep_large_areas();
  const std::vector<int> clearances = graph.clearances();
  std::vector<OpenCell> open;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (graph.is_open(i)) open.push_back({graph.position(i), graph.normal(i), clearances[i]});
  }
  return open;
}

}  // namespace lidar_mapping::map_import
