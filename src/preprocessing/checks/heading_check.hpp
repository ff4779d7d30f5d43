// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::preprocessing {

/// Compares the heading of an IMU's orientation with the course over ground. A six-axis IMU starts
/// at an arbitrary heading, so the heading can only be verified while driving.
class HeadingCheck {
 public:
  /// Adds a position of the vehicle with its sigma (m), the attitude by the IMU, and whether it
  /// drives backwards.
  void add(const Eigen::Vector3d& p_enu, double sigma, const Eigen::Quaterniond& R_enu_base,
           bool backwards);
  /// True after three successive sections of the path agreed, false after three successive ones did
  /// not; empty before.
  std::optional<bool> agrees() const { return agrees_; }

 private:
  void update(const Eigen::Vector3d& step, double yaw);

  std::optional<Eigen::Vector3d> section_start_;
  double section_start_yaw_ = 0.0;
  int agreements_ = 0;
  int contradictions_ = 0;
  std::optional<bool> agrees_;
};

}  // namespace lidar_mapping::preprocessing
