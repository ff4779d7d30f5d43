// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "gnss/local_frame.hpp"

namespace lidar_mapping::preprocessing {

enum class VelocityProblem { kNone, kUnit, kAxes, kAside };

/// True if speeds with this scale may be in m/s.
bool is_true_scale(double scale);
/// True if speeds with this scale are those of km/h (3.6).
bool is_kilometres_per_hour(double scale);
/// The message, for example "its speeds are 3.60 times those of the fixes: they are in km/h".
std::string scale_sentence(double scale);

/// Checks with the other sensors that a velocity is in m/s and in the axes of its frame (x ahead, z
/// up): its speeds agree with those of the fixes, and its direction does not rotate with the
/// vehicle.
class VelocityCheck {
 public:
  /// Adds a velocity and the gyro's rate about the z axis of its frame (rad/s), for each scan.
  void add_turn_rate(Stamp stamp, const Eigen::Vector3d& velocity, double rate);
  /// Adds a fix and the speed at its stamp.
  void add_fix(const LocalFix& fix, double speed);

  /// The reason for not using this velocity; it may disappear with later samples.
  VelocityProblem problem(const Eigen::Vector3d& velocity) const;
  std::string sentence(VelocityProblem problem) const;

 private:
  struct Turn {
    Stamp begin = 0;
    Stamp last = 0;
    Eigen::Vector2d velocity;  ///< at the beginning
    double angle = 0.0;        ///< angle by the gyro since then
  };
  struct Section {
    LocalFix from;
    Stamp last = 0;
    double distance_travelled = 0.0;  ///< m, by the velocity since then
  };

  std::optional<double> consistent_scale() const;

  std::optional<Turn> turn_;
  double squared_angles_ = 0.0;  ///< sum of squares of the gyro's angles
  double angle_products_ = 0.0;  ///< sum of products with the angles of the velocity
  std::optional<Section> section_;
  std::deque<double> scales_;  ///< of the last sections
};

}  // namespace lidar_mapping::preprocessing
