// SPDX-License-Identifier: BSD-3-Clause
#include "scans/scan_matching.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/front_end/prior_of.hpp"
#include "lidar_mapping/front_end/status_warnings.hpp"

namespace lidar_mapping::pipeline {

namespace {

front_end::MotionPrior prior_at(const preprocessing::SyncedScan& synced, bool is_first) {
  front_end::MotionPrior prior = front_end::prior_of(
      synced.imu, synced.velocity, synced.uneven_turning, synced.felt, synced.fingerprint);
  if (is_first && synced.gnss) prior.T_odom_base_initial = synced.gnss->T_enu_base();
  return prior;
}

}  // namespace

front_end::FrontEndConfig with_threads(front_end::FrontEndConfig config, int threads) {
  config.threads = std::max(1, threads / 2);
  return config;
}

ScanMatching::ScanMatching(const front_end::FrontEndConfig& config, Forward forward, Report report)
    : front_end_(config), forward_(std::move(forward)), report_(std::move(report)) {}

void ScanMatching::resume(KeyFrameIndex next_index, std::uint32_t next_segment,
                          const Pose& T_odom_base) {
  front_end_.resume(next_index, next_segment, T_odom_base);
  has_begun_ = true;
}

void ScanMatching::add(const preprocessing::SyncedScan& synced) {
  front_end_.set_sensor_pose(synced.T_base_lidar);
  front_end::FrontEndResult result = front_end_.process(synced.scan, prior_at(synced, !has_begun_));
  has_begun_ = true;
  report_status(result.status);
  forward_finalized(std::exchange(result.finalized, {}));
  if (result.provisional) {
    provisional_scans_.push_back(synced);
  } else {
    forward_(synced, std::move(result));
  }
}

void ScanMatching::flush() { forward_finalized(front_end_.finalize()); }

void ScanMatching::forward_finalized(std::vector<front_end::FrontEndResult>&& finalized) {
  if (finalized.empty()) return;
  const std::vector<preprocessing::SyncedScan> scans = std::exchange(provisional_scans_, {});
  for (std::size_t i = 0; i < scans.size(); ++i) forward_(scans[i], std::move(finalized[i]));
}

void ScanMatching::report_status(const front_end::FrontEndStatus& status) {
  for (const auto& [key, text] : front_end::warnings_of(status)) {
    if (key == front_end::kFullMapKey) {
      if (status.map_points_dropped <= 2 * map_points_dropped_) continue;
      map_points_dropped_ = status.map_points_dropped;
    } else if (!reported_.insert(key).second) {
      continue;
    }
    report_(text);
  }
  if (status.elevation_shift == elevation_shift_) return;
  elevation_shift_ = status.elevation_shift;
  report_(front_end::elevation_message(elevation_shift_));
}

}  // namespace lidar_mapping::pipeline
