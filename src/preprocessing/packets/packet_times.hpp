// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::preprocessing {

/// When a packet came, and when it was made.
struct PacketTime {
  Stamp stamp = 0;                ///< when it came, ns
  std::int64_t microseconds = 0;  ///< by the sensor's clock, us since that began anew
};

/// Times of packets, s after the scan's stamp. They are those of the sensor's clock, which no
/// network delays; the packet that came soonest says how that clock stands to the stamps. Without
/// such a clock the times are the stamps. `period`: us after which the sensor's clock begins anew.
std::vector<double> packet_times(const std::vector<PacketTime>& packets, std::int64_t period,
                                 Stamp stamp);

}  // namespace lidar_mapping::preprocessing
