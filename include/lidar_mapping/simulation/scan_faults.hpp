// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"

namespace lidar_mapping::simulation {

struct SimulatedScan;

/// One thing that is wrong with the scans of a LiDAR.
struct ScanFault {
  enum class Kind {
    kOutliers,  ///< `amount` of the points are made up: in any direction and range of the view
    kRain,      ///< `amount` of the rays end within some metres of the sensor
    kWall,      ///< a truck's flat side fills the left half of the view and moves along
    kJitter,    ///< stamps are off by `amount` seconds (standard deviation)
    kFrozen,    ///< every `every_s` seconds the same scan comes `amount` times again
    kSparse,    ///< at most `amount` points are left of a scan
    kTimes      ///< points have no times (0) or negated ones (1)
  };
  Kind kind = Kind::kOutliers;
  double amount = 0.0;
  double every_s = 0.0;
};

/// From "outliers=0.15", "rain=0.15", "wall", "jitter=0.02", "frozen=3,10", "sparse=500",
/// "times=none" or "times=negated".
/// Throws ConfigError for any other name, a missing amount or one out of range.
ScanFault parse_scan_fault(const std::string& text);
/// "outliers", "rain" and so on.
std::vector<std::string> scan_fault_names();

/// Spoils simulated scans. What happens to a scan depends on the faults, the seed and its index.
class ScanFaults {
 public:
  ScanFaults() = default;
  ScanFaults(std::vector<ScanFault> faults, std::uint64_t seed);

  /// The scan whose points come as those of scan `index`.
  std::size_t source(std::size_t index, Stamp period) const;
  /// What the stamp of scan `index` is off by: less than half a turn.
  Stamp stamp_error(std::size_t index, Stamp period) const;
  /// Changes the points of scan `index`, seen by `lidar` with this noise of the range (m). Made-up
  /// ones count as moving.
  void spoil(SimulatedScan& scan, std::size_t index, const LidarModel& lidar,
             double range_noise) const;

 private:
  std::vector<ScanFault> faults_;
  std::uint64_t seed_ = 0;
};

}  // namespace lidar_mapping::simulation
