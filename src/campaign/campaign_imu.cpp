// SPDX-License-Identifier: BSD-3-Clause
#include "campaign_imu.hpp"

#include <string>
#include <utility>

namespace lidar_mapping::campaign {

namespace {

constexpr char kLidarFrame[] = "lidar";
constexpr char kImuFrame[] = "imu";
/// So long after a sweep its last sample has come.
constexpr Stamp kAfterSweep = from_seconds(0.03);

preprocessing::PreprocessingConfig make_config() {
  preprocessing::PreprocessingConfig config;
  config.use_velocity = config.use_gnss = false;
  return config;
}

preprocessing::ExtrinsicLookup mounted(const simulation::SensorMounting& mounting) {
  return [mounting](const std::string& frame) {
    return std::optional<Pose>(frame == kImuFrame ? mounting.T_base_imu : mounting.T_base_lidar);
  };
}

}  // namespace

ImuFeed::ImuFeed(const simulation::Drive& drive)
    : drive_(drive),
      samples_(drive.imu()),
      preprocessor_(make_config(), mounted(drive.mounting())) {}

std::optional<preprocessing::SyncedScan> ImuFeed::next(std::size_t index) {
  simulation::SimulatedScan taken = drive_.scan(index);
  while (added_ < samples_.size() && samples_[added_].stamp <= taken.end + kAfterSweep) {
    preprocessor_.add_imu(samples_[added_++], kImuFrame);
  }
  preprocessing::RawScan raw;
  raw.stamp = taken.stamp;
  raw.frame_id = kLidarFrame;
  raw.cloud = std::move(taken.cloud);
  auto complete = preprocessor_.process(std::move(raw));
  if (complete.empty()) complete = preprocessor_.flush();
  if (complete.empty()) return std::nullopt;
  return std::move(complete.back());
}

}  // namespace lidar_mapping::campaign
