// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::front_end {

inline simulation::DriveOptions drive_options(const std::string& name, double duration,
                                              std::uint64_t seed = 1,
                                              const std::string& lidar = "vlp16") {
  simulation::DriveOptions options;
  options.drive = name;
  options.lidar = lidar;
  options.seed = seed;
  options.duration = duration;
  return options;
}

inline simulation::Drive make_drive(const std::string& name, double duration,
                                    std::uint64_t seed = 1, const std::string& lidar = "vlp16") {
  return simulation::Drive(drive_options(name, duration, seed, lidar));
}

/// A drive with this fault of its LiDAR or IMU; with none if it is empty.
inline simulation::Drive faulty_drive(simulation::DriveOptions options, const std::string& fault) {
  if (!fault.empty()) simulation::add_fault(options, fault);
  return simulation::Drive(options);
}

/// The true motion of the vehicle from one scan to another.
inline Pose true_motion(const simulation::Drive& drive, std::size_t from, std::size_t to) {
  const auto pose_at = [&](std::size_t i) { return drive.trajectory().pose(drive.scan_stamp(i)); };
  return pose_at(from).inverse() * pose_at(to);
}

/// A scan in the LiDAR's frame.
inline Scan lidar_scan(const simulation::Drive& drive, std::size_t index) {
  simulation::SimulatedScan scan = drive.scan(index);
  return {scan.stamp, std::move(scan.cloud)};
}

/// Runs the front end over a drive and compares each result with the truth.
class EvaluatedDrive {
 public:
  explicit EvaluatedDrive(const simulation::Drive& drive) : drive_(drive) {
    front_end_.set_sensor_pose(drive.mounting().T_base_lidar);
  }

  const FrontEndResult& process(std::size_t index, const MotionPrior& prior = {}) {
    return process(lidar_scan(drive_, index), prior);
  }

  /// A scan in the LiDAR's frame.
  const FrontEndResult& process(const Scan& scan, const MotionPrior& prior = {}) {
    const Pose T_map_base = drive_.trajectory().pose(scan.stamp);
    if (!T_map_begin_)
      T_map_begin_ = T_map_base;
    else
      distance_travelled_ += (T_map_base.translation - T_map_last_.translation).norm();
    T_map_last_ = T_map_base;
    result_ = front_end_.process(scan, prior);
    return result_;
  }

  /// Distance (m) of the result from the true position.
  double error() const {
    const Pose truth = T_map_begin_->inverse() * T_map_last_;
    return (truth.translation - (T_odom_begin_.inverse() * result_.T_odom_base).translation).norm();
  }
  /// Angle (degrees) of the result to the true attitude.
  double angle_error() const {
    const Pose truth = T_map_begin_->inverse() * T_map_last_;
    const Pose found = T_odom_begin_.inverse() * result_.T_odom_base;
    return rotation_angle(truth.rotation.conjugate() * found.rotation) * kDegPerRad;
  }
  /// Error of the step to the present result from the one at which end_step() was called last.
  Pose step_error() const {
    return (T_map_step_.inverse() * T_map_last_).inverse() *
           (T_odom_step_.inverse() * result_.T_odom_base);
  }
  /// The next step begins at the present result.
  void end_step() {
    T_map_step_ = T_map_last_;
    T_odom_step_ = result_.T_odom_base;
  }
  double distance_travelled() const { return distance_travelled_; }
  /// Errors and distance are measured from the present scan on.
  void restart_evaluation() {
    T_map_begin_ = T_map_last_;
    T_odom_begin_ = result_.T_odom_base;
    distance_travelled_ = 0.0;
  }

 private:
  const simulation::Drive& drive_;
  FrontEnd front_end_{FrontEndConfig{}};
  FrontEndResult result_;
  std::optional<Pose> T_map_begin_;
  Pose T_odom_begin_;
  Pose T_map_last_;
  Pose T_map_step_;
  Pose T_odom_step_;
  double distance_travelled_ = 0.0;
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
