// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tracking/tracker.hpp"
#include "tracking/tracker_state.hpp"

namespace lidar_mapping::front_end {

/// The pose of the sensor `seconds` after a tracked scan if nothing has been observed since: it
/// continues with its last twist, and its covariance grows. The state is lost. If the sensor was at
/// rest, the state is degraded instead, because a simulated sensor without noise delivers the same
/// points again while it stands still.
TrackedScan coasted(const TrackedScan& tracked, double seconds);

/// Continues the state after a scan that was not matched, `seconds` after the previous one: the
/// pose is the predicted one, and the speed decreases.
void coast(double seconds, TrackerState& state);

/// False if the sensor has probably left the map, so that a new one has to be started: tracking has
/// been lost for more than `max_lost_time` (s), or the map has one scan only. At an unknown speed
/// the vehicle soon leaves a map of one scan, so the newer scan replaces it.
bool keeps_map(const TrackerState& state, double max_lost_time);

}  // namespace lidar_mapping::front_end
