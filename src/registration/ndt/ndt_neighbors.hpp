// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::registration {

/// The neighbour that is the voxel of the point itself. By definition the first one.
constexpr std::size_t kOwnVoxel = 0;

/// Weighted planes, one per point, as the kernels read them.
struct PlaneArrays {
  std::vector<float> x, y, z, offset;
};

/// Points rotated into the axes of the map, and the translation that they still lack.
struct RotatedPoints {
  std::vector<float> x, y, z;
  Eigen::Vector3f translation = Eigen::Vector3f::Zero();
  std::optional<Eigen::Vector3f> viewpoint;  ///< rotated, too

  Eigen::Vector3f position(std::size_t i) const {
    return Eigen::Vector3f(x[i], y[i], z[i]) + translation;
  }
  /// From the point to the sensor; zero if unknown.
  Eigen::Vector3f view(std::size_t i) const {
    if (!viewpoint) return Eigen::Vector3f::Zero();
    return *viewpoint - Eigen::Vector3f(x[i], y[i], z[i]);
  }
};

/// The planes that each point is matched with. They are kept between iterations and looked up
/// again only for points that have moved to another voxel.
class NdtNeighbors {
 public:
  /// Discards all planes.
  void begin(std::size_t points, NeighborSearch search);
  /// Brings the planes up to date with the packed cells of the points (ndt_kernels.hpp).
  void update(const std::vector<std::int32_t>& cells, const RotatedPoints& points,
              GaussianVoxelMap& map);

  /// Planes per point.
  std::size_t count() const { return planes_.size(); }
  const PlaneArrays& planes(std::size_t neighbor) const { return planes_[neighbor]; }

 private:
  void look_up(std::size_t neighbor, const RotatedPoints& points, GaussianVoxelMap& map);

  NeighborSearch search_ = NeighborSearch::kDirect1;
  std::vector<Eigen::Vector3i> offsets_;
  std::vector<PlaneArrays> planes_;
  std::vector<std::int32_t> cells_;
  std::vector<std::uint32_t> moved_;  ///< the first moved_count_ of them
  std::size_t moved_count_ = 0;
  std::vector<VoxelTable::Slot> slots_;
};

}  // namespace lidar_mapping::registration
