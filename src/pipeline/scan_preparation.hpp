// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <optional>

#include "lidar_mapping/pipeline/input.hpp"

#include "spare_clouds.hpp"

namespace lidar_mapping::pipeline {

/// A scan on its way to the front end.
struct PreparedScan {
  preprocessing::SyncedScan synced;
  std::optional<GeodeticDatum> datum;           ///< where it is new
  std::optional<Eigen::Vector3d> p_base_lidar;  ///< where it is new
};

/// From what sensors sent to scans in the LiDAR's frame. One thread calls it.
class ScanPreparation {
 public:
  using Forward = std::function<void(PreparedScan&&)>;
  using Say = std::function<void(const std::string&)>;

  ScanPreparation(const preprocessing::PreprocessingConfig& config,
                  preprocessing::ExtrinsicLookup T_base, SpareClouds& spare, Forward forward,
                  Say say);

  void take(Input&& input);
  /// Sends on what still waits for other sensors.
  void flush();

  const preprocessing::PreprocessingCounters& counters() const { return stage_.counters(); }
  std::size_t unreadable() const { return unreadable_; }

 private:
  void take(const RecordedScan& scan);
  void forward(std::vector<preprocessing::SyncedScan> scans);
  void leave_out(Stamp stamp);

  preprocessing::Preprocessor stage_;
  SpareClouds& spare_;
  Forward forward_;
  Say say_;
  std::optional<Eigen::Vector3d> p_base_lidar_;  ///< that was sent on
  std::optional<GeodeticDatum> datum_;           ///< that was sent on
  std::optional<Stamp> last_;                    ///< stamp of the newest scan that was sent on
  std::size_t unreadable_ = 0;
  bool left_out_ = false;  ///< scans whose stamps were not after it
};

}  // namespace lidar_mapping::pipeline
