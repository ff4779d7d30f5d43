// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/moving_objects/visits.hpp"

namespace lidar_mapping::moving_objects {

/// Whether something came or went.
enum class ChangeKind : std::uint8_t {
  kAppeared,    ///< Looked through before, something there after.
  kDisappeared  ///< Something there before, looked through after.
};
/// "appeared", "disappeared".
const char* to_string(ChangeKind kind);

/// That a point was not there before the first visit that observed it, or is not there any more
/// after the last one.
struct PointChange {
  ChangeKind kind = ChangeKind::kAppeared;  ///< Whether it came or went.
  /// The visit that looked through the location: the newest one before the point was there, or the
  /// first one after.
  std::uint32_t absent = 0;
  /// The visit next to it in time that observed something at the location.
  std::uint32_t present = 0;
};

/// Something that came or went between two visits.
struct Change {
  ChangeKind kind = ChangeKind::kAppeared;  ///< Whether it came or went.
  std::uint32_t absent = 0;                 ///< Number of the visit that looked through its place.
  std::uint32_t present = 0;  ///< Number of the visit nearest to that one in which it was there.
  Eigen::Vector3d low = Eigen::Vector3d::Zero();   ///< Lower corner of its box in the map frame, m.
  Eigen::Vector3d high = Eigen::Vector3d::Zero();  ///< Upper corner, m.
  PointCloud points;  ///< A point for each voxel of 0.25 m, in the map frame.
};

/// Collects changed points of many key frames and joins them to changes.
class ChangeList {
 public:
  /// Edge of the voxels in which points are counted, m. Chosen: half of the least change that is
  /// listed (kLeastExtent), and beams of 16 rings lie this far apart at 8 m.
  static constexpr double kVoxel = 0.25;
  /// Least height of a change, or least width of a low one, m. Chosen: a person or a bollard is
  /// listed, a bin bag is not.
  static constexpr double kLeastExtent = 0.75;
  /// Least number of voxels of a change. Chosen: half of what a flat object of the least extent
  /// fills; single beams through a hedge make less.
  static constexpr std::size_t kLeastVoxels = 8;

  /// Adds a point in the map frame, m.
  void add(const Eigen::Vector3d& p_map, const PointChange& change);
  /// Adds what another list has collected.
  void add(const ChangeList& other);
  /// The changes, those of later visits last, then by place.
  std::vector<Change> changes() const;

 private:
  /// Visit in which each voxel was occupied, by the numbers of the voxel along x, y and z. A key of
  /// 64 bits would not tell apart voxels of a map that is far from its origin.
  using Voxels = std::map<std::array<int, 3>, std::uint32_t>;

  /// By the visit that looked through, and by what happened.
  std::map<std::pair<std::uint32_t, ChangeKind>, Voxels> voxels_;
};

}  // namespace lidar_mapping::moving_objects
