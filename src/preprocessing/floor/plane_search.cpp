// SPDX-License-Identifier: BSD-3-Clause
#include "floor/plane_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Geometry>

namespace lidar_mapping::preprocessing {

namespace {

// Points that are counted for a candidate. Chosen: the fraction of inliers is then known to 1 %.
constexpr std::size_t kSamplePoints = 2000;
// Chosen: if half of the points lie on the floor, one in eight candidates has only such points;
// then none of them has with a probability of (7/8)^200, about 2e-12.
constexpr int kCandidates = 200;
constexpr std::uint32_t kSeed = 20220613;  // chosen: any, so that the result can be repeated

/// Every n-th point, so that all parts of the cloud are represented.
std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points) {
  const std::size_t stride = points.size() / kSamplePoints + 1;
  std::vector<Eigen::Vector3d> result;
  for (std::size_t i = 0; i < points.size(); i += stride) result.push_back(points[i]);
  return result;
}

std::optional<Plane> plane_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
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

}  // namespace

std::optional<Plane> search_plane(const std::vector<Eigen::Vector3d>& points, double tolerance,
                                  double largest_lean) {
  if (points.size() < 3) return std::nullopt;
  const std::vector<Eigen::Vector3d> sample = thinned(points);
  std::mt19937 engine(kSeed);
  const auto random_point = [&] { return sample[engine() % sample.size()]; };
  std::optional<Plane> best;
  std::size_t most = 0;
  for (int candidate = 0; candidate < kCandidates; ++candidate) {
    const Eigen::Vector3d a = random_point(), b = random_point(), c = random_point();
    const auto plane = plane_through(a, b, c, largest_lean);
    if (!plane) continue;
    const std::size_t count = count_near(sample, *plane, tolerance);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  return best;
}

}  // namespace lidar_mapping::preprocessing
