// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "motion_filter.hpp"

namespace lidar_mapping::front_end {

/// The motion of a sweep as seen from its begin: the pose and the twist there, and the change of
/// the twist per second.
struct SweepMotion {
  MotionState begin;
  Vector6d acceleration = Vector6d::Zero();
};

/// Improves the begin of the current sweep by the previous one, which ends there: a sweep alone
/// determines its middle better than its ends, because its twist changes while it lasts. A steady
/// change (`motion.acceleration`) is known already; the motion of somebody who walks is not steady.
/// The middle of the sweep stays as it is, and so does the end's translation. With `rotation` false
/// only the translation is improved: a measured rotation is more precise.
SweepMotion improved_begin(const SweepMotion& motion, const SweepPair& sweeps, double duration,
                           bool rotation);

/// Motion of the sweep that the filter was corrected with last. The sweep lasts `duration` seconds,
/// and its stamp is `to_stamp` seconds after its middle.
SweepMotion motion_from_stamp(const MotionFilter& filter, double duration, double to_stamp);

}  // namespace lidar_mapping::front_end
