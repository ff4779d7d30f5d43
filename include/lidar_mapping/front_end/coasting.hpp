#pragma once

#include "lidar_mapping/front_end/tracker.hpp"

namespace lidar_mapping::front_end {

/// Where the sensor is believed to be `seconds` after a tracked scan if nothing has been seen
/// since: it goes on as it went, ever less surely. Called lost.
TrackedScan coasted(const TrackedScan& tracked, double seconds);

}  // namespace lidar_mapping::front_end
