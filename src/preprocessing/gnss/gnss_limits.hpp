// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::preprocessing {

/// m/s: largest speed between fixes where none was measured. Chosen: faster than any car on a road
/// (250 km/h).
constexpr double kMaxRoadSpeed = 70.0;

}  // namespace lidar_mapping::preprocessing
