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

/// Points of a key frame that are further away than this are ignored, m. Chosen: beyond the range
/// of LiDARs on vehicles, and bounds the memory of grids around a key frame.
constexpr float kMaxRange = 300.0F;

/// Cell of a grid over the x-y plane of the map, counted from the map's origin.
struct CellIndex {
  int x = 0;  ///< Number along x.
  int y = 0;  ///< Number along y.
};

/// Points of a cloud in axes parallel to those of the map. They are relative to an origin near the
/// vehicle, so that floats hold them; the origin is a corner of every grid used here, so that cells
/// are the same for all clouds. Each coordinate has an array of its own, as vector instructions
/// need it.
struct TransformedPoints {
  /// Spacing of possible origins, m: the least common multiple of the cells of 0.3, 0.4, 0.5 and
  /// 0.6 m, so that each origin is a corner of all of these grids.
  static constexpr double kOriginGrid = 6.0;

  /// Transforms the points of a cloud in base_link.
  TransformedPoints(const PointCloud& cloud, const Pose& T_map_base)
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

  /// Number of points.
  std::size_t size() const { return x.size(); }

  Eigen::Vector3d origin;  ///< Origin of the coordinates in the map frame, m.
  std::vector<float> x;    ///< Relative to the origin, m.
  std::vector<float> y;    ///< Relative to the origin, m.
  std::vector<float> z;    ///< Relative to the origin, m.
};

/// Cells of a grid over the map in which points lie, with an array for each coordinate.
class PointCells {
 public:
  /// Number of a point that has no cell. Chosen: half of the range, so that differences do not
  /// overflow.
  static constexpr int kNone = std::numeric_limits<int>::min() / 2;

  /// Cells of edge `cell` (m). Points further than `max_range` (m) from their origin have no cell.
  PointCells(const TransformedPoints& points, double cell, float max_range)
      : x_(points.size()), y_(points.size()) {
    const auto scale = static_cast<float>(1.0 / cell);
    const auto origin_x = static_cast<int>(std::lround(points.origin.x() / cell));
    const auto origin_y = static_cast<int>(std::lround(points.origin.y() / cell));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int is_near =
          (std::abs(points.x[i]) < max_range ? 1 : 0) & (std::abs(points.y[i]) < max_range ? 1 : 0);
      const float x = is_near != 0 ? points.x[i] : 0.0F;
      const float y = is_near != 0 ? points.y[i] : 0.0F;
      x_[i] = is_near != 0 ? floor_to_int(x * scale) + origin_x : kNone;
      y_[i] = is_near != 0 ? floor_to_int(y * scale) + origin_y : kNone;
    }
  }

  /// Number of points.
  std::size_t size() const { return x_.size(); }
  /// Cell of the i-th point; its x is kNone if the point has none.
  CellIndex at(std::size_t i) const { return {x_[i], y_[i]}; }

 private:
  std::vector<int> x_, y_;
};

/// Smallest rectangle of cells that holds some points; its cells are numbered row by row.
class CellRectangle {
 public:
  /// Number of all cells outside of the rectangle.
  static constexpr std::uint32_t kOutside = std::numeric_limits<std::uint32_t>::max();

  /// Rectangle around all points that have a cell.
  explicit CellRectangle(const PointCells& cells)
      : CellRectangle(cells, [](std::size_t) { return true; }) {}

  /// Rectangle around those points for whose numbers `is_selected` returns true.
  template <typename Predicate>
  CellRectangle(const PointCells& cells, const Predicate& is_selected) {
    constexpr int kLowest = std::numeric_limits<int>::min();
    constexpr int kHighest = std::numeric_limits<int>::max();
    CellIndex first = {kHighest, kHighest};
    CellIndex last = {kLowest, kLowest};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const CellIndex cell = cells.at(i);
      const bool is_used = cell.x != PointCells::kNone && is_selected(i);
      first = {std::min(first.x, is_used ? cell.x : kHighest),
               std::min(first.y, is_used ? cell.y : kHighest)};
      last = {std::max(last.x, is_used ? cell.x : kLowest),
              std::max(last.y, is_used ? cell.y : kLowest)};
    }
    if (last.x == kLowest) return;
    first_ = first;
    width_ = last.x - first.x + 1;
    height_ = last.y - first.y + 1;
  }

  /// Number of a cell of the rectangle, or kOutside.
  std::uint32_t index_of(const CellIndex& cell) const {
    const auto column = static_cast<std::uint32_t>(cell.x) - static_cast<std::uint32_t>(first_.x);
    const auto row = static_cast<std::uint32_t>(cell.y) - static_cast<std::uint32_t>(first_.y);
    const bool is_inside =
        column < static_cast<std::uint32_t>(width_) && row < static_cast<std::uint32_t>(height_);
    return is_inside ? row * static_cast<std::uint32_t>(width_) + column : kOutside;
  }
  /// Numbers of the cells in which the points lie, or kOutside.
  std::vector<std::uint32_t> indices_of(const PointCells& cells) const {
    std::vector<std::uint32_t> numbers(cells.size());
    const CellRectangle rectangle = *this;
    for (std::size_t i = 0; i < cells.size(); ++i) numbers[i] = rectangle.index_of(cells.at(i));
    return numbers;
  }
  /// Cell of this number.
  CellIndex cell_at(std::size_t number) const {
    return {first_.x + static_cast<int>(number % width()),
            first_.y + static_cast<int>(number / width())};
  }
  /// The rectangle with `cells` more cells on each side; an empty one stays empty.
  CellRectangle expanded(int cells) const {
    CellRectangle expanded_rectangle = *this;
    if (size() == 0) return expanded_rectangle;
    expanded_rectangle.first_ = {first_.x - cells, first_.y - cells};
    expanded_rectangle.width_ += 2 * cells;
    expanded_rectangle.height_ += 2 * cells;
    return expanded_rectangle;
  }
  /// Number of cells along x.
  std::size_t width() const { return static_cast<std::size_t>(width_); }
  /// Number of cells.
  std::size_t size() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }

 private:
  CellIndex first_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace lidar_mapping::moving_objects
