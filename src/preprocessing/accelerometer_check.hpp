// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

enum class AccelerationProblem { kNone, kNotGravity, kConstant };

/// Whether accelerations are such as are felt on the Earth, in m/s^2: in the mean they are gravity,
/// and each axis feels it as the sensor tilts.
class AccelerometerCheck {
 public:
  /// In m/s^2 and rad/s, axes of the sensor, in the order of the stamps.
  void add(const ImuSample& sample);

  /// What speaks against using the accelerations; later ones may agree again.
  AccelerationProblem problem() const { return problem_; }
  /// That in words.
  std::string sentence() const;

 private:
  /// What was seen over a while.
  struct Window {
    Stamp begin = 0;
    Stamp last = 0;
    int samples = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double sum_of_sizes = 0.0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Array<bool, 3, 1> constant_axes = Eigen::Array<bool, 3, 1>::Constant(true);
    /// Gravity as the gyro turns it, and the least and most of it on each axis.
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
    Eigen::Array3d min_gravity = Eigen::Array3d::Zero();
    Eigen::Array3d max_gravity = Eigen::Array3d::Zero();
  };

  static void extend(const ImuSample& sample, Window& window);
  AccelerationProblem evaluate(const Window& window) const;
  void finish_window();

  std::optional<Window> window_;
  AccelerationProblem window_problem_ = AccelerationProblem::kNone;  ///< in the windows before
  int equal_windows_ = 0;                                            ///< in a row that have seen it
  AccelerationProblem problem_ = AccelerationProblem::kNone;
  double mean_size_ = 0.0;  ///< mean acceleration of the last window, m/s^2
};

}  // namespace lidar_mapping::preprocessing
