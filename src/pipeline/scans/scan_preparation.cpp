// SPDX-License-Identifier: BSD-3-Clause
#include "scans/scan_preparation.hpp"

#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::pipeline {

ScanPreparation::ScanPreparation(const preprocessing::PreprocessingConfig& config,
                                 preprocessing::ExtrinsicLookup T_base, CloudPool& pool,
                                 Forward forward, Report report)
    : stage_(config, std::move(T_base)),
      pool_(pool),
      forward_(std::move(forward)),
      report_(std::move(report)) {}

void ScanPreparation::add(Input&& input) {
  if (const auto* scan = std::get_if<RecordedScan>(&input)) return add(*scan);
  if (const auto* imu = std::get_if<FramedSample<ImuSample>>(&input)) {
    stage_.add_imu(imu->sample, imu->frame_id);
  } else if (const auto* velocity = std::get_if<FramedSample<VelocitySample>>(&input)) {
    stage_.add_velocity(velocity->sample, velocity->frame_id);
  } else if (const auto* fix = std::get_if<FramedSample<GnssFix>>(&input)) {
    stage_.add_gnss(fix->sample, fix->frame_id);
  }
  forward(stage_.take_complete());
}

void ScanPreparation::add(const RecordedScan& scan) {
  preprocessing::RawScan raw;
  try {
    raw = scan.decode(pool_.acquire());
  } catch (const InputError& error) {
    if (++unreadable_ == 1) report_(std::string("points: a scan was left out: ") + error.what());
    return;
  }
  forward(stage_.process(std::move(raw)));
}

void ScanPreparation::flush() { forward(stage_.flush()); }

void ScanPreparation::forward(std::vector<preprocessing::SyncedScan> scans) {
  for (const preprocessing::Diagnostic& diagnostic : stage_.take_diagnostics())
    report_(diagnostic.text);
  for (preprocessing::SyncedScan& scan : scans) {
    if (last_ && scan.scan.stamp <= *last_) {
      report_dropped(scan.scan.stamp);
      continue;
    }
    last_ = scan.scan.stamp;
    PreparedScan prepared;
    prepared.synced = std::move(scan);
    if (!(stage_.datum() == datum_)) prepared.datum = datum_ = stage_.datum();
    const Eigen::Vector3d& p_base_lidar = prepared.synced.T_base_lidar.translation;
    if (p_base_lidar_ != p_base_lidar) prepared.p_base_lidar = p_base_lidar_ = p_base_lidar;
    forward_(std::move(prepared));
  }
}

/// Reports once that scans are dropped. A session maps one drive, in which time does not go back.
void ScanPreparation::report_dropped(Stamp stamp) {
  if (++before_newest_ > 1) return;
  report_(formatted(
      "points: time went back to %.1f s before the newest scan; scans are left out until it has "
      "passed that again (map another drive by itself and join them with merge_sessions)",
      to_seconds(*last_ - stamp)));
}

}  // namespace lidar_mapping::pipeline
