// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// Where the sensor is believed to be `seconds` after a tracked scan if nothing has been seen
/// since: it goes on as it went, ever less surely. Called lost; degraded where it was at rest, for
/// a simulated sensor without noise that stands still delivers the same points again and again.
TrackedScan coasted(const TrackedScan& tracked, double seconds);

}  // namespace lidar_mapping::front_end
