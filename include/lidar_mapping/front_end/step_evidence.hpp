// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"

namespace lidar_mapping::front_end {

/// What speaks for and against the pose of one scan, as the end of a step from the last scan whose
/// pose was claimed to be right. All of it is of this scan and its match alone: nothing is compared
/// with what was usual before, so a drive that goes wrong slowly does not get used to that.
struct StepEvidence {
  double points = 0.0;             ///< that were matched
  double overlap = 0.0;            ///< share of them with a plane
  double pair_quality = 0.0;       ///< mean robust weight of these
  double residual_variance = 0.0;  ///< NdtMatch::residual_variance
  double converged = 0.0;          ///< 0 or 1
  double iterations = 0.0;
  double rescued = 0.0;     ///< 0 or 1: more than one start was needed
  double degenerate = 0.0;  ///< 0 or 1: the points left a direction open
  double seconds = 0.0;     ///< since the last scan that claimed its pose
  /// Standard deviations of the step: roots of the traces of its covariance.
  double sigma = 0.0;        ///< m
  double sigma_angle = 0.0;  ///< rad
  /// From where the pose was expected if any acceleration is held for possible.
  double surprise = 0.0;         ///< m
  double surprise_angle = 0.0;   ///< rad
  double surprise_sigmas = 0.0;  ///< in standard deviations
  /// Between the poses that disjoint halves of the scan ask for; the worst of several halvings.
  double disagreement = 0.0;         ///< m
  double disagreement_angle = 0.0;   ///< rad
  double disagreement_sigmas = 0.0;  ///< in standard deviations
  /// Between the step and the motion during the sweep, gone on with for as long.
  double motion_change = 0.0;        ///< m
  double motion_change_angle = 0.0;  ///< rad
  /// How many of eight sectors around the sensor hold the pose: 8 if all do alike.
  double sectors = 0.0;
};

/// Every figure by its name, in a fixed order.
std::vector<std::pair<const char*, double>> named_figures(const StepEvidence& evidence);

}  // namespace lidar_mapping::front_end
