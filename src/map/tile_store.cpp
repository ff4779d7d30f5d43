// SPDX-License-Identifier: BSD-3-Clause
#include "tile_store.hpp"

#include <algorithm>
#include <numeric>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

bool is_finite(const Point& point) { return point.position().allFinite(); }

/// The points to insert into a tile, cloud by cloud.
struct TileInsertion {
  std::size_t points() const {
    return std::accumulate(
        sorted_clouds.begin(), sorted_clouds.end(), std::size_t{0},
        [](std::size_t sum, const std::vector<TilePoint>* part) { return sum + part->size(); });
  }

  VoxelTile* tile;
  std::vector<const std::vector<TilePoint>*> sorted_clouds;
};

}  // namespace

TileStore::TileStore(double resolution, double tile_size, int threads)
    : grid_(resolution, tile_size), threads_(threads) {}

std::vector<std::vector<TileIndex>> TileStore::add(const std::vector<CloudWithPose>& clouds,
                                                   const std::set<TileIndex>* only) {
  const std::vector<PointsByTile> sorted_clouds = sort_into_tiles(clouds, only);
  insert(sorted_clouds);
  std::vector<std::vector<TileIndex>> touched(clouds.size());
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    for (const auto& [index, points] : sorted_clouds[i]) touched[i].push_back(index);
  }
  return touched;
}

std::vector<TileStore::PointsByTile> TileStore::sort_into_tiles(
    const std::vector<CloudWithPose>& clouds, const std::set<TileIndex>* only) const {
  std::vector<PointsByTile> sorted_clouds(clouds.size());
  parallel_chunks(clouds.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sorted_clouds[i] = points_by_tile(clouds[i], only);
  });
  return sorted_clouds;
}

void TileStore::insert(const std::vector<PointsByTile>& clouds) {
  std::map<TileIndex, std::vector<const std::vector<TilePoint>*>> by_tile;
  for (const PointsByTile& cloud : clouds) {
    for (const auto& [index, points] : cloud) by_tile[index].push_back(&points);
  }
  std::vector<TileInsertion> work;
  for (auto& [index, sorted_clouds] : by_tile)
    work.push_back({&tiles_[index], std::move(sorted_clouds)});
  // Most points lie in few of the tiles: the largest tasks start first.
  std::sort(work.begin(), work.end(),
            [](const TileInsertion& a, const TileInsertion& b) { return a.points() > b.points(); });
  parallel_chunks(work.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const auto* points : work[i].sorted_clouds) work[i].tile->insert(*points);
    }
  });
}

std::vector<TileIndex> TileStore::tiles_of(const CloudWithPose& cloud) const {
  std::set<TileIndex> tiles;
  for (const Point& point : cloud.cloud->points) {
    if (!is_finite(point)) continue;
    const Eigen::Vector3d p_map = cloud.T_map_base * point.position().cast<double>();
    tiles.insert(grid_.square_of(grid_.voxel_of(p_map)).tile());
  }
  return {tiles.begin(), tiles.end()};
}

TileStore::PointsByTile TileStore::points_by_tile(const CloudWithPose& cloud,
                                                  const std::set<TileIndex>* only) const {
  PointsByTile sorted;
  const Eigen::Matrix3d rotation = cloud.T_map_base.rotation_matrix();
  TileGrid::Square square;
  std::vector<TilePoint>* points = nullptr;  // null while the tile is not selected
  for (const Point& point : cloud.cloud->points) {
    if (!is_finite(point)) continue;
    const Eigen::Vector3d p_map =
        rotation * point.position().cast<double>() + cloud.T_map_base.translation;
    const TileGrid::WideVoxelIndex voxel = grid_.voxel_of(p_map);
    if (!square.contains(voxel)) {
      square = grid_.square_of(voxel);
      const bool is_selected = only == nullptr || only->count(square.tile()) > 0;
      points = is_selected ? &sorted[square.tile()] : nullptr;
    }
    if (points == nullptr) continue;
    const Eigen::Vector3f local = (p_map - square.origin()).cast<float>();
    points->push_back({square.key_of(voxel), {local.x(), local.y(), local.z(), point.intensity}});
  }
  return sorted;
}

void TileStore::clear(const std::set<TileIndex>& tiles) {
  for (const TileIndex& tile : tiles) tiles_.erase(tile);
}

PointCloud TileStore::merged_cloud() const {
  PointCloud cloud;
  for (const auto& [index, tile] : tiles_) tile.append_to(cloud, grid_.origin_of(index));
  return cloud;
}

MapTile TileStore::tile(const TileIndex& index) const {
  MapTile result;
  result.index = index;
  result.origin = grid_.origin_of(index);
  const auto found = tiles_.find(index);
  if (found != tiles_.end()) found->second.append_to(result.cloud, Eigen::Vector3d::Zero());
  return result;
}

}  // namespace lidar_mapping::map
