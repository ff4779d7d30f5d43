// SPDX-License-Identifier: BSD-3-Clause
#include "examined_motion.hpp"

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::report {

namespace {

/// m: path on which a motion is not compared any more, because the place was not followed meanwhile
/// and odometry drifts. Chosen: twice kComparedPath, so that scans may be metres apart.
constexpr double kLongestPath = 2.0 * kComparedPath;
/// m: least path between the beginnings of two motions. Chosen: a vehicle at rest would repeat one
/// motion with each scan.
constexpr double kLeastStep = 0.1;
// A pose that is farther off is wrong. Chosen: as in doc/results/localization.md.
constexpr double kWrongDistance = 0.5;  // m
constexpr double kWrongAngle = 2.0;     // degrees

/// The scans that were followed and have moved since the one before.
std::vector<std::size_t> followed_in_motion(const std::vector<ExaminedScan>& scans) {
  std::vector<std::size_t> followed;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].state != localization::LocalizationState::kFollowing) continue;
    if (!followed.empty() && scans[i].path - scans[followed.back()].path < kLeastStep) continue;
    followed.push_back(i);
  }
  return followed;
}

MotionDifference difference_between(const std::vector<ExaminedScan>& scans, std::size_t from,
                                    std::size_t to) {
  const Pose in_map = scans[from].T_map_base.inverse() * scans[to].T_map_base;
  const Pose by_odometry = scans[from].T_odom_base.inverse() * scans[to].T_odom_base;
  const Pose difference = by_odometry.inverse() * in_map;
  return {from, to, difference.translation.norm(),
          rotation_angle(difference.rotation) * kDegPerRad};
}

}  // namespace

bool MotionDifference::is_jump() const { return metres > kWrongDistance || degrees > kWrongAngle; }

std::vector<MotionDifference> motion_differences(const std::vector<ExaminedScan>& scans) {
  const std::vector<std::size_t> followed = followed_in_motion(scans);
  std::vector<MotionDifference> differences;
  std::size_t end = 0;
  for (const std::size_t from : followed) {
    const auto path_to = [&](std::size_t k) { return scans[followed[k]].path - scans[from].path; };
    while (end < followed.size() && path_to(end) < kComparedPath) ++end;
    if (end == followed.size()) break;
    const bool is_connected = scans[from].segment == scans[followed[end]].segment;
    if (!is_connected || path_to(end) > kLongestPath) continue;
    differences.push_back(difference_between(scans, from, followed[end]));
  }
  return differences;
}

std::vector<MotionDifference> jumps_of(const std::vector<MotionDifference>& differences) {
  std::vector<MotionDifference> jumps;
  bool goes_on = false;
  for (const MotionDifference& difference : differences) {
    if (!difference.is_jump()) {
      goes_on = false;
    } else if (!goes_on) {
      jumps.push_back(difference);
      goes_on = true;
    } else if (difference.metres > jumps.back().metres) {
      jumps.back() = difference;
    }
  }
  return jumps;
}

}  // namespace lidar_mapping::report
