// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

#include "candidates/graph_distance.hpp"
#include "trajectory.hpp"

namespace lidar_mapping::loop_closing {

/// A measured horizontal distance.
struct Distance {
  double value = 0.0;  ///< m
  double sigma = 0.0;  ///< standard deviation, m
};

/// Prior of the relative pose of two key frames, before they are matched.
struct Prior {
  /// Constraints connect the two; otherwise the estimate gives no information.
  bool anchored = false;
  Pose T_from_to;  ///< relative pose by the newest estimate
  /// Standard deviation of the horizontal position, m.
  double sigma_horizontal = std::numeric_limits<double>::infinity();
  /// Standard deviation of the height, m.
  double sigma_vertical = std::numeric_limits<double>::infinity();
  /// Standard deviation of the rotation, rad.
  double sigma_rotation = std::numeric_limits<double>::infinity();
  double height_jumps = 0.0;     ///< sum of the jumps in height of odometry between the two, m
  std::optional<Distance> gnss;  ///< distance by GNSS, if both have a position
};

Prior prior_between(const Trajectory& trajectory, const GraphDistance& graph_distance,
                    Trajectory::NodeId from, Trajectory::NodeId to,
                    const LoopClosingConfig& config);

/// True if there is GNSS and the horizontal distance by GNSS is more certain than by the estimate.
bool gnss_is_more_certain(const Prior& prior);
/// True if the two may observe the same location: they are within detect_area, enlarged to 99 % by
/// the uncertainty. A pair that is neither anchored nor has GNSS is always possible.
bool may_overlap(const Prior& prior, const LoopClosingConfig& config);
/// Upper bound of the radius of may_overlap() after a distance of `path_length` (m).
double largest_radius(double path_length, const LoopClosingConfig& config);

/// Squared Mahalanobis distance of a measured relative pose from the prior: of the whole pose (six
/// degrees of freedom) and of the height alone (one degree of freedom).
struct Innovation {
  double whole = 0.0;
  double height = 0.0;
};
Innovation innovation_of(const Prior& prior, const Pose& T_from_to);

}  // namespace lidar_mapping::loop_closing
