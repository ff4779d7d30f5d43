// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "matching/ndt_types.hpp"

namespace lidar_mapping::front_end {

/// The variance of the residuals, but no less than what a map of one scan can show.
double credible_residual_variance(const NdtMatch& match);

/// Covariance of a match (pose and twist) as it is reported. The filter gives the points a low
/// weight, because the errors of neighbouring points are correlated; so its own covariance is too
/// large. The reported covariance has the size of the errors in simulated drives. It depends on the
/// distances of the points from their planes.
Matrix12d reported_covariance(const NdtMatch& match);

/// Drift variance in a map of few scans, as a multiple of the usual drift variance: the variance of
/// the errors that become different between two scans while the sensor moves on. The map's own
/// error is not included, because two scans that see the same part of the map share it.
double initial_drift_variance_factor(const NdtMatch& match);

/// Additional covariance of a match that is correct only with this probability, where otherwise the
/// prediction is correct: the second moment of this mixture about the match.
Matrix12d doubt_covariance(const MotionState& matched, const MotionBelief& prediction,
                           double probability);

}  // namespace lidar_mapping::front_end
