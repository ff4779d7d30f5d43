// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/step_evidence.hpp"

#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// Mean weight of the pairs; 0 if there are none.
double pair_quality(const NdtMatch& match);

/// A step between two poses.
struct UncertainStep {
  Vector6d step = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Zero();

  /// Length of the step in standard deviations.
  double sigmas() const;
};
/// Step from the predicted pose to that of the match, with the covariance of the prediction.
UncertainStep innovation_of(const NdtMatch& match, const MotionBelief& prediction);

/// The evidence that follows from the match alone: all fields of StepEvidence but `points`,
/// `rescued` and those of the step (`seconds`, `sigma`, `sigma_angle`, `motion_change`,
/// `sweep_gap`, `turn`). `prediction` is the belief before the match.
StepEvidence evidence_of(const NdtMatch& match, const MotionBelief& prediction);

}  // namespace lidar_mapping::front_end
