// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "local_frame.hpp"

namespace lidar_mapping::preprocessing {

enum class VelocityProblem { kNone, kUnit, kAxes, kAside };

/// Whether speeds of so many times the true ones may be meant as m/s.
bool is_true_scale(double scale);
/// "its speeds are 3.60 times those of the fixes: they are in km/h".
std::string scale_sentence(double scale);

/// Whether a velocity is one in m/s and in the axes of its frame (x ahead, z up), by what the other
/// sensors show: its speeds are those of the fixes, and its direction does not turn with the
/// vehicle.
class VelocityCheck {
 public:
  /// A velocity and the gyro's rate about that frame's z (rad/s), scan by scan.
  void add_turn_rate(Stamp stamp, const Eigen::Vector3d& velocity, double rate);
  /// A fix and the speed at its stamp.
  void add_fix(const LocalFix& fix, double speed);

  /// What speaks against using this velocity; later ones may agree again.
  VelocityProblem problem(const Eigen::Vector3d& velocity) const;
  std::string sentence(VelocityProblem problem) const;
  void clear() { *this = {}; }

 private:
  struct Turn {
    Stamp begin = 0;
    Stamp last = 0;
    Eigen::Vector2d velocity;  ///< at the begin
    double angle = 0.0;        ///< by the gyro since
  };
  struct Section {
    LocalFix from;
    Stamp last = 0;
    double distance_travelled = 0.0;  ///< m, by the velocity since
  };

  std::optional<double> consistent_scale() const;

  std::optional<Turn> turn_;
  double squared_angles_ = 0.0;  ///< of the gyro's angles
  double angle_products_ = 0.0;  ///< of them and the velocity's
  std::optional<Section> section_;
  std::deque<double> scales_;  ///< of the last ways
};

}  // namespace lidar_mapping::preprocessing
