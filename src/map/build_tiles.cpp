// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/map/map_builder.hpp"

#include "tile_pages.hpp"
#include "tile_store.hpp"

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kBatch = 8;                 // clouds in memory at a time, twice as large
constexpr std::size_t kVoxelsInMemory = 500'000;  // beyond those that a batch touches

/// Tiles that are filled in the order of the drive. Those that were touched longest ago wait on the
/// disk, and come back as they went.
class TileRun {
 public:
  TileRun(const MapConfig& config, const std::filesystem::path& directory)
      : threads_(config.threads),
        store_(config.resolution, config.tile_size, config.threads),
        pages_(directory) {}

  void add(const std::vector<PlacedCloud>& batch) {
    const std::vector<TileStore::Sorted> parts = store_.sorted(batch, nullptr);
    ++batches_;
    fetch(parts);
    store_.insert(parts);
    put_away(kVoxelsInMemory);
  }

  /// Tile by tile, in the order of their indices.
  void finish(const TileSink& sink) {
    ++batches_;
    for (const auto& [index, batch] : last_use_) {
      if (!store_.contains(index)) store_.put(index, pages_.get(index));
      sink(store_.tile(index));
      store_.take(index);
    }
  }

 private:
  void fetch(const std::vector<TileStore::Sorted>& parts) {
    std::vector<TileIndex> away;
    for (const TileStore::Sorted& part : parts) {
      for (const auto& [index, points] : part) {
        std::size_t& last_use = last_use_[index];
        if (last_use == batches_) continue;
        last_use = batches_;
        if (!store_.contains(index) && pages_.contains(index)) away.push_back(index);
      }
    }
    std::vector<VoxelTile> tiles(away.size());
    parallel_chunks(away.size(), 1, threads_,
                    [&](std::size_t i, std::size_t) { tiles[i] = pages_.get(away[i]); });
    for (std::size_t i = 0; i < away.size(); ++i) store_.put(away[i], std::move(tiles[i]));
  }

  void put_away(std::size_t limit) {
    std::size_t voxels = 0;
    std::vector<std::pair<std::size_t, TileIndex>> oldest;
    for (const auto& [index, batch] : last_use_) {
      if (!store_.contains(index)) continue;
      voxels += store_.voxels(index);
      if (batch != batches_) oldest.emplace_back(batch, index);
    }
    std::sort(oldest.begin(), oldest.end());
    for (const auto& [batch, index] : oldest) {
      if (voxels <= limit) return;
      const VoxelTile tile = store_.take(index);
      voxels -= tile.size();
      pages_.put(index, tile);
    }
  }

  const int threads_;
  TileStore store_;
  TilePages pages_;
  std::map<TileIndex, std::size_t> last_use_;  ///< number of the batch
  std::size_t batches_ = 0;
};

}  // namespace

double true_tile_size(const MapConfig& config) {
  return TileGrid(config.resolution, config.tile_size).origin_of({1, 0}).x();
}

void build_tiles(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                 const std::filesystem::path& directory, const TileSink& sink) {
  TileRun run(config, directory);
  for (std::size_t begin = 0; begin < poses.poses.size(); begin += kBatch) {
    const std::size_t end = std::min(poses.poses.size(), begin + kBatch);
    std::vector<KeyFrameIndex> indices;
    for (std::size_t i = begin; i < end; ++i) indices.push_back(poses.poses[i].index);
    const std::vector<PointCloudPtr> found = clouds.clouds(indices, config.threads);
    std::vector<PlacedCloud> batch;
    for (std::size_t i = begin; i < end; ++i) {
      if (found[i - begin]) batch.push_back({found[i - begin], poses.poses[i].T_map_base});
    }
    run.add(batch);
  }
  run.finish(sink);
}

}  // namespace lidar_mapping::map
