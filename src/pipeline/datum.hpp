// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::pipeline {

/// Pose of the East-North-Up frame at datum `from` in that at datum `to`.
Pose enu_between(const GeodeticDatum& to, const GeodeticDatum& from);

/// The position in another East-North-Up frame.
GnssPosition turned(GnssPosition position, const Pose& T_new_old);

}  // namespace lidar_mapping::pipeline
