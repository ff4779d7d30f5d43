// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::ros_border {

/// Time in which some packet of a sensor comes without a delay of the network, s. Chosen: ten
/// turns.
constexpr double kOusterClockPart = 1.0;

/// How the clock of an Ouster stands to that of ROS.
struct OusterClock {
  Stamp begin = 0;     ///< by the sensor's clock, ns
  Stamp offset = 0;    ///< to be added to the sensor's time there, ns
  double drift = 0.0;  ///< change of the offset, s/s

  /// The time of ROS of a time of the sensor, ns. Throws InputError for one that is out of range.
  Stamp to_ros(Stamp sensor) const;
};

/// The exact offset of a sensor's clock that is that of ROS or, as PTP has it, atomic time, where
/// the offset of its soonest packets (ns) is near one of these; none for a clock of its own.
std::optional<Stamp> known_offset(Stamp offset);

/// Follows the clock of an Ouster by the packets that come soonest after their times, while they
/// come: nothing is known of those behind, as it is in a recording.
class OusterClockTracker {
 public:
  /// Adds the time of a packet by the sensor's clock, and when it came by that of ROS, ns. Damaged
  /// times are ignored, and so is what comes before ROS has a time.
  void add(Stamp sensor, Stamp received);
  /// As far as it is known; a clock that is that of ROS before the first packet.
  OusterClock clock() const;

 private:
  std::optional<Stamp> newest_;   ///< time of the packet before by the sensor's clock, ns
  Stamp begin_ = 0;               ///< of the present part of time, by the clock of ROS, ns
  std::optional<Stamp> present_;  ///< smallest offset in it, ns
  std::optional<Stamp> before_;   ///< smallest offset in the part before it, ns
};

}  // namespace lidar_mapping::ros_border
