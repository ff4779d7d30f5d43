// SPDX-License-Identifier: BSD-3-Clause
#include "grid/free_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

// m, longest part of a ray. Chosen: further out, an attitude that is wrong by 0.2 degrees puts its
// height off by more than the lowest obstacles (0.2 m).
constexpr double kMaxRayLength = 50.0;
constexpr std::size_t kBatch = 16;  // clouds in memory at a time; chosen: one for each thread
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Parameter of the line start + t * direction at its next border between cells, and its increment
/// from one border to the next.
struct Crossings {
  Crossings(double start, double direction, int cell)
      : step(direction > 0.0 ? 1 : -1),
        increment(direction != 0.0 ? 1.0 / std::abs(direction) : kInfinity) {
    const double border = direction > 0.0 ? cell + 1 : cell;
    next = direction != 0.0 ? (border - start) / direction : kInfinity;
  }

  int step;
  double increment;
  double next;
};

}  // namespace

FreeSpace::FreeSpace(const GridFrame& frame, const GridBlock& block, const GroundRaster& ground,
                     const GridOptions& options)
    : frame_(frame), block_(block), ground_(ground), options_(options), passed_(block.size()) {
  for (int i = 0; i < block.columns; ++i) {
    ground_columns_.push_back(GroundRaster::cell_of(frame.x_of(block.column + i + 0.5)));
  }
  for (int i = 0; i < block.rows; ++i) {
    ground_rows_.push_back(GroundRaster::cell_of(frame.y_of(block.row + i + 0.5)));
  }
}

void FreeSpace::carve(const GridRays& rays) {
  std::vector<KeyFramePose> near;
  for (const KeyFramePose& pose : rays.poses.poses) {
    if (is_within_reach(pose.T_map_base * rays.p_base_sensor)) near.push_back(pose);
  }
  for (std::size_t begin = 0; begin < near.size(); begin += kBatch) {
    std::vector<KeyFrameIndex> indices;
    for (std::size_t i = begin; i < std::min(near.size(), begin + kBatch); ++i) {
      indices.push_back(near[i].index);
    }
    const std::vector<PointCloudPtr> clouds = rays.clouds.clouds(indices, options_.threads);
    parallel_chunks(clouds.size(), 1, options_.threads, [&](std::size_t i, std::size_t) {
      if (clouds[i]) carve(*clouds[i], near[begin + i].T_map_base, rays.p_base_sensor);
    });
  }
}

bool FreeSpace::is_within_reach(const Eigen::Vector3d& p_map) const {
  return p_map.x() > frame_.x_of(block_.column) - kMaxRayLength &&
         p_map.x() < frame_.x_of(block_.column + block_.columns) + kMaxRayLength &&
         p_map.y() > frame_.y_of(block_.row) - kMaxRayLength &&
         p_map.y() < frame_.y_of(block_.row + block_.rows) + kMaxRayLength;
}

void FreeSpace::carve(const PointCloud& cloud, const Pose& T_map_base,
                      const Eigen::Vector3d& p_base_sensor) {
  const Eigen::Matrix3d rotation = T_map_base.rotation_matrix();
  const Eigen::Vector3d start = in_block(T_map_base * p_base_sensor);
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d target =
        in_block(rotation * point.position().cast<double>() + T_map_base.translation);
    if (target.allFinite()) carve(Ray{start, target - start});
  }
}

Eigen::Vector3d FreeSpace::in_block(const Eigen::Vector3d& p_map) const {
  return {(p_map.x() - frame_.x_of(block_.column)) / frame_.cell,
          (p_map.y() - frame_.y_of(block_.row)) / frame_.cell, p_map.z()};
}

/// The part of the ray that lies in the block, within kMaxRayLength of the sensor, and not far
/// above or below all of its ground.
FreeSpace::Interval FreeSpace::clipped_interval(const Ray& ray) const {
  const double length = frame_.cell * ray.direction.head<2>().norm();
  Interval interval{0.0, std::min(1.0, kMaxRayLength / std::max(length, 1e-9))};
  const Eigen::Vector3d low(0.0, 0.0, static_cast<double>(ground_.lowest()) - options_.lowest);
  const Eigen::Vector3d high(block_.columns, block_.rows,
                             static_cast<double>(ground_.highest()) + options_.highest);
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0.0) {
      if (ray.start[axis] < low[axis] || ray.start[axis] > high[axis]) return {1.0, 0.0};
      continue;
    }
    const double a = (low[axis] - ray.start[axis]) / ray.direction[axis];
    const double b = (high[axis] - ray.start[axis]) / ray.direction[axis];
    interval.begin = std::max(interval.begin, std::min(a, b));
    interval.end = std::min(interval.end, std::max(a, b));
  }
  return interval;
}

/// Visits the cells along the ray (Amanatides and Woo 1987).
void FreeSpace::carve(const Ray& ray) {
  const Interval interval = clipped_interval(ray);
  if (interval.begin >= interval.end) return;
  const auto cell_at = [&](int axis, int count) {
    const double at = std::floor(ray.start[axis] + interval.begin * ray.direction[axis]);
    return std::clamp(static_cast<int>(at), 0, count - 1);
  };
  int column = cell_at(0, block_.columns);
  int row = cell_at(1, block_.rows);
  Crossings across(ray.start.x(), ray.direction.x(), column);
  Crossings along(ray.start.y(), ray.direction.y(), row);
  double entry = interval.begin;
  while (column >= 0 && column < block_.columns && row >= 0 && row < block_.rows) {
    const double exit = std::min({across.next, along.next, interval.end});
    mark_passed(column, row, ray.start.z() + 0.5 * (entry + exit) * ray.direction.z());
    if (exit >= interval.end) return;
    Crossings& crossed = across.next < along.next ? across : along;
    (across.next < along.next ? column : row) += crossed.step;
    crossed.next += crossed.increment;
    entry = exit;
  }
}

void FreeSpace::mark_passed(int column, int row, double z) {
  std::atomic<std::uint8_t>& cell =
      passed_[static_cast<std::size_t>(row) * static_cast<std::size_t>(block_.columns) +
              static_cast<std::size_t>(column)];
  if (cell.load(std::memory_order_relaxed) != 0) return;
  const double height =
      z - static_cast<double>(ground_.at(ground_columns_[column], ground_rows_[row]));
  if (height > -options_.lowest && height <= options_.highest) {
    cell.store(1, std::memory_order_relaxed);
  }
}

}  // namespace lidar_mapping::map
