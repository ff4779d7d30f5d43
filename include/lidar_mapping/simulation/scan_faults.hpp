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

/// A fault of the scans of a LiDAR.
struct ScanFault {
  /// Kinds of faults.
  enum class Kind {
    /// A fraction `amount` of the points is artificial, with any direction and range of the view.
    kOutliers,
    kRain,    ///< A fraction `amount` of the rays ends within some metres of the sensor.
    kWall,    ///< The flat side of a truck fills the left half of the view and moves along.
    kJitter,  ///< Errors of the stamps with a standard deviation of `amount` seconds.
    kFrozen,  ///< Every `every_s` seconds the same scan is repeated `amount` times.
    kSparse,  ///< A scan has at most `amount` points.
    kTimes    ///< Points have no times (0) or negated ones (1).
  };
  Kind kind = Kind::kOutliers;  ///< Kind of the fault.
  double amount = 0.0;          ///< Size of the fault; see Kind.
  double every_s = 0.0;         ///< Period of repeated scans, s.
};

/// Reads "outliers=0.15", "rain=0.15", "wall", "jitter=0.02", "frozen=3,10", "sparse=500",
/// "times=none" or "times=negated". Throws ConfigError for any other name, and for a value that is
/// missing or out of range.
ScanFault parse_scan_fault(const std::string& text);
/// How all faults are written, with the ranges of their values.
std::vector<std::string> scan_fault_formats();

/// Applies faults to simulated scans. The result for a scan depends on the faults, the seed and its
/// index.
class ScanFaults {
 public:
  /// No faults.
  ScanFaults() = default;
  /// These faults; `seed` is that of all random numbers.
  ScanFaults(std::vector<ScanFault> faults, std::uint64_t seed);

  /// Index of the scan whose points are delivered as those of scan `index`.
  std::size_t source(std::size_t index, Stamp period) const;
  /// Error of the stamp of scan `index`, ns; less than half a turn.
  Stamp stamp_error(std::size_t index, Stamp period) const;
  /// Applies the faults to the points of scan `index`, which `lidar` has measured with this
  /// standard deviation of the ranges (m). Artificial points count as moving.
  void corrupt(SimulatedScan& scan, std::size_t index, const LidarModel& lidar,
               double range_noise) const;

 private:
  std::vector<ScanFault> faults_;
  std::uint64_t seed_ = 0;
};

}  // namespace lidar_mapping::simulation
