// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "floor/plane_search.hpp"

namespace lidar_mapping::preprocessing {

/// A road around a vehicle that heads along x. It is straight across, and may be curved along x, as
/// on a crest or in a dip.
///     z = height + rotation_x y - rotation_y x + curvature x^2 / 2
class RoadSurface {
 public:
  /// Rotation about x, rotation about y (rad), height at the origin (m), curvature (1/m).
  explicit RoadSurface(const Eigen::Vector4d& parameters) : parameters_(parameters) {}
  explicit RoadSurface(const Plane& plane);

  /// Height of a point above the surface, in metres along z.
  double above(const Eigen::Vector3d& p) const {
    return p.z() - parameters_[2] - parameters_[0] * p.y() +
           (parameters_[1] - 0.5 * parameters_[3] * p.x()) * p.x();
  }

  double curvature() const { return parameters_[3]; }
  /// The tangent plane at the origin.
  Plane tangent() const;

 private:
  Eigen::Vector4d parameters_;
};

/// A surface that was fitted to points, and the covariance of its tangent at the origin.
struct RoadFit {
  RoadSurface surface;
  /// Covariance of rotation about x, rotation about y (rad) and height at the origin (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<std::size_t> inliers;
};

/// Repeated least squares on the points within `tolerance` (m) of the surface, with smaller weights
/// for points far from it (Tukey's biweight): first a plane that starts at `start`, then a surface
/// with curvature. Empty if the points do not cover an area.
std::optional<RoadFit> fit_road(const std::vector<Eigen::Vector3d>& points, const Plane& start,
                                double tolerance);

}  // namespace lidar_mapping::preprocessing
