#include "plane_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "lower_scatter.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kSample = 2000;  // points that are counted for a candidate
constexpr int kCandidates = 200;       // at half the points on the floor, one in eight is pure
constexpr std::uint32_t kSeed = 20220613;
constexpr int kRefinements = 8;
constexpr double kIndependent = 1.0;     // m: errors of nearer points are alike
constexpr double kSmallestSigma = 0.01;  // m, of heights: roads are not flat to the millimetre

/// Every n-th point, so that all parts are heard.
std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points) {
  const std::size_t stride = points.size() / kSample + 1;
  std::vector<Eigen::Vector3d> result;
  for (std::size_t i = 0; i < points.size(); i += stride) result.push_back(points[i]);
  return result;
}

std::optional<Plane> through(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const Eigen::Vector3d& c, double largest_lean) {
  Eigen::Vector3d normal = (b - a).cross(c - a);
  const double length = normal.norm();
  if (length < 1e-3) return std::nullopt;
  normal /= normal.z() < 0.0 ? -length : length;
  if (normal.z() < std::cos(largest_lean)) return std::nullopt;
  return Plane{normal, -normal.dot(a)};
}

std::size_t count_near(const std::vector<Eigen::Vector3d>& points, const Plane& plane,
                       double tolerance) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(),
      [&](const Eigen::Vector3d& p) { return std::abs(plane.distance(p)) < tolerance; }));
}

double tukey(double residual, double scale) {
  const double u = residual / scale;
  return std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
}

struct WeightedPoint {
  Eigen::Vector3d p;
  double weight;
};

std::optional<Plane> weighted_plane(const std::vector<Eigen::Vector3d>& points, const Plane& around,
                                    double scale, std::vector<WeightedPoint>& near) {
  near.clear();
  double total = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const double residual = around.distance(p);
    if (!(std::abs(residual) < scale)) continue;
    const double weight = tukey(residual, scale);
    total += weight;
    mean += weight * p;
    near.push_back({p, weight});
  }
  if (total <= 0.0) return std::nullopt;
  mean /= total;
  LowerScatter scatter;
  for (const auto& [p, weight] : near) scatter.add(p - mean, weight / total);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter.matrix());
  // A line of points would leave one rotation open.
  if (eigen.eigenvalues()[1] < 0.25) return std::nullopt;
  Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  if (normal.z() < 0.0) normal = -normal;
  return Plane{normal, -normal.dot(mean)};
}

std::vector<std::size_t> near(const std::vector<Eigen::Vector3d>& points, const Plane& plane,
                              double tolerance) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(plane.distance(points[i])) < tolerance) result.push_back(i);
  }
  return result;
}

/// Points of a patch share their error: each patch counts as one measurement of the mean.
Eigen::Matrix3d covariance_of(const std::vector<Eigen::Vector3d>& points,
                              const std::vector<std::size_t>& inliers, const Plane& plane) {
  std::set<std::pair<int, int>> patches;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double squares = 0.0;
  for (const std::size_t i : inliers) {
    const Eigen::Vector3d& p = points[i];
    patches.emplace(static_cast<int>(std::floor(p.x() / kIndependent)),
                    static_cast<int>(std::floor(p.y() / kIndependent)));
    const Eigen::Vector3d slope(p.y(), -p.x(), 1.0);
    information += slope * slope.transpose();
    squares += plane.distance(p) * plane.distance(p);
  }
  const auto count = static_cast<double>(inliers.size());
  const double variance = std::max(squares / count, kSmallestSigma * kSmallestSigma);
  information *= static_cast<double>(patches.size()) / count / variance;
  const double floor = kSmallestSigma * kSmallestSigma;
  return information.llt().solve(Eigen::Matrix3d::Identity()).eval() +
         Eigen::Vector3d(1e-6, 1e-6, floor).asDiagonal().toDenseMatrix();
}

}  // namespace

std::optional<Plane> search_plane(const std::vector<Eigen::Vector3d>& points, double tolerance,
                                  double largest_lean) {
  if (points.size() < 3) return std::nullopt;
  const std::vector<Eigen::Vector3d> sample = thinned(points);
  std::mt19937 engine(kSeed);
  const auto any = [&] { return sample[engine() % sample.size()]; };
  std::optional<Plane> best;
  std::size_t most = 0;
  for (int candidate = 0; candidate < kCandidates; ++candidate) {
    const Eigen::Vector3d a = any(), b = any(), c = any();
    const auto plane = through(a, b, c, largest_lean);
    if (!plane) continue;
    const std::size_t count = count_near(sample, *plane, tolerance);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  return best;
}

std::optional<PlaneFit> fit_plane(const std::vector<Eigen::Vector3d>& points, const Plane& start,
                                  double tolerance) {
  PlaneFit fit;
  fit.plane = start;
  std::vector<WeightedPoint> buffer;
  for (int step = 0; step < kRefinements; ++step) {
    const auto better = weighted_plane(points, fit.plane, tolerance, buffer);
    if (!better) return std::nullopt;
    fit.plane = *better;
  }
  fit.inliers = near(points, fit.plane, tolerance);
  fit.covariance = covariance_of(points, fit.inliers, fit.plane);
  return fit;
}

}  // namespace lidar_mapping::preprocessing
