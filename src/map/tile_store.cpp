#include "tile_store.hpp"

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::map {

namespace {

bool is_finite(const Point& point) { return point.position().allFinite(); }

}  // namespace

TileStore::TileStore(double resolution, double tile_size, int threads)
    : grid_(resolution, tile_size), threads_(threads) {}

std::vector<std::vector<TileIndex>> TileStore::add(const std::vector<PlacedCloud>& clouds,
                                                   const std::set<TileIndex>* only) {
  std::vector<Sorted> sorted(clouds.size());
  parallel_chunks(clouds.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sorted[i] = sorted_into_tiles(clouds[i], only);
  });
  std::vector<std::vector<TileIndex>> touched(clouds.size());
  std::set<TileIndex> all;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    for (const auto& [index, points] : sorted[i]) {
      touched[i].push_back(index);
      all.insert(index);
    }
  }
  std::vector<std::pair<TileIndex, VoxelTile*>> targets;
  for (const TileIndex& index : all) targets.emplace_back(index, &tiles_[index]);
  parallel_chunks(targets.size(), 1, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const Sorted& cloud : sorted) {
        const auto points = cloud.find(targets[i].first);
        if (points == cloud.end()) continue;
        for (const TilePoint& point : points->second) targets[i].second->insert(point);
      }
    }
  });
  return touched;
}

std::vector<TileIndex> TileStore::tiles_of(const PlacedCloud& cloud) const {
  std::set<TileIndex> tiles;
  for (const Point& point : cloud.cloud->points) {
    if (!is_finite(point)) continue;
    tiles.insert(grid_.cell_of(cloud.T_map_base * point.position().cast<double>()).tile);
  }
  return {tiles.begin(), tiles.end()};
}

TileStore::Sorted TileStore::sorted_into_tiles(const PlacedCloud& cloud,
                                               const std::set<TileIndex>* only) const {
  Sorted sorted;
  const Eigen::Matrix3d rotation = cloud.T_map_base.rotation_matrix();
  for (const Point& point : cloud.cloud->points) {
    if (!is_finite(point)) continue;
    const Eigen::Vector3d p_map =
        rotation * point.position().cast<double>() + cloud.T_map_base.translation;
    const TileGrid::Cell cell = grid_.cell_of(p_map);
    if (only != nullptr && only->count(cell.tile) == 0) continue;
    const Eigen::Vector3f local = (p_map - grid_.origin_of(cell.tile)).cast<float>();
    sorted[cell.tile].push_back({cell.voxel, {local.x(), local.y(), local.z(), point.intensity}});
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

std::vector<TileIndex> TileStore::indices() const {
  std::vector<TileIndex> indices;
  for (const auto& [index, tile] : tiles_) indices.push_back(index);
  return indices;
}

}  // namespace lidar_mapping::map
