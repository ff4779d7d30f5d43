// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::preprocessing {

enum class AccelerationProblem { kNone, kNotGravity, kConstant };

/// Checks that accelerations are plausible on the Earth, in m/s^2: their mean is gravity, and each
/// axis follows gravity when the sensor tilts.
class AccelerometerCheck {
 public:
  /// Adds a sample in m/s^2 and rad/s, in the axes of the sensor and in the order of the stamps.
  void add(const ImuSample& sample);

  /// The reason for not using the accelerations; it may disappear with later samples.
  AccelerationProblem problem() const { return problem_; }
  /// The same as a message.
  std::string sentence() const;

 private:
  /// The samples of one window of time.
  struct Window {
    Stamp begin = 0;
    Stamp last = 0;
    int samples = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double sum_of_sizes = 0.0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Array<bool, 3, 1> constant_axes = Eigen::Array<bool, 3, 1>::Constant(true);
    /// Gravity, rotated by the gyro, and its smallest and largest value on each axis.
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
    Eigen::Array3d min_gravity = Eigen::Array3d::Zero();
    Eigen::Array3d max_gravity = Eigen::Array3d::Zero();
  };

  static void extend(const ImuSample& sample, Window& window);
  AccelerationProblem evaluate(const Window& window) const;
  void finish_window();

  std::optional<Window> window_;
  /// problem of the previous windows
  AccelerationProblem window_problem_ = AccelerationProblem::kNone;
  int equal_windows_ = 0;  ///< number of successive windows with this problem
  AccelerationProblem problem_ = AccelerationProblem::kNone;
  double mean_size_ = 0.0;  ///< mean acceleration of the last window, m/s^2
};

}  // namespace lidar_mapping::preprocessing
