// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/localization/map_index.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"

#include "map_parts.hpp"

namespace lidar_mapping::localization {

namespace {

/// Clouds that are read together. Chosen: 20 MB of them.
constexpr std::size_t kBatch = 16;

/// The key frames that have a pose, and these poses.
struct PlacedKeyFrames {
  std::vector<KeyFrame> key_frames;
  std::vector<Pose> poses;
};

PlacedKeyFrames placed(const MapSource& source) {
  PlacedKeyFrames result;
  auto pose = source.poses.poses.begin();
  for (const KeyFrame& key_frame : source.key_frames) {
    while (pose != source.poses.poses.end() && pose->index < key_frame.index) ++pose;
    if (pose == source.poses.poses.end()) break;
    if (pose->index != key_frame.index) continue;
    result.key_frames.push_back(key_frame);
    result.key_frames.back().cloud = nullptr;
    result.poses.push_back(pose->T_map_base);
  }
  return result;
}

/// Calls `act(i, cloud)` for the clouds of all key frames in their order; null where there is none.
template <typename Act>
void for_each_cloud(const std::vector<KeyFrame>& key_frames, CloudSource& clouds, int threads,
                    const Act& act) {
  for (std::size_t begin = 0; begin < key_frames.size(); begin += kBatch) {
    std::vector<KeyFrameIndex> indices;
    for (std::size_t i = begin; i < std::min(begin + kBatch, key_frames.size()); ++i) {
      indices.push_back(key_frames[i].index);
    }
    const std::vector<PointCloudPtr> batch = clouds.clouds(indices, threads);
    for (std::size_t i = 0; i < batch.size(); ++i) act(begin + i, batch[i]);
  }
}

/// Both in one pass, so that each cloud is read once. Returns the number of clouds that are
/// missing.
std::size_t add_key_frames(const PlacedKeyFrames& map, const Eigen::Vector3d& p_base_lidar,
                           CloudSource& clouds, int threads, MapParts& parts) {
  std::size_t missing = 0;
  loop_closing::KeyFramePreparation preparation(parts.places.verification());
  for_each_cloud(map.key_frames, clouds, threads, [&](std::size_t i, const PointCloudPtr& cloud) {
    if (cloud) parts.surfaces.insert(*cloud, map.poses[i], p_base_lidar);
    if (!cloud) ++missing;
    parts.places.append(cloud ? preparation.prepare(*cloud) : loop_closing::PreparedKeyFrame());
  });
  return missing;
}

}  // namespace

MapIndex::MapIndex(const MapSource& source, CloudSource& clouds,
                   const loop_closing::LoopClosingConfig& verification,
                   const std::filesystem::path& directory, int threads, std::size_t most_slots) {
  const PlacedKeyFrames map = placed(source);
  if (map.poses.empty()) {
    throw InputError("the map has no key frame with a pose; map a drive first (map_bag)");
  }
  // Made in place, because a verifier cannot be moved.
  parts_.reset(new MapParts{MapSurfaces(most_slots, directory),
                            PlaceSearch(verification, clouds, map.key_frames, map.poses,
                                        source.p_base_lidar, directory)});
  places_without_cloud_ = add_key_frames(map, source.p_base_lidar, clouds, threads, *parts_);
  if (gaussians() > 0) return;
  throw InputError("none of the map's clouds can be read; look for its folder key_frames");
}

MapIndex::~MapIndex() = default;
MapIndex::MapIndex(MapIndex&&) noexcept = default;
MapIndex& MapIndex::operator=(MapIndex&&) noexcept = default;

const std::vector<Pose>& MapIndex::places() const { return parts_->places.places(); }
std::size_t MapIndex::gaussians() const { return parts_->surfaces.gaussians(); }
std::size_t MapIndex::bytes() const { return parts_->surfaces.bytes(); }

}  // namespace lidar_mapping::localization
