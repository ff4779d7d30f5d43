// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/map/map_config.hpp"
#include "lidar_mapping/map/map_tile.hpp"

namespace lidar_mapping::map {

/// Joins the clouds of key frames to one map, a point per voxel (centroid, mean intensity). Only
/// the tiles that a moved key frame touches are built again. Memory grows with the map, not with
/// the drive. One thread calls it; clouds come from the source.
class MapBuilder {
 public:
  /// `clouds` must outlive this object.
  MapBuilder(const MapConfig& config, CloudSource& clouds);
  ~MapBuilder();

  /// Takes new or moved poses in (partial or whole).
  void update(const KeyFramePoses& poses);
  /// Grows whenever build() would give something else.
  std::uint64_t revision() const;
  /// The map in the map frame. Key frames whose cloud is missing are left out and counted; they are
  /// asked for again next time.
  PointCloud build();
  /// The same with voxels of another size (m), from the newest poses.
  PointCloud build(double resolution) const;
  std::size_t missing_clouds() const;
  /// Key frames that went through the voxels since the beginning: the work that was done.
  std::size_t insertions() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The whole map at once, from the poses given.
PointCloud build_map(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config);

/// The same tile by tile, in the order of their indices: tiles put together are the map. Memory is
/// that of the tiles around the vehicle, however large the map is: others wait in a file without a
/// name in `directory`. Each cloud is read once. Throws FileError.
void build_tiles(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                 const std::filesystem::path& directory, const TileSink& sink);

/// Edge of the tiles: the whole number of voxels that is nearest to the configured size, m.
double true_tile_size(const MapConfig& config);

}  // namespace lidar_mapping::map
