#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::preprocessing {

/// normal . p + offset = 0, the normal with unit length and upward.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;

  double distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset; }
};

/// The plane with most points within `tolerance` (m) among planes through three points whose normal
/// leans at most `largest_lean` (rad) (Fischler and Bolles 1981); seeded, so the same points give
/// the same plane. Nothing if no three points make such a plane.
std::optional<Plane> search_plane(const std::vector<Eigen::Vector3d>& points, double tolerance,
                                  double largest_lean);

/// A plane fitted to points around it, and how well its heights and slopes are known.
struct PlaneFit {
  Plane plane;
  /// Of rotation about x, rotation about y (rad) and height at the origin (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  std::vector<std::size_t> inliers;
};

/// Least squares on the points within `tolerance` of `start`, again and again with less weight for
/// those that lie off (Tukey's biweight). Nothing if the points do not spread over an area.
std::optional<PlaneFit> fit_plane(const std::vector<Eigen::Vector3d>& points, const Plane& start,
                                  double tolerance);

}  // namespace lidar_mapping::preprocessing
