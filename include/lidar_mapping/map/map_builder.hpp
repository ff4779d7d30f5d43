#pragma once

#include <cstdint>
#include <memory>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/map/map_config.hpp"

namespace lidar_mapping::map {

/// Joins the clouds of key frames to one map, a point per voxel (centroid, mean intensity). Only
/// key frames that moved are put in again. One thread calls it; clouds come from the source.
class MapBuilder {
 public:
  /// `clouds` must outlive this object.
  MapBuilder(const MapConfig& config, CloudSource& clouds);
  ~MapBuilder();

  /// Takes new or moved poses in (partial or whole).
  void update(const KeyFramePoses& poses);
  /// Grows whenever build() would give something else.
  std::uint64_t revision() const;
  /// The map in the map frame. Key frames whose cloud is missing are left out and counted.
  PointCloud build();
  /// The same with voxels of another size (m).
  PointCloud build(double resolution);
  std::size_t missing_clouds() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::map
