// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/elevation_pair.hpp"

#include <cmath>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/robust_weights.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

#include "matching/degeneracy.hpp"

namespace lidar_mapping::front_end {
namespace {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

/// Number of points of scan b that are used; the points of scan a define the planes. Chosen: bounds
/// the time of a pair, which is about a millisecond.
constexpr std::size_t kMaxPoints = 8000;

struct Iteration {
  /// Squared distance in standard deviations at which a point loses most of its weight
  /// (Geman-McClure).
  double kernel_squared;
  std::size_t thinning;
};
constexpr Iteration kIterations[] = {{100.0, 4}, {25.0, 4}, {6.25, 4}, {6.25, 1}};

/// Smallest eigenvalue of the translation's Hessian, as a fraction of its trace, with which a pair
/// determines its relative pose well enough. Tried: with kDegenerateFraction, which is enough to
/// track a scan, pairs of a tunnel and of car parks gave false angles.
constexpr double kMinConditionFraction = 0.0015;

/// Chosen: no sensor has a larger error (KITTI's has 0.2 degrees), so the solution has diverged.
constexpr double kMaxAngle = 0.03;  // rad

struct NormalEquations {
  Matrix7d hessian = Matrix7d::Zero();
  Vector7d gradient = Vector7d::Zero();
};

/// Derivative of a point with respect to its elevation, per radian.
Eigen::Vector3d elevation_derivative(const Eigen::Vector3d& p) {
  const double horizontal = std::hypot(p.x(), p.y());
  if (horizontal == 0.0) return Eigen::Vector3d::Zero();
  const double horizontal_scale = -p.z() / horizontal;
  return {horizontal_scale * p.x(), horizontal_scale * p.y(), horizontal};
}

/// Residuals are the distances of the points of b to the planes of a, with both rotated by `angle`.
/// Unknowns: the perturbation of T_a_b, see perturbed(), then the angle.
NormalEquations normal_equations(const SampledPoints& points, GaussianVoxelMap& map,
                                 const Pose& T_a_b, double angle, const Iteration& iteration) {
  const std::size_t step = iteration.thinning * (1 + points.size() / kMaxPoints);
  const Eigen::Matrix3d R = T_a_b.rotation_matrix();
  NormalEquations sum;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const Eigen::Vector3d p_b(points.x[i], points.y[i], points.z[i]);
    const Eigen::Vector3d p_a = R * p_b + T_a_b.translation;
    const Eigen::Vector3i cell = voxel_index(p_a / map.resolution());
    const registration::WeightedPlane plane = map.plane(cell);
    if (plane.normal.isZero(0.0F)) continue;
    const Eigen::Vector3d n_a = plane.normal.cast<double>();
    const Eigen::Vector3d n_b = R.transpose() * n_a;
    const double slope = n_b.dot(elevation_derivative(p_b)) - n_a.dot(elevation_derivative(p_a));
    const double r = n_a.dot(p_a) - static_cast<double>(plane.offset) + slope * angle;
    const double weight = geman_mcclure_weight_of_squares(r * r, iteration.kernel_squared);
    Vector7d J;
    J << n_b, p_b.cross(n_b), slope;
    const Vector7d weighted = weight * J;
    sum.hessian.noalias() += weighted * J.transpose();
    sum.gradient += r * weighted;
  }
  return sum;
}

}  // namespace

std::optional<ElevationEstimate> estimate_elevation(const SampledPoints& points,
                                                    GaussianVoxelMap& map, const Pose& T_a_b) {
  Pose pose = T_a_b;
  ElevationEstimate estimate;
  for (const Iteration& iteration : kIterations) {
    const NormalEquations sum = normal_equations(points, map, pose, estimate.angle, iteration);
    const Eigen::LDLT<Matrix7d> solver(sum.hessian);
    const Vector7d step = -solver.solve(sum.gradient);
    const double variance = solver.solve(Vector7d::Unit(6))[6];
    if (!step.allFinite() || !(variance > 0.0)) return std::nullopt;
    const Matrix6d pose_hessian = sum.hessian.topLeftCorner<6, 6>();
    if (!degenerate_directions(pose_hessian, kMinConditionFraction).empty()) return std::nullopt;
    pose = perturbed(pose, Vector6d(step.head<6>()));
    estimate = {estimate.angle + step[6], std::sqrt(variance)};
  }
  if (std::abs(estimate.angle) > kMaxAngle) return std::nullopt;
  return estimate;
}

}  // namespace lidar_mapping::front_end
