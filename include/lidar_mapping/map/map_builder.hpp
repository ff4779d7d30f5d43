// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// Joins the clouds of key frames to one map with one point per voxel (centroid and mean
/// intensity). Only the tiles that a moved key frame touches are built again. The memory grows with
/// the size of the map, not with the length of the drive. One thread calls it; the clouds come from
/// the source.
class MapBuilder {
 public:
  /// The map is empty at first. `clouds` must outlive this object.
  MapBuilder(const MapConfig& config, CloudSource& clouds);
  ~MapBuilder();

  /// Adds new poses and replaces moved ones; `poses` hold all key frames or only those that
  /// changed.
  void update(const KeyFramePoses& poses);
  /// Grows whenever the result of build() would change.
  std::uint64_t revision() const;
  /// Builds the map in the map frame. Key frames whose cloud is missing are left out and counted;
  /// the next call asks for their clouds again.
  PointCloud build();
  /// Number of key frames that the last build() left out because their clouds were missing.
  std::size_t missing_clouds() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Builds the whole map at once from these poses.
PointCloud build_map(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config);

/// Builds the same map tile by tile and passes the tiles to `sink` in the order of their indices;
/// all tiles together are the map. Only the tiles around the vehicle are in memory, however large
/// the map is: the others are stored in an unnamed temporary file in `directory`. Each cloud is
/// read once. Throws FileError.
void build_tiles(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                 const std::filesystem::path& directory, const TileSink& sink);

/// Edge of the tiles in m: the multiple of the voxel edge that is nearest to the configured size.
double effective_tile_size(const MapConfig& config);

}  // namespace lidar_mapping::map
