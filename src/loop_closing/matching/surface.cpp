// SPDX-License-Identifier: BSD-3-Clause
#include "matching/surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::size_t kNeighbours = 10;  // chosen: fewer are noisy, more round off edges
// Largest ratio of smallest to middle eigenvalue, 1 : 3.5 in thickness and breadth. Chosen: bushes
// are thicker.
constexpr float kPlanarity = 0.08F;
// m above the ground. Chosen: kerbs and slopes within a block are lower, cars and walls higher.
constexpr float kClearance = 0.6F;
// m; a 3 x 3 block reaches 3.75 m from its centre. Chosen: under a truck (2.5 m wide) it finds the
// road.
constexpr double kGroundCell = 2.5;
// m; points further away count as ground. Chosen: beyond the range of LiDARs on vehicles.
constexpr double kGroundExtent = 250.0;

/// Normal of the plane through neighbours; zero if they lie in none. In single precision, unlike
/// PlaneFit, because it is computed for every point of a submap.
Eigen::Vector3f planar_normal(const std::vector<Eigen::Vector3f>& points,
                              const std::vector<KdTree::Neighbour>& neighbours) {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const auto& n : neighbours) mean += points[n.index];
  mean /= static_cast<float>(neighbours.size());
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (const auto& n : neighbours) {
    const Eigen::Vector3f d = points[n.index] - mean;
    scatter += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(scatter);
  const Eigen::Vector3f& values = solver.eigenvalues();
  if (!(values[0] < kPlanarity * values[1])) return Eigen::Vector3f::Zero();
  return solver.eigenvectors().col(0);
}

// Square cells along an edge around the origin: those of the extent, by definition, and one more on
// each side, which is not used.
constexpr int kGroundWidth = static_cast<int>(2.0 * kGroundExtent / kGroundCell) + 2;

/// Number of the cell; -1 outside of the grid.
int ground_cell_of(const Eigen::Vector3f& p) {
  constexpr double kMiddle = kGroundWidth / 2;  // half of it, added so that the cast rounds down
  const double x = p.x() / kGroundCell + kMiddle;
  const double y = p.y() / kGroundCell + kMiddle;
  if (!(x >= 1.0 && y >= 1.0 && x < kGroundWidth - 1 && y < kGroundWidth - 1)) return -1;
  return static_cast<int>(y) * kGroundWidth + static_cast<int>(x);
}

/// Replaces each value by the minimum of itself and of the values `step` before and after it.
void spread_minimum(std::vector<float>& heights, int step) {
  const std::vector<float> original = heights;
  const auto count = static_cast<int>(original.size());
  for (int i = step; i < count - step; ++i) {
    heights[i] = std::min(original[i], std::min(original[i - step], original[i + step]));
  }
}

}  // namespace

std::vector<Eigen::Vector3f> positions(const PointCloud& cloud) {
  std::vector<Eigen::Vector3f> result;
  result.reserve(cloud.size());
  for (const Point& point : cloud.points) {
    if (point.position().allFinite()) result.push_back(point.position());
  }
  return result;
}

SurfaceCloud::SurfaceCloud(std::vector<Eigen::Vector3f> points)
    : tree_(std::move(points)),
      normals_(tree_.points().size(), Eigen::Vector3f::Zero()),
      is_known_(tree_.points().size(), false) {}

const Eigen::Vector3f& SurfaceCloud::normal(std::size_t index) const {
  if (is_known_[index]) return normals_[index];
  is_known_[index] = true;
  const auto neighbours = tree_.nearest(tree_.points()[index], kNeighbours);
  if (neighbours.size() == kNeighbours) normals_[index] = planar_normal(tree_.points(), neighbours);
  return normals_[index];
}

std::vector<bool> above_ground(const std::vector<Eigen::Vector3f>& points) {
  std::vector<int> cells(points.size());
  std::vector<float> lowest(kGroundWidth * kGroundWidth, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < points.size(); ++i) {
    cells[i] = ground_cell_of(points[i]);
    if (cells[i] >= 0) lowest[cells[i]] = std::min(lowest[cells[i]], points[i].z());
  }
  // The minimum over blocks of 3 x 3 cells.
  spread_minimum(lowest, 1);
  spread_minimum(lowest, kGroundWidth);
  std::vector<bool> result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    result[i] = cells[i] >= 0 && points[i].z() > lowest[cells[i]] + kClearance;
  }
  return result;
}

}  // namespace lidar_mapping::loop_closing
