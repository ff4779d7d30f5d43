#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

constexpr float kFarthest = 300.0F;  // m; points of a key frame further away than this are ignored

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

/// Values by cells, as an array over the cells in which some points lie.
template <typename Value>
class CellGrid {
 public:
  /// Points further than `farthest` from the origin have no cell, m.
  CellGrid(const PlacedPoints& points, double cell, const Value& value, float farthest = kFarthest)
      : CellGrid(points, cell, value, farthest, [](std::size_t) { return true; }) {}

  /// Over those points that are `taken`, by their number.
  template <typename Taken>
  CellGrid(const PlacedPoints& points, double cell, const Value& value, float farthest,
           const Taken& taken)
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
    values_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), value);
  }

  /// Of the map's grid; a cell that find() does not know for points out of reach.
  CellIndex cell_of(const Eigen::Vector3f& point) const {
    if (!(point.head<2>().cwiseAbs().maxCoeff() < farthest_)) return kNoCell;
    return {floored(point.x() * scale_) + origin_.x, floored(point.y() * scale_) + origin_.y};
  }
  /// Null where none of the points is in reach.
  Value* find(const CellIndex& cell) { return contains(cell) ? &values_[at(cell)] : nullptr; }
  const Value* find(const CellIndex& cell) const {
    return contains(cell) ? &values_[at(cell)] : nullptr;
  }

 private:
  static constexpr CellIndex kNoCell = {std::numeric_limits<int>::min() / 2,
                                        std::numeric_limits<int>::min() / 2};

  static int floored(float value) {  // cheaper than std::floor
    const int truncated = static_cast<int>(value);
    return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
  }
  bool contains(const CellIndex& cell) const {
    return cell.x >= first_.x && cell.x < first_.x + width_ && cell.y >= first_.y &&
           cell.y < first_.y + height_;
  }
  std::size_t at(const CellIndex& cell) const {
    return static_cast<std::size_t>(cell.y - first_.y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(cell.x - first_.x);
  }

  float scale_;
  float farthest_;
  CellIndex origin_;
  CellIndex first_;
  int width_ = 0;
  int height_ = 0;
  std::vector<Value> values_;
};

}  // namespace lidar_mapping::map
