#include <algorithm>
#include <cmath>
#include <map>

#include "lidar_mapping/map/map_builder.hpp"

#include "tile_store.hpp"

namespace lidar_mapping::map {

namespace {

constexpr double kBlockSize = 200.0;  // m; larger blocks take more memory, smaller ones read more
constexpr std::size_t kBatch = 16;    // clouds in memory at a time

/// A block of tiles, and the key frames that touch it.
struct Block {
  std::set<TileIndex> tiles;
  std::vector<KeyFramePose> key_frames;
};

class TileRun {
 public:
  TileRun(CloudSource& clouds, const MapConfig& config)
      : clouds_(clouds),
        store_(config.resolution, config.tile_size, config.threads),
        tiles_per_block_(std::max(1.0, std::ceil(kBlockSize / config.tile_size))) {}

  std::map<TileIndex, Block> blocks_of(const KeyFramePoses& poses) {
    std::map<TileIndex, Block> blocks;
    for (const KeyFramePose& pose : poses.poses) {
      const PointCloudPtr cloud = clouds_.cloud(pose.index);
      if (!cloud) continue;
      for (const TileIndex& tile : store_.tiles_of({cloud, pose.T_map_base})) {
        Block& block = blocks[block_of(tile)];
        block.tiles.insert(tile);
        if (block.key_frames.empty() || block.key_frames.back().index != pose.index) {
          block.key_frames.push_back(pose);
        }
      }
    }
    return blocks;
  }

  void build(const Block& block, const TileSink& sink) {
    std::vector<PlacedCloud> batch;
    for (const KeyFramePose& pose : block.key_frames) {
      if (PointCloudPtr cloud = clouds_.cloud(pose.index))
        batch.push_back({cloud, pose.T_map_base});
      if (batch.size() < kBatch) continue;
      store_.add(batch, &block.tiles);
      batch.clear();
    }
    store_.add(batch, &block.tiles);
    for (const TileIndex& tile : block.tiles) sink(store_.tile(tile));
    store_.clear();
  }

 private:
  TileIndex block_of(const TileIndex& tile) const {
    const auto divided = [this](std::int64_t value) {
      return static_cast<std::int64_t>(std::floor(static_cast<double>(value) / tiles_per_block_));
    };
    return {divided(tile.x), divided(tile.y)};
  }

  CloudSource& clouds_;
  TileStore store_;
  double tiles_per_block_;
};

}  // namespace

double true_tile_size(const MapConfig& config) {
  return TileGrid(config.resolution, config.tile_size).origin_of({1, 0}).x();
}

void build_tiles(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                 const TileSink& sink) {
  TileRun run(clouds, config);
  for (const auto& [index, block] : run.blocks_of(poses)) run.build(block, sink);
}

}  // namespace lidar_mapping::map
