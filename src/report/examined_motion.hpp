// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "examined_drive.hpp"

namespace lidar_mapping::report {

/// m: path over which the motion in the map is compared with that by odometry. Chosen: as
/// kComparedDistance in map_noise.cpp, the length over which the localiser itself learns how noisy
/// the map is.
inline constexpr double kComparedPath = 10.0;

/// How far a motion in the map differs from the same motion by the drive's own odometry, which
/// knows nothing of the map.
struct MotionDifference {
  std::size_t from = 0;  ///< scan at which it begins, which was followed
  std::size_t to = 0;    ///< the first one that was followed behind kComparedPath
  double metres = 0.0;
  double degrees = 0.0;

  /// Whether it is more than odometry errs over this path: one of the two poses is wrong, or
  /// odometry failed.
  bool is_jump() const;
};

/// From each scan that was followed and has moved since the one before, as far as odometry leads
/// to the end without a gap.
std::vector<MotionDifference> motion_differences(const std::vector<ExaminedScan>& scans);

/// The largest difference, in m, of each jump: differences that follow each other are one jump.
std::vector<MotionDifference> jumps_of(const std::vector<MotionDifference>& differences);

}  // namespace lidar_mapping::report
