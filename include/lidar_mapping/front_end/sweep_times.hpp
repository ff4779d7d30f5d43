// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

namespace lidar_mapping::front_end {

/// Where the times of the points of a sweep come from.
enum class SweepTimes {
  kAsGiven,    ///< the points have the right times; points without times are motion-compensated
  kNegated,    ///< the points have times with the wrong sign
  kByAzimuth,  ///< the points have no times: they follow from the azimuth
  kByPosition  ///< the points have no times: they follow from the order of the points
};

/// How a spinning sensor turns, about its z axis.
struct SensorRotation {
  bool clockwise = true;       ///< as seen from above
  double start_azimuth = 0.0;  ///< at which a sweep begins, rad from x towards y, -pi to pi
};

/// The times of the points of a sweep.
struct SweepTimesRule {
  SweepTimes source = SweepTimes::kAsGiven;  ///< where they come from
  double duration = 0.0;                     ///< s, of a sweep whose points have no times
  /// With kByAzimuth; empty if it follows from the order of the points.
  std::optional<SensorRotation> rotation;
};

/// "as_given", "negated", "by_azimuth", "by_position".
const char* to_string(SweepTimes times);

/// The message that the times of points are not used as they are given, and what to do about it.
/// Empty for kAsGiven.
std::string sweep_times_message(const SweepTimesRule& rule);

}  // namespace lidar_mapping::front_end
