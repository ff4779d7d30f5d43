// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/preprocessor.hpp"

#include "samples.hpp"

namespace lidar_mapping::test {

/// A drive straight ahead at 10 m/s in the order in which a recorder would store it: IMU 100 Hz,
/// velocity 50 Hz, GNSS 10 Hz, scans 10 Hz. `missing(name, t)` leaves samples out.
template <typename Missing>
std::vector<preprocessing::SyncedScan> drive(preprocessing::Preprocessor& stage, double seconds,
                                             const Missing& missing, double start = 0.0) {
  std::vector<preprocessing::SyncedScan> out;
  const int ticks = static_cast<int>(std::lround(seconds * 100.0));
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = start + 0.01 * tick;
    if (!missing("imu", t)) stage.add_imu(imu(at(t)), "imu");
    if (tick % 2 == 0 && !missing("velocity", t)) {
      stage.add_velocity(velocity(at(t), {10.0, 0.0, 0.0}), "imu");
    }
    if (tick % 10 == 0 && !missing("gnss", t)) {
      stage.add_gnss(fix(at(t), 49.0, 8.4 + 10.0 * (t - start) / 73172.0), "gps");
    }
    if (tick % 10 == 5 && !missing("points", t)) append(out, stage.process(ring_scan(at(t))));
  }
  return out;
}

inline const auto kNothingMissing = [](const std::string&, double) { return false; };

}  // namespace lidar_mapping::test
