// SPDX-License-Identifier: BSD-3-Clause
#include "fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/robust_weights.hpp"

namespace lidar_mapping::registration {

namespace {

// Points of the source. Chosen: enough for fractions in steps of 0.1 % and for a Hessian; a whole
// scan would cost more than matching.
constexpr std::size_t kMaxPoints = 1000;
// Neighbours for a plane, which has three unknowns. Chosen: few enough to lie on one surface.
constexpr int kPlanePoints = 8;
// A ring of the sensor that crosses a surface is a line and gives no information about its normal.
// Chosen: standard deviations in a ratio of 1 : 4.5 (breadth) and 1 : 3 (thickness).
constexpr double kLeastBreadth = 0.05;      // second axis / first axis, of variances
constexpr double kGreatestThickness = 0.1;  // third axis / second axis, of variances
// Fractions of max_range up to which a point is an inlier, by its distance to a surface and, where
// the target is too sparse for a surface, to a point. Chosen: neighbouring points of a sparse
// target are farther from each other than a surface is from a point that lies on it.
constexpr double kSurfaceFraction = 0.2;
constexpr double kPointFraction = 0.5;
constexpr double kLeastSigma = 0.01;  // m; chosen: no scanner of this class is better

/// Distance of a point to the target's plane, and its derivative by the pose's perturbation.
struct Residual {
  double value;
  Vector6d gradient;
};

Residual residual_of(const PlaneFit& plane, const Eigen::Vector3d& p_source, const Pose& T) {
  const Eigen::Vector3d normal_source = T.rotation.conjugate() * plane.normal;
  Residual residual;
  residual.value = plane.normal.dot(T * p_source - plane.mean);
  residual.gradient << normal_source, p_source.cross(normal_source);
  return residual;
}

/// Robust standard deviation about zero.
double scale_of(const std::vector<Residual>& residuals) {
  std::vector<double> sizes;
  for (const Residual& r : residuals) sizes.push_back(std::abs(r.value));
  return std::max(kSigmaPerMad * median(std::move(sizes)), kLeastSigma);
}

Matrix6d hessian_of(const std::vector<Residual>& residuals) {
  Matrix6d hessian = Matrix6d::Zero();
  if (residuals.empty()) return hessian;
  const double sigma = scale_of(residuals);
  for (const Residual& r : residuals) {
    const double weight = geman_mcclure_weight(r.value, 3.0 * sigma);
    hessian += weight / (sigma * sigma) * r.gradient * r.gradient.transpose();
  }
  return hessian;
}

}  // namespace

std::optional<PlaneFit> fit_plane(const PclCloud& cloud, const pcl::Indices& indices) {
  const auto point = [&](pcl::index_t i) { return cloud[i].getVector3fMap().cast<double>(); };
  const Eigen::Vector3d first = point(indices.front());
  PointMoments moments;  // relative to a point nearby: the cloud may be far from its origin
  for (const auto i : indices) moments.add(point(i) - first);
  PlaneFit fit(moments);
  const Eigen::Vector3d& variances = fit.variances;
  if (variances[1] < kLeastBreadth * variances[2]) return std::nullopt;
  if (variances[0] > kGreatestThickness * variances[1]) return std::nullopt;
  fit.mean += first;
  return fit;
}

RegistrationResult evaluate_fit(const pcl::search::KdTree<pcl::PointXYZ>& tree,
                                const PclCloud& source, const Pose& T_target_source,
                                double max_range) {
  RegistrationResult result;
  result.T_target_source = T_target_source;
  const std::size_t stride = (source.size() + kMaxPoints - 1) / kMaxPoints;
  double tried = 0.0, paired = 0.0, inliers = 0.0;
  std::vector<Residual> residuals;
  pcl::Indices neighbors;
  std::vector<float> squared_distances;
  for (std::size_t i = 0; i < source.size(); i += stride) {
    tried += 1.0;
    const Eigen::Vector3d p_source = source[i].getVector3fMap().cast<double>();
    const Eigen::Vector3f p = (T_target_source * p_source).cast<float>();
    tree.nearestKSearch(pcl::PointXYZ(p.x(), p.y(), p.z()), kPlanePoints, neighbors,
                        squared_distances);
    if (neighbors.empty() || squared_distances[0] > max_range * max_range) continue;
    const double squared_distance = squared_distances[0];
    paired += 1.0;
    result.fitness += squared_distance;
    if (const auto plane = fit_plane(*tree.getInputCloud(), neighbors)) {
      residuals.push_back(residual_of(*plane, p_source, T_target_source));
      if (std::abs(residuals.back().value) < kSurfaceFraction * max_range) inliers += 1.0;
    } else if (std::sqrt(squared_distance) < kPointFraction * max_range) {
      inliers += 1.0;
    }
  }
  if (paired == 0.0) return result;
  result.fitness /= paired;
  result.overlap = paired / tried;
  result.inlier_fraction = inliers / tried;
  result.hessian = hessian_of(residuals);
  return result;
}

}  // namespace lidar_mapping::registration
