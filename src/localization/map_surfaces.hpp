// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/localization/map_index.hpp"

#include "surface_tiles.hpp"

namespace lidar_mapping::localization {

/// Farthest points that are used, of the map and of scans, m. Chosen: beyond it, rings lie so far
/// apart that voxels are lines, and the memory of the map would double.
constexpr float kMaxRange = 80.0F;

/// The surfaces of a whole map as Gaussians in voxels: fine ones for matching, and coarse ones that
/// attract from further away. In memory are those around the place that is looked at, and as many
/// others as the tables have room for. Throws FileError.
class MapSurfaces {
 public:
  /// The fine table has at most `most_slots` slots, as MapIndex::kMostSlots, and the coarse one a
  /// quarter of them. What has no room waits in files without a name in `directory`.
  explicit MapSurfaces(
      std::size_t most_slots = MapIndex::kMostSlots,
      const std::filesystem::path& directory = std::filesystem::temp_directory_path());

  /// Adds a cloud in base_link, measured from `p_base_lidar` (m).
  void insert(const PointCloud& cloud, const Pose& T_map_base, const Eigen::Vector3d& p_base_lidar);

  /// Prepares for matches around a position: has all surfaces within `radius` (m, along x and y) in
  /// memory, and moves the origins to it, so that floats around it are exact. Whoever uses fine()
  /// or coarse() calls this first.
  void require(const Eigen::Vector3d& position, double radius);
  registration::GaussianVoxelMap& fine() { return fine_.voxels(); }
  registration::GaussianVoxelMap& coarse() { return coarse_.voxels(); }
  /// Number of fine Gaussians of the whole map.
  std::size_t gaussians() const { return fine_.size(); }
  /// True if the whole map is in memory.
  bool is_whole() const { return fine_.is_whole() && coarse_.is_whole(); }
  /// Memory of the tables, bytes.
  std::size_t bytes() const { return fine_.bytes() + coarse_.bytes(); }

 private:
  void set_center(const Eigen::Vector3d& position);

  SurfaceTiles fine_;
  SurfaceTiles coarse_;
};

}  // namespace lidar_mapping::localization
