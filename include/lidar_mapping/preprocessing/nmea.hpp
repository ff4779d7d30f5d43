// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// The fix in a GGA sentence of NMEA 0183, of any constellation ("$GPGGA,...", "$GNGGA,..."); none
/// in any other sentence, in a damaged one (its checksum, where there is one, has to agree), and
/// where the receiver has no position. The altitude is that above the ellipsoid: the antenna's
/// above the geoid plus the geoid's. The status is that of sensor_msgs/NavSatFix for the quality of
/// the fix; the covariance is the horizontal dilution times an error that goes with the quality,
/// twice as much vertically. A sentence holds no date, so the stamp is the given one.
std::optional<GnssFix> fix_of_nmea(const std::string& sentence, Stamp stamp);

}  // namespace lidar_mapping::preprocessing
