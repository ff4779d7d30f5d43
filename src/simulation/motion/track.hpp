// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "motion/vehicle_motion.hpp"

namespace lidar_mapping::simulation {

/// Position and heading of a carrier at an instant.
struct TrackState {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0.0;       ///< rad, unwrapped
  double distance = 0.0;  ///< Distance travelled since the beginning, m.
};

/// Shape of rounded corners.
struct Corners {
  double radius = 0.5;  ///< Largest radius, m.
  double blend = 0.2;   ///< See Path::rounded, m.
};

/// A motion over level ground, composed of walking, standing and turning on the spot.
class Track {
 public:
  /// Begins at `position` at rest.
  Track(const Eigen::Vector2d& position, double yaw);

  /// Stands still.
  void stand(double seconds);
  /// Turns on the spot by `angle` (rad) with at most `peak_rate` (rad/s).
  void turn(double angle, double peak_rate);
  /// Walks from the present position through these points, from rest to rest; turns towards the
  /// first one before.
  void walk(std::vector<Eigen::Vector2d> points, const SpeedLimits& limits,
            const Corners& corners = {});

  /// States every kStep seconds.
  const std::vector<TrackState>& states() const { return states_; }
  double seconds() const { return static_cast<double>(states_.size()) * kStep; }

  static constexpr double kStep = 0.005;          ///< s; chosen: the period of an IMU of 200 Hz
  static constexpr double kDefaultYawRate = 1.5;  ///< rad/s, of a person who turns; chosen

 private:
  std::vector<TrackState> states_;
};

}  // namespace lidar_mapping::simulation
