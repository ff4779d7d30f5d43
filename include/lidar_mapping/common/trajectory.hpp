// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// A pose of a trajectory, in the frame that its owner documents.
struct StampedPose {
  Stamp stamp = 0;  ///< or the line number, see Trajectory::has_stamps
  Pose pose;        ///< of the moving frame in the fixed one
};

/// Poses in the order of their stamps.
struct Trajectory {
  std::vector<StampedPose> poses;  ///< increasing stamps
  bool has_stamps = true;          ///< KITTI's files have none: stamps are line numbers then
};

/// Brings the poses into the order of their stamps; those of equal stamps stay in the order they
/// have.
void sort_by_stamp(Trajectory& trajectory);

/// Pose at a stamp between those of two poses; empty if these are more than `largest_gap_s` apart.
std::optional<Pose> pose_between(const StampedPose& before, const StampedPose& after, Stamp stamp,
                                 double largest_gap_s);
/// Pose of a trajectory with stamps, interpolated between the two poses around the stamp. Empty
/// before its first and after its last pose, and within a longer gap.
std::optional<Pose> pose_at(Stamp stamp, const Trajectory& trajectory, double largest_gap_s);

/// A line "seconds x y z qx qy qz qw" per pose; 9 decimals, so stamps come back exactly.
std::string to_tum(const Trajectory& trajectory);
/// A line of the 12 numbers of [R|t], row by row, per pose.
std::string to_kitti(const Trajectory& trajectory);

/// Reads either format, distinguished by the count of numbers in a line; lines that begin with #
/// are skipped. The poses are in the order of their stamps, whatever that of the lines. Throws
/// FileError if it cannot be read, InputError naming the line if it is malformed.
Trajectory read_trajectory(const std::string& path);

}  // namespace lidar_mapping
