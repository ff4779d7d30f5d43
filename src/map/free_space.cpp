// SPDX-License-Identifier: BSD-3-Clause
#include "free_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

constexpr double kReach = 50.0;     // m, of a ray; further out it says too little about heights
constexpr std::size_t kBatch = 16;  // clouds in memory at a time
constexpr double kNever = std::numeric_limits<double>::infinity();

/// When a line that starts at `from` and goes on by `way` meets the next border between cells, and
/// how long it takes from each to the next.
struct Crossings {
  Crossings(double from, double way, int cell)
      : step(way > 0.0 ? 1 : -1), each(way != 0.0 ? 1.0 / std::abs(way) : kNever) {
    const double border = way > 0.0 ? cell + 1 : cell;
    next = way != 0.0 ? (border - from) / way : kNever;
  }

  int step;
  double each;
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
    if (is_near(pose.T_map_base * rays.p_base_sensor)) near.push_back(pose);
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

bool FreeSpace::is_near(const Eigen::Vector3d& p_map) const {
  return p_map.x() > frame_.x_of(block_.column) - kReach &&
         p_map.x() < frame_.x_of(block_.column + block_.columns) + kReach &&
         p_map.y() > frame_.y_of(block_.row) - kReach &&
         p_map.y() < frame_.y_of(block_.row + block_.rows) + kReach;
}

void FreeSpace::carve(const PointCloud& cloud, const Pose& T_map_base,
                      const Eigen::Vector3d& p_base_sensor) {
  const Eigen::Matrix3d rotation = T_map_base.rotation_matrix();
  const Eigen::Vector3d from = in_block(T_map_base * p_base_sensor);
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d to =
        in_block(rotation * point.position().cast<double>() + T_map_base.translation);
    if (to.allFinite()) carve(Ray{from, to - from});
  }
}

Eigen::Vector3d FreeSpace::in_block(const Eigen::Vector3d& p_map) const {
  return {(p_map.x() - frame_.x_of(block_.column)) / frame_.cell,
          (p_map.y() - frame_.y_of(block_.row)) / frame_.cell, p_map.z()};
}

/// What lies in the block, in reach, and not far above or below all of its ground.
FreeSpace::Part FreeSpace::part_of(const Ray& ray) const {
  const double length = frame_.cell * ray.way.head<2>().norm();
  Part part{0.0, std::min(1.0, kReach / std::max(length, 1e-9))};
  const Eigen::Vector3d low(0.0, 0.0, static_cast<double>(ground_.lowest()) - options_.lowest);
  const Eigen::Vector3d high(block_.columns, block_.rows,
                             static_cast<double>(ground_.highest()) + options_.highest);
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.way[axis] == 0.0) {
      if (ray.from[axis] < low[axis] || ray.from[axis] > high[axis]) return {1.0, 0.0};
      continue;
    }
    const double a = (low[axis] - ray.from[axis]) / ray.way[axis];
    const double b = (high[axis] - ray.from[axis]) / ray.way[axis];
    part.begin = std::max(part.begin, std::min(a, b));
    part.end = std::min(part.end, std::max(a, b));
  }
  return part;
}

/// From cell to cell, as Amanatides and Woo (1987) go.
void FreeSpace::carve(const Ray& ray) {
  const Part part = part_of(ray);
  if (part.begin >= part.end) return;
  const auto cell_at = [&](int axis, int count) {
    const double at = std::floor(ray.from[axis] + part.begin * ray.way[axis]);
    return std::clamp(static_cast<int>(at), 0, count - 1);
  };
  int column = cell_at(0, block_.columns);
  int row = cell_at(1, block_.rows);
  Crossings across(ray.from.x(), ray.way.x(), column);
  Crossings along(ray.from.y(), ray.way.y(), row);
  double entry = part.begin;
  while (column >= 0 && column < block_.columns && row >= 0 && row < block_.rows) {
    const double exit = std::min({across.next, along.next, part.end});
    pass(column, row, ray.from.z() + 0.5 * (entry + exit) * ray.way.z());
    if (exit >= part.end) return;
    Crossings& crossed = across.next < along.next ? across : along;
    (across.next < along.next ? column : row) += crossed.step;
    crossed.next += crossed.each;
    entry = exit;
  }
}

void FreeSpace::pass(int column, int row, double z) {
  std::atomic<std::uint8_t>& cell =
      passed_[static_cast<std::size_t>(row) * static_cast<std::size_t>(block_.columns) +
              static_cast<std::size_t>(column)];
  if (cell.load(std::memory_order_relaxed) != 0) return;
  const double height =
      z - static_cast<double>(ground_.at(ground_columns_[static_cast<std::size_t>(column)],
                                         ground_rows_[static_cast<std::size_t>(row)]));
  if (height > -options_.lowest && height <= options_.highest) {
    cell.store(1, std::memory_order_relaxed);
  }
}

}  // namespace lidar_mapping::map
