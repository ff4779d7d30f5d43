// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/map_builder.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "tiles/tile_store.hpp"

namespace lidar_mapping::map {

namespace {

// m from the LiDAR, see MapConfig::rebuild_distance. Chosen: most walls of a street lie within.
constexpr double kReferenceDistance = 50.0;
constexpr std::size_t kBatchSize = 16;  // clouds in memory at a time; chosen: one for each thread
// Of the key frames; above it, a partial rebuild costs more than a whole one. Chosen.
constexpr double kRebuildAllFraction = 0.5;

bool are_equal(const Pose& a, const Pose& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

bool has_moved(const Pose& from, const Pose& to, double tolerance) {
  const double distance = (to.translation - from.translation).norm();
  const double angle = rotation_angle(from.rotation.conjugate() * to.rotation);
  return distance + kReferenceDistance * angle > tolerance;
}

}  // namespace

class MapBuilder::Impl {
 public:
  struct KeyFrameEntry {
    Pose target_pose;
    /// Pose at which the cloud is in the tiles; none if it is not in.
    std::optional<Pose> inserted_pose;
    std::vector<TileIndex> tiles;
  };
  using KeyFrameEntries = std::map<KeyFrameIndex, KeyFrameEntry>;

  Impl(const MapConfig& config, CloudSource& clouds)
      : config_(config),
        clouds_(clouds),
        tiles_(config.resolution, config.tile_size, config.threads) {}

  void update(const KeyFramePoses& poses) {
    if (poses.whole) remove_all_but(poses);
    for (const KeyFramePose& pose : poses.poses) {
      const auto [entry, is_new] = key_frames_.try_emplace(pose.index);
      KeyFrameEntry& key_frame = entry->second;
      const bool moved = is_new || !are_equal(key_frame.target_pose, pose.T_map_base);
      key_frame.target_pose = pose.T_map_base;
      if (moved && has_outdated_pose(key_frame)) ++revision_;
    }
  }

  PointCloud build() {
    missing_.clear();
    const std::vector<KeyFrameIndex> changed = outdated_key_frames();
    const bool is_majority = static_cast<double>(changed.size()) >
                             kRebuildAllFraction * static_cast<double>(key_frames_.size());
    if (is_majority && !changed.empty()) {
      rebuild_all();
    } else {
      rebuild_part(changed);
    }
    return tiles_.merged_cloud();
  }

  std::uint64_t revision_ = 0;
  std::set<KeyFrameIndex> missing_;  ///< Whose clouds the last build() has not got.

 private:
  bool has_outdated_pose(const KeyFrameEntry& key_frame) const {
    return !key_frame.inserted_pose ||
           has_moved(*key_frame.inserted_pose, key_frame.target_pose, config_.rebuild_distance);
  }

  void remove_all_but(const KeyFramePoses& poses) {
    KeyFrameEntries remaining;
    for (const KeyFramePose& pose : poses.poses) remaining.insert(key_frames_.extract(pose.index));
    for (const auto& [index, key_frame] : key_frames_) {
      stale_tiles_.insert(key_frame.tiles.begin(), key_frame.tiles.end());
      ++revision_;
    }
    key_frames_ = std::move(remaining);
  }

  std::vector<KeyFrameIndex> outdated_key_frames() const {
    std::vector<KeyFrameIndex> changed;
    for (const auto& [index, key_frame] : key_frames_) {
      if (has_outdated_pose(key_frame)) changed.push_back(index);
    }
    return changed;
  }

  void rebuild_all() {
    tiles_.clear();
    stale_tiles_.clear();
    std::vector<KeyFrameIndex> all;
    for (auto& [index, key_frame] : key_frames_) {
      key_frame.inserted_pose.reset();
      key_frame.tiles.clear();
      all.push_back(index);
    }
    add(all, nullptr);
  }

  /// Appends key frames that follow all those in the map, and rebuilds the tiles of the others that
  /// changed. So the order of insertion, and with it every bit, is that of a new map.
  void rebuild_part(const std::vector<KeyFrameIndex>& changed) {
    const KeyFrameIndex end = end_of_inserted();
    std::vector<KeyFrameIndex> appended;
    for (const KeyFrameIndex index : changed) {
      KeyFrameEntry& key_frame = key_frames_.at(index);
      if (index < end) {
        mark_tiles_stale(key_frame, index);
        continue;
      }
      // It has tiles if its cloud was missing when some of them were rebuilt: the others still hold
      // its points, which would be added once more.
      stale_tiles_.insert(key_frame.tiles.begin(), key_frame.tiles.end());
      key_frame.tiles.clear();
      appended.push_back(index);
    }
    if (!stale_tiles_.empty()) {
      tiles_.clear(stale_tiles_);
      add(key_frames_in(stale_tiles_, end), &stale_tiles_);
      stale_tiles_.clear();
    }
    add(appended, nullptr);
  }

  /// Marks the tiles of its old and of its new pose as stale.
  void mark_tiles_stale(KeyFrameEntry& key_frame, KeyFrameIndex index) {
    const PointCloudPtr cloud = clouds_.cloud(index);
    if (!cloud) {
      missing_.insert(index);
      return;
    }
    stale_tiles_.insert(key_frame.tiles.begin(), key_frame.tiles.end());
    key_frame.tiles = tiles_.tiles_of({index, cloud, key_frame.target_pose});
    key_frame.inserted_pose = key_frame.target_pose;
    stale_tiles_.insert(key_frame.tiles.begin(), key_frame.tiles.end());
  }

  KeyFrameIndex end_of_inserted() const {
    KeyFrameIndex end = 0;
    for (const auto& [index, key_frame] : key_frames_) {
      if (key_frame.inserted_pose) end = index + 1;
    }
    return end;
  }

  std::vector<KeyFrameIndex> key_frames_in(const std::set<TileIndex>& tiles,
                                           KeyFrameIndex end) const {
    std::vector<KeyFrameIndex> found;
    for (const auto& [index, key_frame] : key_frames_) {
      if (index >= end || !key_frame.inserted_pose) continue;
      const bool is_in = std::any_of(key_frame.tiles.begin(), key_frame.tiles.end(),
                                     [&](const TileIndex& tile) { return tiles.count(tile) > 0; });
      if (is_in) found.push_back(index);
    }
    return found;
  }

  /// Inserts key frames into the tiles of `only`; if that is null, new key frames into all their
  /// tiles.
  void add(const std::vector<KeyFrameIndex>& indices, const std::set<TileIndex>* only) {
    for (std::size_t begin = 0; begin < indices.size(); begin += kBatchSize) {
      const std::size_t count = std::min(indices.size() - begin, kBatchSize);
      const std::vector<PointCloudPtr> clouds =
          clouds_.clouds({&indices[begin], &indices[begin] + count}, config_.threads);
      std::vector<CloudWithPose> batch;
      std::vector<KeyFrameEntry*> inserted;
      for (std::size_t i = 0; i < count; ++i) {
        KeyFrameEntry& key_frame = key_frames_.at(indices[begin + i]);
        if (!clouds[i]) {
          missing_.insert(indices[begin + i]);
          key_frame.inserted_pose.reset();
          continue;
        }
        if (!key_frame.inserted_pose) key_frame.inserted_pose = key_frame.target_pose;
        batch.push_back({indices[begin + i], clouds[i], *key_frame.inserted_pose});
        inserted.push_back(&key_frame);
      }
      const auto touched = tiles_.add(batch, only);
      if (only != nullptr) continue;
      for (std::size_t i = 0; i < inserted.size(); ++i) inserted[i]->tiles = touched[i];
    }
  }

  const MapConfig config_;
  CloudSource& clouds_;
  KeyFrameEntries key_frames_;
  std::set<TileIndex> stale_tiles_;
  TileStore tiles_;
};

MapBuilder::MapBuilder(const MapConfig& config, CloudSource& clouds)
    : impl_(std::make_unique<Impl>(config, clouds)) {}
MapBuilder::~MapBuilder() = default;

void MapBuilder::update(const KeyFramePoses& poses) { impl_->update(poses); }
std::uint64_t MapBuilder::revision() const { return impl_->revision_; }
PointCloud MapBuilder::build() { return impl_->build(); }

std::size_t MapBuilder::missing_clouds() const { return impl_->missing_.size(); }

PointCloud build_map(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config) {
  MapBuilder builder(config, clouds);
  builder.update(poses);
  return builder.build();
}

}  // namespace lidar_mapping::map
