// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// Covariance of a match (pose and twist) as it is reported. The filter weighs the points low,
/// because neighbouring ones err together, and so holds itself for worse than it is. What is
/// reported has the size of the errors of simulated drives: by how far the points really lie from
/// their planes.
registration::Matrix12d reported_covariance(const registration::NdtMatch& match);

/// Variance of the errors that part as the sensor moves on through a map of few scans, in units of
/// the usual. The map's own error, which two scans that see the same of it share, is no part.
double initial_drift_variance_factor(const registration::NdtMatch& match);

/// Covariance of a motion T_from_to between two scans, from the reported ones of both poses and
/// from how much more than usual errors part in their maps (1: no more).
Covariance6 motion_covariance(const Covariance6& of_from, double from_factor, const Pose& T_from_to,
                              const Covariance6& of_to, double to_factor);

/// What comes on top where a match is right only with this probability and else the prediction is:
/// the second moment of that about the match.
registration::Matrix12d doubt_covariance(const registration::MotionState& matched,
                                         const registration::MotionBelief& prediction,
                                         double probability);

}  // namespace lidar_mapping::front_end
