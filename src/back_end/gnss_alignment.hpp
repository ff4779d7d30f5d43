// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::back_end {

/// An antenna position, measured and as the trajectory has it.
struct AlignmentSample {
  Eigen::Vector3d p_enu = Eigen::Vector3d::Zero();  ///< altitude NaN where there is none
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();
  double stddev_horizontal = 1.0;  ///< m
  double stddev_altitude = 1.0;    ///< m
};

struct AlignmentLimits {
  double min_extent = 20.0;          ///< m, of the track
  double max_heading_stddev = 0.02;  ///< rad
};

/// How a trajectory lies in East-North-Up.
struct Alignment {
  Pose T_enu_map;
  double heading_stddev = 0.0;  ///< rad
  double rms_horizontal = 0.0;  ///< m, of the samples that fit
  int inliers = 0;
};

/// Turns and shifts a trajectory to measured positions: heading and origin from the positions,
/// robustly (the best of many two-point solutions, then reweighted least squares); the tilt is
/// `R_level_map`, from gravity where it is known. None while the track is too short or the heading
/// too uncertain.
std::optional<Alignment> align_to_enu(const std::vector<AlignmentSample>& samples,
                                      const Eigen::Quaterniond& R_level_map,
                                      const AlignmentLimits& limits);

}  // namespace lidar_mapping::back_end
