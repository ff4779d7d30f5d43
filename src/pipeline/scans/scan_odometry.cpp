// SPDX-License-Identifier: BSD-3-Clause
#include "scans/scan_odometry.hpp"

#include <utility>

#include "lidar_mapping/pipeline/scan_record.hpp"

namespace lidar_mapping::pipeline {

ScanOdometry::ScanOdometry(const front_end::FrontEndConfig& front_end,
                           const preprocessing::FloorDetectionConfig& floor, Forward forward,
                           Report report)
    : matching_(
          front_end,
          [this](const preprocessing::SyncedScan& synced, front_end::FrontEndResult&& result) {
            add(synced, std::move(result));
          },
          std::move(report)),
      floor_detector_(floor),
      forward_(std::move(forward)) {}

void ScanOdometry::resume(const ResumePoint& point) {
  resumed_.emplace(point);
  if (point.from_beginning()) return;
  matching_.resume(point.first.index, point.first.segment, point.first.T_odom_base);
}

void ScanOdometry::add(const PreparedScan& prepared) {
  if (resumed_ && !resumed_->needs(prepared.synced.scan.stamp)) return;
  if (prepared.datum) chunk_.datum = prepared.datum;
  if (prepared.p_base_lidar) chunk_.p_base_lidar = prepared.p_base_lidar;
  matching_.add(prepared.synced);
}

void ScanOdometry::add(const preprocessing::SyncedScan& synced,
                       front_end::FrontEndResult&& result) {
  if (resumed_ && !resumed_->accepts(result)) return;
  chunk_.scans.push_back({record_of(result), result.T_odom_base, synced.gnss, synced.imu});
  chunk_.key_frame = result.key_frame;
  if (!chunk_.key_frame) return;
  chunk_.floor = floor_detector_.process(
      {synced.scan.stamp, transformed(synced.scan.cloud, synced.T_base_lidar)});
  forward_chunk();
}

void ScanOdometry::flush() {
  matching_.flush();
  forward_chunk();
}

void ScanOdometry::forward_chunk() {
  if (!chunk_.scans.empty()) forward_(std::exchange(chunk_, {}));
}

}  // namespace lidar_mapping::pipeline
