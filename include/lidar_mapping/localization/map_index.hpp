// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::localization {

class MapParts;

/// What a finished map is made of.
struct MapSource {
  std::vector<KeyFrame> key_frames;  ///< by increasing index; their own clouds are not used
  KeyFramePoses poses;               ///< of these key frames; one without a pose is left out
  /// Position of the LiDAR that made the map in base_link, m.
  Eigen::Vector3d p_base_lidar = Eigen::Vector3d::Zero();
};

/// A finished map, prepared for finding oneself in it: the Gaussians of its voxels for matching,
/// and the appearance of each of its places for the search (doc/localization.md). Localizers share
/// it one after the other; one thread at a time uses it.
class MapIndex {
 public:
  /// Default bound of the slots of the fine table of Gaussians, of which three quarters can be
  /// used: 64 bytes each, and a quarter of that for the coarse table, 84 MB. Chosen: at 125 to 250
  /// Gaussians for each metre of a road, maps of 3 to 6 km are in memory as a whole, and so are the
  /// surroundings of eight places that look alike.
  static constexpr std::size_t kMostSlots = std::size_t{1} << 20;

  /// Reads all clouds, by at most `threads` threads (0: all cores), and later those of places
  /// that are verified; `clouds` must outlive this object. Appearances, and the Gaussians for which
  /// tables of `most_slots` slots have no room, go into temporary files without a name in
  /// `directory`. No result depends on `most_slots`. Throws InputError if no key frame has a pose
  /// and a cloud, and FileError, as Localizers do that use it.
  MapIndex(const MapSource& source, CloudSource& clouds,
           const loop_closing::LoopClosingConfig& verification,
           const std::filesystem::path& directory = std::filesystem::temp_directory_path(),
           int threads = 1, std::size_t most_slots = kMostSlots);
  ~MapIndex();
  MapIndex(MapIndex&&) noexcept;  ///< Takes over the other index.
  /// Takes over the other index.
  MapIndex& operator=(MapIndex&&) noexcept;

  /// T_map_base of each place: of the key frames with a pose, in their order.
  const std::vector<Pose>& places() const;
  /// Number of the places whose cloud is missing or damaged: nobody is found there.
  std::size_t places_without_cloud() const { return places_without_cloud_; }
  /// Number of Gaussians of the whole map, in memory or not; the coarse ones not counted.
  std::size_t gaussians() const;
  /// Memory of the tables of Gaussians now, bytes.
  std::size_t bytes() const;

  /// For the stage itself.
  MapParts& parts() { return *parts_; }

 private:
  std::unique_ptr<MapParts> parts_;
  std::size_t places_without_cloud_ = 0;
};

}  // namespace lidar_mapping::localization
