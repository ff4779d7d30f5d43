// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

#include "graph_distance.hpp"
#include "trajectory.hpp"

namespace lidar_mapping::loop_closing {

/// A measured horizontal distance.
struct Distance {
  double value = 0.0;  ///< m
  double sigma = 0.0;  ///< m
};

/// What is known of the relative pose of two key frames before they are matched.
struct Prior {
  bool anchored = false;  ///< constraints join the two; if not, the estimate says nothing
  Pose T_from_to;         ///< from the newest estimate
  double sigma_horizontal = std::numeric_limits<double>::infinity();  ///< m
  double sigma_vertical = std::numeric_limits<double>::infinity();    ///< m
  double sigma_rotation = std::numeric_limits<double>::infinity();    ///< rad
  double height_jumps = 0.0;     ///< heights that odometry jumped between the two, m
  std::optional<Distance> gnss;  ///< where both have a position
};

Prior prior_between(const Trajectory& trajectory, const GraphDistance& graph_distance,
                    Trajectory::NodeId from, Trajectory::NodeId to,
                    const LoopClosingConfig& config);

/// True if GNSS is there and knows the horizontal distance better than the estimate does.
bool gnss_is_more_certain(const Prior& prior);
/// True if the two may see the same place: within detect_area, widened to 99 % by the uncertainty.
/// An unanchored pair without GNSS may be anywhere.
bool may_overlap(const Prior& prior, const LoopClosingConfig& config);
/// Upper bound of the radius that may_meet() allows after driving `way` (m).
double largest_radius(double path_length, const LoopClosingConfig& config);

/// Squared distance of a measured relative pose from the prior in units of its covariance (six
/// degrees of freedom), and the part of the height alone (one).
struct Innovation {
  double whole = 0.0;
  double height = 0.0;
};
Innovation innovation_of(const Prior& prior, const Pose& T_from_to);

}  // namespace lidar_mapping::loop_closing
