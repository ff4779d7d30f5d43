#include "lidar_mapping/front_end/preintegration.hpp"

#include <cmath>

namespace lidar_mapping::front_end {

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  const Eigen::Matrix3d w = skew(rotation);
  const double a =
      angle < 1e-4 ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double b = angle < 1e-4 ? 1.0 / 6.0 - angle * angle / 120.0
                                : (angle - std::sin(angle)) / (angle * angle * angle);
  return Eigen::Matrix3d::Identity() - a * w + b * w * w;
}

void Preintegration::add(const Eigen::Vector3d& angular_velocity,
                         const Eigen::Vector3d& specific_force, double dt) {
  const Eigen::Vector3d turn = dt * angular_velocity;
  // The force acts in the axes of the middle of the step.
  const Eigen::Quaterniond half = exp_so3(0.5 * turn);
  const Eigen::Matrix3d R = (rotation * half).toRotationMatrix();
  const Eigen::Vector3d force = R * specific_force;
  const Eigen::Matrix3d rotation_in_middle =
      half.toRotationMatrix().transpose() * rotation_by_gyro -
      right_jacobian(0.5 * turn) * (0.5 * dt);
  const Eigen::Matrix3d force_by_gyro = -R * skew(specific_force) * rotation_in_middle;
  position += dt * velocity + 0.5 * dt * dt * force;
  position_by_gyro += dt * velocity_by_gyro + 0.5 * dt * dt * force_by_gyro;
  position_by_accelerometer += dt * velocity_by_accelerometer - 0.5 * dt * dt * R;
  velocity += dt * force;
  velocity_by_gyro += dt * force_by_gyro;
  velocity_by_accelerometer -= dt * R;
  const Eigen::Quaterniond whole = exp_so3(turn);
  rotation_by_gyro =
      whole.toRotationMatrix().transpose() * rotation_by_gyro - right_jacobian(turn) * dt;
  rotation = (rotation * whole).normalized();
  seconds += dt;
}

Preintegration preintegrated(const std::vector<ImuSample>& samples, const ImuBias& bias) {
  Preintegration sum;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ImuSample& a = samples[i - 1];
    const ImuSample& b = samples[i];
    sum.add(0.5 * (a.angular_velocity + b.angular_velocity) - bias.gyro,
            0.5 * (a.linear_acceleration + b.linear_acceleration) - bias.accelerometer,
            to_seconds(b.stamp - a.stamp));
  }
  return sum;
}

}  // namespace lidar_mapping::front_end
