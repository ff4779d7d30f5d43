// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/uneven_turning.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lidar_mapping {

Eigen::Quaterniond UnevenTurning::at(double time) const {
  const double last = static_cast<double>(R_stamp_knot.size() - 1);
  const double position = std::clamp((time - begin) / step, 0.0, last);
  if (!(position < last)) return R_stamp_knot.back();  // also at a time that is not a number
  const auto index = static_cast<std::size_t>(position);
  return R_stamp_knot[index].slerp(position - std::floor(position), R_stamp_knot[index + 1]);
}

double UnevenTurning::mean_rate() const {
  if (R_stamp_knot.size() < 2) return 0.0;
  double largest = 0.0;
  for (const Eigen::Quaterniond& knot : R_stamp_knot) {
    largest = std::max(largest, rotation_angle(knot));
  }
  return largest / (step * static_cast<double>(R_stamp_knot.size() - 1));
}

PointCloud put_back(const UnevenTurning& turning, PointCloud cloud) {
  if (!cloud.has_times() || turning.R_stamp_knot.empty()) return cloud;
  float time = std::nanf("");
  Eigen::Matrix3f R_knot_stamp = Eigen::Matrix3f::Identity();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.times[i] != time) {  // many points are seen at once
      time = cloud.times[i];
      R_knot_stamp = turning.at(time).conjugate().toRotationMatrix().cast<float>();
    }
    Point& point = cloud.points[i];
    const Eigen::Vector3f p = R_knot_stamp * point.position();
    point = {p.x(), p.y(), p.z(), point.intensity};
  }
  return cloud;
}

}  // namespace lidar_mapping
