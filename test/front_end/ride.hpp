// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::front_end {

inline simulation::Drive make_drive(const std::string& name, double duration,
                                    std::uint64_t seed = 1, const std::string& lidar = "vlp16") {
  simulation::DriveOptions options;
  options.drive = name;
  options.lidar = lidar;
  options.seed = seed;
  options.duration = duration;
  return simulation::Drive(options);
}

/// A scan in the LiDAR's frame.
inline Scan lidar_scan(const simulation::Drive& drive, std::size_t index) {
  simulation::SimulatedScan scan = drive.scan(index);
  return {scan.stamp, std::move(scan.cloud)};
}

/// Runs the front end over a drive and compares each result with the truth.
class Ride {
 public:
  explicit Ride(const simulation::Drive& drive) : drive_(drive) {
    front_end_.set_sensor_pose(drive.mounting().T_base_lidar);
  }

  const FrontEndResult& take(std::size_t index, const MotionPrior& prior = {}) {
    return take(lidar_scan(drive_, index), prior);
  }

  /// A scan in the LiDAR's frame.
  const FrontEndResult& take(const Scan& scan, const MotionPrior& prior = {}) {
    const Pose T_map_base = drive_.trajectory().pose(scan.stamp);
    if (!begin_)
      begin_ = T_map_base;
    else
      way_ += (T_map_base.translation - T_map_last_.translation).norm();
    T_map_last_ = T_map_base;
    result_ = front_end_.process(scan, prior);
    return result_;
  }

  /// Distance (m) from where the sensor really is.
  double error() const {
    const Pose truth = begin_->inverse() * T_map_last_;
    return (truth.translation - (T_odom_begin_.inverse() * result_.T_odom_base).translation).norm();
  }
  /// Angle (degrees) by which it is turned from how the sensor really stands.
  double angle_error() const {
    const Pose truth = begin_->inverse() * T_map_last_;
    const Pose found = T_odom_begin_.inverse() * result_.T_odom_base;
    return rotation_angle(truth.rotation.conjugate() * found.rotation) * 180.0 / M_PI;
  }
  double way() const { return way_; }
  /// Both are counted from here on.
  void begin_anew() {
    begin_ = T_map_last_;
    T_odom_begin_ = result_.T_odom_base;
    way_ = 0.0;
  }

 private:
  const simulation::Drive& drive_;
  FrontEnd front_end_{FrontEndConfig{}};
  FrontEndResult result_;
  std::optional<Pose> begin_;
  Pose T_odom_begin_;
  Pose T_map_last_;
  double way_ = 0.0;
};

/// The vehicle's velocity as a wheel sensor with a wrong radius and noise measures it.
inline MotionPrior wheel_speed(const simulation::Drive& drive, Stamp stamp, double scale,
                               double noise, std::mt19937& engine) {
  const simulation::MotionState state = drive.trajectory().state(stamp);
  std::normal_distribution<double> normal(0.0, noise);
  MotionPrior prior;
  prior.linear_velocity = scale * (state.T_map_base.rotation.conjugate() * state.velocity_map);
  for (int axis = 0; axis < 3; ++axis) (*prior.linear_velocity)[axis] += normal(engine);
  return prior;
}

}  // namespace lidar_mapping::front_end
