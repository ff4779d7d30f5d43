// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/uneven_turning.hpp"

namespace lidar_mapping::preprocessing {

/// The motion of a point of the vehicle during a scan, in the axes of base_link: T_stamp_t is its
/// pose at time t in its own frame at the scan's stamp. Poses are given at equal steps of time (s,
/// relative to the stamp).
struct ScanMotion {
  double begin = 0.0;              ///< time of the first knot, s
  double step = 0.0;               ///< from knot to knot, s
  std::vector<Pose> T_stamp_knot;  ///< two or more

  /// Linear interpolation between the knots; constant beyond the ends. At a time that is not a
  /// number it is the last knot, as in UnevenTurning; points with such a time are dropped before
  /// (keep_and_deskew()).
  Pose at(double time) const;
};

/// Empty if it was not measured.
using MaybeVector = std::optional<Eigen::Vector3d>;
/// Angular velocity (rad/s) at a time (s, relative to the scan's stamp).
using TurningAtTime = std::function<MaybeVector(double time)>;
/// Velocity (m/s) at a time (s, relative to the scan's stamp) at which the vehicle turns at the
/// rate `omega` (rad/s).
using VelocityAtTime = std::function<MaybeVector(double time, const Eigen::Vector3d& omega)>;

/// Integrates angular velocity (on SO(3)) and velocity, both in the axes of base_link, by the
/// midpoint rule from the stamp to both ends of [begin, end]. Without a `velocity` only the
/// rotation is integrated. Empty if a value is missing.
std::optional<ScanMotion> integrated(double begin, double end, const TurningAtTime& turning,
                                     const VelocityAtTime& velocity);

/// Mean angular velocity over the scan, rad/s.
Eigen::Vector3d mean_angular_velocity(const ScanMotion& motion);

/// The rotation that remains when a uniform rotation is removed: exp(-omega t) R(t). A scan that is
/// corrected by it looks as if the vehicle had turned at the constant rate `omega` (rad/s).
/// Translations stay as they are.
ScanMotion without_uniform_turning(const ScanMotion& motion, const Eigen::Vector3d& omega);
/// The rotations of a motion without its uniform part.
UnevenTurning turning_of(const ScanMotion& motion);

}  // namespace lidar_mapping::preprocessing
