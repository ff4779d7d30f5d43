// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/step_evidence.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// The evidence that follows from the match alone: all fields of StepEvidence but `points`,
/// `rescued` and those of the step (`seconds`, `sigma`, `sigma_angle`, `motion_change`,
/// `sweep_gap`, `turn`). `prediction` is the belief before the match.
StepEvidence evidence_of(const registration::NdtMatch& match,
                         const registration::MotionBelief& prediction);

}  // namespace lidar_mapping::front_end
