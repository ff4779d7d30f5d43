// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
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
  void add(const Eigen::Vector3d& value) {
    for (int i = 0; i < 3; ++i) {
      Axis& axis = axes_[i];
      const double size = std::abs(value[i]);
      axis.equal_samples = value[i] == axis.last ? axis.equal_samples + 1 : 1;
      axis.last = value[i];
      axis.largest = std::max(axis.largest, size);
      if (axis.limit && size > *axis.limit) axis.limit.reset();
      if (axis.equal_samples >= kMinEqualSamples && size >= axis.largest && size > min_limit_)
        axis.limit = size;
    }
  }
  /// True if any axis of the value is at the end of its range.
  bool reaches_limit(const Eigen::Vector3d& value) const {
    for (int i = 0; i < 3; ++i) {
      const std::optional<double>& limit = axes_[i].limit;
      if (limit && std::abs(value[i]) >= *limit) return true;
    }
    return false;
  }
  /// The lowest limit of the three axes; empty if none was found.
  std::optional<double> lowest() const {
    std::optional<double> lowest;
    for (const Axis& axis : axes_) {
      if (axis.limit && (!lowest || *axis.limit < *lowest)) lowest = axis.limit;
    }
    return lowest;
  }

 private:
  /// Chosen: two successive samples may be equal because of noise and the steps of the converter.
  /// Three equal samples at the largest value of all are very rare.
  static constexpr int kMinEqualSamples = 3;

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
