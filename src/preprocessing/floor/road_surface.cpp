// SPDX-License-Identifier: BSD-3-Clause
#include "floor/road_surface.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/robust_weights.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr int kPlaneIterations = 5;    // chosen: Tukey's weights need a good start
constexpr int kSurfaceIterations = 3;  // from the plane on; chosen, bounds the time
// 1/m, standard deviation with which the surface stays a plane. Chosen: 1e-9 m at 1 m, numerically
// zero.
constexpr double kFlatCurvatureSigma = 1e-9;
// 1/m, standard deviation. Chosen: crests of slow streets have radii from about 300 m on.
constexpr double kCurvatureSigma = 1.0 / 300.0;
// m: points that are nearer to each other have the same error (range, attitude, surface). Chosen.
constexpr double kPatchSize = 1.0;
// m, lower bound for heights. Chosen: roads are not flat to the millimetre.
constexpr double kMinHeightSigma = 0.01;
// m^2, variance of 0.5 m: points on a line do not determine one rotation. Chosen.
constexpr double kMinSpread = 0.25;

/// Weighted sums over points, from which everything else is computed. Thirteen scalar sums stay in
/// registers; a matrix would be read and written in memory for each point.
class Moments {
 public:
  void add(const Eigen::Vector3d& p, double weight) {
    const double x = weight * p.x(), y = weight * p.y(), xx = x * p.x();
    weight_ += weight;
    x_ += x;
    y_ += y;
    xx_ += xx;
    xy_ += x * p.y();
    yy_ += y * p.y();
    xxx_ += xx * p.x();
    xxy_ += xx * p.y();
    xxxx_ += xx * p.x() * p.x();
    z_ += weight * p.z();
    xz_ += x * p.z();
    yz_ += y * p.z();
    xxz_ += xx * p.z();
  }

  bool spread_over_an_area() const {
    if (weight_ <= 0.0) return false;
    const Eigen::Vector2d mean(x_ / weight_, y_ / weight_);
    Eigen::Matrix2d scatter;
    scatter << xx_, xy_, xy_, yy_;
    scatter = scatter / weight_ - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter, Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[0] >= kMinSpread;
  }

  /// Normal equations of RoadSurface's parameters, for heights z = (y, -x, 1, x^2 / 2) parameters.
  Eigen::Matrix4d information() const {
    Eigen::Matrix4d result;
    result << yy_, -xy_, y_, 0.5 * xxy_,  //
        -xy_, xx_, -x_, -0.5 * xxx_,      //
        y_, -x_, weight_, 0.5 * xx_,      //
        0.5 * xxy_, -0.5 * xxx_, 0.5 * xx_, 0.25 * xxxx_;
    return result;
  }
  Eigen::Vector4d right_hand_side() const { return {yz_, -xz_, z_, 0.5 * xxz_}; }

 private:
  double weight_ = 0.0, x_ = 0.0, y_ = 0.0, xx_ = 0.0, xy_ = 0.0, yy_ = 0.0, xxx_ = 0.0, xxy_ = 0.0,
         xxxx_ = 0.0;
  double z_ = 0.0, xz_ = 0.0, yz_ = 0.0, xxz_ = 0.0;
};

/// The weights become zero at `scale`. A prior keeps the curvature at zero with `curvature_sigma`.
std::optional<RoadSurface> weighted_surface(const std::vector<Eigen::Vector3d>& points,
                                            const RoadSurface& previous, double scale,
                                            double curvature_sigma) {
  Moments moments;
  for (const Eigen::Vector3d& p : points) {
    const double above = previous.above(p);
    if (std::abs(above) < scale) moments.add(p, tukey_weight(above, scale));
  }
  if (!moments.spread_over_an_area()) return std::nullopt;
  Eigen::Matrix4d information = moments.information();
  information(3, 3) += scale * scale / (curvature_sigma * curvature_sigma);
  return RoadSurface(information.ldlt().solve(moments.right_hand_side()));
}

std::vector<std::size_t> points_near(const std::vector<Eigen::Vector3d>& points,
                                     const RoadSurface& surface, double tolerance) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(surface.above(points[i])) < tolerance) result.push_back(i);
  }
  return result;
}

/// The points of a patch have a common error: each patch counts as one measurement.
Eigen::Matrix3d covariance_of(const std::vector<Eigen::Vector3d>& points,
                              const std::vector<std::size_t>& inliers, const RoadSurface& surface) {
  std::set<std::pair<int, int>> patches;
  Moments moments;
  double squares = 0.0;
  for (const std::size_t i : inliers) {
    const Eigen::Vector3d& p = points[i];
    patches.emplace(static_cast<int>(floor_to_int(p.x() / kPatchSize)),
                    static_cast<int>(floor_to_int(p.y() / kPatchSize)));
    moments.add(p, 1.0);
    squares += surface.above(p) * surface.above(p);
  }
  const auto count = static_cast<double>(inliers.size());
  const double min_variance = kMinHeightSigma * kMinHeightSigma;
  const double variance = std::max(squares / count, min_variance);
  Eigen::Matrix4d information =
      moments.information() * (static_cast<double>(patches.size()) / count / variance);
  information(3, 3) += 1.0 / (kCurvatureSigma * kCurvatureSigma);
  const Eigen::Matrix4d covariance = information.llt().solve(Eigen::Matrix4d::Identity());
  return covariance.topLeftCorner<3, 3>() +
         Eigen::Vector3d(1e-6, 1e-6, min_variance).asDiagonal().toDenseMatrix();
}

}  // namespace

RoadSurface::RoadSurface(const Plane& plane)
    : parameters_(-plane.normal.y() / plane.normal.z(), plane.normal.x() / plane.normal.z(),
                  -plane.offset / plane.normal.z(), 0.0) {}

Plane RoadSurface::tangent() const {
  const Eigen::Vector3d normal = Eigen::Vector3d(parameters_[1], -parameters_[0], 1.0).normalized();
  return {normal, -parameters_[2] * normal.z()};
}

std::optional<RoadFit> fit_road(const std::vector<Eigen::Vector3d>& points, const Plane& start,
                                double tolerance) {
  RoadFit fit{RoadSurface(start), Eigen::Matrix3d::Identity(), {}};
  for (int step = 0; step < kPlaneIterations + kSurfaceIterations; ++step) {
    const bool is_plane = step < kPlaneIterations;
    // With the full tolerance, a pavement within reach would bend the surface up to it.
    const auto refined = weighted_surface(points, fit.surface, is_plane ? tolerance : tolerance / 2,
                                          is_plane ? kFlatCurvatureSigma : kCurvatureSigma);
    if (!refined) return std::nullopt;
    fit.surface = *refined;
  }
  fit.inliers = points_near(points, fit.surface, tolerance);
  fit.covariance = covariance_of(points, fit.inliers, fit.surface);
  return fit;
}

}  // namespace lidar_mapping::preprocessing
