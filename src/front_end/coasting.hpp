// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// The pose of the sensor `seconds` after a tracked scan if nothing has been observed since: it
/// continues with its last twist, and its covariance grows. The state is lost. If the sensor was at
/// rest, the state is degraded instead, because a simulated sensor without noise delivers the same
/// points again while it stands still.
TrackedScan coasted(const TrackedScan& tracked, double seconds);

}  // namespace lidar_mapping::front_end
