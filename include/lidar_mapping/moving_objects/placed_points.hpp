// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::moving_objects {

constexpr float kFarthest = 300.0F;  // m; points of a key frame further away than this are ignored

/// A square of a grid over the map's x-y plane.
struct CellIndex {
  int x = 0;
  int y = 0;
};

/// Points in axes parallel to the map's, relative to an origin that is a corner of every grid used
/// here, so that floats hold them and cells are the same for all clouds. An array for each
/// coordinate, as vectors are made of what is alike.
struct PlacedPoints {
  static constexpr double kOriginGrid = 6.0;  // m, a multiple of 0.3, 0.4, 0.5 and 0.6

  PlacedPoints(const PointCloud& cloud, const Pose& T_map_base)
      : origin(((T_map_base.translation / kOriginGrid).array().floor() * kOriginGrid)),
        x(cloud.size()),
        y(cloud.size()),
        z(cloud.size()) {
    const Eigen::Matrix3f R = T_map_base.rotation_matrix().cast<float>();
    const Eigen::Vector3f t = (T_map_base.translation - origin).cast<float>();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Point p = cloud.points[i];
      x[i] = R(0, 0) * p.x + (R(0, 1) * p.y + R(0, 2) * p.z) + t.x();
      y[i] = R(1, 0) * p.x + (R(1, 1) * p.y + R(1, 2) * p.z) + t.y();
      z[i] = R(2, 0) * p.x + (R(2, 1) * p.y + R(2, 2) * p.z) + t.z();
    }
  }

  std::size_t size() const { return x.size(); }

  Eigen::Vector3d origin;
  std::vector<float> x, y, z;
};

/// The cells of the map's grid in which points lie, an array for each coordinate.
class PointCells {
 public:
  static constexpr int kNone = std::numeric_limits<int>::min() / 2;

  /// Points further than `farthest` from the origin have no cell, m.
  PointCells(const PlacedPoints& points, double cell, float farthest)
      : x_(points.size()), y_(points.size()) {
    const auto scale = static_cast<float>(1.0 / cell);
    const auto origin_x = static_cast<int>(std::lround(points.origin.x() / cell));
    const auto origin_y = static_cast<int>(std::lround(points.origin.y() / cell));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int is_near =
          (std::abs(points.x[i]) < farthest ? 1 : 0) & (std::abs(points.y[i]) < farthest ? 1 : 0);
      const float x = is_near != 0 ? points.x[i] : 0.0F;
      const float y = is_near != 0 ? points.y[i] : 0.0F;
      x_[i] = is_near != 0 ? floor_to_int(x * scale) + origin_x : kNone;
      y_[i] = is_near != 0 ? floor_to_int(y * scale) + origin_y : kNone;
    }
  }

  std::size_t size() const { return x_.size(); }
  /// Of the i-th point; x is kNone if it is out of reach.
  CellIndex at(std::size_t i) const { return {x_[i], y_[i]}; }

 private:
  std::vector<int> x_, y_;
};

/// The rectangle of cells in which some points lie, numbered row by row.
class CellArea {
 public:
  static constexpr std::uint32_t kOutside = std::numeric_limits<std::uint32_t>::max();

  explicit CellArea(const PointCells& cells) : CellArea(cells, [](std::size_t) { return true; }) {}

  /// Of those points that are `taken`, by their number.
  template <typename Taken>
  CellArea(const PointCells& cells, const Taken& taken) {
    constexpr int kLowest = std::numeric_limits<int>::min();
    constexpr int kHighest = std::numeric_limits<int>::max();
    CellIndex first = {kHighest, kHighest};
    CellIndex last = {kLowest, kLowest};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const CellIndex cell = cells.at(i);
      const bool counts = cell.x != PointCells::kNone && taken(i);
      first = {std::min(first.x, counts ? cell.x : kHighest),
               std::min(first.y, counts ? cell.y : kHighest)};
      last = {std::max(last.x, counts ? cell.x : kLowest),
              std::max(last.y, counts ? cell.y : kLowest)};
    }
    if (last.x == kLowest) return;
    first_ = first;
    width_ = last.x - first.x + 1;
    height_ = last.y - first.y + 1;
  }

  /// kOutside where none of the points is in reach.
  std::uint32_t number_of(const CellIndex& cell) const {
    const auto column = static_cast<std::uint32_t>(cell.x) - static_cast<std::uint32_t>(first_.x);
    const auto row = static_cast<std::uint32_t>(cell.y) - static_cast<std::uint32_t>(first_.y);
    const bool is_inside =
        column < static_cast<std::uint32_t>(width_) && row < static_cast<std::uint32_t>(height_);
    return is_inside ? row * static_cast<std::uint32_t>(width_) + column : kOutside;
  }
  /// Those of the cells of points.
  std::vector<std::uint32_t> numbers_of(const PointCells& cells) const {
    std::vector<std::uint32_t> numbers(cells.size());
    const CellArea area = *this;
    for (std::size_t i = 0; i < cells.size(); ++i) numbers[i] = area.number_of(cells.at(i));
    return numbers;
  }
  CellIndex cell_at(std::size_t number) const {
    return {first_.x + static_cast<int>(number % width()),
            first_.y + static_cast<int>(number / width())};
  }
  /// With so many cells more on each side.
  CellArea widened(int cells) const {
    CellArea wide = *this;
    if (size() == 0) return wide;
    wide.first_ = {first_.x - cells, first_.y - cells};
    wide.width_ += 2 * cells;
    wide.height_ += 2 * cells;
    return wide;
  }
  std::size_t width() const { return static_cast<std::size_t>(width_); }
  std::size_t size() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }

 private:
  CellIndex first_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace lidar_mapping::moving_objects
