// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/preprocessor.hpp"

/// Hand-made input of the preprocessing tests.
namespace lidar_mapping::test {

/// An epoch whose nanoseconds no float and no double of seconds can hold.
constexpr Stamp kEpoch = 1317384506123456789;

inline Stamp at(double seconds) { return kEpoch + from_seconds(seconds); }

/// Every frame is known and coincides with base_link.
inline std::optional<Pose> identity_lookup(const std::string&) { return Pose::Identity(); }

/// A ring of points at 10 m around the sensor.
inline preprocessing::RawScan ring_scan(Stamp stamp, int count = 100) {
  preprocessing::RawScan scan;
  scan.stamp = stamp;
  scan.frame_id = "lidar";
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2.0 * M_PI * i / count;
    scan.cloud.points.push_back({static_cast<float>(10.0 * std::cos(azimuth)),
                                 static_cast<float>(10.0 * std::sin(azimuth)), 0.0F,
                                 static_cast<float>(i)});
  }
  return scan;
}

inline ImuSample imu(Stamp stamp, const Eigen::Vector3d& rate = Eigen::Vector3d::Zero()) {
  ImuSample sample;
  sample.stamp = stamp;
  sample.angular_velocity = rate;
  sample.linear_acceleration = {0.0, 0.0, 9.81};
  return sample;
}

inline VelocitySample velocity(Stamp stamp, const Eigen::Vector3d& linear,
                               const Eigen::Vector3d& angular = Eigen::Vector3d::Zero()) {
  return {stamp, linear, angular};
}

inline GnssFix fix(Stamp stamp, double latitude_deg = 49.0, double longitude_deg = 8.4,
                   double altitude_m = 115.0) {
  GnssFix result;
  result.stamp = stamp;
  result.latitude_deg = latitude_deg;
  result.longitude_deg = longitude_deg;
  result.altitude_m = altitude_m;
  result.status = 2;
  result.covariance = 0.0004 * Eigen::Matrix3d::Identity();
  return result;
}

/// The messages since the last call, a line each.
template <typename Stage>
std::string messages_of(Stage& stage) {
  std::string text;
  for (const preprocessing::Diagnostic& diagnostic : stage.take_diagnostics())
    text += diagnostic.text + "\n";
  return text;
}

inline void append(std::vector<preprocessing::SyncedScan>& all,
                   std::vector<preprocessing::SyncedScan> more) {
  for (preprocessing::SyncedScan& scan : more) all.push_back(std::move(scan));
}

}  // namespace lidar_mapping::test
