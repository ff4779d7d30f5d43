// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/scan_motion.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kMaxStep = 0.002;  // s; chosen: at 10 rad/s^2 a step errs by less than 1e-4 rad

/// Integrates from the pose at `time` by one `step` (of either sign).
std::optional<Pose> advanced(const Pose& pose, double time, double step,
                             const TurningAtTime& turning, const VelocityAtTime& velocity) {
  const double middle = time + 0.5 * step;
  const auto omega = turning(middle);
  if (!omega) return std::nullopt;
  const Eigen::Quaterniond half = exp_so3(*omega * (0.5 * step));
  Pose next = pose;
  next.rotation = (pose.rotation * (half * half)).normalized();
  if (velocity) {
    const auto v = velocity(middle, *omega);
    if (!v) return std::nullopt;
    next.translation += pose.rotation * (half * *v) * step;
  }
  return next;
}

/// Poses at the times stamp + k step for k = 1 .. count.
std::optional<std::vector<Pose>> integrate_steps(int count, double step,
                                                 const TurningAtTime& turning,
                                                 const VelocityAtTime& velocity) {
  std::vector<Pose> poses;
  Pose pose;
  for (int k = 0; k < count; ++k) {
    const auto next = advanced(pose, k * step, step, turning, velocity);
    if (!next) return std::nullopt;
    pose = *next;
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace

Pose ScanMotion::at(double time) const {
  const double last = static_cast<double>(T_stamp_knot.size() - 1);
  const double position = std::clamp((time - begin) / step, 0.0, last);
  // It passes the clamp, and no index may be made of it.
  if (std::isnan(position)) return T_stamp_knot.back();
  const auto index = std::min(static_cast<std::size_t>(position), T_stamp_knot.size() - 2);
  return interpolate(T_stamp_knot[index], T_stamp_knot[index + 1],
                     position - static_cast<double>(index));
}

std::optional<ScanMotion> integrated(double begin, double end, const TurningAtTime& turning,
                                     const VelocityAtTime& velocity) {
  // The stamp itself is a knot, so that points measured at the stamp are not moved at all.
  const double step = kMaxStep;
  const int before = static_cast<int>(std::ceil(std::max(0.0, -begin) / step));
  const int after =
      std::max(static_cast<int>(std::ceil(std::max(0.0, end) / step)), before ? 0 : 1);
  auto earlier = integrate_steps(before, -step, turning, velocity);
  const auto later = integrate_steps(after, step, turning, velocity);
  if (!earlier || !later) return std::nullopt;
  ScanMotion motion;
  motion.begin = -before * step;
  motion.step = step;
  motion.T_stamp_knot.assign(earlier->rbegin(), earlier->rend());
  motion.T_stamp_knot.emplace_back();
  motion.T_stamp_knot.insert(motion.T_stamp_knot.end(), later->begin(), later->end());
  return motion;
}

Eigen::Vector3d mean_angular_velocity(const ScanMotion& motion) {
  const auto& knots = motion.T_stamp_knot;
  const double duration = motion.step * static_cast<double>(knots.size() - 1);
  return log_so3(knots.front().rotation.conjugate() * knots.back().rotation) / duration;
}

ScanMotion without_uniform_turning(const ScanMotion& motion, const Eigen::Vector3d& omega) {
  ScanMotion result = motion;
  for (std::size_t k = 0; k < result.T_stamp_knot.size(); ++k) {
    const double time = motion.begin + motion.step * static_cast<double>(k);
    Pose& knot = result.T_stamp_knot[k];
    knot.rotation = (exp_so3(-omega * time) * knot.rotation).normalized();
  }
  return result;
}

UnevenTurning turning_of(const ScanMotion& motion) {
  UnevenTurning turning{motion.begin, motion.step, {}};
  for (const Pose& knot : motion.T_stamp_knot) turning.R_stamp_knot.push_back(knot.rotation);
  return turning;
}

}  // namespace lidar_mapping::preprocessing
