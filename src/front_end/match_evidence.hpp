// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/step_evidence.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// What a match says of itself: all of StepEvidence but `points`, `rescued` and what is of the step
/// (`seconds`, `sigma`, `sigma_angle`, `unsteadiness`). `prediction` is what was held for possible
/// before.
StepEvidence evidence_of(const registration::NdtMatch& match,
                         const registration::MotionBelief& prediction);

}  // namespace lidar_mapping::front_end
