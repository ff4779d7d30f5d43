// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace lidar_mapping::preprocessing {

/// Where the range of a sensor with three axes ends, learnt from values that stay exactly at the
/// largest one that the axis has said so far. What is as large may be larger in truth.
class AxisLimits {
 public:
  /// Axes that have not said more than `least` are taken as within their range.
  explicit AxisLimits(double min_limit) : min_limit_(min_limit) {}

  /// Samples in the order of their stamps.
  void add(const Eigen::Vector3d& value);
  /// Whether any axis of the value is at the end of its range.
  bool reaches_limit(const Eigen::Vector3d& value) const;
  /// The lowest limit of the three axes; nothing if none was found.
  std::optional<double> lowest() const;

 private:
  struct Axis {
    double last = 0.0;
    double largest = 0.0;
    int equal_samples = 0;  ///< samples in a row that are as the last one
    std::optional<double> limit;
  };

  double min_limit_;
  std::array<Axis, 3> axes_;
};

}  // namespace lidar_mapping::preprocessing
