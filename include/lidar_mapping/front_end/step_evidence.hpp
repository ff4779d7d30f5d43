// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"

namespace lidar_mapping::front_end {

/// Evidence for and against the pose of one scan, as the end of a step from the last scan whose
/// pose was claimed to be correct. All figures come from this scan and its match alone. Nothing is
/// compared with earlier values, so that a drive that goes wrong slowly does not become the
/// reference.
struct StepEvidence {
  double points = 0.0;             ///< number of matched points
  double overlap = 0.0;            ///< fraction of these that found a plane
  double pair_quality = 0.0;       ///< mean robust weight of the paired points
  double residual_variance = 0.0;  ///< NdtMatch::residual_variance
  double converged = 0.0;          ///< 0 or 1
  double iterations = 0.0;         ///< steps of the search
  double rescued = 0.0;            ///< 0 or 1: the match needed more than one starting pose
  double degenerate = 0.0;         ///< 0 or 1: the points did not observe one direction
  double seconds = 0.0;            ///< s since the last scan with a claimed pose
  /// Standard deviations of the step: square roots of the traces of its covariance.
  double sigma = 0.0;        ///< m
  double sigma_angle = 0.0;  ///< rad
  /// Distance between the matched pose and the predicted one; the prediction allows any
  /// acceleration.
  double surprise = 0.0;         ///< m
  double surprise_angle = 0.0;   ///< rad
  double surprise_sigmas = 0.0;  ///< in standard deviations
  /// Difference between the poses that two disjoint halves of the scan prefer; the largest value of
  /// several ways to divide the scan.
  double disagreement = 0.0;         ///< m
  double disagreement_angle = 0.0;   ///< rad
  double disagreement_sigmas = 0.0;  ///< in standard deviations
  /// Difference between the step and the motion during the sweep, continued for the duration of the
  /// step. The columns in evidence tables are called `unsteadiness` and `unsteadiness_angle`.
  double motion_change = 0.0;        ///< m
  double motion_change_angle = 0.0;  ///< rad
  /// Disagreement of this sweep and the last matched one about the pose half-way between them: each
  /// is continued with its own twist. Large if the twist changes irregularly.
  double sweep_gap = 0.0;        ///< m
  double sweep_gap_angle = 0.0;  ///< rad
  /// Rotation during the time of the step, as the sweep shows it.
  double turn = 0.0;  ///< rad
  /// Effective number of the eight sectors around the sensor that constrain the pose: 8 if all
  /// contribute equally.
  double sectors = 0.0;
};

/// All figures with their names, in the order of the members above.
std::vector<std::pair<const char*, double>> named_figures(const StepEvidence& evidence);

}  // namespace lidar_mapping::front_end
