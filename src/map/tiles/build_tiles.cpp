// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/map/map_builder.hpp"

#include "tiles/tile_pages.hpp"
#include "tiles/tile_store.hpp"

namespace lidar_mapping::map {

namespace {

// Clouds in memory at a time; a batch takes twice their size. Chosen: this stays below the growth
// at which memory is given back to the system (kStep of process_memory.cpp).
constexpr std::size_t kBatchSize = 8;
// Voxels besides those of the current batch. Chosen: about the tiles around the vehicle; more only
// save reading from the disk.
constexpr std::size_t kVoxelsInMemory = 500'000;

/// Tiles that are filled in the order of the drive. The least recently used ones are stored on the
/// disk and read again when they are needed.
class TileAccumulator {
 public:
  TileAccumulator(const MapConfig& config, const std::filesystem::path& directory)
      : threads_(config.threads),
        store_(config.resolution, config.tile_size, config.threads),
        pages_(directory) {}

  void add(const std::vector<CloudWithPose>& batch) {
    const std::vector<TileStore::PointsByTile> parts = store_.sort_into_tiles(batch, nullptr);
    ++batches_;
    load(parts);
    store_.insert(parts);
    evict();
  }

  /// Passes all tiles to `sink` in the order of their indices.
  void finish(const TileSink& sink) {
    for (const auto& [index, batch] : last_use_) {
      if (!store_.contains(index)) store_.put(index, pages_.get(index));
      sink(store_.tile(index));
      store_.extract(index);
    }
  }

 private:
  void load(const std::vector<TileStore::PointsByTile>& parts) {
    std::vector<TileIndex> stored;
    for (const TileStore::PointsByTile& part : parts) {
      for (const auto& [index, points] : part.tiles) {
        std::size_t& last_use = last_use_[index];
        if (last_use == batches_) continue;
        last_use = batches_;
        if (!store_.contains(index) && pages_.contains(index)) stored.push_back(index);
      }
    }
    std::vector<VoxelTile> tiles(stored.size());
    parallel_chunks(stored.size(), 1, threads_,
                    [&](std::size_t i, std::size_t) { tiles[i] = pages_.get(stored[i]); });
    for (std::size_t i = 0; i < stored.size(); ++i) store_.put(stored[i], std::move(tiles[i]));
  }

  void evict() {
    std::size_t voxels = 0;
    std::vector<std::pair<std::size_t, TileIndex>> oldest;
    for (const auto& [index, batch] : last_use_) {
      if (!store_.contains(index)) continue;
      voxels += store_.voxels(index);
      if (batch != batches_) oldest.emplace_back(batch, index);
    }
    std::sort(oldest.begin(), oldest.end());
    for (const auto& [batch, index] : oldest) {
      if (voxels <= kVoxelsInMemory) return;
      const VoxelTile tile = store_.extract(index);
      voxels -= tile.size();
      pages_.put(index, tile);
    }
  }

  const int threads_;
  TileStore store_;
  TilePages pages_;
  std::map<TileIndex, std::size_t> last_use_;  ///< Number of the batch that used the tile last.
  std::size_t batches_ = 0;
};

}  // namespace

double effective_tile_size(const MapConfig& config) {
  return TileGrid(config.resolution, config.tile_size).origin_of({1, 0}).x();
}

void build_tiles(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                 const std::filesystem::path& directory, const TileSink& sink) {
  TileAccumulator accumulator(config, directory);
  for (std::size_t begin = 0; begin < poses.poses.size(); begin += kBatchSize) {
    const std::size_t end = std::min(poses.poses.size(), begin + kBatchSize);
    std::vector<KeyFrameIndex> indices;
    for (std::size_t i = begin; i < end; ++i) indices.push_back(poses.poses[i].index);
    const std::vector<PointCloudPtr> found = clouds.clouds(indices, config.threads);
    std::vector<CloudWithPose> batch;
    for (std::size_t i = begin; i < end; ++i) {
      const KeyFramePose& pose = poses.poses[i];
      if (found[i - begin]) batch.push_back({pose.index, found[i - begin], pose.T_map_base});
    }
    accumulator.add(batch);
  }
  accumulator.finish(sink);
}

}  // namespace lidar_mapping::map
