// SPDX-License-Identifier: BSD-3-Clause
#include "checks/axis_limits.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::preprocessing {
namespace {

/// Chosen: two successive samples may be equal because of noise and the steps of the converter.
/// Three equal samples at the largest value of all are very rare.
constexpr int kMinEqualSamples = 3;

}  // namespace

void AxisLimits::add(const Eigen::Vector3d& value) {
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

bool AxisLimits::reaches_limit(const Eigen::Vector3d& value) const {
  for (int i = 0; i < 3; ++i) {
    const std::optional<double>& limit = axes_[i].limit;
    if (limit && std::abs(value[i]) >= *limit) return true;
  }
  return false;
}

std::optional<double> AxisLimits::lowest() const {
  std::optional<double> lowest;
  for (const Axis& axis : axes_) {
    if (axis.limit && (!lowest || *axis.limit < *lowest)) lowest = axis.limit;
  }
  return lowest;
}

}  // namespace lidar_mapping::preprocessing
