// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace lidar_mapping::preprocessing {

/// Finds the end of the measuring range of a sensor with three axes: the values of an axis stay
/// exactly at the largest value that occurred so far. A value at this limit may be larger in truth.
class AxisLimits {
 public:
  /// Axes whose values do not exceed `min_limit` are taken as within their range.
  explicit AxisLimits(double min_limit) : min_limit_(min_limit) {}

  /// Adds samples in the order of their stamps.
  void add(const Eigen::Vector3d& value);
  /// True if any axis of the value is at the end of its range.
  bool reaches_limit(const Eigen::Vector3d& value) const;
  /// The lowest limit of the three axes; empty if none was found.
  std::optional<double> lowest() const;

 private:
  struct Axis {
    double last = 0.0;
    double largest = 0.0;
    int equal_samples = 0;  ///< number of successive samples that are equal to the last one
    std::optional<double> limit;
  };

  double min_limit_;
  std::array<Axis, 3> axes_;
};

}  // namespace lidar_mapping::preprocessing
