// SPDX-License-Identifier: BSD-3-Clause
#include "point_tiles.hpp"

#include <cmath>
#include <utility>

#include "lidar_mapping/common/voxel_filter.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::map_import {

namespace {

constexpr std::size_t kBuffer = 1024;  // points, 16 kB for each square; chosen: few large writes

PointTileIndex index_of(const Eigen::Vector3d& p_map) {
  return {floor_to_int(p_map.x() / PointTiles::kEdge), floor_to_int(p_map.y() / PointTiles::kEdge)};
}

}  // namespace

PointTiles::PointTiles(std::filesystem::path directory, double resolution, std::size_t most_cached)
    : directory_(std::move(directory)),
      resolution_(resolution),
      pending_parts_(directory_),
      stored_(directory_),
      cache_(most_cached) {}

/// Floats near the ground are exact: heights count from the first point.
Eigen::Vector3d PointTiles::origin_of(const PointTileIndex& index) const {
  return {static_cast<double>(index.column * kEdge), static_cast<double>(index.row * kEdge),
          height_};
}

void PointTiles::add(const std::vector<MapPoint>& points) {
  for (const MapPoint& point : points) {
    if (points_++ == 0) height_ = std::round(point.p_map.z());
    bounds_.extend(point.p_map);
    const PointTileIndex index = index_of(point.p_map);
    PendingTile& tile = pending_[index];
    const Eigen::Vector3f p = (point.p_map - origin_of(index)).cast<float>();
    tile.buffer.push_back({p.x(), p.y(), p.z(), point.intensity});
    if (tile.buffer.size() == kBuffer) store(tile);
  }
}

void PointTiles::store(PendingTile& tile) {
  tile.parts.push_back(pending_parts_.size());
  pending_parts_.put(tile.parts.back(), tile.buffer);
  tile.buffer.clear();
}

PointCloud PointTiles::collected(const PendingTile& tile) const {
  PointCloud cloud;
  cloud.points.reserve(tile.parts.size() * kBuffer + tile.buffer.size());
  for (const std::size_t number : tile.parts) {
    const std::vector<Point> part = pending_parts_.get(number);
    cloud.points.insert(cloud.points.end(), part.begin(), part.end());
  }
  cloud.points.insert(cloud.points.end(), tile.buffer.begin(), tile.buffer.end());
  return cloud;
}

void PointTiles::finish() {
  for (; !pending_.empty(); pending_.erase(pending_.begin())) {
    const auto& [index, tile] = *pending_.begin();
    const PointCloud cloud = voxel_filtered(collected(tile), resolution_);
    stored_.put(index, cloud.points);
    thinned_ += cloud.size();
  }
  pending_parts_ = ListFile<std::size_t, Point>(directory_);
}

std::vector<PointTileIndex> PointTiles::indices_around(const Eigen::Vector3d& p_map,
                                                       double radius) const {
  const PointTileIndex low = index_of(p_map - Eigen::Vector3d::Constant(radius));
  const PointTileIndex high = index_of(p_map + Eigen::Vector3d::Constant(radius));
  std::vector<PointTileIndex> indices;
  for (std::int64_t column = low.column; column <= high.column; ++column) {
    for (std::int64_t row = low.row; row <= high.row; ++row) {
      if (stored_.contains({column, row})) indices.push_back({column, row});
    }
  }
  return indices;
}

std::uint64_t PointTiles::points_outside(const Eigen::AlignedBox3d& box) {
  std::uint64_t count = 0;
  for (const PointTileIndex& index : indices()) {
    const PointTilePtr square = tile(index);
    for (const Point& point : square->cloud.points) {
      const Eigen::Vector3d p_map = square->origin + point.position().cast<double>();
      if (!box.contains(p_map)) ++count;
    }
  }
  return count;
}

PointTilePtr PointTiles::tile(const PointTileIndex& index) {
  if (const PointTilePtr* const cached = cache_.find(index)) return *cached;
  auto tile = std::make_shared<PointTile>();
  tile->origin = origin_of(index);
  tile->cloud.points = stored_.get(index);
  cache_.insert(index, tile, tile->cloud.size());
  return tile;
}

}  // namespace lidar_mapping::map_import
