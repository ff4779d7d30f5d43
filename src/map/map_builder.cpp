// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/map_builder.hpp"

#include <map>
#include <optional>

#include "tile_store.hpp"

namespace lidar_mapping::map {

namespace {

constexpr double kFarPoint = 50.0;        // m; see MapConfig::rebuild_distance
constexpr std::size_t kBatch = 16;        // clouds in memory at a time
constexpr double kRebuildAllShare = 0.5;  // above it, partial work costs more than all of it

bool are_equal(const Pose& a, const Pose& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

bool has_moved(const Pose& from, const Pose& to, double tolerance) {
  const double distance = (to.translation - from.translation).norm();
  const double angle = rotation_angle(from.rotation.conjugate() * to.rotation);
  return distance + kFarPoint * angle > tolerance;
}

}  // namespace

class MapBuilder::Impl {
 public:
  struct Member {
    Pose wanted;
    std::optional<Pose> placed;  ///< where it lies in the tiles; none if it is not in
    std::vector<TileIndex> tiles;
  };
  using Members = std::map<KeyFrameIndex, Member>;

  Impl(const MapConfig& config, CloudSource& clouds)
      : config_(config),
        clouds_(clouds),
        tiles_(config.resolution, config.tile_size, config.threads) {}

  void update(const KeyFramePoses& poses) {
    if (poses.whole) forget_others(poses);
    for (const KeyFramePose& pose : poses.poses) {
      const auto [entry, is_new] = members_.try_emplace(pose.index);
      Member& member = entry->second;
      const bool moved = is_new || !are_equal(member.wanted, pose.T_map_base);
      member.wanted = pose.T_map_base;
      if (moved && is_out_of_place(member)) ++revision_;
    }
  }

  PointCloud build() {
    missing_ = 0;
    const std::vector<KeyFrameIndex> changed = changed_members();
    const bool most = static_cast<double>(changed.size()) >
                      kRebuildAllShare * static_cast<double>(members_.size());
    if (most && !changed.empty()) {
      rebuild_all();
    } else {
      rebuild_part(changed);
    }
    return tiles_.joined();
  }

  KeyFramePoses poses() const {
    KeyFramePoses poses;
    for (const auto& [index, member] : members_) poses.poses.push_back({index, 0, member.wanted});
    return poses;
  }

  const MapConfig config_;
  CloudSource& clouds_;
  std::uint64_t revision_ = 0;
  std::size_t missing_ = 0;
  std::size_t insertions_ = 0;

 private:
  bool is_out_of_place(const Member& member) const {
    return !member.placed || has_moved(*member.placed, member.wanted, config_.rebuild_distance);
  }

  void forget_others(const KeyFramePoses& poses) {
    Members kept;
    for (const KeyFramePose& pose : poses.poses) {
      const auto member = members_.find(pose.index);
      if (member != members_.end()) kept.insert(members_.extract(member));
    }
    for (const auto& [index, member] : members_) {
      stale_.insert(member.tiles.begin(), member.tiles.end());
      ++revision_;
    }
    members_ = std::move(kept);
  }

  std::vector<KeyFrameIndex> changed_members() const {
    std::vector<KeyFrameIndex> changed;
    for (const auto& [index, member] : members_) {
      if (is_out_of_place(member)) changed.push_back(index);
    }
    return changed;
  }

  void rebuild_all() {
    tiles_.clear();
    stale_.clear();
    std::vector<KeyFrameIndex> all;
    for (auto& [index, member] : members_) {
      member.placed.reset();
      member.tiles.clear();
      all.push_back(index);
    }
    add(all, nullptr);
  }

  /// Key frames behind all that are in the map are added; the tiles of the others that changed are
  /// built again, so that the order of insertion, and with it every bit, is that of a new map.
  void rebuild_part(const std::vector<KeyFrameIndex>& changed) {
    const KeyFrameIndex end = end_of_placed();
    std::vector<KeyFrameIndex> appended;
    for (const KeyFrameIndex index : changed) {
      if (index >= end) {
        appended.push_back(index);
      } else {
        lift(members_.at(index), index);
      }
    }
    if (!stale_.empty()) {
      tiles_.clear(stale_);
      add(members_in(stale_, end), &stale_);
      stale_.clear();
    }
    add(appended, nullptr);
  }

  /// Marks the tiles where it lay and where it will lie.
  void lift(Member& member, KeyFrameIndex index) {
    const PointCloudPtr cloud = clouds_.cloud(index);
    if (!cloud) {
      ++missing_;
      return;
    }
    stale_.insert(member.tiles.begin(), member.tiles.end());
    member.tiles = tiles_.tiles_of({cloud, member.wanted});
    member.placed = member.wanted;
    stale_.insert(member.tiles.begin(), member.tiles.end());
  }

  KeyFrameIndex end_of_placed() const {
    KeyFrameIndex end = 0;
    for (const auto& [index, member] : members_) {
      if (member.placed) end = index + 1;
    }
    return end;
  }

  std::vector<KeyFrameIndex> members_in(const std::set<TileIndex>& tiles, KeyFrameIndex end) const {
    std::vector<KeyFrameIndex> found;
    for (const auto& [index, member] : members_) {
      if (index >= end || !member.placed) continue;
      for (const TileIndex& tile : member.tiles) {
        if (tiles.count(tile) == 0) continue;
        found.push_back(index);
        break;
      }
    }
    return found;
  }

  /// Puts key frames into the tiles of `only`, or, those that are new, into all.
  void add(const std::vector<KeyFrameIndex>& indices, const std::set<TileIndex>* only) {
    for (std::size_t begin = 0; begin < indices.size(); begin += kBatch) {
      const std::size_t count = std::min(indices.size() - begin, kBatch);
      const std::vector<PointCloudPtr> clouds =
          clouds_.clouds({&indices[begin], &indices[begin] + count}, config_.threads);
      std::vector<PlacedCloud> batch;
      std::vector<Member*> owners;
      for (std::size_t i = 0; i < count; ++i) {
        Member& member = members_.at(indices[begin + i]);
        if (!clouds[i]) {
          ++missing_;
          member.placed.reset();
          continue;
        }
        if (!member.placed) member.placed = member.wanted;
        batch.push_back({clouds[i], *member.placed});
        owners.push_back(&member);
      }
      insertions_ += batch.size();
      const auto touched = tiles_.add(batch, only);
      if (only != nullptr) continue;
      for (std::size_t i = 0; i < owners.size(); ++i) owners[i]->tiles = touched[i];
    }
  }

  Members members_;
  std::set<TileIndex> stale_;
  TileStore tiles_;
};

MapBuilder::MapBuilder(const MapConfig& config, CloudSource& clouds)
    : impl_(std::make_unique<Impl>(config, clouds)) {}
MapBuilder::~MapBuilder() = default;

void MapBuilder::update(const KeyFramePoses& poses) { impl_->update(poses); }
std::uint64_t MapBuilder::revision() const { return impl_->revision_; }
PointCloud MapBuilder::build() { return impl_->build(); }

PointCloud MapBuilder::build(double resolution) const {
  MapConfig config = impl_->config_;
  config.resolution = resolution;
  return build_map(impl_->poses(), impl_->clouds_, config);
}

std::size_t MapBuilder::missing_clouds() const { return impl_->missing_; }
std::size_t MapBuilder::insertions() const { return impl_->insertions_; }

PointCloud build_map(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config) {
  MapBuilder builder(config, clouds);
  builder.update(poses);
  return builder.build();
}

}  // namespace lidar_mapping::map
