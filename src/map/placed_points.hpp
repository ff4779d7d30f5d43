#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

constexpr float kFarthest = 300.0F;  // m; points of a key frame further away than this are ignored

/// Cheaper than std::floor, which is a call on processors without SSE 4.1.
inline int floored(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

/// A square of a grid over the map's x-y plane.
struct CellIndex {
  int x = 0;
  int y = 0;
};

/// Points in axes parallel to the map's, relative to an origin that is a corner of every grid used
/// here, so that floats hold them and cells are the same for all clouds.
struct PlacedPoints {
  static constexpr double kOriginGrid = 6.0;  // m, a multiple of 0.3, 0.4, 0.5 and 0.6

  PlacedPoints(const PointCloud& cloud, const Pose& T_map_base)
      : origin(((T_map_base.translation / kOriginGrid).array().floor() * kOriginGrid)) {
    const Eigen::Matrix3f rotation = T_map_base.rotation_matrix().cast<float>();
    const Eigen::Vector3f offset = (T_map_base.translation - origin).cast<float>();
    points.reserve(cloud.size());
    for (const Point& point : cloud.points) points.push_back(rotation * point.position() + offset);
  }

  std::size_t size() const { return points.size(); }

  Eigen::Vector3d origin;
  std::vector<Eigen::Vector3f> points;
};

/// The cells in which some points lie, numbered row by row over a rectangle.
class CellArea {
 public:
  static constexpr std::size_t kOutside = std::numeric_limits<std::size_t>::max();

  /// Points further than `farthest` from the origin have no cell, m.
  CellArea(const PlacedPoints& points, double cell, float farthest)
      : CellArea(points, cell, farthest, [](std::size_t) { return true; }) {}

  /// Of those points that are `taken`, by their number.
  template <typename Taken>
  CellArea(const PlacedPoints& points, double cell, float farthest, const Taken& taken)
      : scale_(static_cast<float>(1.0 / cell)),
        farthest_(farthest),
        origin_{static_cast<int>(std::lround(points.origin.x() / cell)),
                static_cast<int>(std::lround(points.origin.y() / cell))} {
    CellIndex last = kNoCell;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!taken(i)) continue;
      const CellIndex cell_index = cell_of(points.points[i]);
      if (cell_index.x == kNoCell.x) continue;
      if (last.x == kNoCell.x) first_ = last = cell_index;
      first_ = {std::min(first_.x, cell_index.x), std::min(first_.y, cell_index.y)};
      last = {std::max(last.x, cell_index.x), std::max(last.y, cell_index.y)};
    }
    if (last.x == kNoCell.x) return;
    width_ = last.x - first_.x + 1;
    height_ = last.y - first_.y + 1;
  }

  /// Of the map's grid; one that is outside for points out of reach.
  CellIndex cell_of(const Eigen::Vector3f& point) const {
    if (!(point.head<2>().cwiseAbs().maxCoeff() < farthest_)) return kNoCell;
    return {floored(point.x() * scale_) + origin_.x, floored(point.y() * scale_) + origin_.y};
  }
  /// kOutside where none of the points is in reach.
  std::size_t number_of(const CellIndex& cell) const {
    const bool is_inside = cell.x >= first_.x && cell.x < first_.x + width_ && cell.y >= first_.y &&
                           cell.y < first_.y + height_;
    if (!is_inside) return kOutside;
    return static_cast<std::size_t>(cell.y - first_.y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(cell.x - first_.x);
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
  static constexpr CellIndex kNoCell = {std::numeric_limits<int>::min() / 2,
                                        std::numeric_limits<int>::min() / 2};

  float scale_;
  float farthest_;
  CellIndex origin_;
  CellIndex first_;
  int width_ = 0;
  int height_ = 0;
};

/// Values by cells, as an array over an area.
template <typename Value>
class CellGrid {
 public:
  CellGrid(const CellArea& area, const Value& value) : area_(area), values_(area.size(), value) {}

  const CellArea& area() const { return area_; }
  CellIndex cell_of(const Eigen::Vector3f& point) const { return area_.cell_of(point); }
  /// Null outside the area.
  Value* find(const CellIndex& cell) { return found(values_, area_.number_of(cell)); }
  const Value* find(const CellIndex& cell) const { return found(values_, area_.number_of(cell)); }
  Value& at(std::size_t number) { return values_[number]; }
  const Value& at(std::size_t number) const { return values_[number]; }

 private:
  template <typename Values>
  static auto found(Values& values, std::size_t number) {
    return number == CellArea::kOutside ? nullptr : &values[number];
  }

  CellArea area_;
  std::vector<Value> values_;
};

}  // namespace lidar_mapping::map
