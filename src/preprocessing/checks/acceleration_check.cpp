// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/text.hpp"

#include "checks/input_checks.hpp"
#include "checks/velocity_check.hpp"
#include "motion/time_offset.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// s over which accelerations are compared. Chosen: vibrations are averaged out, and starting takes
// longer.
constexpr Stamp kWindow = from_seconds(0.5);
constexpr std::size_t kMinWindows = 8;  // chosen: the five seconds before a map is begun have ten
// m/s^2, standard deviation of the accelerations ahead. Chosen: a road that tilts by 3 degrees, and
// a car that starts gently.
constexpr double kMinDeviation = 0.5;
// Chosen: tilting roads, which the accelerometer feels as well, disturb it; then nothing is said.
constexpr double kMinCorrelation = 0.9;
// Of the ratio of both accelerations. Chosen: a vehicle that pitches as it starts changes it by a
// tenth; units and signs are farther off.
constexpr double kLeastRatio = 0.5;
constexpr double kLargestRatio = 2.0;
// m/s^2 of the mean acceleration. Chosen as in check_gravity(): without gravity the unit is not
// known.
constexpr double kLeastGravity = 8.8;
constexpr double kLargestGravity = 10.8;

/// An acceleration ahead by the accelerometer and by the velocity, m/s^2.
struct Accelerations {
  double felt = 0.0;
  double by_velocity = 0.0;
};

/// Of the sensor itself: what its lever arm adds while turning is small, and not in its unit.
std::vector<TimedValue> speeds_ahead(const VelocityRecord& velocity, const Pose& T_base_sensor) {
  std::vector<TimedValue> speeds;
  for (const VelocitySample& sample : velocity.samples) {
    speeds.push_back({sample.stamp, (T_base_sensor.rotation * sample.linear).x()});
  }
  return speeds;
}

/// Forces ahead, m/s^2; none if gravity is not as it should be.
std::vector<TimedValue> forces_ahead(const ImuRecord& imu, const Pose& T_base_sensor, double unit) {
  std::vector<TimedValue> forces;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : imu.samples) {
    if (!sample.has_linear_acceleration) continue;
    const Eigen::Vector3d force = unit * (T_base_sensor.rotation * sample.linear_acceleration);
    sum += force;
    forces.push_back({sample.stamp, force.x()});
  }
  const Eigen::Vector3d mean = sum / static_cast<double>(std::max<std::size_t>(forces.size(), 1));
  const bool has_gravity =
      mean.norm() > kLeastGravity && mean.norm() < kLargestGravity && mean.z() > 0.0;
  return has_gravity ? forces : std::vector<TimedValue>();
}

std::vector<Accelerations> accelerations(const std::vector<TimedValue>& speeds,
                                         const std::vector<TimedValue>& forces) {
  std::vector<Accelerations> windows;
  if (speeds.empty() || forces.empty()) return windows;
  const Stamp end = std::min(speeds.back().stamp, forces.back().stamp);
  Stamp begin = std::max(speeds.front().stamp, forces.front().stamp);
  for (; begin + kWindow <= end; begin += kWindow) {
    const auto from = first_not_before(forces, begin);
    const auto until = first_not_before(forces, begin + kWindow);
    if (from == until) continue;
    double sum = 0.0;
    for (auto force = from; force != until; ++force) sum += force->value;
    const double change =
        first_not_before(speeds, begin + kWindow)->value - first_not_before(speeds, begin)->value;
    windows.push_back({sum / static_cast<double>(until - from), change / to_seconds(kWindow)});
  }
  return windows;
}

/// Slope of the accelerations by the velocity over the felt ones, if they belong together; 0 of a
/// velocity that never changes.
std::optional<double> slope(const std::vector<Accelerations>& windows) {
  if (windows.size() < kMinWindows) return std::nullopt;
  const auto count = static_cast<double>(windows.size());
  double mean_felt = 0.0, mean_by_velocity = 0.0;
  for (const Accelerations& window : windows) {
    mean_felt += window.felt / count;
    mean_by_velocity += window.by_velocity / count;
  }
  double ff = 0.0, fv = 0.0, vv = 0.0;
  for (const Accelerations& window : windows) {
    const double f = window.felt - mean_felt;
    const double v = window.by_velocity - mean_by_velocity;
    ff += f * f;
    fv += f * v;
    vv += v * v;
  }
  if (std::sqrt(ff / count) < kMinDeviation) return std::nullopt;
  if (vv == 0.0) return 0.0;
  const bool belong_together = std::abs(fv) > kMinCorrelation * std::sqrt(ff * vv);
  return belong_together ? std::optional<double>(fv / ff) : std::nullopt;
}

}  // namespace

void check_accelerations(const VelocityRecord& velocity, const ImuRecord& imu,
                         const ExtrinsicLookup& lookup, const PreprocessingConfig& config,
                         InputReport& report) {
  const auto T_base_velocity = lookup(velocity.topic.frame());
  const auto T_base_imu = lookup(imu.topic.frame());
  if (!T_base_velocity || !T_base_imu) return;
  const auto ratio =
      slope(accelerations(speeds_ahead(velocity, *T_base_velocity),
                          forces_ahead(imu, *T_base_imu, si_factor(config.imu_acceleration_unit))));
  if (!ratio) return;
  if (*ratio == 0.0) {
    add_fault(report,
              "it never changes, although the IMU measures that the vehicle accelerates or brakes",
              "check whether its sensor is connected, or set use_velocity to false");
  } else if (*ratio < 0.0) {
    add_fault(report, "it decreases although the IMU measures that the vehicle accelerates",
              "its sign is wrong, or an x axis points backwards; correct its driver or the "
              "transform, or set use_velocity to false");
  } else if (*ratio < kLeastRatio || *ratio > kLargestRatio) {
    add_fault(report,
              formatted("it changes %.2f times as fast as the IMU measures%s", *ratio,
                        is_kilometres_per_hour(*ratio) ? ": it is in km/h" : ""),
              "publish m/s (REP 103), or set use_velocity to false");
  }
}

}  // namespace lidar_mapping::preprocessing
