// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::pipeline {

/// Pose of the East-North-Up frame of datum `from` in the one of datum `to`.
Pose enu_between(const GeodeticDatum& to, const GeodeticDatum& from);

/// Transforms a position with its covariance and orientation to another East-North-Up frame.
GnssPosition transformed_position(GnssPosition position, const Pose& T_new_old);

}  // namespace lidar_mapping::pipeline
