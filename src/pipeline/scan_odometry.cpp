// SPDX-License-Identifier: BSD-3-Clause
#include "scan_odometry.hpp"

#include <utility>

#include "lidar_mapping/front_end/prior_of.hpp"
#include "lidar_mapping/front_end/status_warnings.hpp"

namespace lidar_mapping::pipeline {

namespace {

front_end::MotionPrior prior_at(const preprocessing::SyncedScan& synced, bool is_first) {
  front_end::MotionPrior prior =
      front_end::prior_of(synced.imu, synced.velocity, synced.uneven_turning, synced.felt);
  if (is_first && synced.gnss) prior.T_odom_base_initial = synced.gnss->T_enu_base();
  return prior;
}

/// Computing times are left out, because they differ from run to run.
session::ScanRecord record_of(const front_end::FrontEndResult& result) {
  session::ScanRecord record;
  record.stamp = result.stamp;
  record.state = result.status.repeated ? "repeated" : front_end::to_string(result.status.state);
  record.fitness = result.status.fitness;
  record.overlap = result.status.overlap;
  record.unobserved_stddev = result.status.unobserved_stddev;
  record.elevation_shift = result.status.elevation_shift;
  record.probability = result.status.probability;
  return record;
}

}  // namespace

ScanOdometry::ScanOdometry(const front_end::FrontEndConfig& front_end,
                           const preprocessing::FloorDetectionConfig& floor, Forward forward,
                           Report report)
    : front_end_(front_end),
      floor_detector_(floor),
      forward_(std::move(forward)),
      report_(std::move(report)) {}

void ScanOdometry::resume(const ResumePoint& point) {
  resumed_.emplace(point);
  if (point.from_beginning()) return;
  front_end_.resume(point.first.index, point.first.segment, point.first.T_odom_base);
  has_begun_ = true;
}

void ScanOdometry::add(const PreparedScan& prepared) {
  const preprocessing::SyncedScan& synced = prepared.synced;
  front_end_.set_sensor_pose(synced.T_base_lidar);
  if (resumed_ && !resumed_->needs(synced.scan.stamp)) return;
  if (prepared.datum) chunk_.datum = prepared.datum;
  if (prepared.p_base_lidar) chunk_.p_base_lidar = prepared.p_base_lidar;
  front_end::FrontEndResult result = front_end_.process(synced.scan, prior_at(synced, !has_begun_));
  has_begun_ = true;
  report_status(result.status);
  add_finalized(std::exchange(result.finalized, {}));
  if (result.provisional) {
    provisional_scans_.push_back(synced);
  } else {
    add(synced, std::move(result));
  }
}

void ScanOdometry::add_finalized(std::vector<front_end::FrontEndResult>&& finalized) {
  if (finalized.empty()) return;
  const std::vector<preprocessing::SyncedScan> scans = std::exchange(provisional_scans_, {});
  for (std::size_t i = 0; i < scans.size(); ++i) add(scans[i], std::move(finalized[i]));
}

void ScanOdometry::add(const preprocessing::SyncedScan& synced,
                       front_end::FrontEndResult&& result) {
  if (resumed_ && !resumed_->accepts(result)) return;
  record(synced, result);
  if (!chunk_.key_frame) return;
  chunk_.floor = floor_detector_.process(
      {synced.scan.stamp, transformed(synced.scan.cloud, synced.T_base_lidar)});
  forward_chunk();
}

void ScanOdometry::report_status(const front_end::FrontEndStatus& status) {
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

void ScanOdometry::record(const preprocessing::SyncedScan& synced,
                          const front_end::FrontEndResult& result) {
  chunk_.scans.push_back({record_of(result), result.T_odom_base, synced.gnss, synced.imu});
  chunk_.key_frame = result.key_frame;
}

void ScanOdometry::flush() {
  add_finalized(front_end_.finalize());
  forward_chunk();
}

void ScanOdometry::forward_chunk() {
  if (!chunk_.scans.empty()) forward_(std::exchange(chunk_, {}));
}

}  // namespace lidar_mapping::pipeline
