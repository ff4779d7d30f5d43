// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/smooth_trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/rotations.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Degree of the spline. Chosen: with four continuous derivatives, neither acceleration nor jerk
/// has a jump.
constexpr int kDegree = 5;

/// Weights of degree + 1 control points at u in [0, 1] of a span (recursion of Cox and de Boor,
/// uniform knots).
std::array<double, kDegree + 1> basis(double u, int degree) {
  std::array<double, kDegree + 1> weights{};
  weights[0] = 1.0;
  for (int d = 1; d <= degree; ++d) {
    double carried = 0.0;
    for (int i = 0; i < d; ++i) {
      const double part = weights[i] / d;
      weights[i] = carried + (i + 1 - u) * part;
      carried = (u + d - 1 - i) * part;
    }
    weights[d] = carried;
  }
  return weights;
}

Pose to_pose(const Vector6d& value) {
  return {rotation_from_rpy(value(5), value(4), value(3)), value.head<3>()};
}

Eigen::Vector3d body_rates(const Vector6d& value, const Vector6d& first) {
  const double sp = std::sin(value(4)), cp = std::cos(value(4));
  const double sr = std::sin(value(5)), cr = std::cos(value(5));
  const double yaw = first(3), pitch = first(4), roll = first(5);
  return {roll - yaw * sp, pitch * cr + yaw * cp * sr, yaw * cp * cr - pitch * sr};
}

Eigen::Vector3d body_accelerations(const Vector6d& value, const Vector6d& first,
                                   const Vector6d& second) {
  const double sp = std::sin(value(4)), cp = std::cos(value(4));
  const double sr = std::sin(value(5)), cr = std::cos(value(5));
  const double yaw = first(3), pitch = first(4), roll = first(5);
  return body_rates(value, second) +
         Eigen::Vector3d(-yaw * pitch * cp,
                         -pitch * roll * sr - yaw * pitch * sp * sr + yaw * roll * cp * cr,
                         -yaw * pitch * sp * cr - yaw * roll * cp * sr - pitch * roll * cr);
}

}  // namespace

MotionState MotionState::of_frame(const Pose& T_base_frame) const {
  const Eigen::Vector3d& arm = T_base_frame.translation;
  const Eigen::Vector3d& w = angular_velocity_base;
  const Eigen::Quaterniond to_frame = T_base_frame.rotation.conjugate();
  MotionState state;
  state.T_map_base = T_map_base * T_base_frame;
  state.velocity_map = velocity_map + T_map_base.rotation * w.cross(arm);
  state.acceleration_map =
      acceleration_map +
      T_map_base.rotation * (angular_acceleration_base.cross(arm) + w.cross(w.cross(arm)));
  state.angular_velocity_base = to_frame * w;
  state.angular_acceleration_base = to_frame * angular_acceleration_base;
  return state;
}

SmoothTrajectory::SmoothTrajectory(Stamp begin, double step_s, std::vector<Vector6d> control)
    : begin_(begin), step_s_(step_s), control_(std::move(control)) {
  if (control_.size() < kDegree + 2) {
    throw InputError("trajectory: " + std::to_string(control_.size()) +
                     " control points; at least 7 are needed");
  }
  end_ = begin_ + from_seconds(static_cast<double>(control_.size() - kDegree) * step_s_);
}

Vector6d SmoothTrajectory::evaluate(Stamp stamp, int derivative) const {
  const double position = to_seconds(stamp - begin_) / step_s_;
  const auto last_span = static_cast<double>(control_.size() - kDegree - 1);
  const double span = std::clamp(std::floor(position), 0.0, last_span);
  std::array<Vector6d, kDegree + 1> points;
  std::copy_n(control_.begin() + static_cast<std::ptrdiff_t>(span), kDegree + 1, points.begin());
  int degree = kDegree;
  for (; degree > kDegree - derivative; --degree) {
    for (int i = 0; i < degree; ++i) points[i] = (points[i + 1] - points[i]) / step_s_;
  }
  const auto weights = basis(position - span, degree);
  Vector6d value = Vector6d::Zero();
  for (int i = 0; i <= degree; ++i) value += weights[i] * points[i];
  return value;
}

Pose SmoothTrajectory::pose(Stamp stamp) const {
  if (stamp < begin_ || stamp > end_) {
    throw InputError("trajectory: stamp " + std::to_string(stamp) + " lies outside [" +
                     std::to_string(begin_) + ", " + std::to_string(end_) + "]");
  }
  return to_pose(evaluate(stamp, 0));
}

MotionState SmoothTrajectory::state(Stamp stamp) const {
  MotionState state;
  state.T_map_base = pose(stamp);
  const Vector6d value = evaluate(stamp, 0), first = evaluate(stamp, 1),
                 second = evaluate(stamp, 2);
  state.velocity_map = first.head<3>();
  state.acceleration_map = second.head<3>();
  state.angular_velocity_base = body_rates(value, first);
  state.angular_acceleration_base = body_accelerations(value, first, second);
  return state;
}

double SmoothTrajectory::length(Stamp from, Stamp to) const {
  constexpr Stamp kStep = 50'000'000;
  double length = 0.0;
  for (Stamp stamp = from; stamp < to; stamp += kStep) {
    const Stamp next = std::min(stamp + kStep, to);
    length += (pose(next).translation - pose(stamp).translation).norm();
  }
  return length;
}

}  // namespace lidar_mapping::simulation
