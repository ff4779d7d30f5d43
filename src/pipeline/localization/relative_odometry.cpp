// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/relative_odometry.hpp"

#include <utility>

namespace lidar_mapping::pipeline {

void RelativeOdometry::add(const OdometryStep& step) {
  is_connected_ = is_connected_ && step.covariance.has_value();
  if (is_connected_) {
    covariance_ = compose_covariance(covariance_, T_odom_newest_.inverse() * step.T_odom_base,
                                     *step.covariance);
  }
  T_odom_newest_ = step.T_odom_base;
}

localization::LocalizerInput RelativeOdometry::input_of(Scan&& scan) {
  localization::LocalizerInput input;
  input.scan = std::move(scan);
  input.is_connected = is_connected_;
  if (is_connected_) {
    input.T_previous_base = T_odom_last_.inverse() * T_odom_newest_;
    input.covariance = covariance_;
  }
  T_odom_last_ = T_odom_newest_;
  covariance_.setZero();
  is_connected_ = true;
  return input;
}

}  // namespace lidar_mapping::pipeline
