// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "vehicle_motion.hpp"

namespace lidar_mapping::simulation {

/// Where somebody on foot is at an instant.
struct TrackState {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0.0;  ///< rad, unwrapped
  double way = 0.0;  ///< m since the beginning
};

/// How corners are taken.
struct Corners {
  double radius = 0.5;  ///< m
  double blend = 0.2;   ///< m, see Path::rounded
};

/// A way over level ground, put together piece by piece: walking, standing, turning on the spot.
class Track {
 public:
  /// Stands at `position`.
  Track(const Eigen::Vector2d& position, double yaw);

  void stand(double seconds);
  /// Turns by `angle` (rad), at most at `peak_rate` (rad/s).
  void turn(double angle, double peak_rate);
  /// From where it is through these points, from rest to rest; turns to the first one before.
  void walk(std::vector<Eigen::Vector2d> points, const SpeedLimits& limits,
            const Corners& corners = {});

  /// Every kStep seconds.
  const std::vector<TrackState>& states() const { return states_; }
  double seconds() const { return static_cast<double>(states_.size()) * kStep; }

  static constexpr double kStep = 0.005;     ///< s
  static constexpr double kUsualTurn = 1.5;  ///< rad/s

 private:
  std::vector<TrackState> states_;
};

}  // namespace lidar_mapping::simulation
