// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/tile_store.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

/// The points to insert into a tile, cloud by cloud.
struct TileInsertion {
  std::size_t points() const {
    return std::accumulate(
        parts.begin(), parts.end(), std::size_t{0},
        [](std::size_t sum, const auto& part) { return sum + part.second->size(); });
  }

  VoxelTile* tile;
  std::vector<std::pair<KeyFrameIndex, const std::vector<TilePoint>*>> parts;
};

std::vector<TileIndex> indices_of(const TileStore::PointsByTile& cloud) {
  std::vector<TileIndex> indices;
  for (const auto& [index, points] : cloud.tiles) indices.push_back(index);
  return indices;
}

}  // namespace

TileStore::TileStore(double resolution, double tile_size, int threads)
    : grid_(resolution, tile_size), threads_(threads) {}

std::vector<std::vector<TileIndex>> TileStore::add(const std::vector<CloudWithPose>& clouds,
                                                   const std::set<TileIndex>* only) {
  const std::vector<PointsByTile> sorted_clouds = sort_into_tiles(clouds, only);
  insert(sorted_clouds);
  std::vector<std::vector<TileIndex>> touched;
  for (const PointsByTile& cloud : sorted_clouds) touched.push_back(indices_of(cloud));
  return touched;
}

std::vector<TileStore::PointsByTile> TileStore::sort_into_tiles(
    const std::vector<CloudWithPose>& clouds, const std::set<TileIndex>* only) const {
  std::vector<PointsByTile> sorted_clouds(clouds.size());
  parallel_chunks(clouds.size(), 1, threads_, [&](std::size_t i, std::size_t) {
    sorted_clouds[i] = points_by_tile(clouds[i], only);
  });
  return sorted_clouds;
}

void TileStore::insert(const std::vector<PointsByTile>& clouds) {
  std::map<TileIndex, TileInsertion> by_tile;
  for (const PointsByTile& cloud : clouds) {
    for (const auto& [index, points] : cloud.tiles) {
      by_tile[index].parts.emplace_back(cloud.key_frame, &points);
    }
  }
  std::vector<TileInsertion> work;
  for (auto& [index, insertion] : by_tile) {
    insertion.tile = &tiles_[index];
    work.push_back(std::move(insertion));
  }
  // Most points lie in few of the tiles: the largest tasks start first.
  std::sort(work.begin(), work.end(),
            [](const TileInsertion& a, const TileInsertion& b) { return a.points() > b.points(); });
  parallel_chunks(work.size(), 1, threads_, [&](std::size_t i, std::size_t) {
    for (const auto& [key_frame, points] : work[i].parts) {
      work[i].tile->insert(*points, key_frame);
    }
  });
}

std::vector<TileIndex> TileStore::tiles_of(const CloudWithPose& cloud) const {
  return indices_of(points_by_tile(cloud, nullptr));
}

TileStore::PointsByTile TileStore::points_by_tile(const CloudWithPose& cloud,
                                                  const std::set<TileIndex>* only) const {
  PointsByTile sorted;
  sorted.key_frame = cloud.key_frame;
  const Eigen::Matrix3d rotation = cloud.T_map_base.rotation_matrix();
  TileGrid::Square square;
  std::vector<TilePoint>* points = nullptr;  // null while the tile is not selected
  for (const Point& point : cloud.cloud->points) {
    if (!point.position().allFinite()) continue;
    const Eigen::Vector3d p_map =
        rotation * point.position().cast<double>() + cloud.T_map_base.translation;
    const TileGrid::WideVoxelIndex voxel = grid_.voxel_of(p_map);
    if (!square.contains(voxel)) {
      square = grid_.square_of(voxel);
      const bool is_selected = only == nullptr || only->count(square.tile) > 0;
      points = is_selected ? &sorted.tiles[square.tile] : nullptr;
    }
    if (points == nullptr) continue;
    const Eigen::Vector3f local = (p_map - square.origin).cast<float>();
    points->push_back({square.key_of(voxel), {local.x(), local.y(), local.z(), point.intensity}});
  }
  return sorted;
}

void TileStore::clear(const std::set<TileIndex>& tiles) {
  for (const TileIndex& tile : tiles) tiles_.erase(tile);
}

PointCloud TileStore::merged_cloud() const {
  std::size_t points = 0;
  for (const auto& [index, tile] : tiles_) points += tile.size();
  PointCloud cloud;
  cloud.points.reserve(points);
  for (const auto& [index, tile] : tiles_) tile.append_to(cloud, grid_.origin_of(index));
  return cloud;
}

MapTile TileStore::tile(const TileIndex& index) const {
  MapTile result;
  result.index = index;
  result.origin = grid_.origin_of(index);
  const auto found = tiles_.find(index);
  if (found == tiles_.end()) return result;
  found->second.append_to(result.cloud, Eigen::Vector3d::Zero());
  result.key_frames = found->second.key_frames();
  return result;
}

}  // namespace lidar_mapping::map
