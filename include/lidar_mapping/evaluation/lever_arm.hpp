// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/evaluation/association.hpp"

namespace lidar_mapping::evaluation {

/// The pairs with their estimates moved from the estimated frame to another one on the same
/// vehicle, whose pose in the estimated frame is T_estimate_truth: that of a truth which was
/// measured elsewhere, as by the antenna of a receiver.
std::vector<PosePair> moved_on_vehicle(std::vector<PosePair> pairs, const Pose& T_estimate_truth);

/// Where on the vehicle the true positions were measured, in the axes of the estimated frame (m),
/// found as the point whose estimated positions come nearest to the true ones in the least-squares
/// sense; with `align` after a rigid motion that is found along with it. Components that
/// cannot be distinguished from such a motion, because the vehicle did not turn, are zero. Empty
/// with fewer than three pairs.
std::optional<Eigen::Vector3d> estimated_lever_arm(const std::vector<PosePair>& pairs, bool align);

/// The turn R_estimate_truth on the vehicle that brings estimated orientations nearest to the true
/// ones. Throws InputError without pairs.
Eigen::Quaterniond estimated_turn(const std::vector<PosePair>& pairs);

}  // namespace lidar_mapping::evaluation
