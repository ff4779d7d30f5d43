// SPDX-License-Identifier: BSD-3-Clause
#include "base_frame.hpp"

#include <memory>
#include <utility>

namespace lidar_mapping::front_end {

void turn_axes(const Eigen::Quaterniond& R_new_old, UnevenTurning& turning) {
  for (Eigen::Quaterniond& knot : turning.R_stamp_knot)
    knot = R_new_old * knot * R_new_old.conjugate();
}

MotionPrior BaseFrame::of_sensor(const MotionPrior& prior, const Eigen::Vector3d& turning) const {
  const Eigen::Quaterniond R_sensor_base = T_base_sensor_.rotation.conjugate();
  MotionPrior result = prior;
  if (prior.angular_velocity) result.angular_velocity = R_sensor_base * *prior.angular_velocity;
  if (prior.linear_velocity) {
    const Eigen::Vector3d omega = prior.velocity_turning   ? *prior.velocity_turning
                                  : prior.angular_velocity ? *prior.angular_velocity
                                                           : T_base_sensor_.rotation * turning;
    result.linear_velocity =
        R_sensor_base * (*prior.linear_velocity + omega.cross(T_base_sensor_.translation));
    result.velocity_turning = R_sensor_base * omega;
  }
  if (prior.uneven_turning) turn_axes(R_sensor_base, *result.uneven_turning);
  if (prior.felt) {
    result.felt->mean = R_sensor_base * prior.felt->mean;
    result.felt->p_base_imu = T_base_sensor_.inverse() * prior.felt->p_base_imu;
  }
  if (prior.T_external_base) result.T_external_base = *prior.T_external_base * T_base_sensor_;
  return result;
}

Pose BaseFrame::base_in_odom(const Pose& T_first_sensor) const {
  return T_odom_first_ * T_first_sensor * T_base_sensor_.inverse();
}

void BaseFrame::to_base(std::vector<Eigen::Vector3d>& directions) const {
  for (Eigen::Vector3d& direction : directions) direction = T_base_sensor_.rotation * direction;
}

/// If the LiDAR moves by M, base_link moves by T_base_sensor M T_base_sensor^-1. Perturbations and
/// twists are therefore converted by the adjoint.
FrontEndResult BaseFrame::of_base(FrontEndResult result) const {
  const Matrix6d to_base_motion = adjoint(T_base_sensor_);
  result.T_odom_base = base_in_odom(result.T_odom_base);
  result.covariance = to_base_motion * result.covariance * to_base_motion.transpose();
  result.twist = to_base_motion * result.twist;
  result.acceleration = to_base_motion * result.acceleration;
  to_base(result.status.degenerate_directions);
  if (result.key_frame) result.key_frame = of_base(*std::move(result.key_frame));
  result.finalized = of_base(std::move(result.finalized));
  return result;
}

std::vector<FrontEndResult> BaseFrame::of_base(std::vector<FrontEndResult> results) const {
  for (FrontEndResult& result : results) result = of_base(std::move(result));
  return results;
}

KeyFrame BaseFrame::of_base(KeyFrame key_frame) const {
  const Matrix6d to_base_motion = adjoint(T_base_sensor_);
  key_frame.T_odom_base = base_in_odom(key_frame.T_odom_base);
  key_frame.motion_covariance =
      to_base_motion * key_frame.motion_covariance * to_base_motion.transpose();
  to_base(key_frame.degenerate_directions);
  key_frame.cloud =
      std::make_shared<const PointCloud>(transformed(*key_frame.cloud, T_base_sensor_));
  return key_frame;
}

}  // namespace lidar_mapping::front_end
