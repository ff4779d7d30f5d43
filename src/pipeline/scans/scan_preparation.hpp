// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "lidar_mapping/pipeline/input.hpp"

#include "threads/cloud_pool.hpp"

namespace lidar_mapping::pipeline {

/// A preprocessed scan for the front end.
struct PreparedScan {
  preprocessing::SyncedScan synced;
  std::optional<GeodeticDatum> datum;           ///< Set where it is new.
  std::optional<Eigen::Vector3d> p_base_lidar;  ///< Set where it is new, m.
};

/// Turns recorded sensor data into preprocessed scans in the frame of the LiDAR. One thread calls
/// it.
class ScanPreparation {
 public:
  using Forward = std::function<void(PreparedScan&&)>;
  using Report = std::function<void(const std::string&)>;

  ScanPreparation(const preprocessing::PreprocessingConfig& config,
                  preprocessing::ExtrinsicLookup T_base, CloudPool& pool, Forward forward,
                  Report report);

  void add(Input&& input);
  /// Forwards scans that still wait for other sensors.
  void flush();

  const preprocessing::PreprocessingCounters& counters() const { return stage_.counters(); }
  std::size_t unreadable() const { return unreadable_; }
  std::size_t before_newest() const { return before_newest_; }

 private:
  void add(const RecordedScan& scan);
  void forward(std::vector<preprocessing::SyncedScan> scans);
  void report_dropped(Stamp stamp);

  preprocessing::Preprocessor stage_;
  CloudPool& pool_;
  Forward forward_;
  Report report_;
  std::optional<Eigen::Vector3d> p_base_lidar_;  ///< Last value that was forwarded, m.
  std::optional<GeodeticDatum> datum_;           ///< Last value that was forwarded.
  std::optional<Stamp> last_;                    ///< Stamp of the newest scan that was forwarded.
  std::size_t unreadable_ = 0;
  std::size_t before_newest_ = 0;  ///< Scans that were dropped because time went back.
};

}  // namespace lidar_mapping::pipeline
