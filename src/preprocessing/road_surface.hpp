// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "plane_search.hpp"

namespace lidar_mapping::preprocessing {

/// A road around a vehicle that heads along x: straight across, over a crest or through a dip
/// along.
///     z = height + rotation_x y - rotation_y x + curvature x^2 / 2
class RoadSurface {
 public:
  /// Rotation about x, rotation about y (rad), height at the origin (m), curvature (1/m).
  explicit RoadSurface(const Eigen::Vector4d& parameters) : parameters_(parameters) {}
  explicit RoadSurface(const Plane& plane);

  /// How far a point is above the surface, in metres along z.
  double above(const Eigen::Vector3d& p) const {
    return p.z() - parameters_[2] - parameters_[0] * p.y() +
           (parameters_[1] - 0.5 * parameters_[3] * p.x()) * p.x();
  }

  double curvature() const { return parameters_[3]; }
  /// The plane that touches the surface at the origin.
  Plane tangent() const;

 private:
  Eigen::Vector4d parameters_;
};

/// A surface fitted to points around it, and how well its tangent at the origin is known.
struct RoadFit {
  RoadSurface surface;
  /// Of rotation about x, rotation about y (rad) and height at the origin (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<std::size_t> inliers;
};

/// Least squares on the points within `tolerance` (m) of the surface, again and again with less
/// weight for those that lie off (Tukey's biweight): first a plane about `start`, then, about that,
/// a surface that may bend. Nothing if the points do not spread over an area.
std::optional<RoadFit> fit_road(const std::vector<Eigen::Vector3d>& points, const Plane& start,
                                double tolerance);

}  // namespace lidar_mapping::preprocessing
