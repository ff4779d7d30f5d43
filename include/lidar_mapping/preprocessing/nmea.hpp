// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

/// The fix in a GGA sentence of NMEA 0183, of any constellation ("$GPGGA,...", "$GNGGA,..."). Empty
/// for any other sentence, for a damaged one (if there is a checksum, it has to agree), and if the
/// receiver has no position. The altitude is above the ellipsoid: the antenna's height above the
/// geoid plus the geoid's height; NaN if that field is empty. The status is that of
/// sensor_msgs/NavSatFix for the quality of the fix. The horizontal standard deviation is the
/// horizontal dilution times an error that depends on the quality; the vertical one is twice as
/// large. A sentence contains no date, so the given stamp is used.
std::optional<GnssFix> fix_of_nmea(const std::string& sentence, Stamp stamp);

/// Finds out that a receiver sends no GGA, without which it has no position here.
class SentenceCheck {
 public:
  /// Takes the next sentence. Returns what to tell the user, once, when enough sentences have come
  /// and none of them was a GGA (with or without a position); else an empty text.
  std::string add(const std::string& sentence);

 private:
  std::size_t count_ = 0;
  bool has_gga_ = false;
};

}  // namespace lidar_mapping::preprocessing
