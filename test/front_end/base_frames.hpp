// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/front_end/prior_of.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::test {

/// What the sensors of a vehicle measure, and their poses in one base_link.
struct SensorData {
  Pose T_base_lidar;
  Pose T_base_imu;  ///< of the velocity's sensor, too
  std::size_t scan_count = 0;
  std::function<preprocessing::RawScan(std::size_t)> scan;  ///< in the frame "lidar"
  std::vector<ImuSample> imu;
  std::vector<VelocitySample> velocity;
};

inline SensorData sensor_data(const simulation::Drive& drive, bool with_others) {
  SensorData data;
  data.T_base_lidar = drive.mounting().T_base_lidar;
  data.T_base_imu = drive.mounting().T_base_imu;
  data.scan_count = drive.scan_count();
  // They are kept, because they are needed once per base_link.
  const auto scans = std::make_shared<std::vector<preprocessing::RawScan>>();
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    simulation::SimulatedScan taken = drive.scan(i);
    scans->push_back({taken.stamp, "lidar", std::move(taken.cloud)});
  }
  data.scan = [scans](std::size_t index) { return (*scans)[index]; };
  if (!with_others) return data;
  data.imu = drive.imu();
  data.velocity = drive.velocity();
  return data;
}

/// Another base_link of the same vehicle: its pose in the usual one.
struct OtherBase {
  std::string name;
  Pose T_usual_other;
};

/// A base_link that is displaced (m) and then turned about z, y and x (degrees).
inline OtherBase other_base(std::string name, const Eigen::Vector3d& at, double yaw_deg,
                            double pitch_deg, double roll_deg) {
  return {std::move(name),
          pose_from_degrees({at.x(), at.y(), at.z(), roll_deg, pitch_deg, yaw_deg})};
}

/// Poses of the LiDAR relative to its first one, and how many scans were lost or became key frames.
struct SensorTrack {
  std::vector<Pose> T_first_lidar;
  std::size_t lost = 0;
  std::size_t key_frames = 0;
};

/// The odometry of the vehicle if its base_link is another one.
class OdometryInOtherBase {
 public:
  OdometryInOtherBase(const SensorData& data, const OtherBase& other)
      : data_(data),
        T_other_lidar_(other.T_usual_other.inverse() * data.T_base_lidar),
        T_other_imu_(other.T_usual_other.inverse() * data.T_base_imu),
        preprocessor_(config(data), [this](const std::string& frame) {
          return std::optional<Pose>(frame == "lidar" ? T_other_lidar_ : T_other_imu_);
        }) {}

  SensorTrack run() {
    for (const ImuSample& sample : data_.imu) add_until(sample);
    for (; next_scan_ < data_.scan_count; ++next_scan_) take(data_.scan(next_scan_));
    for (const auto& synced : preprocessor_.flush()) take(synced);
    put(front_end_.finalize());
    SensorTrack track;
    for (const Pose& T_odom_lidar : T_odom_lidar_) {
      track.T_first_lidar.push_back(T_odom_lidar_.front().inverse() * T_odom_lidar);
    }
    track.lost = lost_;
    track.key_frames = key_frames_;
    return track;
  }

 private:
  static preprocessing::PreprocessingConfig config(const SensorData& data) {
    preprocessing::PreprocessingConfig config;
    config.use_gnss = false;
    config.use_imu = !data.imu.empty();
    config.use_velocity = !data.velocity.empty();
    return config;
  }

  /// Gives the scans whose turn has ended before this sample, then the sample.
  void add_until(const ImuSample& sample) {
    while (next_scan_ < data_.scan_count) {
      if (!pending_) pending_ = data_.scan(next_scan_);
      if (pending_->stamp + from_seconds(0.1) > sample.stamp) break;
      take(*std::exchange(pending_, std::nullopt));
      ++next_scan_;
    }
    preprocessor_.add_imu(sample, "imu");
    while (next_velocity_ < data_.velocity.size() &&
           data_.velocity[next_velocity_].stamp <= sample.stamp) {
      preprocessor_.add_velocity(data_.velocity[next_velocity_++], "imu");
    }
  }

  void take(preprocessing::RawScan raw) {
    for (const auto& synced : preprocessor_.process(std::move(raw))) take(synced);
  }

  void take(const preprocessing::SyncedScan& synced) {
    front_end_.set_sensor_pose(synced.T_base_lidar);
    const front_end::FrontEndResult result = front_end_.process(
        synced.scan, front_end::prior_of(synced.imu, synced.velocity, std::nullopt, std::nullopt,
                                         synced.fingerprint));
    put(result.finalized);
    lost_ += result.status.state == front_end::TrackingState::kLost ? 1 : 0;
    key_frames_ += result.key_frame ? 1 : 0;
    T_odom_lidar_.push_back(result.T_odom_base * T_other_lidar_);
  }

  void put(const std::vector<front_end::FrontEndResult>& finalized) {
    std::size_t index = T_odom_lidar_.size() - finalized.size();
    for (const front_end::FrontEndResult& result : finalized) {
      key_frames_ += result.key_frame ? 1 : 0;
      T_odom_lidar_[index++] = result.T_odom_base * T_other_lidar_;
    }
  }

  const SensorData& data_;
  Pose T_other_lidar_;
  Pose T_other_imu_;
  preprocessing::Preprocessor preprocessor_;
  front_end::FrontEnd front_end_{front_end::FrontEndConfig{}};
  std::vector<Pose> T_odom_lidar_;
  std::size_t lost_ = 0;
  std::size_t key_frames_ = 0;
  std::size_t next_scan_ = 0;
  std::size_t next_velocity_ = 0;
  std::optional<preprocessing::RawScan> pending_;  ///< number next_scan_, if it was made already
};

/// By how much two tracks differ at most.
struct TrackDifference {
  double metres = 0.0;
  double degrees = 0.0;
};

inline TrackDifference difference_of(const SensorTrack& a, const SensorTrack& b) {
  TrackDifference largest;
  if (a.T_first_lidar.size() != b.T_first_lidar.size()) return {INFINITY, INFINITY};
  for (std::size_t i = 0; i < a.T_first_lidar.size(); ++i) {
    const Pose T_a_b = a.T_first_lidar[i].inverse() * b.T_first_lidar[i];
    largest.metres = std::max(largest.metres, T_a_b.translation.norm());
    largest.degrees = std::max(largest.degrees, rotation_angle(T_a_b.rotation) * kDegPerRad);
  }
  return largest;
}

}  // namespace lidar_mapping::test
