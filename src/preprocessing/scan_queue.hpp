// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "motion/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

struct WaitingScan {
  RawScan raw;
  TimeSpan span;
};

/// Scans that wait for the other sensors, in the order of their stamps.
class ScanQueue {
 public:
  /// Rejects a scan whose stamp is in the queue already, or not after all scans that were released.
  /// If time has gone back so far that the recording must have started again, nothing is inserted,
  /// and the result is kTimeWentBack.
  Insertion insert(WaitingScan&& scan);

  bool empty() const { return scans_.empty(); }
  std::size_t size() const { return scans_.size(); }
  /// True if the queue is too long: the oldest scan has to be released.
  bool is_too_long() const;
  const WaitingScan& oldest() const { return scans_.front(); }
  WaitingScan take_oldest();
  void clear();

 private:
  std::deque<WaitingScan> scans_;
  std::optional<Stamp> last_released_;
};

}  // namespace lidar_mapping::preprocessing
