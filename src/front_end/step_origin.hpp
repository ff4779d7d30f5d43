// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/front_end/step_evidence.hpp"

namespace lidar_mapping::front_end {

/// A pose that is claimed to be correct, at the stamp of its scan.
struct PoseEstimate {
  Pose T_odom_base;
  Covariance6 covariance = Covariance6::Zero();  ///< TrackedScan::covariance
  double drift_variance_factor = 1.0;            ///< TrackedScan::drift_variance_factor
};

/// Writes the standard deviations of the step from one pose to the other into the evidence.
void set_step(const PoseEstimate& from, const PoseEstimate& to, double seconds,
              StepEvidence& evidence);

}  // namespace lidar_mapping::front_end
