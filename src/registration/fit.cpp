// SPDX-License-Identifier: BSD-3-Clause
#include "fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/plane_fit.hpp"
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

Residual residual_of(const Plane& plane, const Eigen::Vector3d& p_source, const Pose& T) {
  const Eigen::Vector3d normal_source = T.rotation.conjugate() * plane.normal;
  Residual residual;
  residual.value = plane.normal.dot(T * p_source - plane.centroid);
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

/// A point of the source and its nearest neighbours in the target.
struct Match {
  double squared_distance;
  std::optional<Residual> residual;
};

class Matcher {
 public:
  Matcher(const pcl::search::KdTree<pcl::PointXYZ>& tree, const Pose& T_target_source)
      : tree_(tree), T_target_source_(T_target_source) {}

  std::optional<Match> match(const Eigen::Vector3d& p_source, double max_range) {
    const Eigen::Vector3f p = (T_target_source_ * p_source).cast<float>();
    tree_.nearestKSearch(pcl::PointXYZ(p.x(), p.y(), p.z()), kPlanePoints, indices_,
                         squared_distances_);
    if (indices_.empty() || squared_distances_[0] > max_range * max_range) return std::nullopt;
    Match match{squared_distances_[0], std::nullopt};
    if (const auto plane = fit_plane(*tree_.getInputCloud(), indices_)) {
      match.residual = residual_of(*plane, p_source, T_target_source_);
    }
    return match;
  }

 private:
  const pcl::search::KdTree<pcl::PointXYZ>& tree_;
  Pose T_target_source_;
  pcl::Indices indices_;
  std::vector<float> squared_distances_;
};

bool is_inlier(const Match& match, double max_range) {
  if (match.residual) return std::abs(match.residual->value) < kSurfaceFraction * max_range;
  return std::sqrt(match.squared_distance) < kPointFraction * max_range;
}

}  // namespace

std::optional<Plane> fit_plane(const PclCloud& cloud, const pcl::Indices& indices) {
  const auto point = [&](pcl::index_t i) { return cloud[i].getVector3fMap().cast<double>(); };
  const Eigen::Vector3d first = point(indices.front());
  PointMoments moments;  // relative to a point nearby: the cloud may be far from its origin
  for (const auto i : indices) moments.add(point(i) - first);
  const PlaneFit fit(moments);
  const Eigen::Vector3d& variances = fit.variances;
  if (variances[1] < kLeastBreadth * variances[2]) return std::nullopt;
  if (variances[0] > kGreatestThickness * variances[1]) return std::nullopt;
  return Plane{fit.mean + first, fit.normal};
}

Fit evaluate_fit(const pcl::search::KdTree<pcl::PointXYZ>& tree, const PclCloud& source,
                 const Pose& T_target_source, double max_range) {
  Fit fit;
  const std::size_t stride = (source.size() + kMaxPoints - 1) / kMaxPoints;
  double tried = 0.0, paired = 0.0, inliers = 0.0;
  std::vector<Residual> residuals;
  Matcher matcher(tree, T_target_source);
  for (std::size_t i = 0; i < source.size(); i += stride) {
    tried += 1.0;
    const auto match = matcher.match(source[i].getVector3fMap().cast<double>(), max_range);
    if (!match) continue;
    paired += 1.0;
    fit.fitness += match->squared_distance;
    if (is_inlier(*match, max_range)) inliers += 1.0;
    if (match->residual) residuals.push_back(*match->residual);
  }
  if (paired == 0.0) return fit;
  fit.fitness /= paired;
  fit.overlap = paired / tried;
  fit.inlier_fraction = inliers / tried;
  fit.hessian = hessian_of(residuals);
  return fit;
}

void copy_figures(const Fit& fit, RegistrationResult& result) {
  result.fitness = fit.fitness;
  result.inlier_fraction = fit.inlier_fraction;
  result.overlap = fit.overlap;
  result.hessian = fit.hessian;
}

}  // namespace lidar_mapping::registration
