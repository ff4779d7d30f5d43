// SPDX-License-Identifier: BSD-3-Clause
#include "tile_store.hpp"

#include <algorithm>
#include <numeric>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

bool is_finite(const Point& point) { return point.position().allFinite(); }

/// What falls into a tile, cloud by cloud.
struct TileWork {
  std::size_t points() const {
    return std::accumulate(
        parts.begin(), parts.end(), std::size_t{0},
        [](std::size_t sum, const std::vector<TilePoint>* part) { return sum + part->size(); });
  }

  VoxelTile* tile;
  std::vector<const std::vector<TilePoint>*> parts;
};

}  // namespace

TileStore::TileStore(double resolution, double tile_size, int threads)
    : grid_(resolution, tile_size), threads_(threads) {}

std::vector<std::vector<TileIndex>> TileStore::add(const std::vector<PlacedCloud>& clouds,
                                                   const std::set<TileIndex>* only) {
  const std::vector<Sorted> parts = sorted(clouds, only);
  insert(parts);
  std::vector<std::vector<TileIndex>> touched(clouds.size());
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    for (const auto& [index, points] : parts[i]) touched[i].push_back(index);
  }
  return touched;
}

std::vector<TileStore::Sorted> TileStore::sorted(const std::vector<PlacedCloud>& clouds,
                                                 const std::set<TileIndex>* only) const {
  std::vector<Sorted> parts(clouds.size());
  parallel_chunks(clouds.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) parts[i] = sorted_into_tiles(clouds[i], only);
  });
  return parts;
}

void TileStore::insert(const std::vector<Sorted>& clouds) {
  std::map<TileIndex, std::vector<const std::vector<TilePoint>*>> by_tile;
  for (const Sorted& cloud : clouds) {
    for (const auto& [index, points] : cloud) by_tile[index].push_back(&points);
  }
  std::vector<TileWork> work;
  for (auto& [index, parts] : by_tile) work.push_back({&tiles_[index], std::move(parts)});
  // Much falls into few of the tiles: what takes longest is begun first.
  std::sort(work.begin(), work.end(),
            [](const TileWork& a, const TileWork& b) { return a.points() > b.points(); });
  parallel_chunks(work.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const auto* points : work[i].parts) work[i].tile->insert(*points);
    }
  });
}

std::vector<TileIndex> TileStore::tiles_of(const PlacedCloud& cloud) const {
  std::set<TileIndex> tiles;
  for (const Point& point : cloud.cloud->points) {
    if (!is_finite(point)) continue;
    const Eigen::Vector3d p_map = cloud.T_map_base * point.position().cast<double>();
    tiles.insert(grid_.square_of(grid_.voxel_of(p_map)).tile());
  }
  return {tiles.begin(), tiles.end()};
}

TileStore::Sorted TileStore::sorted_into_tiles(const PlacedCloud& cloud,
                                               const std::set<TileIndex>* only) const {
  Sorted sorted;
  const Eigen::Matrix3d rotation = cloud.T_map_base.rotation_matrix();
  TileGrid::Square square;
  std::vector<TilePoint>* points = nullptr;  // null: of a tile that is not wanted
  for (const Point& point : cloud.cloud->points) {
    if (!is_finite(point)) continue;
    const Eigen::Vector3d p_map =
        rotation * point.position().cast<double>() + cloud.T_map_base.translation;
    const TileGrid::VoxelIndex voxel = grid_.voxel_of(p_map);
    if (!square.holds(voxel)) {
      square = grid_.square_of(voxel);
      const bool is_wanted = only == nullptr || only->count(square.tile()) > 0;
      points = is_wanted ? &sorted[square.tile()] : nullptr;
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

PointCloud TileStore::joined() const {
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
