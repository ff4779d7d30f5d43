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
      file_(directory_),
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
  if (!pending_file_) pending_file_ = std::make_unique<NamelessFile>(directory_);
  const std::size_t bytes = tile.buffer.size() * sizeof(Point);
  pending_file_->write(pending_bytes_, tile.buffer.data(), bytes);
  tile.parts.push_back({pending_bytes_, tile.buffer.size()});
  pending_bytes_ += bytes;
  tile.buffer.clear();
}

PointCloud PointTiles::collected(const PendingTile& tile) const {
  PointCloud cloud;
  cloud.points.resize(tile.parts.size() * kBuffer);
  std::size_t count = 0;
  for (const Part& part : tile.parts) {
    pending_file_->read(part.offset, cloud.points.data() + count, part.count * sizeof(Point));
    count += part.count;
  }
  cloud.points.insert(cloud.points.end(), tile.buffer.begin(), tile.buffer.end());
  return cloud;
}

void PointTiles::finish() {
  std::uint64_t offset = 0;
  while (!pending_.empty()) {
    const auto first = pending_.begin();
    const PointCloud cloud = voxel_filtered(collected(first->second), resolution_);
    const std::size_t bytes = cloud.size() * sizeof(Point);
    file_.write(offset, cloud.points.data(), bytes);
    stored_[first->first] = {offset, cloud.size()};
    offset += bytes;
    thinned_ += cloud.size();
    pending_.erase(first);
  }
  pending_file_.reset();
}

std::vector<PointTileIndex> PointTiles::indices() const {
  std::vector<PointTileIndex> indices;
  for (const auto& [index, part] : stored_) indices.push_back(index);
  return indices;
}

std::vector<PointTileIndex> PointTiles::indices_around(const Eigen::Vector3d& p_map,
                                                       double radius) const {
  const PointTileIndex low = index_of(p_map - Eigen::Vector3d::Constant(radius));
  const PointTileIndex high = index_of(p_map + Eigen::Vector3d::Constant(radius));
  std::vector<PointTileIndex> indices;
  for (std::int64_t column = low.column; column <= high.column; ++column) {
    for (auto tile = stored_.lower_bound({column, low.row});
         tile != stored_.end() && tile->first.column == column && tile->first.row <= high.row;
         ++tile) {
      indices.push_back(tile->first);
    }
  }
  return indices;
}

PointTilePtr PointTiles::tile(const PointTileIndex& index) {
  if (const PointTilePtr* const cached = cache_.find(index)) return *cached;
  const Part part = stored_.at(index);
  auto tile = std::make_shared<PointTile>();
  tile->origin = origin_of(index);
  tile->cloud.points.resize(part.count);
  file_.read(part.offset, tile->cloud.points.data(), part.count * sizeof(Point));
  return cache_.insert(index, tile, part.count);
}

}  // namespace lidar_mapping::map_import
