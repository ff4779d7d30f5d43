// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::back_end {

/// A position of the antenna, as measured and by the trajectory.
struct AlignmentSample {
  /// Measured, m; the altitude is NaN if there is none.
  Eigen::Vector3d p_enu = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();
  double stddev_horizontal = 1.0;  ///< of the measured position, m
  double stddev_altitude = 1.0;    ///< of the measured altitude, m
};

/// When a trajectory is aligned. The parameters of the back end say so; there are no defaults.
struct AlignmentLimits {
  double min_extent;          ///< least extent of the track, m
  double max_heading_stddev;  ///< largest standard deviation of the heading, rad
};

/// The result of an alignment to East-North-Up.
struct Alignment {
  Pose T_enu_map;
  double rms_horizontal = 0.0;  ///< RMS error of the inliers, m
  int inliers = 0;
};

/// Aligns a trajectory with measured positions. Heading and origin come from a robust fit to the
/// positions: the best of many solutions from two points, then iteratively reweighted least
/// squares. The tilt is `R_level_map`, from gravity if it is known. Empty if the track is too short
/// or the heading too uncertain.
std::optional<Alignment> align_to_enu(const std::vector<AlignmentSample>& samples,
                                      const Eigen::Quaterniond& R_level_map,
                                      const AlignmentLimits& limits);

}  // namespace lidar_mapping::back_end
